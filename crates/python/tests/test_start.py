"""The commands and the Python lines of README, docs/index.md and docs/start.md run, as a newcomer types them, in one
folder."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
# Commands that install something or take minutes, and lines that need the package h5netcdf.
LEFT = ("cargo ", "pip ", ".ci/", "gfmd kappa-sweep --target", "gfmd kappa-sweep --preset", "import xarray")

pytestmark = pytest.mark.skipif(not (ROOT / "docs/start.md").is_file(), reason="the repository is not there")


def blocks(page, language):
    return re.findall(rf"```{language}\n(.*?)```", (ROOT / page).read_text(encoding="utf-8"), re.S)


def commands(page):
    """The command lines of a page, continued lines joined, without remarks."""
    for block in blocks(page, "sh"):
        for line in block.replace("\\\n", " ").splitlines():
            line = line.split("  #")[0].split(" # ")[0].strip()
            if line and not line.startswith(LEFT) and line != "gfmd kappa-sweep":
                yield line


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("start")


def test_there_are_commands():
    assert len(list(commands("docs/start.md"))) > 8 and list(commands("README.md")) and list(commands("docs/index.md"))


@pytest.mark.parametrize("command", [*commands("docs/start.md"), *commands("README.md"), *commands("docs/index.md")])
def test_the_command_runs(command, folder):
    program = [sys.executable, "-c", "from gfmd._program import main; main()"]
    assert command.startswith("gfmd "), command
    done = subprocess.run([*program, *command.split()[1:], "--quiet"], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, f"{command}\n{done.stderr}"
    # The page has the table of one command.
    if command.endswith("--plots contact --out contact.h5"):
        assert blocks("docs/start.md", "text")[0] in done.stdout
    if command in commands("docs/index.md"):
        assert blocks("docs/index.md", "text")[1] in done.stdout


@pytest.mark.parametrize("page", ["docs/start.md", "README.md", "docs/index.md"])
def test_the_lines_of_python_run(page, folder, monkeypatch, capsys):
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(folder)
    for block in blocks(page, "python"):
        if not block.startswith(LEFT):
            exec(block, {})
    if page == "docs/index.md":
        assert blocks(page, "text")[0].removesuffix("  ...\n") in capsys.readouterr().out


@pytest.mark.parametrize(
    "page", ["README.md", "CONTRIBUTING.md", "SECURITY.md", "docs/site/README.md", "packaging/README.md"]
)
def test_links_of_pages_outside_the_site_lead_somewhere(page):
    text = re.sub(r"```.*?```", "", (ROOT / page).read_text(encoding="utf-8"), flags=re.S)
    for link in re.findall(r"\]\(([^)#\s]+)", text):
        assert link.startswith("http") or (ROOT / page).parent.joinpath(link).exists(), link
