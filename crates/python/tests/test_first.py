"""Names that people try first: the answer has the right one. Results show their answer."""

import re

import numpy as np
import pytest

import gfmd


@pytest.fixture(scope="module")
def surface():
    return gfmd.self_affine(n=32, eps_f_inv=4, size="100 um", unit="um", seed=1)


@pytest.fixture(scope="module")
def pressed(surface):
    return gfmd.contact(surface, gfmd.Body(young="70 GPa", poisson=0.3), pressure="100 MPa")


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """A result of each kind, by the name of its function."""
    rough, rubber = gfmd.self_affine(n=16, eps_f_inv=4), gfmd.Body(prony=[(0.1, 0.3), (10.0, 0.4)])
    found = {
        "path": gfmd.path(rough, gfmd.Body(), p_star=[0.05, 0.1, 0.02], steps=10, flow=True),
        "slide": gfmd.slide(rough, rubber, velocity=[0.01, 1.0], p_star=0.05),
        "wear": gfmd.wear(rough, gfmd.Body(), coefficient=1.0, distance=[0, 1.0], p_star=0.05, steps=2),
        "punch": gfmd.punch(n=16),
        "interior": gfmd.contact(rough, gfmd.Body(), p_star=0.05).interior(depths=[0.1]),
    }
    folder = tmp_path_factory.mktemp("results")
    for name, result in found.items():
        result.save(folder / f"{name}.h5")
    return folder, found


@pytest.mark.parametrize(
    "call, right",
    [
        (lambda: gfmd.Body(nu=0.3), "poisson"),
        (lambda: gfmd.Body(E="70 GPa"), "young"),
        (lambda: gfmd.Body(thickness=1.0), "height"),
        (lambda: gfmd.self_affine(n=16, rms_slope=0.1), "rms_gradient"),
        (lambda: gfmd.self_affine(n=16, H=0.8), "hurst"),
        (lambda: gfmd.self_affine(n=16, length=1.0), "size"),
        (lambda: gfmd.self_affine(n=16, rms_gradiant=0.1), "rms_gradient"),
        (lambda: gfmd.Surface(np.eye(4), length=1.0), "size"),
        (lambda: gfmd.contact(np.eye(4), gfmd.Body(), mean_pressure=0.1), "pressure"),
        (lambda: gfmd.contact(np.eye(4), gfmd.Body(), normal_force=0.1), "force"),
        (lambda: gfmd.contacts(np.eye(4), gfmd.Body(), mean_pressure=[0.1]), "pressure"),
        (lambda: gfmd.contact(np.eye(4), gfmd.Body(), p_star=0.1, tol=1e-6), "tolerance"),
        (lambda: gfmd.contact(np.eye(4), gfmd.Body(), displacement=0.1), "approach"),
        (lambda: gfmd.path(np.eye(4), gfmd.Body(), mean_pressure=0.1), "pressure"),
        (lambda: gfmd.slide(np.eye(4), gfmd.Body(), speed=0.1, p_star=0.1), "velocity"),
        (lambda: gfmd.wear(np.eye(4), gfmd.Body(), coefficient=1, distance=1, mean_pressure=0.1), "pressure"),
        (lambda: gfmd.read("scan.sur", units="um"), "unit"),
    ],
)
def test_an_argument_by_another_name_is_answered_with_the_right_one(call, right):
    with pytest.raises(TypeError, match=f"has no argument '.*'; write {right}"):
        call()


def test_an_argument_that_nobody_has_is_answered_with_all():
    with pytest.raises(TypeError, match="it must be one of young, poisson, e_star, "):
        gfmd.Body(xyzzy=1)


@pytest.mark.parametrize(
    "name, right",
    [
        ("traction", "pressure"),
        ("area", "area_fraction"),
        ("contact_area", "area_fraction"),
        ("displacements", "displacement_z"),
        ("indentation", "approach"),
        ("displacement", "approach"),
        ("mask", "touching"),
        ("heights", "surface.heights"),
        ("area_fractoin", "area_fraction"),
        ("load", "mean_pressure times the area"),
    ],
)
def test_an_attribute_by_another_name_is_answered_with_the_right_one(pressed, name, right):
    assert not hasattr(pressed, name)
    with pytest.raises(AttributeError, match=f"Contact has no {name}; write {right}"):
        getattr(pressed, name)


def test_attributes_of_other_results_and_of_surfaces_have_hints(surface, pressed, results):
    _, found = results
    with pytest.raises(AttributeError, match="write leak_rate"):
        pressed.flow().rate
    with pytest.raises(TypeError, match="leak_rate"):
        pressed.flow(viscosity="1 mPa*s", pressure_drop="1 bar")
    with pytest.raises(AttributeError, match="write leak_rate"):
        found["path"].rate
    with pytest.raises(AttributeError, match=r"write to_dataframe\(\)"):
        found["slide"].to_pandas
    with pytest.raises(AttributeError, match="Surface has no rms_slope; write rms_gradient"):
        surface.rms_slope
    with pytest.raises(AttributeError, match="write heights"):
        surface.data
    several = gfmd.contacts(surface, gfmd.Body(e_star="1 GPa"), p_star=[0.01, 0.02])
    with pytest.raises(AttributeError, match="write area_fraction"):
        several.area


def test_both_leak_rates_are_one_number(surface):
    body = gfmd.Body(young="70 GPa", poisson=0.3)
    fluid = {"viscosity": "1 mPa*s", "pressure_drop": "1 bar"}
    way = gfmd.path(surface, body, pressure=["100 MPa"], steps=1, flow=True)
    alone = gfmd.contact(surface, body, pressure="100 MPa", tolerance=1e-12)
    assert np.allclose(way.leak_rate(**fluid)[-1], alone.leak_rate(**fluid), rtol=1e-5)
    slit = (alone.mean_gap * 1e-6) ** 3 / (12 * 1e-3) * 1e5
    assert np.allclose(alone.leak_rate(**fluid), np.diag(alone.flow().conductivity) * slit, rtol=1e-12)


def test_a_contact_is_shown_in_a_dozen_lines_with_errors(pressed):
    lines = repr(pressed).splitlines()
    assert len(lines) <= 15 and not any("_limit" in line or "nan" in line for line in lines), lines
    assert max(map(len, lines)) <= 120
    shown = {line.split()[0]: line.split(maxsplit=1)[1] for line in lines[1:-1]}
    assert shown["mean_pressure"] == "100 MPa" and shown["converged"] == "True"
    # The value is the limit, and the brackets have the error of its last digits.
    number, error = shown["area_fraction"].rstrip(")").split("(")
    decimals = len(number.split(".")[1])
    assert float(number) == pytest.approx(pressed.area_fraction_limit, abs=0.51 * 10**-decimals)
    assert int(error) * 10**-decimals == pytest.approx(pressed.area_fraction_limit_error, rel=0.3)
    assert f"{len(pressed) - len(shown)} more numbers" in lines[-1]


def test_other_results_show_their_answer(results, pressed):
    _, found = results
    way, sliding, worn = (found[name] for name in ("path", "slide", "wear"))
    text = repr(way)
    assert f"{way.steps.approach[-1]:.2g}" in text and f"{way.dissipated:.6g}" in text and "..." in text
    text = repr(sliding)
    assert all(f"{mu:.6g}" in text for mu in sliding.states.friction) and "\n..." not in text
    text = repr(worn)
    assert f"{worn.wear_volume:.6g}" in text and f"{worn.steps.distance[-1]:.6g}" in text
    flow = pressed.flow()
    lines = repr(flow).splitlines()
    assert lines[0] == "Flow" and "array" not in repr(flow)
    # The conductivity is its limit with an error, or a few digits and ~.
    shown = re.match(r" *conductivity +\[\[([0-9.e-]+)(~|\(\d+\))", lines[1])
    expected = flow.conductivity[0, 0] if shown[2] == "~" else flow.conductivity_limit[0][0]
    assert float(shown[1]) == pytest.approx(expected, rel=0.1)


def test_tables_of_steps_are_data_frames(results):
    pytest.importorskip("pandas")
    _, found = results
    for name, steps in (("path", "steps"), ("slide", "states"), ("wear", "steps")):
        table, of = found[name].to_dataframe(), found[name][steps]
        assert np.array_equal(table.area_fraction, of.area_fraction) and len(table) == len(of.area_fraction)
