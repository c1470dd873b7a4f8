"""Every result is shown in a few lines, has the same methods, and is equal to its copies."""

import pickle

import gfmd
import matplotlib.axes
import matplotlib.colors
import matplotlib.pyplot
import numpy as np
import pytest
from gfmd._record import same

UNITS = {"size": "50 um", "unit": "um"}
KINDS = (
    "contact",
    "contacts",
    "adhesive",
    "path",
    "refined",
    "rubbed",
    "creep",
    "wear",
    "slide",
    "heat",
    "punch",
    "strip",
    "below",
    "slice",
    "below_line",
    "sweep",
)


def made():
    """A result of each kind, most of them with units."""
    rough, line = gfmd.self_affine(n=32, eps_f_inv=4, **UNITS), gfmd.self_affine(n=32, dim=2, eps_f_inv=4)
    body = gfmd.Body(young="1 MPa", poisson=0.5)
    rubber = gfmd.Body(young="1 MPa", poisson=0.5, prony=[("0.1 s", 0.3), ("10 s", 0.4)])
    law = gfmd.law("exponential", gamma="0.05 J/m^2", range="2 um")
    contacts = gfmd.contacts(rough, body, p_star=list(np.geomspace(0.01, 0.1, 20)))
    punch = gfmd.punch(n=16)
    points = {"eps_t_inv": [1, 2], "eps_f_inv": [4, 8], "eps_c_inv": [2, 4], "centre": [1, 4, 2]}
    heat = {"heat": ("0.2 W/(m K)", "1e-7 m^2/s"), "friction": 0.3}
    return {
        "contact": contacts[0],
        "contacts": contacts,
        "adhesive": gfmd.contact(rough, body, p_star=0.05, law=law),
        "path": gfmd.path(rough, body, p_star=[0.05, 0.01], hardness="50 kPa", flow=True),
        "refined": gfmd.path(rough, body, p_star=[0.05, 0.01], steps=3, grid_error="refine"),
        "rubbed": gfmd.friction(rough, body, coefficient=0.3, p_star=0.05, lateral=[0, "1 um"], steps=2),
        "creep": gfmd.path(rough, rubber, p_star=0.05, time=[0, "1 min"], steps=2),
        "wear": gfmd.wear(rough, body, coefficient="1e-12 1/Pa", distance=[0, "1 mm"], p_star=0.05, steps=2),
        "slide": gfmd.slide(rough, rubber, velocity=["1 um/s", "0.1 mm/s", "1 mm/s"], p_star=[0.05, 0.02]),
        "heat": gfmd.slide(rough, body, velocity="1 m/s", p_star=0.05, **heat),
        "punch": punch,
        "strip": gfmd.punch(n=16, dim=2, refine=2, history=True),
        "below": contacts[3].interior(levels=20, deepest="5 um"),
        "slice": punch.interior(depths=[0.0, 0.1], along="x=0.5"),
        "below_line": gfmd.contact(line, gfmd.Body(), p_star=0.05).interior(depths=[0.1]),
        "sweep": gfmd.kappa_sweep({"points": points}),
    }


@pytest.fixture(scope="module")
def results():
    found = made()
    assert tuple(found) == KINDS
    return found


@pytest.mark.parametrize("kind", KINDS)
def test_a_representation_has_a_few_lines_with_numbers(results, kind):
    result = results[kind]
    assert isinstance(result, gfmd.Result)
    lines = repr(result).splitlines()
    assert len(lines) <= 15 and max(map(len, lines)) <= 120, repr(result)
    assert sum(any(digit in line for digit in "123456789") for line in lines) > 2 and "rray [2]" not in repr(result)
    parts = [value for value in dict(result).values()] if isinstance(result, gfmd.Record) else []
    for part in parts:
        if isinstance(part, gfmd.Record):
            assert len(repr(part).splitlines()) <= 15


def test_numbers_have_units_and_errors(results):
    assert "pressure / kPa" in repr(results["contacts"]) and "approach / nm" in repr(results["contacts"])
    assert "velocity / mm/s" in repr(results["slide"]) and "mean_pressure / kPa" in repr(results["slide"])
    assert "time / s" in repr(results["creep"]) and "distance / mm" in repr(results["wear"])
    text = repr(results["refined"])
    assert text.count("(") > 8 and "J/m²" in text, text
    assert "Pa/µm, friction_coefficient 0." in repr(results["rubbed"])
    assert " kPa" in repr(results["below"]) and "µm" in repr(results["below"])
    adhesion = results["adhesive"].adhesion()
    assert type(adhesion).__name__ == "Adhesion" and "50 mJ/m²" in repr(adhesion) and "µm" in repr(adhesion)
    rough = results["contact"].surface
    squeezed = gfmd.contacts(
        rough, gfmd.Body(e_star="1 MPa", height="9 um"), p_star=[0.05], lower_surface=0 * rough.heights
    )
    assert "mean_gap" in repr(squeezed[0].lower) and "kPa" in repr(squeezed[0].lower) and "kPa" in repr(squeezed.lower)
    flow = results["contact"].flow()
    assert type(flow).__name__ == "Flow" and "m³" in repr(flow)
    assert "µm" in repr(results["contact"].surface.statistics()) or "nm" in repr(
        results["contact"].surface.statistics()
    )


@pytest.mark.parametrize("kind", KINDS)
def test_units_are_known(results, kind):
    without = kind in ("punch", "strip", "slice", "below_line", "sweep")
    assert results[kind].units == ((None, None) if without else ("µm", "Pa"))


@pytest.mark.parametrize("kind", KINDS)
def test_numbers_are_a_data_frame(results, kind):
    pytest.importorskip("pandas")
    result = results[kind]
    frame = result.to_dataframe()
    rows = {"contacts": 20, "path": 21, "slide": 6, "below": 20, "slice": 2, "sweep": 28}
    assert len(frame) == rows.get(kind, len(frame)) >= 1
    assert all(frame[name].dtype != object for name in frame), frame.dtypes
    units = frame.attrs["units"]
    assert set(units) <= set(frame)
    if result.units[0] is not None:
        assert {"µm", "Pa"} <= set(units.values())


@pytest.mark.parametrize("kind", KINDS)
def test_numbers_and_fields_are_a_data_set(results, kind):
    pytest.importorskip("xarray")
    result = results[kind]
    made = result.to_xarray()
    for name, variable in {**made.data_vars, **made.coords}.items():
        if name not in ("axis", "component", "tensor"):
            assert variable.attrs["long_name"], name
        # Without units, only numbers without dimension have one.
        if result.units[0] is not None and variable.dtype.kind == "f":
            assert variable.attrs["units"], name
    assert all(name in made.coords for name in made.dims if name != "axis" or kind in ("path", "wear")), made


def test_the_data_sets_have_the_fields(results):
    pytest.importorskip("xarray")
    contacts, slide, below, punch = (results[name] for name in ("contacts", "slide", "below", "punch"))
    made = contacts.to_xarray()
    assert made.pressure.dims == ("load", "y", "x") and made["load"].values.tolist() == list(range(20))
    assert made.pressure.long_name.startswith("pressure on the elastic surface")
    assert contacts[0].to_xarray()["load"] == 0
    made = slide.to_xarray()
    assert made.velocity.dims == ("state",) and np.array_equal(made.gap.values, np.swapaxes(slide.gap, 1, 2))
    assert made.velocity.units == "µm/s"
    made = below.to_xarray()
    assert np.array_equal(made.stress.sel(tensor="xz").values, np.swapaxes(below.stress[..., 4], 1, 2))
    assert made.depth.values.tolist() == [level.depth for level in below.levels] and made.depth.units == "µm"
    made = punch.to_xarray()
    assert np.array_equal(made.traction.sel(component="z").values, punch.traction[..., 2].T)
    assert results["path"].to_xarray().mean_pressure.dims == ("step",)
    assert results["slice"].to_xarray().von_mises.dims == ("depth", "y")
    assert results["below_line"].to_xarray().stress.dims == ("depth", "x", "tensor")


@pytest.mark.parametrize("kind", KINDS)
def test_a_result_is_drawn(results, kind):
    drawn = results[kind].plot()
    assert isinstance(drawn, matplotlib.axes.Axes) and drawn.get_xlabel()
    matplotlib.pyplot.close(drawn.figure)


def test_figures_have_the_style_of_the_program_unless_another_is_chosen():
    s = gfmd.self_affine(n=16)
    contact = gfmd.contact(s, gfmd.Body(), p_star=0.05)
    maps = [contact.plot(), gfmd.contacts(s, gfmd.Body(), p_star=[0.01, 0.1]).plot()]
    assert matplotlib.colors.to_hex(maps[0].get_facecolor()) == "#e9e9e6"
    assert maps[0].images[0].get_cmap().name == "viridis" and maps[0].images[0].get_clim()[0] == 0.0
    assert np.ma.getmaskarray(maps[0].images[0].get_array()).sum() == np.sum(contact.pressure == 0)
    assert maps[1].lines[0].get_color() == "#0072b2"
    with matplotlib.pyplot.style.context("ggplot"):
        own = matplotlib.rcParams["axes.prop_cycle"].by_key()["color"][0]
        maps.append(gfmd.contacts(s, gfmd.Body(), p_star=[0.01, 0.1]).plot())
        assert maps[2].lines[0].get_color() == own
    for ax in maps:
        matplotlib.pyplot.close(ax.figure)


def test_the_figures_have_the_numbers(results):
    slide, below, punch = (results[name] for name in ("slide", "below", "punch"))
    ax = slide.plot()
    assert len(ax.lines) == 2 and ax.get_xscale() == "log" and "mm/s" in ax.get_xlabel()
    assert sorted(ax.lines[0].get_ydata()) == sorted(slide.states.friction[:3])
    assert "stress $\\sigma_{xz}$" in [axis.get_ylabel() for axis in below.plot("stress", "xz").figure.axes][-1]
    assert "displacement $u_x$" in [axis.get_ylabel() for axis in punch.plot("displacement", "x").figure.axes][-1]
    matplotlib.pyplot.close("all")
    for call, words in (
        (lambda: slide.plot("time"), "the scalar is 'time'"),
        (lambda: below.plot("pressure"), "field is 'pressure'; it must be one of von_mises"),
        (lambda: below.plot("stress", "a"), "component is 'a'; it must be one of xx, yy"),
        (lambda: below.plot(level=20), "level is 20"),
        (lambda: below.plot("von_mises", "z"), "component is 'z'; it must be left out for von_mises"),
        (lambda: punch.plot("gap"), "field is 'gap'"),
        (lambda: punch.plot(component="w"), "component is 'w'; it must be one of x, y, z"),
    ):
        with pytest.raises(gfmd.InputError, match=words):
            call()
    matplotlib.pyplot.close("all")


@pytest.mark.parametrize("kind", KINDS)
def test_a_result_is_saved(results, kind, tmp_path):
    results[kind].save(tmp_path / "r.h5")
    if kind in ("contact", "contacts", "adhesive"):
        assert gfmd.load(tmp_path / "r.h5") == results[kind]
    elif isinstance(results[kind], (gfmd.Path, gfmd.Slide)):
        rows = "steps" if isinstance(results[kind], gfmd.Path) else "states"
        loaded, made = gfmd.load(tmp_path / "r.h5"), results[kind]
        # A file has the largest part of each residual alone.
        names = {name for name in made[rows] if not name.startswith("residual_")}
        assert loaded[rows].keys() - {"residual_largest"} == names
        assert all(np.array_equal(loaded[rows][name], made[rows][name], equal_nan=True) for name in names)
        differing = [name for name in made.keys() | loaded.keys() if not same(made.get(name), loaded.get(name))]
        # A coefficient of wear was given with its unit.
        assert set(differing) <= {rows, "plots", "surface", "wear"}
        assert np.array_equal(loaded.surface.heights, made.surface.heights)
    else:
        loaded = gfmd.load(tmp_path / "r.h5")
        assert type(loaded) is type(results[kind]) and loaded == results[kind] and loaded.units == results[kind].units
        loaded.save(tmp_path / "again.h5")
        assert (tmp_path / "again.h5").read_bytes() == (tmp_path / "r.h5").read_bytes()


@pytest.mark.parametrize("kind", ["path", "wear", "slide", "punch", "contact"])
def test_results_of_one_input_are_equal(results, kind):
    again = pickle.loads(pickle.dumps(results[kind]))
    assert again == results[kind] and hash(again) == hash(results[kind]) and again is not results[kind]
    assert results[kind] != results["creep"] and results[kind] != dict(results[kind])


def test_another_run_is_equal_and_another_input_is_not():
    surface = gfmd.self_affine(n=16)
    first, second = (gfmd.path(surface, gfmd.Body(), p_star=[0.05, 0.01], steps=2) for _ in range(2))
    assert first == second and hash(first) == hash(second) and first.steps == second.steps
    assert first != gfmd.path(surface, gfmd.Body(), p_star=[0.05, 0.02], steps=2)
    assert surface.psd() == surface.psd() and surface.psd() != surface.flip().distributions()
    assert gfmd.Record({"a": np.array([1.0, np.nan]), "b": [np.nan]}) == gfmd.Record(
        {"b": [np.nan], "a": np.array([1.0, np.nan])}
    )
    assert gfmd.Record({"a": np.array([1.0])}) != gfmd.Record({"a": np.array([2.0])})
    assert gfmd.Record({"a": 1.0, "seconds": 1.0}) == gfmd.Record({"a": 1.0, "seconds": 2.0})


@pytest.mark.parametrize(
    "kind", ["contact", "contacts", "adhesive", "path", "rubbed", "creep", "wear", "slide", "heat"]
)
def test_residuals_have_one_shape(results, kind):
    residual = results[kind].residual
    assert isinstance(residual, gfmd.Residual) and len(residual) > 1
    largest = np.max([np.asarray(part) for part in residual.values()], axis=0)
    assert np.array_equal(residual.largest, largest) and float(residual) == largest.max()
    assert float(residual) <= 1e-8 and repr(residual).startswith("Residual, the largest ")
    assert all(getattr(residual, name) is residual[name] for name in residual)


# Calls of all results, and whether the numbers of a result alone refuse them.
CALLS = {
    "save": (lambda of, folder: of.save(folder / "of.h5"), True),
    "to_dataframe": (lambda of, folder: of.to_dataframe(), False),
    "to_xarray": (lambda of, folder: of.to_xarray(), True),
    "plot": (lambda of, folder: of.plot(), True),
    "units": (lambda of, folder: of.units, False),
    "repr": (lambda of, folder: repr(of), False),
}
# Calls beside a table and units that numbers without a file have.
HAVE = {"PronyFit": {"plot", "save"}, "Estimate": {"plot", "to_xarray"}, "Surface": {"plot", "to_xarray"}}


def parts(results):
    """Numbers that belong to a result, by the names of their classes."""
    contact, rough = results["contact"], results["contact"].surface
    elastic = gfmd.contact(rough.heights, gfmd.Body(), p_star=0.05)
    way = gfmd.path(rough.heights, gfmd.Body(), p_star=0.05, steps=1)
    curves = {"frequency": [0.1, 1, 10], "storage": [2.0, 2.5, 3.0], "loss": [0.1, 0.5, 0.1]}
    found = [
        contact.flow(),
        results["adhesive"].adhesion(),
        elastic.vjp(approach=1.0),
        way.vjp(approach=1.0),
        rough.statistics(),
        gfmd.green(gfmd.Body(), qx=3.0),
        gfmd.prony(**curves, branches=1, stress_unit="MPa"),
        gfmd.estimate(gfmd.self_affine(n=64, hurst=0.8), gfmd.Body(), p_star=[0.01, 0.1]),
        rough,
    ]
    return {type(part).__name__: part for part in found}


def test_every_result_has_the_same_calls_or_says_why_not(results, tmp_path):
    pytest.importorskip("pandas"), pytest.importorskip("xarray")
    all_classes = {
        name
        for name in gfmd.__all__
        if isinstance(getattr(gfmd, name), type) and {"to_dataframe", "save"} <= set(dir(getattr(gfmd, name)))
    } - {"Result"}
    made = {**{type(result).__name__: result for result in results.values()}, **parts(results)}
    made["Study"] = gfmd.study({"command": "contact", "contact": {"n": 16, "p_star": 0.1}, "study": {"seed": "1:2"}})
    assert set(made) == all_classes
    for name, result in made.items():
        for call, (perform, is_refused) in CALLS.items():
            if is_refused and not isinstance(result, gfmd.Result) and call not in HAVE.get(name, ()):
                with pytest.raises(gfmd.Error, match=f"^{name} has no (file|fields|figure); [^\n]*$"):
                    perform(result, tmp_path)
            else:
                assert call == "save" or perform(result, tmp_path) is not None, (name, call)
        assert len(repr(result).splitlines()) <= 15 and len(result.units) == 2
        assert len(result.to_dataframe()) > 0 and len(result.to_dataframe().columns) > 0, name
    matplotlib.pyplot.close("all")
