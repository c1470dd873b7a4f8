"""Contacts with finite slopes, of a slab between two surfaces, and with an attraction on a coarse grid."""

import pickle
import warnings

import gfmd
import numpy as np
import pytest

BODY = gfmd.Body(young=1.0, poisson=0.3, height=0.5)
SMALL = gfmd.self_affine(n=32)
BELOW = gfmd.self_affine(n=32, seed=2)
NARROW = gfmd.law("exponential", gamma=1e-4, range=1e-4)

KINDS = {"finite slopes": dict(finite_slope=True), "squeezed": dict(lower_surface=BELOW)}
OTHERS = {
    "plain": {},
    "hardness": dict(hardness=0.1),
    "held": dict(components="held"),
    "squeezed with a hardness": dict(lower_surface=BELOW, hardness=0.1),
    "squeezed and held": dict(lower_surface=BELOW, components="held"),
    "law": dict(law=gfmd.law("morse", gamma=1e-4, range=5e-3)),
}


@pytest.mark.parametrize("kind", OTHERS)
@pytest.mark.parametrize(
    "load", [dict(p_star=0.05), dict(approach=0.01), dict(pressure=0.004)], ids=["p_star", "approach", "pressure"]
)
def test_the_program_finds_in_a_saved_file_what_it_computes_itself(kind, load, tmp_path, run_program):
    gfmd.contact(SMALL, BODY, **OTHERS[kind], **load).save(tmp_path / "c.h5")
    assert run_program("check", str(tmp_path / "c.h5"))["differences"] == []


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("load", [("p_star", 0.05, 0.06), ("approach", 0.01, 0.012)], ids=["p_star", "approach"])
def test_it_survives_files_and_pickles_and_starts_the_next_load_with_the_same_bits(kind, load, tmp_path, run_program):
    name, low, high = load
    c = gfmd.contact(SMALL, BODY, **KINDS[kind], **{name: low})
    wanted = gfmd.contacts(SMALL, BODY, **KINDS[kind], **{name: [low, high]})
    c.save(tmp_path / "c.h5")
    for again in (c, gfmd.load(tmp_path / "c.h5"), pickle.loads(pickle.dumps(c))):
        assert again.finite_slope == c.finite_slope and list(again._fields) == list(c._fields)
        assert all(np.array_equal(field, c._fields[key]) for key, field in again._fields.items())
        assert again._fields["pressure"].flags.writeable is False
        started = gfmd.contact(SMALL, BODY, start=again, **KINDS[kind], **{name: high})
        assert all(np.array_equal(field, started._fields[key]) for key, field in wanted[1]._fields.items())
        assert started.iterations == wanted[1].iterations
    for contact in (wanted, gfmd.load(tmp_path / "c.h5")):
        contact.save(tmp_path / "saved.h5")
        assert run_program("check", str(tmp_path / "saved.h5"))["differences"] == []


def test_finite_slopes_change_the_contact_and_vanish_with_the_slope():
    gaps = []
    for scale in (1.0, 0.01):
        s = gfmd.Surface(scale * SMALL.heights)
        steep, small = (
            gfmd.contact(s, BODY, p_star=0.1, finite_slope=finite, tolerance=1e-10) for finite in (True, False)
        )
        gaps.append(abs(steep.projected_area_fraction / small.area_fraction - 1.0))
        assert steep.residual.lateral_displacement <= 1e-10 and not small.finite_slope
        assert abs(steep.stiffness / small.stiffness - 1.0) < 0.01 and steep.stiffness_error <= 5e-6
        # The mean shear is that of the pressure along the normal; it balances no load.
        assert len(steep.mean_shear) == 2 and np.abs(steep.mean_shear).max() < 0.1 * scale * steep.mean_pressure
    assert gaps[0] > 10 * gaps[1]
    assert np.abs(steep.displacement_x).max() > 0.0 and small.displacement_x is None
    below = steep.interior(depths=[0.0], quantities=["displacement"]).displacement[0]
    assert np.abs(below[..., 0] - steep.displacement_x).max() < 1e-6 * np.abs(steep.displacement_x).max()


def test_a_slab_between_two_surfaces_is_in_equilibrium_and_knows_which_face_is_which():
    c = gfmd.contact(SMALL, BODY, p_star=0.05, lower_surface=BELOW)
    assert c.lower.mean_pressure == pytest.approx(c.mean_pressure, rel=1e-8) and float(c.lower.residual) <= 1e-8
    assert np.all(c.lower_pressure * c.lower_gap == 0.0) or c.lower.residual.complementarity <= 1e-8
    assert np.mean(c.lower_pressure > 0.0) == c.lower.area_fraction and c.lower_gap.mean() == pytest.approx(
        c.lower.mean_gap, rel=1e-12
    )
    turned = gfmd.contact(BELOW, BODY, pressure=c.mean_pressure, lower_surface=SMALL)
    assert np.allclose(turned.pressure, c.lower_pressure, atol=1e-6 * c.max_pressure, rtol=0)
    assert np.allclose(
        turned.lower_displacement_z, -c.displacement_z, atol=1e-6 * np.abs(c.displacement_z).max(), rtol=0
    )
    assert turned.approach == pytest.approx(c.approach, rel=1e-7) and c.lower_surface is BELOW
    hard = gfmd.contact(SMALL, BODY, p_star=0.2, lower_surface=BELOW, hardness=0.1)
    assert np.mean(hard.lower_pressure >= 0.1 * (1 - 1e-12)) == pytest.approx(hard.lower.plastic_fraction, abs=1e-12)
    assert hard.lower_plastic_depth.mean() == pytest.approx(hard.lower.plastic_volume, rel=1e-12)
    assert 0.0 < hard.lower.plastic_fraction and hard.lower.residual.saturation <= hard.residual.saturation <= 1e-8
    flat = gfmd.contact(SMALL, BODY, p_star=0.05, lower_surface=np.zeros((32, 32)))
    assert flat.lower.area_fraction > 0.9 and flat.lower_surface.size == SMALL.size


def test_several_loads_have_arrays_of_everything(tmp_path):
    cs = gfmd.contacts(SMALL, BODY, p_star=[0.01, 0.1], lower_surface=BELOW)
    assert (
        cs.lower_gap.shape == (2, 32, 32) and cs.lower.area_fraction.shape == (2,) and float(cs.lower.residual) <= 1e-8
    )
    cs.save(tmp_path / "cs.h5")
    again = gfmd.load(tmp_path / "cs.h5")
    assert np.array_equal(again.lower.mean_gap, cs.lower.mean_gap) and np.array_equal(
        again.lower_pressure, cs.lower_pressure
    )
    assert np.array_equal(again[0].lower_surface.heights, BELOW.heights) and isinstance(
        again[0].lower.contact_nodes, int
    )
    steep = gfmd.contacts(SMALL, BODY, p_star=[0.01, 0.1], finite_slope=True)
    assert steep.mean_shear.shape == (2, 2) and steep.displacement_y.shape == (2, 32, 32)
    xarray = pytest.importorskip("xarray")
    for contacts, name in (
        (cs, "lower_residual_load"),
        (cs, "lower_displacement_z"),
        (steep, "mean_shear"),
        (steep, "displacement_x"),
    ):
        assert isinstance(contacts.to_xarray()[name], xarray.DataArray), name


def test_all_fields_are_drawn():
    pytest.importorskip("matplotlib")
    for kind, label in (("finite slopes", "displacement $u_x$ (length)"), ("squeezed", "lower pressure (stress)")):
        c = gfmd.contact(SMALL, BODY, p_star=0.05, **KINDS[kind])
        drawn = [c.plot(field).figure.axes[1].get_ylabel() for field in c._fields]
        assert label in drawn, drawn
        for other, shown in (("shear", "'shear'"), ([], r"\[\]")):
            with pytest.raises(gfmd.InputError, match=f"field is {shown}"):
                c.plot(other)


def test_a_law_acts_at_both_faces_and_a_path_follows_them():
    law = gfmd.law("exponential", gamma=1e-5, range=2e-2)
    contact = gfmd.contact(SMALL, BODY, p_star=0.02, law=law, lower_surface=BELOW)
    assert abs(contact.lower.mean_pressure / contact.mean_pressure - 1) < 1e-6
    assert contact.lower_gap.shape == (32, 32) and contact.lower_repulsion.max() > contact.lower_pressure.max() > 0
    loop = gfmd.path(SMALL, BODY, approach=[0.0, 0.02, 0.0], law=law, lower_surface=BELOW, steps=2)
    assert loop.steps.converged.all() and abs(loop.steps.approach[-1]) < 1e-9
    assert loop.lower_gap.shape == (3, 32, 32)


def test_what_does_not_go_together_is_named():
    law, half_space = gfmd.law("morse", gamma=1e-4, range=5e-3), gfmd.Body()
    steep, squeezed, plain = (gfmd.contact(SMALL, BODY, p_star=0.1, **options) for options in (*KINDS.values(), {}))
    for arguments, words in [
        (dict(finite_slope=1), "finite_slope is 1"),
        (dict(finite_slope=True, law=law), "law is morse; it must be left out with finite_slope"),
        (
            dict(finite_slope=True, boundary="free", body=half_space),
            "boundary is free; it must be periodic with finite_slope",
        ),
        (dict(finite_slope=True, components="all"), "components is all"),
        (dict(finite_slope=True, solver="cg"), "solver: "),
        (dict(finite_slope=True, lower_surface=BELOW), "finite_slope is given; it must be left out with lower_surface"),
        (dict(finite_slope=True, body=gfmd.Body(height=0.5, second_body=(1.0, 0.3))), "second_body is given"),
        (dict(lower_surface=BELOW, body=half_space), "height is inf; it must be finite with lower_surface"),
        (dict(lower_surface=BELOW, body=gfmd.Body(height=0.5, base="sliding")), "base is sliding; it must be left out"),
        (dict(lower_surface=BELOW, law=law, components="all"), "components is all"),
        (dict(lower_surface=BELOW, components="all"), "components is all"),
        (dict(lower_surface=BELOW, surface=np.zeros((32, 32))), "surface: the heights are all equal"),
        (dict(lower_surface=gfmd.self_affine(n=16)), "n of lower_surface is (16, 16); it must be (32, 32)"),
        (dict(lower_surface=gfmd.self_affine(n=32, size=2.0)), "size of lower_surface is (2.0, 2.0)"),
        (dict(lower_surface="x"), "heights is the text"),
        (dict(start=steep), "start has finite_slope=True"),
        (dict(start=squeezed), "start has a lower_surface"),
        (dict(start=plain, lower_surface=BELOW), "start has no lower_surface"),
        (dict(coarse="no"), "coarse is 'no'; it must be True or False"),
        (dict(dt="fast"), "dt is 'fast'; it must be a number"),
        (dict(range_continuation=True), "range_continuation: the law hard-wall has no range"),
        (dict(range_continuation=True, law=law, start=plain), "range_continuation and start are both given"),
    ]:
        with pytest.raises(gfmd.InputError) as reported:
            gfmd.contact(**{"surface": SMALL, "body": BODY, "p_star": 0.1, **arguments})
        assert str(reported.value).startswith(words), str(reported.value)


def test_a_grid_much_too_coarse_for_an_attraction_is_refused_before_the_solve():
    with pytest.raises(gfmd.InputError, match="law: the process zone .* at least 0.1: .* give coarse for"):
        gfmd.contact(SMALL, gfmd.Body(), p_star=0.05, law=NARROW)
    with pytest.warns(UserWarning, match="lattice trapping"):
        c = gfmd.contact(SMALL, gfmd.Body(), p_star=0.05, law=NARROW, coarse=True)
    assert (
        0.0 < c.adhesion().process_zone_points < 0.1
        and c.adhesion().work == 1e-4
        and c.adhesion().pastewka_robbins > 0.0
    )
    assert gfmd.contact(SMALL, gfmd.Body(), p_star=0.05).adhesion() is None


def test_slopes_that_are_not_small_are_told_once_with_the_largest_pressure():
    steep = gfmd.self_affine(n=16, eps_f_inv=4, rms_gradient=0.5, seed=3)
    with pytest.warns(UserWarning, match="the rms gradient is 0.50, .*; finite_slope includes the slopes") as reported:
        cs = gfmd.contacts(steep, gfmd.Body(), p_star=[0.05, 0.2])
    assert len(reported) == 1 and f"the largest pressure {max(cs.max_pressure):.2f} E*" in str(reported[0].message)
    with pytest.warns(UserWarning, match="strains are still taken as small"):
        gfmd.contact(steep, gfmd.Body(), p_star=0.05, finite_slope=True)
    with pytest.warns(UserWarning, match="is of this size$"):
        gfmd.contact(steep, gfmd.Body(), p_star=0.05, boundary="free")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        gfmd.contact(gfmd.self_affine(n=16, eps_f_inv=4, rms_gradient=0.19, seed=3), gfmd.Body(), p_star=0.05)


def test_a_longer_range_first_pulls_the_surfaces_together():
    law, load = gfmd.law("exponential", gamma=1e-3, range=2e-3), dict(approach=-0.004)
    apart = gfmd.contact(SMALL, gfmd.Body(), law=law, **load)
    c = gfmd.contact(SMALL, gfmd.Body(), law=law, range_continuation=True, **load)
    start = None
    for factor in (8, 4, 2):
        longer = gfmd.law("exponential", gamma=1e-3, range=factor * 2e-3)
        start = gfmd.contact(SMALL, gfmd.Body(), law=longer, start=start, **load)
    by_hand = gfmd.contact(SMALL, gfmd.Body(), law=law, start=start, **load)
    assert np.array_equal(c.gap, by_hand.gap) and c.iterations == by_hand.iterations
    assert c.area_fraction > apart.area_fraction and c.converged
    both = gfmd.contacts(SMALL, gfmd.Body(), law=law, range_continuation=True, approach=[-0.004, -0.0045])
    assert np.array_equal(both[0].gap, c.gap)
    assert np.array_equal(both[1].gap, gfmd.contact(SMALL, gfmd.Body(), law=law, start=c, approach=-0.0045).gap)


def test_surfaces_that_part_under_a_longer_range_have_no_state():
    law = gfmd.law("morse", gamma=1e-3, range=0.1)
    with pytest.raises(gfmd.NotConverged, match="range times 8: the surfaces part") as caught:
        gfmd.contacts(SMALL, gfmd.Body(), law=law, range_continuation=True, pressure=[-0.03])
    assert len(caught.value.state) == 0
