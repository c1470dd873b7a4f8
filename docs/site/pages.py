"""Prepares the sources of the site: a copy of docs, in which long pages are divided at their sections.

Usage: pages.py ROOT FOLDER. Sphinx reads FOLDER/docs; beside it stand links to the rest of the repository, so that
links out of docs lead where they lead on a code host. Files that did not change are left alone.
"""

import re
import sys
import unicodedata
from pathlib import Path

# Pages that are divided at headings of the second level, and sections of them at headings of the third.
DIVIDED = {"theory": ("7",)}
# Pages with a folder of their name, whose pages stand below them in the contents.
NESTED = ("interface", "python-api")


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
