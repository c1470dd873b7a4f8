"""Prepares the sources of the site: a copy of docs, in which long pages are divided at their sections, each public name
and method of the Python package has a page, lists after a mark become cards, and notebooks can be downloaded.

Usage: pages.py ROOT FOLDER. Sphinx reads FOLDER/docs; beside it stand links to the rest of the repository, so that
links out of docs lead where they lead on a code host. Files that did not change are left alone. The package gfmd must
be importable.
"""

import functools
import inspect
import re
import sys
import types
import unicodedata
from pathlib import Path

# Pages that are divided at headings of the second level, and sections of them at headings of the third.
DIVIDED = {"theory": ("7",)}
# Pages with a folder of their name, whose pages stand below them in the contents.
NESTED = ("interface", "python-api")
# Groups of the names of the package.
GROUPS = "python-api/"
# Folders of their pages; classes and exceptions stand in another one.
FOLDERS = {"function": "functions", "method": "methods"}
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


def contents(paths: list[str]) -> list[str]:
    """Returns the lines by which the contents have pages below a page."""
    return ["```{toctree}", ":hidden:", "", *paths, "```", ""] if paths else []


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
    lines = [head, "", *(f"- [{title}]({name}/{file}.md)" for file, title, _ in pages), ""]
    files = {f"{name}.md": "\n".join([*lines, *contents([f"{name}/{file}" for file, *_ in pages])])}
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


def parts(owner: type) -> dict[str, dict[str, object]]:
    """Returns the methods and properties of a class, in groups by title, of numbers and fields the shorter group first.
    Names begin with the class; methods of a public base begin with the base. Inherited methods that only refuse are
    left out."""
    import gfmd

    groups, columns = {"Methods": {}, "Properties": {}}, {}
    seen = set()
    for base in [base for base in owner.__mro__ if base.__module__.startswith("gfmd")]:
        holder = base if getattr(gfmd, base.__name__, None) is base else owner
        for name, thing in vars(base).items():
            if name.startswith("_") or name in seen:
                continue
            seen.add(name)
            if isinstance(thing, (property, functools.cached_property)):
                is_column = base.__module__ == "gfmd._columns"
                group = columns.setdefault(summary(base).rstrip("."), {}) if is_column else groups["Properties"]
                group[f"{owner.__name__}.{name}"] = thing
            elif isinstance(thing, (types.FunctionType, classmethod, staticmethod)):
                if base is owner or not summary(thing).startswith("Refused"):
                    groups["Methods"][f"{holder.__name__}.{name}"] = thing
    return groups | dict(sorted(columns.items(), key=lambda group: len(group[1])))


def members(owner: type) -> list[str]:
    """Returns a table of the methods of a class, and its properties with their descriptions."""
    lines = []
    for title, things in parts(owner).items():
        if things:
            described = [f".. autoproperty:: gfmd.{name}" for name in things]
            lines += [f".. rubric:: {title}", "", *(table(things) if title == "Methods" else described), ""]
    return lines


def named(files: dict[str, bytes]) -> dict[str, str]:
    """Returns a page for each public name of the package and each method, the pages of the groups, which become tables,
    and their list, in which names are links."""
    import gfmd

    pages, left = {}, set(gfmd.__all__) - {"__version__"}

    def add(kind: str, name: str, thing: object, above: str) -> str:
        """Adds the page of a name, and the pages of its methods below it. Returns its entry in the contents."""
        path = f"/{GROUPS}{FOLDERS.get(kind, 'classes')}/{name}"
        lines = [f"# gfmd.{name}", "", above, "", "```{eval-rst}", f".. auto{kind}:: gfmd.{name}"]
        below = []
        if isinstance(thing, type):
            lines += [*(["   :show-inheritance:"] if kind == "exception" else []), "", *members(thing)]
            trail = f"{above} › [gfmd.{name}]({path}.md)"
            methods = parts(thing)["Methods"].items()
            below = [add("method", *method, trail) for method in methods if method[0].startswith(f"{name}.")]
        pages[f"{path[1:]}.md"] = "\n".join([*lines, "```", "", *contents(below)])
        return f"{name.split('.')[-1]} <{path}>"

    for path in [path for path in files if path.startswith(GROUPS)]:
        text, below = files[path].decode(), []
        title = text.splitlines()[0].lstrip("# ")

        def tables(block: re.Match) -> str:
            found = re.findall(r"(?m)^\.\. auto(\w+):: ([\w.]+)", block[0])
            things = {name: functools.reduce(getattr, name.split("."), gfmd) for _, name in found}
            for kind, name in found:
                if kind != "method":
                    left.discard(name)
                    above = f"[Python interface](/{GROUPS[:-1]}.md) › [{title}](/{path})"
                    below.append(add(kind, name, things[name], above))
            lines = table(things)
            if [kind for kind, _ in found] == ["class"]:
                lines += [".. rubric:: Methods", "", *table(parts(things[found[0][1]])["Methods"])]
            return "\n".join(["```{eval-rst}", *lines, "```"])

        text = re.sub(r"(?ms)^```\{eval-rst\}\n.*?^```$", tables, text)
        pages[path] = "\n".join([text, *contents(below)])
    if left:
        sys.exit(f"no page of docs/{GROUPS} has {', '.join(sorted(left))}")
    overview = f"{GROUPS[:-1]}.md"
    pages[overview] = re.sub(r"`(\w+)`", r"{py:obj}`\1 <gfmd.\1>`", files[overview].decode())
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
        files[f"{name}.md"] += "\n".join(["", *contents(list(below))]).encode()
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
