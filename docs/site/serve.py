"""Uses the page of `gfmd serve` in headless Chromium as a person does: from a scan to a pressure map, two runs at once,
refused uploads and options, maps with zoom and section, downloads; without errors, requests to other hosts or overflow.
`.ci/site --check` runs it.

Usage: serve.py PROGRAM [SCREENSHOTS]
"""

import math
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from playwright.sync_api import Page, expect, sync_playwright

OVERFLOW = "document.documentElement.scrollWidth - document.documentElement.clientWidth"
DROP = """text => { const data = new DataTransfer();
    data.items.add(new File([text], 'dropped.txt')); return data; }"""
# A person without documentation has this time from the open page to the pressure map, in s; a program needs less.
LIMIT = 120.0
POINTS = 96


def scan(path: Path) -> None:
    """Writes a rough scan with a tilt and missing points."""
    waves = [
        (m, n, 1.7 * m + 2.3 * n, (m * m + n * n) ** -0.9) for m in range(-8, 9) for n in range(9) if (m, n) != (0, 0)
    ]
    rows = []
    for j in range(POINTS):
        at = [(2 * math.pi * i / POINTS, 2 * math.pi * j / POINTS) for i in range(POINTS)]
        row = [
            sum(a * math.cos(m * x + n * y + p) for m, n, p, a in waves) * 1e-7 + 0.02e-7 * i
            for i, (x, y) in enumerate(at)
        ]
        gone = [(i - 30) ** 2 + (j - 60) ** 2 < 30 for i in range(POINTS)]
        rows.append(" ".join("nan" if lost else repr(z) for z, lost in zip(row, gone)))
    path.write_text("\n".join(rows) + "\n")


def started(program: str, folder: Path) -> tuple["subprocess.Popen[str]", str]:
    """Starts the server with small uploads; returns it with the address of its page."""
    words = [program, "serve", "--folder", str(folder), "--upload-limit", "1"]
    server = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    assert server.stdout is not None
    first = server.stdout.readline()
    assert first.startswith("page:"), first
    return server, first.split()[-1]


def shoot(page: Page, shots: Path | None, name: str) -> None:
    if shots:
        shots.mkdir(parents=True, exist_ok=True)
        page.screenshot(path=shots / f"serve-{name}.png", full_page=True)


def used(page: Page, address: str, folder: Path, shots: Path | None) -> None:
    """Uses the page; raises if something is not as a person needs it."""
    page.goto(address)
    begin = time.monotonic()
    page.set_input_files("#file", folder / "scan.txt")
    expect(page.locator("#about")).to_contain_text("missing points")
    expect(page.locator("#numbers")).to_contain_text("rms height")
    expect(page.locator("#notes")).to_contain_text("names no unit")
    page.fill("#option-unit", "m")
    page.locator("#option-unit").blur()
    expect(page.locator("#option-young")).to_be_empty()
    page.fill("#option-size", "100um")
    page.select_option("#material", "aluminium")
    shoot(page, shots, "prepared")
    page.click("#press")
    expect(page.locator("#view-title")).to_contain_text("pressure", timeout=60000)
    took = time.monotonic() - begin
    assert took < LIMIT, f"{took} s from the scan to the pressure map"
    expect(page.locator("#sheets")).to_contain_text("pressure / MPa")
    shoot(page, shots, "pressure")

    # The pointer reads a value, a drag makes a section, the wheel zooms, the slider changes the load.
    page.locator("#map").scroll_into_view_if_needed()
    box = page.locator("#map").bounding_box()
    assert box is not None
    middle = (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.mouse.move(*middle)
    expect(page.locator("#pointer")).to_contain_text("Pa")
    page.mouse.down()
    page.mouse.move(middle[0] + 120, middle[1] - 60, steps=4)
    page.mouse.up()
    expect(page.locator("#section")).to_be_visible()
    page.mouse.move(*middle)
    page.mouse.wheel(0, -400)
    assert page.evaluate("view.zoom") > 1.5
    page.locator("#map").press("Home")
    page.locator("#map").press("x")
    assert page.evaluate("view.section.from[0]") == 0 and page.evaluate("view.section.to[0]") == 1
    page.locator("#map").press("+")
    assert page.evaluate("view.zoom") == 1.5
    page.locator("#map").press("Home")
    assert page.evaluate("view.zoom") == 1
    page.locator("#load").fill("0")
    expect(page.locator("#load-text")).to_contain_text("1 of 3")
    page.get_by_role("button", name="Gap", exact=True).click()
    expect(page.locator("#view-title")).to_contain_text("gap")
    shoot(page, shots, "gap")

    # Downloads.
    for name, end in [("Page (HTML)", ".html"), ("All fields (HDF5)", ".h5")]:
        with page.expect_download() as download:
            page.get_by_role("link", name=name).click()
        assert download.value.suggested_filename.endswith(end), download.value.suggested_filename

    # The page about the result, which has its style and figures inside.
    with page.context.expect_page() as opened:
        page.get_by_role("link", name="Open the page").click()
    about, said = opened.value, []
    about.on("console", lambda heard: said.append(heard.text))
    about.wait_for_load_state()
    about.reload()
    expect(about.locator("svg").first).to_be_visible()
    shoot(about, shots, "page")
    assert not said, said
    about.close()

    # A refused option stands beside its field; refused uploads say why and keep the scan.
    page.fill("#option-young", "-3GPa")
    page.click("#press")
    expect(page.locator(".field:has(#option-young) .error")).to_contain_text("--young")
    shoot(page, shots, "refused")
    page.fill("#option-young", "70GPa")
    page.set_input_files("#file", folder / "large.txt")
    expect(page.locator("#scan-error")).to_contain_text("too large")
    page.set_input_files("#file", folder / "damaged.sur")
    expect(page.locator("#scan-error")).to_contain_text("damaged.sur")
    expect(page.locator("#about")).to_contain_text("scan.txt")

    # Two runs at once, and one that is stopped.
    page.fill("#option-load", "0.001:0.3:60")
    page.click("#press")
    expect(page.locator("#press-status")).to_be_empty()
    page.click("#press")
    expect(page.locator("#runs li")).to_have_count(4)
    expect(page.locator("#runs progress")).to_have_count(2)
    shoot(page, shots, "two-runs")
    page.get_by_role("button", name="Stop").first.click()
    expect(page.locator("#runs")).to_contain_text("stopped", timeout=60000)
    expect(page.locator("#runs progress")).to_have_count(0, timeout=120000)
    expect(page.locator("#runs")).to_contain_text("contact-3: done")
    page.get_by_role("button", name="Resume").click()
    expect(page.locator("#runs")).to_contain_text("contact-4: done", timeout=120000)
    expect(page.get_by_role("button", name="Resume")).to_have_count(0)


def main() -> int:
    program = str(Path(sys.argv[1]).resolve())
    shots = Path(sys.argv[2]) if len(sys.argv) > 2 else None
    wrong: list[str] = []
    known = (os.environ.get("CHROMIUM"), *map(shutil.which, ("chromium", "chromium-browser", "google-chrome")))
    browser_program = next((found for found in known if found), None)
    flags = ["--no-sandbox", "--disable-gpu", "--disable-background-networking"]
    with tempfile.TemporaryDirectory() as name, sync_playwright() as playwright:
        folder = Path(name)
        scan(folder / "scan.txt")
        (folder / "large.txt").write_text("0.0 1.0\n" * 200_000)
        (folder / "damaged.sur").write_bytes(b"DIGITAL SURF" + bytes(range(256)) * 4)
        server, address = started(program, folder / "results")
        try:
            browser = playwright.chromium.launch(executable_path=browser_program, headless=True, args=flags)
            home = address.rsplit("/", 2)[0]
            for width, scheme in ((1280, "light"), (390, "dark")):
                context = browser.new_context(viewport={"width": width, "height": 900}, color_scheme=scheme)
                page = context.new_page()
                said: list[str] = []
                # A refusal is an answer with an error status, which the console reports, too.
                is_fault = (
                    lambda heard: heard.type == "error" and "Failed to load resource" not in heard.text
                )  # noqa: E731
                page.on("console", lambda heard: said.append(heard.text) if is_fault(heard) else None)
                page.on("pageerror", lambda error: said.append(str(error)))
                elsewhere = lambda asked: not asked.url.startswith((home, "data:", "blob:"))  # noqa: E731
                page.on("request", lambda asked: said.append(asked.url) if elsewhere(asked) else None)
                if scheme == "light":
                    used(page, address, folder, shots)
                else:
                    page.goto(address)
                    dropped = page.evaluate_handle(DROP, (folder / "scan.txt").read_text())
                    page.dispatch_event("#drop", "drop", {"dataTransfer": dropped})
                    expect(page.locator("#view-title")).to_contain_text("dropped.txt: prepared")
                    page.get_by_role("button", name="Show").last.click()
                    expect(page.locator("#view-title")).to_contain_text("pressure")
                    shoot(page, shots, "phone-dark")
                if (wide := page.evaluate(OVERFLOW)) > 1:
                    wrong.append(f"{width}, {scheme}: {wide} pixels wider than the window")
                wrong += [f"{width}, {scheme}: {told}" for told in said]
                context.close()
            browser.close()
        finally:
            server.send_signal(signal.SIGINT)
            status = server.wait(timeout=60)
        if status != 0:
            wrong.append(f"the server ends with {status}")
    print("\n".join(wrong) or "the page of gfmd serve works")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
