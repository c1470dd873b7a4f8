"""Layers, bases and second bodies: kept, written, read, and of one meaning everywhere."""

import math
import pickle

import gfmd
import h5py
import numpy as np
import pytest

COATED = dict(
    young=2.0,
    poisson=0.3,
    height=0.05,
    layers=[(1.0, 0.4, 0.1)],
    base="half-space",
    base_young=10.0,
    base_poisson=0.2,
    second_body=(3.0, 0.3),
)


def test_a_body_has_its_layers_and_the_modulus_of_p_star():
    body = gfmd.Body(**COATED)
    assert body.layers == ((1.0, 0.4, 0.1),) and body.second_body == (3.0, 0.3)
    assert math.isclose(body.e_star, 1.0 / (0.91 / 2.0 + 0.91 / 3.0), rel_tol=1e-14)
    assert pickle.loads(pickle.dumps(body)) == body != gfmd.Body(**{**COATED, "base_young": 9.0})
    assert hash(body) == hash(gfmd.Body(**COATED))
    plain = gfmd.Body(height=1.0)
    assert plain.layers == () and plain.second_body is None and plain != gfmd.Body(height=1.0, base="free")


def test_a_contact_on_layers_is_written_and_read(tmp_path):
    c = gfmd.contact(gfmd.self_affine(n=32, eps_f_inv=4), gfmd.Body(**COATED), p_star=0.1)
    c.save(tmp_path / "c.h5")
    again = gfmd.load(tmp_path / "c.h5")
    assert again.body == c.body and again.approach == c.approach
    warm = gfmd.contact(c.surface, c.body, p_star=0.11, start=again)
    assert warm.area_fraction >= c.area_fraction
    below = gfmd.interior(c, depths=[0.0, 0.05])
    assert [level.get("side") for level in below.levels] == [None, "above", "below"]
    # Without lateral coupling along Nyquist directions: see theory.md.
    assert np.abs(below.stress[0, ..., 2] + c.pressure).max() < 0.02 * c.pressure.max()
    assert np.abs(below.stress[1, ..., 0] - below.stress[2, ..., 0]).max() > 0.05 * c.pressure.max()


def test_punches_and_paths_take_any_body():
    whole = gfmd.Body(poisson=0.3, height=0.3, base="sliding")
    parts = gfmd.Body(poisson=0.3, height=0.1, layers=[[1.0, 0.3, 0.2]], base="sliding")
    a, b = (gfmd.punch(body, n=16, size=1.0, nodes="inclusive") for body in (whole, parts))
    assert math.isclose(a.mean_pressure, b.mean_pressure, rel_tol=1e-6)
    assert gfmd.interior(b, depths=[0.0, 0.2]).stress.shape[0] == 2
    s = gfmd.self_affine(n=16, eps_f_inv=4)
    a, b = (gfmd.friction(s, body, coefficient=0.3, p_star=0.1, lateral=[0, 0.001], steps=1) for body in (whole, parts))
    assert math.isclose(a.dissipated, b.dissipated, rel_tol=1e-5)


@pytest.mark.parametrize(
    "given, words",
    [
        (dict(layers=[(1.0, 0.3, 1.0)]), "layers is"),
        (dict(height=1.0, layers=[(1.0, 0.3)]), "a list of (young, poisson, height)"),
        (dict(height=1.0, layers=[(1.0, 0.3, 0.0)]), "height of layers is 0.0"),
        (dict(height=1.0, layers="soft"), "layers is"),
        (dict(second_body=(1.0,)), "second_body is"),
        (dict(second_body=(1.0, 0.7)), "poisson of second_body is 0.7"),
        (dict(base="free"), "it must be 'bonded' for a half-space"),
    ],
)
def test_what_no_body_has_is_refused(given, words):
    with pytest.raises(gfmd.InputError) as refused:
        gfmd.Body(**given)
    assert words in str(refused.value)


def test_free_boundaries_need_half_spaces():
    s = gfmd.self_affine(n=16, eps_f_inv=4)
    with pytest.raises(gfmd.InputError):
        gfmd.contact(s, gfmd.Body(height=1.0, base="free"), p_star=0.1, boundary="free")


@pytest.mark.parametrize("name", ["base_displacement", "base_traction"])
def test_a_changed_array_of_the_base_does_not_change_a_contact(name, tmp_path):
    given = 1e-3 * np.sin(np.arange(16) * np.pi / 8)[:, np.newaxis] * np.ones((1, 16))
    body = gfmd.Body(height=0.1, base="bonded" if name == "base_displacement" else "free")
    found = gfmd.contact(gfmd.self_affine(n=16, eps_f_inv=4), body, p_star=0.05, **{name: given})
    files = [tmp_path / "before.h5", tmp_path / "after.h5"]
    found.save(files[0])
    given *= 3.0
    found.save(files[1])
    with h5py.File(files[0]) as before, h5py.File(files[1]) as after:
        field = "/base/" + name.removeprefix("base_")
        np.testing.assert_array_equal(before[field][()], after[field][()])
