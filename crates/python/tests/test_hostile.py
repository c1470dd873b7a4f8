"""Surroundings that work against a call: outputs named like inputs, broken generators, no room, a closed stderr."""

import subprocess
import sys
from pathlib import Path
from typing import Iterator

import numpy as np
import pytest

import gfmd

ROUGH = gfmd.self_affine(n=16, seed=1)
BODY = gfmd.Body()


def test_no_output_replaces_the_file_that_the_surface_was_read_from(tmp_path: Path) -> None:
    scan, link = tmp_path / "scan.npy", tmp_path / "link.npy"
    np.save(scan, ROUGH.heights)
    link.symlink_to(scan)
    before = scan.read_bytes()
    surface = gfmd.read(str(link))
    calls = (
        lambda: gfmd.path(surface, BODY, p_star=[0.05], steps=1, out=scan),
        lambda: gfmd.wear(surface, BODY, p_star=[0.05], coefficient=1.0, distance=[1.0], steps=1, out=scan),
        lambda: gfmd.contact(surface, BODY, p_star=0.05).save(scan),
        lambda: gfmd.contact(surface.detrend(), BODY, p_star=0.05).save(scan),
    )
    for call in calls:
        with pytest.raises(gfmd.InputError, match="it must be another file than the input of the surface"):
            call()
        assert scan.read_bytes() == before
    gfmd.contact(surface, BODY, p_star=0.05).save(tmp_path / "c.h5")


def test_contacts_before_an_exception_of_the_generator_come() -> None:
    def surfaces() -> Iterator[gfmd.Surface]:
        yield ROUGH
        yield ROUGH
        raise RuntimeError("no third one")

    found = gfmd.many(surfaces(), BODY, p_star=0.05, workers=4)
    assert next(found).converged and next(found).converged
    with pytest.raises(RuntimeError, match="no third one"):
        next(found)


def test_arrays_of_results_cannot_be_written() -> None:
    contacts = gfmd.contact(ROUGH, BODY, p_star=[0.02, 0.05])
    below = gfmd.green(gfmd.Body(young=1.0, poisson=0.3, height=1.0), qx=3.0, depth=0.1)
    arrays = {
        "pressure": contacts.pressure,
        "area_fraction": contacts.area_fraction,
        "approach": contacts.approach,
        "touching": contacts[0].touching,
        **{f"green {name}": value for name, value in below.items() if isinstance(value, np.ndarray)},
    }
    for name, array in arrays.items():
        assert not array.flags.writeable, name


def test_fields_below_that_need_more_than_the_memory_are_refused() -> None:
    contact = gfmd.contact(gfmd.self_affine(n=128, seed=1), gfmd.Body(young=1.0), p_star=0.05)
    with pytest.raises(gfmd.InputError, match="GiB"):
        contact.interior(levels=100_000, deepest=1.0)


@pytest.mark.parametrize("closing", ["sys.stderr.close()", "os.close(2)", "os.dup2(os.open('/dev/full', 1), 2)"])
def test_a_stderr_that_cannot_be_written_ends_no_run(closing: str) -> None:
    if "full" in closing and not Path("/dev/full").exists():
        pytest.skip("no full device")
    script = f"""
import os, sys
import gfmd, gfmd._progress
gfmd._progress._PATIENCE = 0.0
{closing}
c = gfmd.contact(gfmd.self_affine(n=64, seed=1), gfmd.Body(), p_star=[0.02, 0.05])
print(c[1].area_fraction)
sys.stdout.flush()
os._exit(0)
"""
    done = subprocess.run([sys.executable, "-c", script], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    assert done.returncode == 0 and 0.0 < float(done.stdout) < 1.0


@pytest.mark.parametrize("name", ["\0", "a\0b.json", "a\0b.h5"])
def test_a_name_with_a_zero_byte_is_refused(name: str) -> None:
    for function in (gfmd.load, gfmd.read):
        with pytest.raises(gfmd.InputError, match="NUL"):
            function(name)


def test_masked_entries_are_no_numbers() -> None:
    def masked(values: object, place: int) -> object:
        array = np.ma.array(values, dtype=float)
        array[place] = np.ma.masked
        return array

    flat = np.zeros((16, 16))
    calls = (
        lambda: gfmd.path(ROUGH, BODY, p_star=0.05, friction=0.3, lateral=masked([0, 1e-3, 2e-3], 2), steps=1),
        lambda: gfmd.path(ROUGH, gfmd.Body(prony=[(1.0, 0.5)]), p_star=0.05, time=masked([0, 1, 2], 2), steps=1),
        lambda: gfmd.path(ROUGH, BODY, p_star=0.05, friction=np.ma.masked, lateral=1e-3, steps=1),
        lambda: gfmd.Body(poisson=np.ma.masked),
        lambda: gfmd.contact(ROUGH, BODY, p_star=0.05, hardness=masked(flat + 1, 3)),
        lambda: gfmd.contact(ROUGH, gfmd.Body(height=0.2), p_star=0.05, base_displacement=masked(flat, 3)),
        lambda: gfmd.contacts(ROUGH, BODY, p_star=masked([0.05, 0.1], 1)),
    )
    for call in calls:
        with pytest.raises(gfmd.InputError, match="masked of [0-9]+ entries; every entry must be a number"):
            call()


def test_numbers_of_steps_and_states_cannot_be_changed() -> None:
    p = gfmd.path(ROUGH, BODY, p_star=[0.05], steps=2)
    slide = gfmd.slide(ROUGH, gfmd.Body(prony=[(1.0, 0.5)]), p_star=0.05, velocity=[1.0])
    for array in (p.steps.mean_pressure, p.steps.area_fraction, slide.states.friction):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 7.0
