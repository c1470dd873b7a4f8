"""Configuration of the documentation site. `.ci/site` builds it; docs/site/README.md says how it is made."""

import os
import re
import sys
import tomllib
from html import escape
from pathlib import Path

import latex2mathml.converter

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "docs" / "site"))

import formulas  # noqa: E402

project = "gfmd"
author = "The gfmd developers"
version = release = tomllib.loads((ROOT / "Cargo.toml").read_text(encoding="utf-8"))["workspace"]["package"]["version"]
copyright = author

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
    "sphinx_copybutton",
    "sphinx_design",
]
source_suffix = {".md": "myst-nb"}
exclude_patterns = ["site/README.md", "downloads", "_build"]
suppress_warnings = ["misc.highlighting_failure"]  # tables of formulas in fenced text
nitpicky = False

# Markdown: formulas, anchors of headings as code hosts make them, fenced directives.
myst_enable_extensions = ["dollarmath", "colon_fence", "deflist"]
myst_heading_anchors = 4
myst_dmath_allow_labels = False
myst_dmath_double_inline = True

# Notebooks run when the site is built, and a cell that fails fails the build. Results are kept between builds.
nb_execution_mode = "cache"
nb_execution_raise_on_error = True
nb_execution_timeout = 300
nb_merge_streams = True
nb_number_source_lines = False
os.environ["MATPLOTLIBRC"] = str(ROOT / "docs" / "site" / "matplotlibrc")

# The Python interface, from its docstrings. Names between single marks are code, with links.
default_role = "py:obj"
autodoc_typehints = "none"
autodoc_member_order = "bysource"
napoleon_google_docstring = True
napoleon_numpy_docstring = False
napoleon_use_rtype = False
napoleon_use_ivar = True

templates_path = []
html_theme = "furo"
html_title = f"gfmd {release}"
html_static_path = ["site/static"]
html_css_files = ["gfmd.css"]
html_js_files = [("search.js", {"defer": "defer"}), ("wide.js", {"defer": "defer"}), ("sidebar.js", {"defer": "defer"})]
html_search_scorer = str(Path(__file__).parent / "site" / "scorer.js")
html_favicon = "site/static/icon.svg"
html_show_sphinx = False
html_domain_indices = False
html_copy_source = False
html_show_sourcelink = False
html_theme_options = {"navigation_with_keys": True}
# A prompt is no part of a command.
copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True


def _mathml(source: str, display: str) -> str:
    return latex2mathml.converter.convert(source, display=display)


def _inline(writer, node):
    """A formula in a line, as MathML: no script, no font from elsewhere."""
    from docutils import nodes

    writer.body.append(f'<span class="math">{_mathml(node.astext(), "inline")}</span>')
    raise nodes.SkipNode


def _block(writer, node):
    from docutils import nodes

    writer.body.append(f'<div class="math" role="math">{_mathml(node.astext(), "block")}</div>')
    raise nodes.SkipNode


html_math_renderer = "mathml"


# Pages of the repository that are not below docs, by the page of the site that includes them.
OUTSIDE = {
    "data/reference/README.md": "reference-data",
    "CONTRIBUTING.md": "contributing",
    "CHANGELOG.md": "changelog",
    "CODE_OF_CONDUCT.md": "conduct",
    "SECURITY.md": "security",
}


def _inside(app, page, source):
    """Links to pages outside docs lead to the pages that include them."""
    for outside, shown in OUTSIDE.items():
        source[0] = re.sub(rf"\]\((?:\.\./)*{re.escape(outside)}", f"](/site/{shown}.md", source[0])


def _included(app, parent, page, source):
    """The same in pages that are included, whose links into docs have the name of the folder."""
    _inside(app, page, source)
    source[0] = re.sub(r"\]\(docs/", "](/", source[0])


def _described(app, tree):
    """Figures of notebooks, which have no text of their own, are described by their heading."""
    from docutils import nodes

    for image in tree.findall(nodes.image):
        section = image.parent
        while section is not None and not isinstance(section, nodes.section):
            section = section.parent
        if section is not None and not image.get("alt"):
            image["alt"] = f"Figure: {section[0].astext()}"


def _warned(app, tree):
    """Warnings of notebooks come without the place in a temporary file."""
    from docutils import nodes

    for block in list(tree.findall(nodes.literal_block)):
        text = re.sub(r"\S*ipykernel\S*: UserWarning: (.*)\n  .*\n?", r"warning: \1\n", block.astext())
        if text != block.astext():
            block.replace_self(nodes.literal_block(text, text, language="none", classes=block["classes"]))


def _thumbnails(app, tree):
    """The gallery begins with its figures, which lead to their sections."""
    from docutils import nodes

    if app.env.docname != "gallery":
        return
    items = []
    for section in tree.findall(nodes.section):
        own = (part for part in section.children if not isinstance(part, nodes.section))
        image = next((image for part in own for image in part.findall(nodes.image)), None)
        if image is not None:
            title = section[0].astext()
            link = nodes.reference("", "", image.deepcopy(), nodes.inline("", title), refid=section["ids"][0])
            items.append(nodes.list_item("", nodes.paragraph("", "", link)))
    next(tree.findall(nodes.paragraph)).parent.insert(2, nodes.bullet_list("", *items, classes=["thumbnails"]))


def _columns(app, tree):
    """Cells of tables that are numbers, which stay whole, and cells of words, which need room."""
    from docutils import nodes

    for entry in tree.findall(nodes.entry):
        text = entry.astext()
        if len(text) <= 40 and re.match(r"[\W_]*\d[^a-z]*([a-zµ°*/^ ]{1,8}[^a-z]*)?$", text, re.I):
            entry["classes"].append("number")
        elif len(text) > 40:
            entry["classes"].append("text")


def _folded(app, tree):
    """Three or more notes (block quotes) in a row become one list that opens on demand."""
    from docutils import nodes

    for parent in {id(note.parent): note.parent for note in tree.findall(nodes.block_quote)}.values():
        row = []
        for child in [*parent.children, None]:
            if isinstance(child, nodes.block_quote):
                row.append(child)
                continue
            if len(row) > 2:
                lines = "".join(f"<li>{escape(note.astext())}</li>" for note in row)
                text = f"<details><summary>{len(row)} notes</summary><ul>{lines}</ul></details>"
                parent.insert(parent.index(row[0]), nodes.raw("", text, format="html"))
                for note in row:
                    parent.remove(note)
            row = []


def _joined(app, what, name, obj, options, lines):
    """Names that share a description stay one name: Sphinx takes all but the last for its type."""
    for place, line in enumerate(lines):
        if found := re.match(r":(?:ivar|param) ([^:]*,[^:]*):", line):
            lines[place] = line.replace(found[1], found[1].replace(", ", ",\u200b"), 1)


def _plain(app, what, name, obj, options, lines):
    """Descriptions of numbers, such as "Length: |a - b|", stay as they are: Napoleon would take words before a colon
    for a type, unless the description begins with a comment, and docutils bars for marks."""
    if what == "property":
        lines[:] = ["..", "", *(line.replace("|", r"\|") for line in lines)]


# Pages whose text is no mathematics: lists of changes, of names in code, and of flags.
UNTYPESET = ("site/", "python-api", "options", "architecture", "crates", "style")


def _typeset(app, tree):
    """Formulas in plain text become MathML; in the theory blocks of them, too."""
    from docutils import nodes

    page = app.env.docname
    if page.startswith(UNTYPESET):
        return
    for parent in {id(text.parent): text.parent for text in tree.findall(nodes.Text)}.values():
        merged = []  # each line is a text of its own
        for child in parent.children:
            if merged and isinstance(child, nodes.Text) and isinstance(merged[-1], nodes.Text):
                merged[-1] = nodes.Text(str(merged[-1]) + str(child))
            else:
                merged.append(child)
        if len(merged) < len(parent.children):
            parent.children = []
            parent += merged
    kept = (nodes.literal, nodes.literal_block, nodes.math, nodes.math_block, nodes.raw, nodes.title, nodes.comment)
    for text in list(tree.findall(nodes.Text)):
        above = text.parent
        while above is not None and not isinstance(above, kept):
            above = above.parent
        if above is None:
            if isinstance(text.parent.parent, nodes.entry):
                text = _replaced(text, str(text).replace(" ± ", "\u00a0±\u00a0"))
            parts = [_formula(part) if found else nodes.Text(part) for found, part in formulas.typeset(str(text))]
            if any(isinstance(part, nodes.raw) for part in parts):
                text.parent.replace(text, parts)
    if page.startswith(("theory", "results")):
        for block in list(tree.findall(nodes.literal_block)):
            plain = block.get("language") in ("text", "none", "default")
            if plain and not re.search("gfmd|cargo|xtask", block.astext()):
                lines = "".join(_line(line) for line in block.astext().strip("\n").split("\n"))
                block.replace_self(nodes.raw("", f'<div class="formulas">{lines}</div>', format="html"))


def _replaced(text, words):
    from docutils import nodes

    other = nodes.Text(words)
    text.parent.replace(text, other)
    return other


def _formula(text):
    from docutils import nodes

    return nodes.raw("", formulas.mathml(text), format="html")


def _line(line):
    """A line of a block of formulas: columns between two blanks or more, words beside formulas."""
    indent = len(line) - len(line.lstrip())
    columns = []
    for column in re.split(r"(?<![=≤≥≈ ]) {2,}(?![=≤≥≈])", line.strip()):
        parts = formulas.typeset(re.sub(" +", " ", column), longest=2)
        columns.append("".join(formulas.mathml(part) if found else escape(part) for found, part in parts))
    return (
        f'<div style="padding-left: {indent / 2}em">' + "".join(f"<span>{text}</span> " for text in columns) + "</div>"
    )


def setup(app):
    app.connect("source-read", _inside)
    app.connect("include-read", _included)
    app.connect("autodoc-process-docstring", _joined, priority=600)
    app.connect("autodoc-process-docstring", _plain, priority=400)
    app.connect("doctree-read", _described)
    app.connect("doctree-read", _warned)
    app.connect("doctree-read", _thumbnails)
    app.connect("doctree-read", _columns)
    app.connect("doctree-read", _folded)
    app.connect("doctree-read", _typeset)
    app.add_html_math_renderer("mathml", inline_renderers=(_inline, None), block_renderers=(_block, None))
