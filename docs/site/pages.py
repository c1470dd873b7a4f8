"""Prepares the sources of the site: a copy of docs, in which long pages are divided at their sections, each public name
of the Python package has a page, lists after a mark become cards, and notebooks can be downloaded.

Usage: pages.py ROOT FOLDER. Sphinx reads FOLDER/docs; beside it stand links to the rest of the repository, so that
links out of docs lead where they lead on a code host. Files that did not change are left alone. The package gfmd must
be importable.
"""

import functools
import inspect
import re
import sys
import unicodedata
from pathlib import Path

# Pages that are divided at headings of the second level, and sections of them at headings of the third.
DIVIDED = {"theory": ("7",)}
# Pages with a folder of their name, whose pages stand below them in the contents.
NESTED = ("interface", "python-api")
# Groups of the names of the package.
GROUPS = "python-api/"
# The list after this line becomes cards: "- **Title.** Text".
CARDS = "<!-- cards -->\n"
NOTEBOOK = "---\nfile_format: mystnb\n"


def slug(title: str) -> str:
    """Returns the anchor that code hosts and MyST give a heading."""
    return re.sub(r"[^\w\- ]", "", title.lower().replace("`", "")).strip().replace(" ", "-")


def sections(text: str, level: str) -> list[tuple[str, str]]:
    """Divides a page before its headings of a level; the first part has no title."""
    found, title, lines, code = [], "", [], False
    for line in text.splitlines():
        code ^= line.lstrip().startswith("```")
        if not code and line.startswith(f"{level} "):
            found.append((title, "\n".join(lines)))
            title, lines = line[len(level) + 1 :], []
        else:
            lines.append(line)
    return [*found, (title, "\n".join(lines))]


def lower(text: str) -> str:
    """Leads links of a page from one folder deeper."""
    return re.sub(r"\]\((?!https?:|/|#)", "](../", text)


def divided(name: str, text: str, split: tuple[str, ...]) -> dict[str, str]:
    """Returns the pages of a long one by their paths, the overview first."""
    (_, head), *parts = sections(text, "##")
    pages: list[tuple[str, str, str]] = []
    for title, body in parts:
        number = title.split(".")[0]
        if number not in split:
            pages.append((f"{number.zfill(2)}", title, body))
            continue
        (_, first), *rest = sections(body, "###")
        pages.append((number.zfill(2), title, first))
        for sub, below in rest:
            outer, inner = sub.split(" ")[0].split(".")
            pages.append((f"{outer.zfill(2)}-{inner.zfill(2)}", sub, below))
    anchors = {}
    for file, title, body in pages:
        anchors[slug(title)] = file
        anchors.update({slug(line.lstrip("# ")): file for line in body.splitlines() if re.match("#{3,4} ", line)})
    head = head.split("\nContents:")[0]
    lines = [
        head,
        "",
        *(f"- [{title}]({name}/{file}.md)" for file, title, _ in pages),
        "",
        "```{toctree}",
        ":hidden:",
        "",
    ]
    files = {f"{name}.md": "\n".join([*lines, *(f"{name}/{file}" for file, *_ in pages), "```", ""])}
    for file, title, body in pages:
        above = "##" if "-" in file else "#"
        body = re.sub(rf"(?m)^{above}(#+ )", r"\1", body)
        body = re.sub(r"\]\(#([^)]*)\)", lambda m: f"]({name}.md#{m[1]})", lower(body))
        files[f"{name}/{file}.md"] = f"# {title}\n{body}\n"
    for path, body in files.items():
        files[path] = redirected(body, name, anchors)
    return files


def redirected(text: str, name: str, anchors: dict[str, str]) -> str:
    """Leads links to sections of a divided page to their own pages."""

    def to(match: re.Match) -> str:
        folder, anchor = match[1], match[2]
        return f"]({folder}{name}/{anchors[anchor]}.md)" if anchor in anchors else match[0]

    return re.sub(rf"\]\(((?:\.\./)*){name}\.md#([^)]*)\)", to, text)


def summary(thing: object) -> str:
    """Returns the first paragraph of a docstring as one line."""
    return " ".join((inspect.getdoc(thing) or "").split("\n\n")[0].split())


def table(things: dict[str, object]) -> list[str]:
    """Returns a table of names with their summaries in reStructuredText; names are links."""
    lines = [".. list-table::", "   :class: names", ""]
    for name, thing in things.items():
        lines += [f"   * - :py:obj:`{name.split('.')[-1]} <gfmd.{name}>`", f"     - {summary(thing)}"]
    return [*lines, ""]


def members(owner: type) -> list[str]:
    """Returns tables of the properties and methods that the page of a class describes."""
    own = {f"{owner.__name__}.{name}": thing for name, thing in vars(owner).items() if not name.startswith("_")}
    properties = {
        name: thing for name, thing in own.items() if isinstance(thing, (property, functools.cached_property))
    }
    methods = {name: thing for name, thing in own.items() if inspect.isroutine(thing) or isinstance(thing, classmethod)}
    lines = []
    for title, things in (("Properties", properties), ("Methods", methods)):
        things = {name: thing for name, thing in things.items() if summary(thing)}
        if things:
            lines += [f".. rubric:: {title}", "", *table(things)]
    return lines


def named(files: dict[str, bytes]) -> dict[str, str]:
    """Returns a page for each public name of the package, and the pages of the groups, which become tables."""
    import gfmd

    pages, left = {}, set(gfmd.__all__) - {"__version__"}
    for path in [path for path in files if path.startswith(GROUPS)]:
        text, below = files[path].decode(), []
        title = text.splitlines()[0].lstrip("# ")

        def tables(block: re.Match) -> str:
            found = re.findall(r"(?m)^\.\. auto(\w+):: ([\w.]+)", block[0])
            things = {name: functools.reduce(getattr, name.split("."), gfmd) for _, name in found}
            for kind, name in found:
                if kind == "method":
                    continue
                left.discard(name)
                folder = "functions" if kind == "function" else "classes"
                below.append(f"{name} <{folder}/{name}>")
                pages[f"{GROUPS}{folder}/{name}.md"] = "\n".join(
                    [
                        f"# gfmd.{name}",
                        "",
                        f"[Python interface](../../{GROUPS[:-1]}.md) › [{title}](../{path.removeprefix(GROUPS)})",
                        "",
                        "```{eval-rst}",
                        f".. auto{kind}:: gfmd.{name}",
                        "```",
                        "",
                    ]
                )
            lines = table(things)
            if [kind for kind, _ in found] == ["class"]:
                lines += members(things[found[0][1]])
            return "\n".join(["```{eval-rst}", *lines, "```"])

        text = re.sub(r"(?ms)^```\{eval-rst\}\n.*?^```$", tables, text)
        pages[path] = "\n".join([text, "```{toctree}", ":hidden:", "", *below, "```", ""])
    if left:
        sys.exit(f"no page of docs/{GROUPS} has {', '.join(sorted(left))}")
    return pages


def cards(text: str) -> str:
    """Makes the list after the mark a grid of cards: a title, a sentence, and links on lines of their own."""
    before, mark, after = text.partition(CARDS)
    if not mark:
        return text
    items, _, rest = after.strip("\n").partition("\n\n")
    lines = ["::::{grid} 1 2 2 3", ":gutter: 3", ""]
    for title, body in re.findall(r"(?ms)^- \*\*(.*?)\.\*\* (.*?)(?=^- |\Z)", items):
        text, _, links = body.partition("\n  [")
        lines += [
            f":::{{grid-item-card}} {title}",
            text,
            "",
            *f"[{links}".replace(" ·", "\u00a0·").split("\n  "),
            ":::",
            "",
        ]
    return "\n".join([before, *lines, "::::", "", rest])


def notebook(name: str, text: str, docs: Path) -> dict[str, bytes]:
    """Returns a page with a link to its notebook, the notebook, and the repository files that it reads. Links of the
    notebook to other pages become text."""
    import nbformat
    from myst_nb.core.read import read_myst_markdown_notebook

    page = (docs / name).parent
    read = {found: page / found for found in re.findall(r'"(\.\./[^"\n]+)"', text) if (page / found).is_file()}
    alone = text
    for found, source in read.items():
        alone = alone.replace(f'"{found}"', f'"{source.name}"')
    book = read_myst_markdown_notebook(alone)
    for number, cell in enumerate(book.cells):
        cell["id"] = f"cell-{number}"
        if cell.cell_type == "markdown":
            cell.source = re.sub(r"!\[([^][]*)\]\([^)]*\)", r"(Figure: \1)", cell.source)
            cell.source = re.sub(r"\[([^][]*)\]\((?!https?:)[^)]*\)", r"\1", cell.source)
    book.nbformat_minor = 5
    nbformat.validate(book)
    stem = Path(name).stem
    files = {f"downloads/{stem}.ipynb": (nbformat.writes(book) + "\n").encode()}
    files |= {f"downloads/{source.name}": source.read_bytes() for source in read.values()}
    offers = [f"{{download}}`Notebook </downloads/{stem}.ipynb>`"]
    offers += [f"{{download}}`{source.name} </downloads/{source.name}>`" for source in read.values()]
    offered = re.sub(r"(?m)^(# .*\n)", lambda head: f"{head[1]}\nDownload: {', '.join(offers)}\n", text, count=1)
    return files | {name: offered.encode()}


def main(root: Path, folder: Path) -> None:
    docs = folder / "docs"
    docs.mkdir(parents=True, exist_ok=True)
    for entry in root.iterdir():
        if entry.name not in ("docs", "target", ".git") and not (folder / entry.name).exists():
            (folder / entry.name).symlink_to(entry.resolve())
    files: dict[str, bytes] = {}
    for path in sorted((root / "docs").rglob("*")):
        if path.is_file() and "__pycache__" not in path.parts:
            files[str(path.relative_to(root / "docs"))] = path.read_bytes()
    for name, split in DIVIDED.items():
        pages = divided(name, unicodedata.normalize("NFC", files[f"{name}.md"].decode()), split)
        files |= {path: text.encode() for path, text in pages.items()}
    for name in NESTED:
        below = dict.fromkeys(re.findall(rf"\]\(({name}/[\w-]+)\.md", files[f"{name}.md"].decode()))
        files[f"{name}.md"] += "\n".join(["", "```{toctree}", ":hidden:", "", *below, "```", ""]).encode()
    files |= {path: text.encode() for path, text in named(files).items()}
    files["index.md"] = cards(files["index.md"].decode()).encode()
    for name in [name for name, data in files.items() if data.startswith(NOTEBOOK.encode())]:
        files |= notebook(name, files[name].decode(), root / "docs")
    for path in docs.rglob("*"):
        if path.is_file() and str(path.relative_to(docs)) not in files:
            path.unlink()
    for name, data in files.items():
        path = docs / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.exists() or path.read_bytes() != data:
            path.write_bytes(data)


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve())
