"""The lines of Python that the page of `gfmd serve` prints repeat its result, bit for bit."""

import json
import os
import signal
import subprocess
import sys
import time
import urllib.request
import warnings

import gfmd
import numpy as np
import pytest

START = [sys.executable, "-c", "from gfmd._program import main; main()"]

USUAL = {"size": "100um", "unit": "m", "young": "70GPa", "fill": "harmonic", "detrend": "plane"}
PREPARED = {
    "crop": "5um:,:90um",
    "despike": True,
    "level": "rows:median",
    "detrend": "quadratic",
    "filter": "s:10um,kind=gaussian",
    "periodise": "mirror",
    "flip": True,
    "poisson": "0.3",
    "height": "20um",
    "pressure": "50MPa",
}


@pytest.fixture
def page(tmp_path):
    """Address of a page, whose server ends with the test as Ctrl-C ends it."""
    words = ["serve", "--json", "--folder", str(tmp_path / "results")]
    named = os.environ.get("GFMD_PROGRAM")
    server = subprocess.Popen(
        [*([named] if named else START), *words], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
    )
    yield json.loads(server.stdout.readline())["address"]
    server.send_signal(signal.SIGINT)
    assert server.wait(60) == 0


def asked(address: str, body: bytes | None = None, **headers: str):
    request = urllib.request.Request(address, body, {name.replace("_", "-"): value for name, value in headers.items()})
    with urllib.request.urlopen(request, timeout=60) as answer:
        return json.loads(answer.read())


@pytest.mark.skipif(os.name == "nt", reason="Windows has no SIGINT for another process")
@pytest.mark.parametrize("options", [{"p_star": "0.02, 0.05", "boundary": "free"}, PREPARED])
def test_lines_of_python_repeat_a_result_of_the_page(options, page, tmp_path):
    x = 2 * np.pi * np.arange(48) / 48
    heights = 1e-7 * (np.sin(2 * x)[:, None] * np.cos(3 * x + 1) + 0.3 * np.sin(5 * x[:, None] + 4 * x))
    heights[3:6, 7] = np.nan
    np.savetxt(tmp_path / "scan.txt", heights.T)
    sent = (tmp_path / "scan.txt").read_bytes()
    scan = asked(page + "upload", sent, Content_Type="application/octet-stream", X_Name="scan.txt")["scan"]
    body = json.dumps({"scan": scan, "options": {**USUAL, **options}}).encode()
    run = asked(page + "run", body, Content_Type="application/json")["run"]
    until = time.monotonic() + 120
    while (about := asked(f"{page}run/{run}"))["state"]["phase"] in ("waiting", "running"):
        assert time.monotonic() < until, about
        time.sleep(0.05)
    assert about["state"]["phase"] == "done", about
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        exec(about["python"], {})  # the lines are what is tested
    folder = tmp_path / "results"
    stem = about["state"]["name"]
    of_page, of_python = (gfmd.load(folder / f"{stem}{end}.h5") for end in ("", "-python"))
    for name in ("pressure", "gap", "displacement_z"):
        pairs = zip(of_page, of_python) if isinstance(of_page, gfmd.Contacts) else [(of_page, of_python)]
        for one, other in pairs:
            assert np.array_equal(getattr(one, name), getattr(other, name)), name
