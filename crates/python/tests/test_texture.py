"""The functions that describe a surface, beside SurfaceTopography's with its conventions, and NumPy's where that has
none.
"""

import re

import gfmd
import numpy as np
import pytest

# Points and spacings differ along x and y. The second is no power of two, and does not repeat.
PERIODIC = gfmd.self_affine(n=(96, 64), eps_f_inv=8, hurst=0.7, size=(3.0, 2.3457), seed=2)
_ROUGH = np.random.default_rng(5).standard_normal((45, 30)).cumsum(axis=0).cumsum(axis=1)
SCAN = gfmd.Surface(_ROUGH - _ROUGH.mean(), size=(9.0, 3.0), unit="um")
LINE = gfmd.self_affine(n=256, dim=2, eps_f_inv=16, size=4.0, seed=3)
SURFACES = {"periodic": PERIODIC, "scan": SCAN, "line": LINE, "open line": gfmd.Surface(SCAN.heights[:, 3], size=9.0)}


def topography(surface):
    package = pytest.importorskip("SurfaceTopography")
    heights = np.array(surface.heights)
    if surface.n[1] == 1:
        return package.UniformLineScan(heights[:, 0], surface.size[0], periodic=surface.is_periodic)
    return package.Topography(heights, surface.size, periodic=surface.is_periodic)


def close(found, wanted, tolerance=1e-9):
    found, wanted = np.asarray(found), np.asarray(wanted)
    assert found.shape == wanted.shape
    assert np.abs(found - wanted).max() <= tolerance * np.abs(wanted).max()


def test_a_surface_knows_whether_it_repeats():
    assert PERIODIC.is_periodic and not SCAN.is_periodic and SCAN.periodise().is_periodic
    assert gfmd.Surface(topography(PERIODIC)).is_periodic and not gfmd.Surface(topography(SCAN)).is_periodic
    assert (
        PERIODIC.flip().finer(2).is_periodic
        and not PERIODIC.against(SCAN.heights[:1, :1] + np.zeros((96, 64))).is_periodic
    )
    assert not gfmd.self_affine(n=64, method="rmd").is_periodic
    for name in ("autocorrelation", "distributions", "scale_dependence"):
        with pytest.raises(gfmd.InputError, match="boundary is 'open'; it must be 'periodic' or 'free'"):
            getattr(SCAN, name)(boundary="open")


@pytest.mark.parametrize("name", SURFACES)
def test_the_autocorrelation_along_x(name):
    """Its `difference` is the height-difference autocorrelation of SurfaceTopography, A(r) = <(h(x+r) - h(x))^2>/2."""
    surface = SURFACES[name]
    distance, wanted = topography(surface).autocorrelation_from_profile(resampling_method=None, reliable=False)
    found = surface.autocorrelation().x
    count = min(len(distance), len(found.distance))
    assert count >= surface.n[0] // 2
    close(found.distance[:count], distance[:count])
    close(found.difference[:count], wanted[:count])
    close(found.autocorrelation, 1.0 - found.difference / np.var(surface.heights), 1e-12)


def test_the_radial_autocorrelation():
    """In the same rings, SurfaceTopography has the same distances and values."""
    found = PERIODIC.autocorrelation().radial
    step = max(size / n for size, n in zip(PERIODIC.size, PERIODIC.n))
    edges = (np.arange(len(found.distance)) + 0.5) * step
    distance, wanted = topography(PERIODIC).autocorrelation_from_area(collocation=edges, reliable=False)
    close(found.distance[1:-1], distance[: len(edges) - 2])
    close(found.difference[1:-1], wanted[: len(edges) - 2])


def test_the_areal_autocorrelation_of_a_scan():
    """SurfaceTopography has the quadrant of positive distances."""
    found = SCAN.autocorrelation()
    _, _, wanted = topography(SCAN).autocorrelation_from_area(return_map=True, reliable=False)
    relative = 1.0 - wanted[:23, :16] / np.var(SCAN.heights)
    close(found.map[22:, 15:], relative)
    close(found.map[::-1, ::-1], found.map, 1e-12)
    assert found.map.shape == (45, 31) and found.map[22, 15] == 1.0
    close(found.y.autocorrelation, found.map[22, 15:], 1e-12)


def test_correlation_lengths():
    """Sal is the shortest distance to the line of 0.2, Str is one of an isotropic surface, and half of one stretched
    twice.
    """
    found = gfmd.self_affine(n=256, eps_t_inv=8, eps_f_inv=8, seed=4)
    once, twice = found.autocorrelation(), gfmd.Surface(found.heights, size=(1.0, 2.0)).autocorrelation(
        boundary="periodic"
    )
    first = np.interp(0.2, once.x.autocorrelation[:16][::-1], once.x.distance[:16][::-1])
    assert 0.75 * first < once.sal <= first * (1 + 1e-9) and 0.7 < once.str <= 1.0
    assert twice.sal == pytest.approx(once.sal, rel=0.3) and 0.35 < twice.str < 0.72
    flat = gfmd.Surface(np.zeros((8, 8))).autocorrelation()
    assert np.isnan(flat.sal) and np.isnan(flat.map).all()


@pytest.mark.parametrize("name", SURFACES)
def test_the_roughness_against_distance(name):
    """Distances and values are those of `scale_dependent_statistical_property`, with the mean square as its func, of
    every line of points.
    """
    package = pytest.importorskip("SurfaceTopography")
    surface = SURFACES[name]
    found = surface.scale_dependence()
    for axis, along in enumerate("xy"[: 1 if surface.n[1] == 1 else 2]):
        lines = np.moveaxis(np.array(surface.heights), axis, -1)
        lines = [
            package.UniformLineScan(np.array(line), surface.size[axis], periodic=surface.is_periodic) for line in lines
        ]
        for order, quantity in ((1, "slope"), (2, "curvature")):
            own = found[f"{quantity}_{along}"]
            assert len(own.distance) >= 6 and own.distance[-1] <= surface.size[axis] / 2 * (1 + 1e-12)

            def mean_square(line, distance, n=order):
                property_of = line.scale_dependent_statistical_property
                return property_of(lambda dx: np.mean(dx**2), n=n, distance=[distance], reliable=False)[1][0]

            for distance, value in list(zip(own.distance, own[quantity]))[::4]:
                assert value == pytest.approx(
                    np.sqrt(np.mean([mean_square(line, distance) for line in lines])), rel=1e-9
                )


@pytest.mark.parametrize("name", SURFACES)
def test_distributions(name):
    """The values are those of `derivative` of SurfaceTopography, the bins those of NumPy."""
    surface = SURFACES[name]
    other, found = topography(surface), surface.distributions()
    heights = np.array(surface.heights)
    first, second = other.derivative(n=1), other.derivative(n=2)
    values = {"height": heights - heights.mean()}
    if surface.n[1] == 1:
        values.update(slope_x=first, curvature=second)
        assert "slope_y" not in found
    else:
        x, y = second
        # SurfaceTopography leaves the last row and column out of both slopes of a surface that does not repeat.
        values.update(curvature=(x + y) / 2)
        if surface.is_periodic:
            values.update(slope_x=first[0], slope_y=first[1])
        else:
            dx, dy = (size / n for size, n in zip(surface.size, surface.n))
            values.update(slope_x=np.diff(heights, axis=0) / dx, slope_y=np.diff(heights, axis=1) / dy)
            close(values["slope_x"][:, : first[0].shape[1]], first[0])
    for part, all_values in values.items():
        own, all_values = found[part], np.ravel(all_values)
        assert own.mean == pytest.approx(
            all_values.mean(), abs=1e-9 * all_values.std()
        ) and own.deviation == pytest.approx(all_values.std())
        half = (own.value[1] - own.value[0]) / 2
        low, high = own.value[0] - half, own.value[-1] + half
        assert low == pytest.approx(max(all_values.min(), own.mean - 6 * own.deviation), abs=1e-9 * own.deviation)
        counts, _ = np.histogram(all_values, bins=100, range=(low, high))
        # A value on an edge may be on either side of it.
        assert np.abs(own.density * all_values.size * 2 * half - counts).sum() <= 4.0
        wanted = np.exp(-(((own.value - own.mean) / own.deviation) ** 2) / 2) / np.sqrt(2 * np.pi) / own.deviation
        close(own.gaussian, wanted)


@pytest.mark.parametrize("name", SURFACES)
def test_the_bearing_curve(name):
    """SurfaceTopography joins the points by triangles, of which the ratio of points is a sum with an error of the
    grid.
    """
    surface = SURFACES[name]
    found, other = surface.bearing_curve(), topography(surface)
    heights = np.sort(np.ravel(surface.heights))[::-1] - surface.heights.mean()
    place = found.ratio * (heights.size - 1)
    close(found.height, np.interp(place, np.arange(heights.size), heights), 1e-12)
    wanted = other.bearing_area()(np.ascontiguousarray(found.height + surface.heights.mean()))
    # Points of a scan at the edge have less weight in triangles.
    assert np.abs(wanted - found.ratio).max() < (0.02 if surface.is_periodic else 0.06)


def test_the_core_of_a_gaussian_surface():
    """The line of least squares through the middle two fifths of the normal distribution, by its integrals."""
    heights = np.random.default_rng(1).standard_normal((600, 600))
    core = gfmd.Surface(heights).bearing_curve()
    for found, wanted in (
        (core.sk, 2.5737),
        (core.spk, 0.9449),
        (core.svk, 0.9449),
        (core.smr1, 0.0991),
        (core.smr2, 0.9009),
    ):
        assert found == pytest.approx(wanted, abs=0.03)


@pytest.mark.parametrize("name", SURFACES)
def test_the_spectrum(name):
    """SurfaceTopography's density is (2 pi)^2 times ours, of a profile 2 pi times; the rings are those of multiples of
    2 pi over the side.
    """
    surface = SURFACES[name]
    found, other = surface.psd(), topography(surface)
    if surface.n[1] == 1:
        q, wanted = other.power_spectrum_from_profile(window="None", resampling_method=None, reliable=False)
        count = len(q) - 1
        close(found.wavenumber[:count], q[1:])
        close(found.density[:count] * 2 * np.pi, wanted[1:], 1e-9)
    else:
        step = 2 * np.pi / min(surface.size)
        edges = (np.arange(len(found.wavenumber) + 1) + 0.5) * step
        q, wanted = other.power_spectrum_from_area(window="None", collocation=edges, reliable=False)
        # The last ring of ours is cut by the Nyquist wavenumber, that of theirs by its edge.
        rings = slice(1, len(edges) - 3)
        close(found.wavenumber[found.wavenumber > edges[0]][rings], q[rings])
        close(found.density[found.wavenumber > edges[0]][rings] * (2 * np.pi) ** 2, wanted[rings])


def test_heights_of_iso_25178():
    """Sq and the rms curvature as SurfaceTopography has them."""
    other, found = topography(SCAN), SCAN.statistics()
    assert found.rms_height == pytest.approx(other.rms_height_from_area(), rel=1e-12)
    heights = SCAN.heights - SCAN.heights.mean()
    assert found.sa == pytest.approx(np.abs(heights).mean()) and found.sku == pytest.approx(
        (heights**4).mean() / found.rms_height**4
    )


def test_the_page_of_a_surface(tmp_path):
    for name, surface in SURFACES.items():
        page = tmp_path / f"{name}.html"
        surface.report(page)
        text = page.read_text()
        figures = 7 if surface.n[1] == 1 else 11
        # Curves: heights, profile, spectrum, autocorrelation, its map, three or four distributions, slopes, curvatures,
        # bearing.
        assert text.startswith("<!DOCTYPE html>") and text.count("<figure>") == len(re.findall("<figcaption>", text))
        assert text.count("<figure>") >= figures and "<script" not in text and "certificates" not in text
        assert ("not periodic" in text) == (not surface.is_periodic)
    with pytest.raises(gfmd.InputError, match="no-such-folder"):
        SCAN.report(tmp_path / "no-such-folder" / "page.html")


def test_volumes_and_reduced_heights_are_integrals_of_the_bearing_curve():
    """The polygon of the sorted heights, integrated on a grid that is fine beside the points."""
    found = SCAN.statistics()
    heights = np.sort(np.ravel(SCAN.heights))[::-1] - SCAN.heights.mean()
    ratio = np.linspace(0.0, 1.0, heights.size)
    fine = np.linspace(0.0, 1.0, 400_001)
    curve = np.interp(fine, ratio, heights)

    def area(values, inside):
        return float(np.trapezoid(np.where(inside, values, 0.0), fine))

    high, low = np.interp([0.1, 0.8], ratio, heights)
    assert found.vmp == pytest.approx(area(curve - high, fine <= 0.1), rel=1e-3)
    assert found.vmc == pytest.approx(area(curve - low, fine <= 0.8) - found.vmp, rel=1e-3)
    assert found.vvv == pytest.approx(area(low - curve, fine >= 0.8), rel=1e-3)
    assert found.vvc == pytest.approx(area(high - curve, fine >= 0.1) - found.vvv, rel=1e-3)
    assert found.sdc == pytest.approx(high - low, rel=1e-12)
    top = heights[0] - found.spkx
    assert found.spk * found.smr1 / 2 == pytest.approx(area(curve - top, curve > top), rel=1e-2)
    assert top - found.sk == pytest.approx(heights[-1] + found.svkx, rel=1e-9)


def test_hills_and_dales_of_waves():
    """Three waves by two have six hills, with the heights, the density and the curvature of the waves."""
    x, y = np.meshgrid(np.arange(96) / 96, np.arange(64) / 64, indexing="ij")
    waves = gfmd.Surface(np.cos(6 * np.pi * x) + 0.5 * np.cos(4 * np.pi * y + 0.3), size=(3.0, 2.0))
    found = waves.statistics(features=True, boundary="periodic")
    assert (found.hills, found.dales, found.spd) == (6, 6, 1.0)
    assert found.s10z == pytest.approx(3.0, rel=1e-2)
    assert found.spc == pytest.approx(0.5 * ((2 * np.pi) ** 2 + 0.5 * (2 * np.pi) ** 2), rel=1e-2)
    assert found.mean_hill_area == pytest.approx(1.0)
    # Hills and dales at the edges do not count where the surface does not continue.
    assert waves.statistics(features=True, boundary="free").hills < 6
    assert waves.statistics(features=True, boundary="free", motif_edges="all").hills > 6
    # The smaller wave has hills of 1 of a range of 3 only.
    assert waves.statistics(features=True, boundary="periodic", wolf=0.5).hills < 6
    for given, words in (
        ({"wolf": 1.5}, "Wolf pruning is 1.5; it must be between 0 and 1"),
        ({"motif_edges": "none"}, "motif_edges is 'none'; it must be 'all', 'leave-out' or 'periodic'"),
        ({"boundary": "open"}, "boundary is 'open'; it must be 'periodic' or 'free'"),
    ):
        with pytest.raises(gfmd.InputError, match=words):
            waves.statistics(features=True, **given)


def test_a_surface_with_a_lay():
    """Its waves are longer along the lay, and Std, Str and the steepest direction show it."""
    made = [gfmd.self_affine(n=128, eps_t_inv=4, eps_f_inv=8, aspect=4, lay=30, seed=seed) for seed in range(4)]
    found = [one.statistics(features=True) for one in made]
    assert np.mean([one.str for one in found]) == pytest.approx(0.25, abs=0.08)
    for one, surface in zip(found, made):
        assert surface.rms_gradient == pytest.approx(0.1)
        off = (np.array([one.lay, one.std + 90, one.steepest + 90]) - 30 + 90) % 180 - 90
        assert np.abs(off).max() < 12, off
    with pytest.raises(gfmd.InputError, match="aspect is 5; it must be at most 4"):
        gfmd.self_affine(n=128, aspect=5)
    assert "aspect 4 along 30°" in made[0].description


def test_a_filtered_profile_has_the_parameters_of_profiles():
    """Sections are as long as the index of the L filter; Rz is the mean over them."""
    profile = gfmd.self_affine(n=512, dim=2, eps_f_inv=64, size=4.0, seed=5)
    unfiltered = profile.statistics()
    assert np.isnan(unfiltered.rz) and "L filter" in unfiltered.undefined["rz"]
    rough = profile.filter(s=0.05, l=0.8, edges="periodic")
    found = rough.statistics()
    heights = np.ravel(rough.heights)
    heights = heights - heights.mean()
    sections = heights[: 5 * 102].reshape(5, 102)
    assert found.sections == 5
    assert found.rz == pytest.approx(np.mean(sections.max(axis=1) - sections.min(axis=1)))
    assert found.rzx == pytest.approx(np.max(sections.max(axis=1) - sections.min(axis=1)))
    assert found.rq == pytest.approx(np.std(heights)) and found.ra == pytest.approx(np.mean(np.abs(heights)))
    assert 0 < found.rsm < 0.8 and found.rk == found.sk


def test_heights_of_a_given_distribution():
    options = dict(n=128, eps_t_inv=4, eps_f_inv=8, rms_gradient=0.1, seed=2)
    s = gfmd.self_affine(marginal="weibull:-1.5", **options)
    numbers = s.statistics()
    assert abs(numbers.ssk + 1.072) < 0.02 and abs(numbers.sku - 4.39) < 0.1
    assert s.rms_gradient == pytest.approx(0.1, rel=1e-12)
    assert "heights weibull:-1.5" in s.description
    # The normal surface has the same amplitudes, and so the same rms height.
    assert numbers.rms_height == pytest.approx(gfmd.self_affine(**options).statistics().rms_height, rel=1e-12)
    uniform = gfmd.self_affine(marginal=[(-1, 0), (1, 1)], **options).statistics()
    assert abs(uniform.sku - 1.8) < 0.05
    with pytest.raises(gfmd.InputError, match="marginal: it is 'normal'|marginal: it is \"normal\""):
        gfmd.self_affine(marginal="normal", **options)
    with pytest.raises(gfmd.InputError, match="marginal has the shape"):
        gfmd.self_affine(marginal=[1.0, 2.0], **options)
    with pytest.raises(gfmd.InputError, match="marginal: the heights lie .* away from the distribution"):
        gfmd.self_affine(marginal="lognormal:1", **options)


def test_an_uneven_profile():
    x = np.array([3.0, 0.0, 1.0, 1.5])
    s = gfmd.profile(x, 2 * x, n=7, unit="um")
    assert s.heights.shape == (7, 1) and s.unit == "µm"
    assert s.size[0] == pytest.approx(3.5) and np.allclose(s.heights[:, 0], np.arange(7.0))
    assert gfmd.profile(x, 2 * x).heights.shape == (3, 1)
    with pytest.raises(gfmd.InputError, match="given once"):
        gfmd.profile([0, 0, 1], [1, 2, 3])
    with pytest.raises(gfmd.InputError, match="at most 10, ten median spacings"):
        gfmd.profile([0, 1, 2, 13], [1, 2, 3, 4])
    with pytest.raises(gfmd.InputError, match="2 places with heights"):
        gfmd.profile([0, 1, 2], [1, 2])
