"""Checks the built site: links and anchors in its files; in headless Chromium at two widths, light and dark, each page
without errors, requests to other hosts, overflow, code that is cut, missing images or empty formulas, and without
formulas in plain text where they are typeset; the height of long pages; and the search.
`.ci/site --check` runs it.

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


OVERFLOW = "document.documentElement.scrollWidth - document.documentElement.clientWidth"
IMAGES = """[...document.images].filter(i => { i.loading = 'eager'; return i.offsetParent !== null; })
    .filter(i => !(i.complete && i.naturalWidth > 0)).map(i => i.src)"""
NAMELESS = """[...document.images].filter(i => !i.alt || i.alt.endsWith(i.src.split('/').pop())).map(i => i.src)"""
FONT = """document.querySelector('math') === null ||
    [...document.fonts].some(font => font.family.includes('STIX Two Math') && font.status === 'loaded')"""
CUT = "[...document.querySelectorAll('article pre')].filter(p => p.scrollWidth > p.clientWidth + 1).length"
HIGH = "document.documentElement.scrollHeight"
# Marks of an index or a power that are left in the text of a page.
PLAIN = """[...document.querySelectorAll('article p, article li, article td, div.formulas')].flatMap(e => {
    const copy = e.cloneNode(true); copy.querySelectorAll('math, code, pre, a').forEach(x => x.remove());
    return copy.textContent.match(/(^|[^A-Za-z0-9])[A-Za-z\\u0391-\\u03c9][_^][A-Za-z{(]\\S*/g) || []; })"""
LINKS = "all => all.map(a => a.getAttribute('href'))"
FORMULAS = """[...document.querySelectorAll('math')].filter(m => { const r = m.getBoundingClientRect();
    return r.width < 2 || r.height < 2; }).length"""


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
                    page.wait_for_load_state("networkidle")
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
                    if width == max(WIDTHS) and name.startswith(DIVIDED) and (high := page.evaluate(HIGH)) > HEIGHT:
                        wrong.append(f"{where}: {high} pixels high, more than {HEIGHT}")
                    if name.startswith(("theory", "results")) and (left := page.evaluate(PLAIN)):
                        wrong.append(f"{where}: formulas in plain text: {' '.join(left[:5])}")
                    if shots and name in SHOTS:
                        shots.mkdir(parents=True, exist_ok=True)
                        shot = shots / f"{name.replace('/', '-')[:-5]}-{width}-{scheme}.png"
                        page.screenshot(path=shot, full_page=name == "index.html")
                context.close()
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
    print(f"{len(names)} pages, {len(WIDTHS)} widths, {len(SCHEMES)} schemes, {len(SEARCHES)} searches")
    return wrong


def main() -> int:
    folder = Path(sys.argv[1]).resolve()
    wrong = links(folder) + visited(folder, Path(sys.argv[2]) if len(sys.argv) > 2 else None)
    print("\n".join(wrong) or "no link, page or search is wrong")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
