"""Every public name is documented, with units, errors and an example that runs; the types agree with the code."""

import ast
import builtins
import doctest
import inspect
import re
import subprocess
import sys
from pathlib import Path

import gfmd
import numpy as np
import pytest
from gfmd._columns import LowerFace, Patches, States, Steps
from gfmd._given import TABLES
from gfmd._options import ContactOptions, PathOptions, SlideOptions
from gfmd._options_inside import (
    EstimateOptions,
    GreenOptions,
    InteriorOptions,
    PronyOptions,
    PunchOptions,
    StudyOptions,
    SweepOptions,
)

FOLDER = Path(__file__).parents[1]
ERRORS = (gfmd.Error, gfmd.Interrupted)


def public():
    """Names and objects: functions, classes, and the methods and properties that they define."""
    for name in gfmd.__all__:
        thing = getattr(gfmd, name)
        if isinstance(thing, str):
            continue
        yield name, thing
        if isinstance(thing, type):
            own = ((key, value) for key, value in vars(thing).items() if not key.startswith("_"))
            yield from ((f"{name}.{key}", value) for key, value in own if not isinstance(value, str))


NAMES = dict(public())
CALLED = {name: thing for name, thing in NAMES.items() if inspect.isfunction(thing)}
RESULTS = {name: thing for name, thing in NAMES.items() if isinstance(thing, type) and issubclass(thing, gfmd.Record)}


@pytest.fixture(scope="module")
def words(tmp_path_factory):
    """The names that the examples use."""
    surface = gfmd.self_affine(n=64)
    contacts = gfmd.contacts(surface, gfmd.Body(), p_star=[0.01, 0.05])
    law = gfmd.law("exponential", gamma=1e-4, range=1.2e-3)
    return {
        "gfmd": gfmd,
        "np": np,
        "s": surface,
        "c": contacts[1],
        "cs": contacts,
        "punch": gfmd.punch(n=32),
        "sliding": gfmd.slide(
            gfmd.self_affine(n=16), gfmd.Body(prony=[(0.1, 0.3)]), velocity=[0.01, 1.0], p_star=[0.02, 0.05]
        ),
        "loop": gfmd.path(
            gfmd.self_affine(n=32, eps_f_inv=4), gfmd.Body(), law=law, approach=[-0.004, 0.004, -0.007], steps=4
        ),
        "k": gfmd.kappa_sweep(
            {"points": {"eps_t_inv": [1, 2], "eps_f_inv": [4, 8], "eps_c_inv": [2, 4], "centre": [1, 4, 2]}}
        ),
        "many": gfmd.study(
            {
                "command": "contact",
                "contact": {"n": 32, "eps_f_inv": 4, "p_star": [0.02, 0.1]},
                "study": {"seed": "1:3"},
            }
        ),
    }


def test_there_is_something_to_document():
    assert len(CALLED) > 30 and len(RESULTS) > 8


@pytest.mark.parametrize("name", NAMES)
def test_it_is_documented(name):
    text = inspect.getdoc(NAMES[name])
    assert text and text[0].isupper() and text.splitlines()[0].endswith("."), text
    if not (isinstance(NAMES[name], property) or isinstance(NAMES[name], type) and issubclass(NAMES[name], ERRORS)):
        assert ">>> " in text, "an example"
    if isinstance(NAMES[name], property):
        assert any(
            word in text
            for word in (
                "[x, y]",
                "length",
                "stress",
                "without unit",
                "points",
                "unit",
                "origin",
                "of the file",
                "in the file",
                "by name",
            )
        ), "shape or unit"


@pytest.mark.parametrize("name", CALLED)
def test_arguments_and_errors_are_documented(name):
    text, parameters = inspect.getdoc(CALLED[name]), [
        key for key in inspect.signature(CALLED[name]).parameters if key != "self"
    ]
    reported = text.split("Args:")[1].split("Raises:")[0] if "Args:" in text else ""
    for key in parameters:
        assert f"{key}:" in reported or f"{key}," in reported or f"`{key}`" in reported, key
    if parameters:
        assert "Raises:" in text


@pytest.mark.parametrize("name", NAMES)
def test_the_example_runs(name, words, tmp_path, monkeypatch):
    pytest.importorskip("matplotlib")
    pytest.importorskip("xarray")
    monkeypatch.chdir(tmp_path)
    text = inspect.getdoc(NAMES[name])
    test = doctest.DocTestParser().get_doctest(text, dict(words), name, None, None)
    runner = doctest.DocTestRunner(verbose=False, optionflags=doctest.ELLIPSIS)
    heard = []
    runner.run(test, out=heard.append)
    assert not heard, "".join(heard)


def test_the_module_and_the_page_of_the_package_run(words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    runner = doctest.DocTestRunner(verbose=False)
    runner.run(doctest.DocTestParser().get_doctest(gfmd.__doc__, {}, "gfmd", None, None))
    assert runner.summarize(verbose=False).failed == 0
    pytest.importorskip("matplotlib")
    for page in (FOLDER / "README.md", FOLDER.parents[1] / "docs" / "python.md"):
        blocks = page.read_text(encoding="utf-8").split("```python\n")[1:]
        assert blocks, page
        for block in blocks:
            exec(block.split("```")[0], {})


def test_results_have_the_attributes_that_are_documented(words):
    adhesive = gfmd.contact(words["s"], gfmd.Body(), approach=0.001, law=gfmd.law("morse", gamma=1e-4, range=5e-3))
    rubbed = gfmd.friction(
        gfmd.self_affine(n=16), gfmd.Body(), coefficient=0.3, p_star=0.05, lateral=[0, 0.001], steps=1
    )
    indented = gfmd.path(gfmd.self_affine(n=16), gfmd.Body(), p_star=[0.1], hardness=0.05, steps=1)
    steep = gfmd.contact(gfmd.self_affine(n=16), gfmd.Body(), p_star=0.05, finite_slope=True)
    squeezed = gfmd.contact(
        gfmd.self_affine(n=16), gfmd.Body(height=0.5), p_star=0.05, lower_surface=np.zeros((16, 16))
    )
    flat = gfmd.Surface(np.zeros((4, 4))).statistics()
    filtered = gfmd.self_affine(n=256, dim=2, eps_f_inv=16, seed=5).filter(l=0.2, edges="periodic")
    slab = gfmd.self_affine(n=16)
    rubber = gfmd.Body(prony=[(0.1, 0.3)])
    creeping = gfmd.path(
        slab,
        rubber,
        p_star=0.05,
        time=[0, 1],
        steps=1,
        statistics=True,
        conductivity=[1.0, 2.0],
        flow=True,
        grid_error="refine",
        viscosity=1e-3,
        pressure_drop=1e5,
        gas_conductivity=0.026,
        gas_jump=1e-3,
    )
    pulled = gfmd.path(slab, gfmd.Body(), approach=[0.001, 0.002], hardness=0.05, steps=1)
    patch = gfmd.path(slab, gfmd.Body(), p_star=0.01, boundary="free", steps=1)
    law = gfmd.law("exponential", gamma=1e-4, range=5e-3)
    measured = gfmd.path(slab, gfmd.Body(), p_star=0.05, law=law, statistics=True)
    sticking = gfmd.path(slab, gfmd.Body(), approach=0.001, lateral=0.001, law=law, steps=1)
    worn = gfmd.wear(slab, gfmd.Body(), coefficient=1.0, distance=[0, 0.1], approach=0.005, steps=1, flow=True)
    parts = dict(law=law, friction=0.3, hardness=0.05, wear=gfmd.Wear(1.0), p_star=0.05, lateral=[0, 0.001])
    composed = gfmd.path(slab, rubber, time=[0, 1], distance=[0, 0.1], steps=1, **parts)
    flattened = gfmd.contact(words["s"], gfmd.Body(height=0.5), p_star=0.05, lower_surface=words["s"], hardness=0.1)
    steel = gfmd.Body(yield_stress=0.01, hardening=0.02, kinematic_hardening=0.01)
    curve = gfmd.Body(yield_stress=0.01, hardening_curve=[(0.0, 0.01), (0.1, 0.02)])
    dented = [gfmd.path(slab, metal, p_star=0.05, steps=1, kept_strain="waypoints") for metal in (steel, curve)]
    plate = gfmd.Body(height=0.5, prony=[(0.1, 0.3)])
    two_faces = dict(lower_surface=slab, hardness=0.05, wear=gfmd.Wear(1.0), time=[0, 1], distance=[0, 0.1])
    between = gfmd.path(slab, plate, p_star=0.05, steps=1, **two_faces)
    warm = dict(velocity=1.0, p_star=0.05, heat=(1.0, 0.01, 0.2, 0.1), friction=0.3)
    refined = gfmd.slide(slab, rubber, velocity=1.0, p_star=0.05, hardness=0.05, grid_error="refine")
    sliding = [gfmd.slide(slab, rubber, **warm), gfmd.slide(slab, gfmd.Body(), **warm), refined]
    curves = dict(frequency=[1.0, 10.0, 100.0], storage=[2.0, 2.5, 3.0], loss=[0.1, 0.5, 0.1], branches=1)
    series = gfmd.prony(**curves, temperature=[20.0] * 3, wlf=(17.0, 51.0, 20.0), stress_unit="MPa")
    rough = gfmd.self_affine(n=64, unit="um")
    known = gfmd.estimate(rough, gfmd.Body(young="1 GPa"), p_star=[0.1, 5.0], hardness="1 GPa", stress_unit="MPa")
    examples = [
        (gfmd.Estimate, [known]),
        (
            gfmd.Contact,
            [
                words["c"],
                adhesive,
                gfmd.contact(words["s"], gfmd.Body(), p_star=0.05, boundary="free"),
                gfmd.contact(words["s"], gfmd.Body(), p_star=0.05, hardness=0.1, law=law),
                steep,
                squeezed,
                flattened,
            ],
        ),
        (gfmd.Path, [words["loop"], rubbed, indented, composed, between, measured, *dented]),
        (gfmd.Adhesion, [adhesive.adhesion()]),
        (gfmd.Flow, [words["c"].flow()]),
        (
            Steps,
            [
                result.steps
                for result in (
                    *(words["loop"], rubbed, indented, creeping, pulled, patch, sticking),
                    *(worn, composed, between, *dented),
                )
            ],
        ),
        (States, [[key for key in result.states if not key.startswith("residual_")] for result in sliding]),
        (LowerFace, [squeezed.lower, flattened.lower]),
        (Patches, [words["c"].patches()]),
        (gfmd.Punch, [words["punch"], gfmd.punch(n=16, refine=2)]),
        (gfmd.FieldsBelow, [words["punch"].interior(depths=[0.1])]),
        (gfmd.Green, [gfmd.green(gfmd.Body(), qx=1.0, depth=0.1)]),
        (gfmd.KappaSweep, [words["k"]]),
        (gfmd.Study, [words["many"]]),
        (gfmd.Statistics, [words["s"].statistics(features=True), flat, filtered.statistics()]),
        (gfmd.Body, [gfmd.Body(), curve, gfmd.Body(material="aluminium", second_material="peek")]),
        (gfmd.PronyFit, [series]),
        (
            gfmd.Residual,
            [
                words["c"].residual,
                gfmd.contact(words["s"], gfmd.Body(), p_star=0.05, hardness=0.1).residual,
                gfmd.contact(gfmd.self_affine(n=16), gfmd.Body(), p_star=0.05, components="all").residual,
                steep.residual,
            ],
        ),
    ]
    for kind, results in examples:
        typed = {key for key in kind.__annotations__ if not key.startswith("_")} | set(kind._declared())
        found = {key for result in results for key in result} | {
            key for key in typed if all(hasattr(result, key) for result in results)
        }
        extra = {"refinement"} if kind is gfmd.Punch else set()
        assert found == typed | extra, (kind, found ^ typed)
        text = inspect.getdoc(kind)
        for key in found - set(kind._declared()):
            assert any(f"{key}{end}" in text for end in (":", ",", "`", " ", ".")), (kind, key)
        for key in kind._declared():
            own = inspect.getdoc(getattr(kind, key))
            assert own and own[0].isupper() and own.endswith("."), (kind, key)


def checked(*words):
    done = subprocess.run([sys.executable, "-m", *words], capture_output=True, text=True, cwd=FOLDER)
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_package_and_the_examples_are_typed():
    pytest.importorskip("mypy")
    words = ["--strict", "--ignore-missing-imports", "--allow-untyped-calls"]
    checked("mypy", *words, FOLDER / "python" / "gfmd", *sorted((FOLDER / "examples").glob("*.py")))


# Calls with an argument that does not exist, or of a wrong type, and good ones.
CALLS = """
import gfmd
import numpy as np

surface, body = gfmd.self_affine(n=16), gfmd.Body()
gfmd.contact(surface, body, p_star=0.1, tolerence=1e-8)  # wrong
gfmd.contact(surface, body, p_star=0.1, boundary="open")  # wrong
gfmd.contacts(surface, body, p_star=[0.1], max_iterations="many")  # wrong
gfmd.many([surface], body, p_star=0.1, worker=2)  # wrong
gfmd.friction(surface, body, coefficient=0.3, p_star=0.1, step=2)  # wrong
contact = gfmd.contact(surface, body, p_star=0.1, tolerance=1e-8, law=None, base_traction=np.zeros((16, 16)), dt=0.5)
contact.interior(depth=0.1)  # wrong
contact.interior(levels=3, deepest="1 um", quantities=["stress"])
gfmd.punch(body).interior([0.1], threads=1)
gfmd.contacts(surface, body, pressure=["1 MPa", 2.0], hardness="1 GPa", damping=[1.0, 1.0, 0.9], start=contact)
gfmd.many([surface], body, p_star=[0.1, 0.2], accuracy="1%", workers=2)
gfmd.friction(surface, body, coefficient=0.3, p_star=0.1, steps=2, energy_solves=None, out="a.h5")
gfmd.path(surface, body, p_star=0.1, friction=0.3, wear=gfmd.Wear(1.0, by="time"))  # wrong
gfmd.path(surface, body, p_star=0.1, wear=1.0, distance=1.0)  # wrong
gfmd.friction(surface, body, coefficient=0.3, p_star=0.1, wear=gfmd.Wear("1e-15/Pa", by="slip"), law="morse")
gfmd.path(surface, body, p_star=0.1, friction=0.3, lateral=([0, 1], [0, 1]), friction_of="net")
gfmd.contact(surface, body, p_star=0.1, lower_seed=2)  # wrong
gfmd.path(surface, body, p_star=0.1, step=2)  # wrong
gfmd.slide(surface, body, velocity=1.0, p_star=0.1, grid_errors="refine")  # wrong
gfmd.slide(surface, body, velocity=1.0, p_star=0.1, heat=("0.2W/(m K)", "1e-7m^2/s"), friction=0.3, tolerance=None)
gfmd.punch(body, contact="glued")  # wrong
gfmd.punch(body, mask=np.ones((4, 4)), shift=(0.001, 0.0), history_modes=[(1, 0, "x")])
gfmd.interior(contact, [0.1], quantities=["heat"])  # wrong
gfmd.slide(surface, body, velocity=1.0, p_star=0.1, grid_error="estimate")  # wrong
gfmd.green(body, qx=1.0, qz=2.0)  # wrong
gfmd.green(body, qx=1.0, qy=2.0, dim=3, depth=0.1)
gfmd.prony("dma.csv", branch=2)  # wrong
gfmd.prony(frequency=np.ones(3), storage=np.ones(3), loss=np.ones(3), times=np.ones(1), wlf=(8.86, 101.6, 300.0))
gfmd.kappa_sweep("smoke", resum=True)  # wrong
gfmd.kappa_sweep({"points": {}}, out="k.h5", resume=True, threads=2)
gfmd.study("study.toml", threads="all")  # wrong
gfmd.study("study.toml", out=None, progress=False)
"""


def test_the_types_know_the_options(tmp_path):
    pytest.importorskip("mypy")
    (tmp_path / "calls.py").write_text(CALLS, encoding="utf-8")
    words = ["--strict", "--ignore-missing-imports", "--no-error-summary", tmp_path / "calls.py"]
    done = subprocess.run([sys.executable, "-m", "mypy", *words], capture_output=True, text=True, cwd=FOLDER / "python")
    found = {int(line.split(":")[1]) for line in done.stdout.splitlines() if ": error: " in line}
    wrong = {number for number, line in enumerate(CALLS.splitlines(), 1) if line.endswith("# wrong")}
    assert found == wrong, done.stdout + done.stderr


LOADS = {"pressure", "p_star", "force", "approach"}
# Functions with their options, and the arguments that are none.
TAKING = {
    gfmd.contact: (ContactOptions, LOADS),
    gfmd.path: (PathOptions, LOADS | {"lateral", "distance", "friction", "shear_strength", "wear"}),
    gfmd.slide: (SlideOptions, LOADS | {"velocity"}),
    gfmd.interior: (InteriorOptions, set()),
    gfmd.punch: (PunchOptions, set()),
    gfmd.green: (GreenOptions, {"qx"}),
    gfmd.kappa_sweep: (SweepOptions, set()),
    gfmd.estimate: (EstimateOptions, LOADS - {"approach"}),
    gfmd.prony: (PronyOptions, {"frequency", "storage", "loss", "temperature", "log_a_t"}),
    gfmd.study: (StudyOptions, {"progress"}),
}


@pytest.mark.parametrize("function", TAKING, ids=lambda function: function.__name__)
def test_a_signature_has_the_options_of_the_table(function):
    options, others = TAKING[function]
    own = {
        name: of
        for name, of in inspect.signature(function).parameters.items()
        if of.kind is inspect.Parameter.KEYWORD_ONLY
    }
    assert set(options.__annotations__) == set(own) - others
    table = TABLES[options.__name__]
    for name in options.__annotations__:
        assert (own[name].annotation, own[name].default) == (table[name]["type"], table[name]["default"])


@pytest.mark.parametrize("function", [gfmd.Body, gfmd.Wear, gfmd.self_affine], ids=lambda function: function.__name__)
def test_a_group_has_the_options_of_the_table_and_their_defaults(function):
    parameters, table = inspect.signature(function).parameters, TABLES[function.__name__]
    assert set(parameters) == set(table)
    for name, of in parameters.items():
        default = list(of.default) if isinstance(of.default, tuple) else of.default
        default = None if default is of.empty else default
        found = table[name]["default"]
        assert default == found or (default, found) in [(None, []), ([], None)], name


def test_the_native_half_has_the_types_of_its_stub():
    pytest.importorskip("mypy")
    checked("mypy.stubtest", "gfmd._gfmd")


# What stands before a colon in the first line of a property is shown as its type.
KIND = re.compile(
    r"(Stress|Length|Without unit|Count|Flag|Seconds|Temperature)[ /*^0-9a-z]*?( along x and y)?( \[[a-z0-9, ]+\])?"
)


@pytest.mark.parametrize("name", [name for name, thing in NAMES.items() if isinstance(thing, property)])
def test_a_property_is_a_sentence_or_begins_with_its_kind(name):
    before, colon, behind = inspect.getdoc(NAMES[name]).splitlines()[0].partition(":")
    assert not (colon and behind) or KIND.fullmatch(before), before


def names(cell, context):
    return {node.id for node in ast.walk(cell) if isinstance(node, ast.Name) and isinstance(node.ctx, context)}


def given(cell):
    """The names that a cell has for itself."""
    imports = (node for node in ast.walk(cell) if isinstance(node, (ast.Import, ast.ImportFrom)))
    imported = {(alias.asname or alias.name).split(".")[0] for node in imports for alias in node.names}
    defined = {node.name for node in ast.walk(cell) if isinstance(node, ast.FunctionDef)}
    arguments = {node.arg for node in ast.walk(cell) if isinstance(node, ast.arg)}
    return names(cell, ast.Store) | imported | defined | arguments


def test_a_cell_of_the_gallery_needs_the_first_one_alone():
    text = (FOLDER.parents[1] / "docs" / "gallery.md").read_text(encoding="utf-8")
    first, *others = (ast.parse(cell) for cell in re.findall(r"```\{code-cell\}[^\n]*\n(.*?)```", text, re.DOTALL))
    assert len(others) > 20
    for cell in others:
        missing = names(cell, ast.Load) - given(cell) - given(first) - set(vars(builtins))
        assert not missing, ast.unparse(cell)
