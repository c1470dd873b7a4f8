"""Combinations at random: every attribute of Python is the number of the program, of its JSON and of its HDF5, bit for
bit.

`GFMD_COMBINATIONS=1000 pytest -s crates/python/tests/test_combinations.py` takes so many (default: 40) and prints
counts; `GFMD_COMBINATION=N` takes the case N alone. The numbers themselves are compared with their definitions by the
test of that name of the program (docs/reliability.md, "Random combinations").
"""

import collections
import json
import math
import os
import random
import subprocess
import sys

import gfmd
import numpy as np
import pytest

h5py = pytest.importorskip("h5py")

CASES = int(os.environ.get("GFMD_COMBINATIONS", 40))
# Not numbers of the state, or of one outlet alone.
BESIDE = ("seconds", "undefined", "peak_bytes")


def draw(index, folder):
    """A problem as words of the program and as arguments of the call."""
    dice = random.Random(index)
    chance = lambda share: dice.random() < share  # noqa: E731
    is_path, is_line, is_free = chance(0.3), chance(0.15), chance(0.3)
    n = [dice.randint(8, 32), 1] if is_line else [dice.randint(4, 12), dice.randint(4, 12)]
    length = [round(dice.uniform(0.7, 1.5), 3), 1.0 if is_line else round(dice.uniform(0.7, 1.5), 3)]
    x, y = np.meshgrid(np.arange(n[0]) / n[0], np.arange(n[1]) / n[1], indexing="ij")
    heights = sum(
        0.005
        * dice.random()
        * np.cos(2 * np.pi * (dice.randint(0, 2) * x + (0 if is_line else dice.randint(0, 2)) * y) + dice.uniform(0, 6))
        for _ in range(5)
    )
    heights = heights + 0.001 * np.random.default_rng(index).random(n)
    heights = heights[:, 0] if is_line else heights
    file = folder / f"h{index}.npy"
    np.save(file, heights)
    size = length[0] if is_line else tuple(length)
    surface = gfmd.Surface(heights, size=size)
    words = [f"--surface={file}", "--size=" + (repr(length[0]) if is_line else f"{length[0]!r},{length[1]!r}")]
    body = dict(young=round(dice.uniform(0.5, 3), 3), poisson=dice.choice([0.0, 0.3, 0.49, 0.5, -0.3]))
    kind = "path" if is_path else dice.choice(["plain"] * 5 + ["all", "held", "steep", "lower"])
    if kind in ("all", "held", "steep", "lower"):
        is_free = False
    if kind == "lower" or chance(0.5):
        body["height"] = round(dice.uniform(0.3, 0.8), 3)
        if chance(0.4):
            body["layers"] = [
                (round(dice.uniform(0.5, 3), 3), dice.choice([0.0, 0.3, 0.5]), round(dice.uniform(0.1, 0.4), 3))
            ]
        base = "bonded" if kind == "lower" or is_free else dice.choice(["bonded", "sliding", "free", "half-space"])
        if base != "bonded":
            body["base"] = base
        if base == "half-space":
            body |= dict(base_young=2.0, base_poisson=0.2)
    if kind not in ("lower", "steep", "held") and chance(0.1):
        body["second_body"] = (1.5, 0.3)
    for name, value in body.items():
        flag = "--" + name.replace("_", "-")
        if name == "layers":
            words += ["--layer=" + ",".join(map(repr, layer)) for layer in value]
        elif name == "second_body":
            words.append("--second-body=" + ",".join(map(repr, value)))
        else:
            words.append(f"{flag}={value}")
    options = {}
    if is_free:
        words.append("--boundary=free")
        options["boundary"] = "free"
    has_friction = False
    if kind in ("plain", "path"):
        choice = dice.choice(
            ["wall", "wall", "exponential", "morse", "dugdale", "hardness", "field"]
            + ["friction"] * 2 * (kind == "path")
        )
        if choice in ("exponential", "morse", "dugdale"):
            gamma = round(1e-4 * dice.uniform(0.5, 2), 7)
            scale = 0.01 if n[1] > 1 else 0.005
            words += [f"--law={choice}", f"--param=gamma={gamma!r},range={scale!r}"]
            options["law"] = gfmd.law(choice, gamma=gamma, range=scale)
        elif choice == "hardness":
            words.append("--hardness=0.2")
            options["hardness"] = 0.2
        elif choice == "field":
            field = 0.1 + 0.2 * np.random.default_rng(index + 1).random(heights.shape)
            np.save(folder / f"p{index}.npy", field)
            words.append(f"--hardness={folder / f'p{index}.npy'}")
            options["hardness"] = field
        elif choice == "friction":
            words.append("--friction=0.3")
            options["friction"] = 0.3
            has_friction = True
    if kind in ("all", "held"):
        words.append(f"--components={kind}")
        options["components"] = kind
    if kind == "steep":
        words.append("--finite-slope")
        options["finite_slope"] = True
    if kind == "lower":
        lower = 0.7 * np.roll(heights, 2, axis=0)
        np.save(folder / f"l{index}.npy", lower)
        words.append(f"--lower-surface={folder / f'l{index}.npy'}")
        options["lower_surface"] = gfmd.Surface(lower, size=size)
    tolerance = 1e-6 if kind == "all" or has_friction else 1e-8
    if tolerance != 1e-8:
        words.append("--tolerance=1e-6")
        options["tolerance"] = 1e-6
    is_floating = (
        is_free and is_line and body.get("base", "bonded" if "height" in body else None) in (None, "half-space")
    )
    control = dice.choice(
        ["pressure", "p-star"] if kind == "all" or is_floating else ["pressure", "p-star", "approach"]
    )
    count = dice.randint(2, 3) if is_path else dice.randint(1, 3)
    scale = {"pressure": 0.02, "p-star": 0.3, "approach": 0.003}[control]
    loads = [round(scale * dice.uniform(0.1, 1), 6) for _ in range(count)]
    words.append(f"--{control}=" + ",".join(map(repr, loads)))
    options[control.replace("-", "_")] = loads
    if is_path:
        words.append("--steps=2")
        options["steps"] = 2
        if has_friction:
            sideways = [0.0] + [round(dice.uniform(-0.002, 0.002), 6) for _ in loads[1:]]
            words.append("--lateral=" + ",".join(map(repr, sideways)))
            options["lateral"] = sideways
    return ("path" if is_path else "contact"), words, surface, body, options


def program(*words):
    """Status, JSON and message of the program of this package, in a process of its own."""
    named = os.environ.get("GFMD_PROGRAM")
    start = [named] if named else [sys.executable, "-c", "from gfmd._program import main; main()"]
    done = subprocess.run([*start, *words, "--json", "--quiet"], capture_output=True, text=True)
    return done.returncode, json.loads(done.stdout) if done.stdout else None, done.stderr


def equal(found, wanted, where):
    """The same bits; null is NaN."""
    if isinstance(wanted, dict):
        for key in set(wanted) - set(BESIDE):
            equal(found[key], wanted[key], f"{where}.{key}")
        return
    found = math.nan if found is None else found
    wanted = math.nan if wanted is None else wanted
    assert np.shape(found) == np.shape(wanted), where
    assert np.array_equal(np.asarray(found, float), np.asarray(wanted, float), equal_nan=True), (where, found, wanted)


def compare_contacts(found, report, file, folder):
    loads = report["loads"]
    assert len(found) == len(loads)
    for contact, load in zip(found, loads):
        equal(contact, load, "load")
        assert set(contact) - set(BESIDE) == set(load) - set(BESIDE)
    found.save(folder / "saved.h5")
    table = found.to_xarray()
    with h5py.File(file) as made, h5py.File(folder / "saved.h5") as saved:
        for group in ("loads", "fields"):
            names = set(made[group]) - {"seconds"}
            assert names == set(saved[group]) - {"seconds"}, group
            for name in names:
                equal(saved[group][name][...], made[group][name][...], f"{group}/{name}")
        for name, values in made["fields"].items():
            if values.ndim == 3:
                equal(getattr(found, name), values[...], name)
                equal(table[name].transpose("load", "x", "y").values, values[...], f"{name} of xarray")
        for key in set(loads[0]) - set(BESIDE):
            if not isinstance(loads[0][key], (dict, list)):
                equal(
                    table[key].values,
                    [math.nan if load[key] is None else load[key] for load in loads],
                    f"{key} of xarray",
                )
                stored = made["loads"][key][...]
                equal(
                    np.where(np.isfinite(stored), stored, math.nan),
                    [math.nan if load[key] is None else load[key] for load in loads],
                    f"{key} of HDF5",
                )
    read = gfmd.load(file)
    for contact, written in zip(found, [read] if isinstance(read, gfmd.Contact) else read):
        equal(written, {key: value for key, value in contact.items() if not isinstance(value, gfmd.Record)}, "read")


def compare_path(found, report, file):
    for index, step in enumerate(report["steps"]):
        step |= {f"residual_{part}": value for part, value in step.pop("residual").items()}
        assert set(step) - set(BESIDE) == set(found.steps) - set(BESIDE)
        for key in set(step) - set(BESIDE):
            equal(found.steps[key][index], step[key], f"step {index}: {key}")
    for key in (
        "dissipated",
        "dissipated_error",
        "extra_solves",
        "lowest_mean_pressure",
        "direction",
        "e_star",
        "rms_gradient",
        "rms_height",
    ):
        equal(found[key], report[key], key)
    assert found.parted_at == report["parted_at"]
    with h5py.File(file) as made:
        for name, values in made["fields"].items():
            if values.ndim == 3:
                equal(found[name], values[...], name)
        for name, values in made["path"].items():
            if name in found.steps and name not in BESIDE and values.ndim == 1:
                equal(found.steps[name], values[: len(report["steps"])], f"path/{name}")


def test_python_has_the_numbers_of_the_program(tmp_path):
    alone = os.environ.get("GFMD_COMBINATION")
    ends, bad = collections.Counter(), []
    for index in range(CASES) if alone is None else [int(alone)]:
        command, words, surface, given, options = draw(index, tmp_path)
        file = tmp_path / f"c{index}.h5"
        status, report, reported = program(command, *words, "--threads=1", f"--out={file}")
        try:
            try:
                body = gfmd.Body(**given)
                call = gfmd.path if command == "path" else gfmd.contacts
                found, raised = call(surface, body, threads=1, **options), None
            except gfmd.Error as error:
                found, raised = None, error
            if status == 0:
                assert raised is None, f"Python: {raised}"
                (
                    compare_path(found, report, file)
                    if command == "path"
                    else compare_contacts(found, report, file, tmp_path)
                )
            elif status == 2:
                assert isinstance(raised, gfmd.InputError), f"Python: {raised!r}; the program refuses: {reported}"
            else:
                assert status == 1 and isinstance(
                    raised, gfmd.NotConverged
                ), f"Python: {raised!r}; the program: {reported}"
            ends["solved" if status == 0 else "refused" if status == 2 else "not converged"] += 1
        except (AssertionError, AttributeError, KeyError) as error:
            bad.append(f"GFMD_COMBINATION={index}: {command} {' '.join(words)}\n    {type(error).__name__}: {error}")
    print(f"\n{sum(ends.values()) + len(bad)} combinations: {dict(ends)}, {len(bad)} bad")
    assert not bad, "\n".join(bad)
    if alone is None:
        assert ends["solved"] >= 0.7 * CASES, ends
