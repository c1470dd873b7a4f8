"""The installed package: beside h5py in one process, without a library of HDF5 of its own, with the program."""

import os
import re
import shutil
import signal
import subprocess
import sys
import sysconfig
import time
import zipfile
from pathlib import Path

import gfmd
import pytest

WHEEL = os.environ.get("GFMD_WHEEL")
needs_wheel = pytest.mark.skipif(WHEEL is None, reason=".ci/wheel names the wheel")


def python(code, **options):
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120, **options)
    assert done.returncode == 0, done.stderr
    return done.stdout


BESIDE = """
import {first}
import {second}
import numpy as np, os
contact = gfmd.contact(gfmd.self_affine(n=32), gfmd.Body(), p_star=0.05)
with h5py.File("own.h5", "w") as own:                       # both libraries have a file open
    own.create_dataset("h", data=contact.surface.heights, compression="gzip", track_order=True)
    contact.save("c.h5")
    own["after"] = contact.pressure
assert np.array_equal(gfmd.read("own.h5:/h").heights, contact.surface.heights)
with h5py.File("c.h5") as read:
    assert np.array_equal(read["fields/pressure"][0], contact.pressure)
    assert list(read["fields/pressure"].dims[1].keys()) == ["x"] and "config" in read.attrs
    again = gfmd.load("c.h5")
    assert np.array_equal(again.gap, read["fields/gap"][0])
for _ in range(3):
    try:
        gfmd.load("nothing.h5")
    except gfmd.InputError as error:
        assert "nothing.h5" in str(error)
    try:
        h5py.File("nothing.h5")
    except OSError:
        pass
print(h5py.version.hdf5_version, contact.area_fraction)
maps = open("/proc/self/maps").read() if os.path.exists("/proc/self/maps") else ""
print(sorted({{line.split()[-1] for line in maps.splitlines() if "hdf5" in line.lower()}}))
"""


@pytest.mark.parametrize("first, second", [("h5py", "gfmd"), ("gfmd", "h5py")])
def test_it_lives_beside_h5py(first, second, tmp_path):
    pytest.importorskip("h5py")
    reported = python(BESIDE.format(first=first, second=second), cwd=tmp_path)
    libraries = re.findall(r"'([^']+)'", reported.splitlines()[-1])
    if WHEEL:
        assert all("h5py" in library for library in libraries), libraries


@needs_wheel
def test_the_wheel_brings_its_hdf5_and_shows_nothing_of_it(tmp_path):
    code = (
        "import gfmd\nc = gfmd.contact(gfmd.self_affine(n=16), gfmd.Body(), p_star=0.1)\nc.save('c.h5')\nassert"
        " gfmd.load('c.h5').p_star > 0\nprint(open('/proc/self/maps').read())"
    )
    if Path("/proc/self/maps").exists():
        assert "hdf5" not in python(code, cwd=tmp_path).lower()
    with zipfile.ZipFile(WHEEL) as wheel:
        names = wheel.namelist()
        (native,) = (name for name in names if name.startswith("gfmd/_gfmd.") and not name.endswith(".pyi"))
        wheel.extract(native, tmp_path)
        assert "gfmd/py.typed" in names and "gfmd/_gfmd.pyi" in names
        assert not any(".libs/" in name for name in names)
        licences = [name for name in names if "/licenses/" in name]
        assert any("HDF5" in name for name in licences) and any("MIT" in name for name in licences), names
    if sys.platform == "linux" and shutil.which("nm"):
        shown = subprocess.run(
            ["nm", "-D", "--defined-only", tmp_path / native], capture_output=True, text=True, check=True
        ).stdout
        assert [line.split()[-1] for line in shown.splitlines()] == ["PyInit__gfmd"]
        needed = subprocess.run(["ldd", tmp_path / native], capture_output=True, text=True, check=True).stdout
        assert not re.search("hdf5|libz|stdc", needed), needed


def program():
    name = Path(sysconfig.get_path("scripts")) / ("gfmd.exe" if sys.platform == "win32" else "gfmd")
    assert name.exists()
    return str(name)


def test_the_program_is_installed(tmp_path):
    done = subprocess.run([program(), "--version"], capture_output=True, text=True)
    assert done.returncode == 0 and done.stdout.split() == ["gfmd", gfmd.__version__]
    done = subprocess.run([program(), "contact", "--n=16", "--p-star=-1"], capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 2 and done.stdout == "" and done.stderr.startswith("error: --p-star is -1;")
    done = subprocess.run(
        [program(), "contact", "--n=32", "--p-star=0.1", "--out=c.h5", "--plots=c"],
        capture_output=True,
        text=True,
        cwd=tmp_path,
    )
    assert done.returncode == 0, done.stderr
    assert (
        gfmd.load(tmp_path / "c.h5").area_fraction
        == gfmd.contact(gfmd.self_affine(n=32), gfmd.Body(), p_star=0.1).area_fraction
    )
    assert (tmp_path / "c-map.png").stat().st_size > 1000


@pytest.mark.skipif(sys.platform == "win32", reason="no such signals")
def test_ctrl_c_ends_the_program_with_its_state_saved(tmp_path):
    words = [
        "contact",
        "--n=64",
        "--p-star=0.02",
        "--solver=verlet-critical",
        "--tolerance=1e-15",
        "--max-iterations=1000000000",
        "--out=c.h5",
    ]
    # A shell in the background has the signal ignored.
    start = (
        f"import os, signal; signal.signal(signal.SIGINT, signal.SIG_DFL); os.execv({program()!r},"
        f" {['gfmd', *words]!r})"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", start], cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    try:
        while not (tmp_path / "c.h5.part").exists():
            assert process.poll() is None
            time.sleep(0.02)
        time.sleep(0.2)
        process.send_signal(signal.SIGINT)
        _, reported = process.communicate(timeout=60)
    finally:
        process.kill()
    assert process.returncode == 130 and "interrupted" in reported, reported
    assert any((tmp_path / f"c.h5.{kind}").exists() for kind in ("checkpoint", "state"))
