"""Checks the built site: links and anchors in its files; in headless Chromium at two widths, light and dark, each page
without errors, requests to other hosts, overflow, code that is cut, missing images or empty formulas, and without
formulas in plain text where they are typeset, with tables that show where they go on and fit on paper; the height of
long pages; the downloads of notebooks; the search, and the search as you type. `.ci/site --check` runs it.

Usage: check.py FOLDER [SCREENSHOTS]
"""

import os
import shutil
import sys
import threading
from functools import partial
from html.parser import HTMLParser
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from urllib.parse import unquote, urldefrag, urlsplit

from playwright.sync_api import sync_playwright

WIDTHS = (390, 1200)
SCHEMES = ("light", "dark")
# Words that people look for, and a page that must be among the first results.
SEARCHES = {
    "leak": "tutorials/leak.html",
    "units": "units.html",
    "p*": "glossary.html",
    "layer": "glossary.html",
    "resume": "start.html",
    "kappa": "tutorials/kappa.html",
    "adhesion": "tutorials/adhesion.html",
    "wear": "time.html",
    "Tamaas": "others.html",
    "Hertz": "classical.html",
    "JKR": "laws/adhesion.html",
    "sphere": "classical.html",
}
FIRST = 2
# Words being typed, and a page that must be in the list.
TYPED = {
    "adhes": "tutorials/adhesion.html",
    "notebook": "tutorials/kappa.html",
    "leak": "tutorials/leak.html",
    "self_aff": "python-api/functions/self_affine.html",
    "Surface.ps": "python-api/methods/Surface.psd.html",
    "Surface.level": "python-api/methods/Surface.level.html",
    "level": "python-api/methods/Surface.level.html",
    "rms_heig": "python-api/classes/Surface.html",
    "Contact.gap": "python-api/classes/Contact.html",
    "contact": "python-api/functions/contact.html",
    "contact of rough": "index.html",
    "p*": "glossary.html",
    "material": "python-api/functions/material.html",
}
# Pages that are divided, and the largest height of each in pixels at the larger width.
DIVIDED = ("theory", "interface", "python-api")
HEIGHT = 8000
SHOTS = ("index.html", "start.html", "gallery.html", "glossary.html", "how-it-works.html", "tutorials/leak.html")
# Pages that are no page of the site.
OTHERS = ("crates/", "_", "genindex", "search", "py-modindex")


class Page(HTMLParser):
    """The names that links can point to, and the links."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.ids: set[str] = set()
        self.links: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        for name, value in attributes:
            if name in ("id", "name") and value:
                self.ids.add(value)
            if name in ("href", "src") and value:
                self.links.append(value)


def notebooks(folder: Path, sources: Path) -> list[str]:
    """Pages that are notebooks and offer no file."""
    wrong = []
    for source in sources.rglob("*.md"):
        if source.read_text(encoding="utf-8").startswith("---\nfile_format: mystnb\n"):
            path = folder / source.relative_to(sources).with_suffix(".html")
            files = [link for link in Page(path.read_text(encoding="utf-8")).links if link.endswith(".ipynb")]
            if not files:
                wrong.append(f"{path.relative_to(folder)} offers no notebook")
    return wrong


def links(folder: Path) -> list[str]:
    """Links within the site that lead nowhere. The pages of rustdoc are its own affair; links to them count, unless the
    site was built without them."""
    is_quick = not (folder / "crates").exists()
    ours = (path for path in folder.rglob("*.html") if not str(path.relative_to(folder)).startswith("crates/"))
    pages = {path: Page(path.read_text(encoding="utf-8")) for path in ours}
    wrong = []
    for path, page in pages.items():
        for link in page.links:
            address, anchor = urldefrag(link)
            if urlsplit(link).scheme or link.startswith("//"):
                continue
            target = (path.parent / unquote(address.split("?")[0])).resolve() if address else path
            if not target.exists() and not (is_quick and target.is_relative_to(folder / "crates")):
                wrong.append(f"{path.relative_to(folder)}: {link} does not exist")
            elif anchor and target in pages and unquote(anchor) not in pages[target].ids:
                wrong.append(f"{path.relative_to(folder)}: {link} has no such anchor")
    return wrong


class Quiet(SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass


# Fonts are there, and sizes known to the scripts of the page.
SETTLED = "document.fonts.ready.then(() => new Promise(done => requestAnimationFrame(() => setTimeout(done, 20))))"
OVERFLOW = "document.documentElement.scrollWidth - document.documentElement.clientWidth"
IMAGES = """[...document.images].filter(i => { i.loading = 'eager'; return i.offsetParent !== null; })
    .filter(i => !(i.complete && i.naturalWidth > 0)).map(i => i.src)"""
NAMELESS = """[...document.images].filter(i => !i.alt || i.alt.endsWith(i.src.split('/').pop())).map(i => i.src)"""
FONT = """document.querySelector('math') === null ||
    [...document.fonts].some(font => font.family.includes('STIX Two Math') && font.status === 'loaded')"""
CUT = """[...document.querySelectorAll('article pre')].filter(p => p.scrollWidth > p.clientWidth + 1 &&
    !p.classList.contains('more-right')).length"""
HIGH = "document.documentElement.scrollHeight"
# Marks of an index or a power that are left in the text of a page.
PLAIN = """[...document.querySelectorAll('article p, article li, article td, div.formulas')].flatMap(e => {
    const copy = e.cloneNode(true); copy.querySelectorAll('math, code, pre, a').forEach(x => x.remove());
    return copy.textContent.match(/(^|[^A-Za-z0-9])[A-Za-z\\u0391-\\u03c9][_^][A-Za-z{(]\\S*/g) || []; })"""
# Tables that are wider than the page and do not show it; numbers in more than one line.
HIDDEN = """[...document.querySelectorAll('article table')].filter(t => t.scrollWidth > t.clientWidth + 1
    && !t.classList.contains('more-right')).length"""
BROKEN = """[...document.querySelectorAll('article td')].filter(cell => {
    if (!/^[-−+±~<>≤≥≈ ]*[0-9][-−+0-9.,()±e ]*$/.test(cell.textContent.trim())) return false;
    const lines = new Set(), walk = document.createTreeWalker(cell, NodeFilter.SHOW_TEXT);
    while (walk.nextNode()) {
        const range = document.createRange();
        range.selectNode(walk.currentNode);
        [...range.getClientRects()].filter(r => r.width > 1).forEach(r => lines.add(Math.round(r.bottom / 10)));
    }
    return lines.size > 1; }).map(cell => cell.textContent)"""
# Tables that paper cuts, whose width at 96 points per inch is A4 without margins.
PAPER = 718
CUT_ON_PAPER = """[...document.querySelectorAll('article table')].filter(t => t.getBoundingClientRect().right >
    document.documentElement.clientWidth + 1 || t.scrollWidth > t.clientWidth + 2).length"""
ROWS = "all => all.map(a => a.pathname + a.hash)"
LINKS = "all => all.map(a => a.getAttribute('href'))"
FORMULAS = """[...document.querySelectorAll('math')].filter(m => { const r = m.getBoundingClientRect();
    return r.width < 2 || r.height < 2; }).length"""


def typed(page, home: str) -> list[str]:
    """Types words into the search field of the sidebar, and opens pages by keys."""
    wrong = []
    field, row = page.locator("input.sidebar-search"), page.locator("#search-list a")
    for word, wanted in TYPED.items():
        page.goto(f"{home}/start.html")
        page.keyboard.press("/")
        page.keyboard.type(word, delay=20)
        row.first.wait_for()
        page.wait_for_timeout(200)
        found = [address.split("#")[0].lstrip("/") for address in row.evaluate_all(ROWS)]
        if wanted not in found:
            wrong.append(f"typing {word!r}: {wanted} is not in the list: {', '.join(found)}")
            continue
        for _ in range(found.index(wanted)):
            page.keyboard.press("ArrowDown")
        page.keyboard.press("Enter")
        page.wait_for_url(lambda address: urlsplit(address).path == f"/{wanted}")
    page.goto(f"{home}/start.html")
    page.keyboard.press("Control+k")
    page.keyboard.type("creep")
    row.first.wait_for()
    page.keyboard.press("ArrowUp")
    if "search.html?q=creep" not in page.locator("#search-list a[aria-selected=true]").get_attribute("href"):
        wrong.append("the last row of the list is no link to the search page")
    page.keyboard.press("Escape")
    if row.first.is_visible() or field.input_value() != "creep":
        wrong.append("Escape does not close the list, or empties the field")
    page.keyboard.press("Enter")
    page.wait_for_url("**/search.html?q=creep*")
    return wrong


def is_elsewhere(address: str, home: str) -> bool:
    return not address.startswith((home, "data:"))


def visited(folder: Path, shots: Path | None) -> list[str]:
    wrong: list[str] = []
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(folder)))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    home = f"http://127.0.0.1:{server.server_port}"
    names = sorted(str(path.relative_to(folder)) for path in folder.rglob("*.html"))
    names = [name for name in names if not name.startswith(OTHERS)]
    known = (os.environ.get("CHROMIUM"), *map(shutil.which, ("chromium", "chromium-browser", "google-chrome")))
    program = next((found for found in known if found), None)
    flags = ["--no-sandbox", "--disable-gpu", "--disable-background-networking"]
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, headless=True, args=flags)
        for width in WIDTHS:
            for scheme in SCHEMES:
                context = browser.new_context(viewport={"width": width, "height": 900}, color_scheme=scheme)
                page = context.new_page()
                heard: list[str] = []
                page.on("console", lambda said: heard.append(said.text) if said.type == "error" else None)
                page.on("pageerror", lambda error: heard.append(str(error)))
                page.on("request", lambda asked: heard.append(asked.url) if is_elsewhere(asked.url, home) else None)
                page.on("requestfailed", lambda asked: heard.append(f"{asked.url} failed"))
                for name in names:
                    heard.clear()
                    page.goto(f"{home}/{name}", wait_until="load")
                    page.evaluate(SETTLED)
                    where = f"{name} at {width}, {scheme}"
                    wrong += [f"{where}: {told}" for told in heard]
                    if (wide := page.evaluate(OVERFLOW)) > 1:
                        wrong.append(f"{where}: {wide} pixels wider than the window")
                    wrong += [f"{where}: the image {source} is not there" for source in page.evaluate(IMAGES)]
                    wrong += [f"{where}: the image {source} has no description" for source in page.evaluate(NAMELESS)]
                    if empty := page.evaluate(FORMULAS):
                        wrong.append(f"{where}: {empty} formulas are empty")
                    if not page.evaluate(FONT):
                        wrong.append(f"{where}: the font of formulas is not loaded")
                    if cut := page.evaluate(CUT):
                        wrong.append(f"{where}: {cut} blocks of code are cut")
                    if hidden := page.evaluate(HIDDEN):
                        wrong.append(f"{where}: {hidden} tables do not show that they go on")
                    if broken := page.evaluate(BROKEN):
                        wrong.append(f"{where}: numbers in two lines: {' '.join(broken[:5])}")
                    is_divided = width == max(WIDTHS) and name.startswith(DIVIDED)
                    if is_divided and (high := page.evaluate(HIGH)) > HEIGHT:
                        wrong.append(f"{where}: {high} pixels high, more than {HEIGHT}")
                    if name.startswith(("theory", "results")) and (left := page.evaluate(PLAIN)):
                        wrong.append(f"{where}: formulas in plain text: {' '.join(left[:5])}")
                    if shots and name in SHOTS:
                        shots.mkdir(parents=True, exist_ok=True)
                        shot = shots / f"{name.replace('/', '-')[:-5]}-{width}-{scheme}.png"
                        page.screenshot(path=shot, full_page=name == "index.html")
                context.close()
        page = browser.new_page(viewport={"width": PAPER, "height": 900})
        page.emulate_media(media="print")
        for name in names:
            page.goto(f"{home}/{name}", wait_until="load")
            if cut := page.evaluate(CUT_ON_PAPER):
                wrong.append(f"{name} on paper: {cut} tables are cut")
        for size in ({"width": 1200, "height": 900}, {"width": 390, "height": 900}):
            wrong += typed(browser.new_page(viewport=size), home)
        page = browser.new_page()
        for word, wanted in SEARCHES.items():
            page.goto(f"{home}/search.html?q={word.replace('*', '%2A')}")
            page.wait_for_selector("#search-results ul.search li a", timeout=20000)
            page.wait_for_timeout(500)
            found = page.eval_on_selector_all("#search-results ul.search li > a", LINKS)
            first = list(dict.fromkeys(link.split("#")[0].split("?")[0] for link in found))[:FIRST]
            if wanted not in first:
                wrong.append(f"search for {word!r}: {wanted} is not among the first {FIRST}: {', '.join(first)}")
        browser.close()
    server.shutdown()
    print(f"{len(names)} pages, {len(WIDTHS)} widths, {len(SCHEMES)} schemes, {len(SEARCHES) + len(TYPED)} searches")
    return wrong


def main() -> int:
    folder = Path(sys.argv[1]).resolve()
    wrong = links(folder) + notebooks(folder, Path(__file__).parents[1])
    wrong += visited(folder, Path(sys.argv[2]) if len(sys.argv) > 2 else None)
    print("\n".join(wrong) or "no link, page or search is wrong")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
