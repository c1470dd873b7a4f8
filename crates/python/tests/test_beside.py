"""Beside other packages: SurfaceTopography, xarray, matplotlib, pyvista, notebooks, progress bars; and files of
instruments.
"""

import struct
import subprocess
import sys
from pathlib import Path

import gfmd
import numpy as np
import pytest

BODY = gfmd.Body(young=1.0, poisson=0.3)
SMALL = gfmd.self_affine(n=32)
FILES = Path(__file__).parents[2] / "topography" / "tests" / "data"


def test_objects_like_topographies_are_taken_as_they_are():
    class Topography:
        physical_sizes = (2.0, 3.0)
        nb_grid_pts = (8, 12)
        unit = "µm"

        def heights(self):
            return np.arange(96.0).reshape(8, 12)

    surface = gfmd.Surface(Topography())
    assert surface.size == (2.0, 3.0) and surface.unit == "µm" and surface.n == (8, 12)
    assert gfmd.contact(Topography(), BODY, p_star=0.05).surface.size == (2.0, 3.0)


def test_topographies_are_taken_as_they_are():
    package = pytest.importorskip("SurfaceTopography")
    heights = np.array(SMALL.heights)
    surface = gfmd.Surface(package.Topography(heights, (2.0, 2.0), unit="µm", periodic=True))
    assert np.array_equal(surface.heights, heights) and surface.size == (2.0, 2.0) and surface.unit == "µm"
    flat = package.Topography(heights, (2.0, 2.0)).detrend("center")
    assert gfmd.contact(flat, BODY, p_star=0.05).surface.size == (2.0, 2.0)
    line = gfmd.Surface(package.UniformLineScan(heights[0], 3.0, unit="nm"))
    assert line.n == (32, 1) and line.size[0] == 3.0 and line.unit == "nm"
    # The rms gradient is that of another package but for the seam of finite differences.
    smooth = gfmd.self_affine(n=128, eps_f_inv=4)
    other = package.Topography(np.array(smooth.heights), (1.0, 1.0), periodic=True).rms_gradient()
    assert abs(smooth.rms_gradient / other - 1.0) < 0.03


def test_topographies_that_are_no_whole_grid_are_refused():
    package = pytest.importorskip("SurfaceTopography")
    holed = package.Topography(np.ma.array(np.array(SMALL.heights), mask=SMALL.heights > 0.01), (1.0, 1.0))
    holes = int((SMALL.heights > 0.01).sum())
    assert holes > 0
    with pytest.raises(gfmd.InputError, match=f"heights has {holes} undefined points of 1024"):
        gfmd.Surface(holed)
    filled = gfmd.Surface(holed, fill="harmonic")
    assert filled.undefined == holes and filled.heights[SMALL.heights > 0.01].max() <= 0.01
    with pytest.raises(gfmd.InputError, match="not at equal distances"):
        gfmd.Surface(package.NonuniformLineScan([0.0, 1.0, 3.0], [0.0, 1.0, 0.0]))


def test_undefined_points_are_refused_or_filled():
    heights = np.array(SMALL.heights)
    heights[3:5, 7] = np.nan
    with pytest.raises(
        gfmd.InputError, match=r"heights has 2 undefined points of 1024, the first at \[3, 7\]; .* fill='harmonic'"
    ):
        gfmd.Surface(heights)
    for fill in ("harmonic", "nearest"):
        surface = gfmd.Surface(heights, fill=fill)
        assert surface.undefined == 2 and np.isfinite(surface.heights).all() and fill in repr(surface)
        kept = np.isfinite(heights)
        assert np.array_equal(surface.heights[kept], heights[kept])
    with pytest.raises(gfmd.InputError, match="fill is 'best'"):
        gfmd.Surface(heights, fill="best")
    heights[0, 0] = np.inf
    with pytest.raises(gfmd.InputError, match="1 infinite points"):
        gfmd.Surface(heights, fill="nearest")
    with pytest.raises(gfmd.InputError):
        gfmd.Surface(np.full((4, 4), np.nan), fill="nearest")


def test_channels_of_a_file_are_read_by_name_and_number():
    first, named = (gfmd.read(FILES / "two.npz", channel) for channel in (0, 1))
    assert len(first.channels) == 2 and first.channels == named.channels and named.channel == named.channels[1]
    assert np.array_equal(gfmd.read(FILES / "two.npz", named.channels[1]).heights, named.heights)
    assert first.format and isinstance(first.details, dict)
    with pytest.raises(gfmd.InputError, match="two.npz"):
        gfmd.read(FILES / "two.npz", "no such channel")
    with pytest.raises(gfmd.InputError, match="channel is -1"):
        gfmd.read(FILES / "two.npz", -1)
    holed = gfmd.read(FILES / "holes.nc")
    with pytest.raises(gfmd.InputError, match="undefined"):
        gfmd.contact(holed, gfmd.Body(), p_star=0.1)
    heights, size, unit = gfmd.read_heights(FILES / "holes.nc")
    filled = gfmd.read(FILES / "holes.nc", fill="nearest")
    kept = np.isfinite(heights)
    assert (~kept).sum() == filled.undefined and np.array_equal(filled.heights[kept], heights[kept])
    assert np.array_equal(holed.fill("nearest").heights, filled.heights)
    assert (unit, size) == (filled.unit, filled.size)
    # A part without holes: a row without them is one.
    rows = np.flatnonzero(kept.all(axis=1))
    assert len(rows) and gfmd.Surface(heights[rows[0]], unit=unit).undefined == 0
    assert filled.undefined > 0 and np.isfinite(filled.heights).all()
    assert filled.flip().undefined == filled.undefined and filled.flip().format == filled.format


def test_figures_and_notebooks():
    matplotlib = pytest.importorskip("matplotlib")
    contacts = gfmd.contacts(SMALL, BODY, p_star=[0.01, 0.05])
    loop = gfmd.path(SMALL, BODY, p_star=[0.01, 0.05], steps=2)
    for drawn in (
        SMALL.plot(),
        contacts.plot(),
        contacts[0].plot(),
        contacts[0].plot("gap"),
        gfmd.self_affine(n=32, dim=2).plot(),
        loop.plot(),
    ):
        assert isinstance(drawn, matplotlib.axes.Axes)
        matplotlib.pyplot.close(drawn.figure)
    assert "data:image/png;base64" in SMALL._repr_html_() and "<img" not in gfmd.self_affine(n=32, dim=2)._repr_html_()
    # Results are shown with the first figures of their page, lightly.
    line = gfmd.contact(gfmd.self_affine(n=32, dim=2), BODY, p_star=0.05)
    large = gfmd.contact(gfmd.self_affine(n=512, eps_f_inv=4), BODY, p_star=0.05)
    for result in (contacts, contacts[0], loop, gfmd.punch(n=16), line, large):
        text = result._repr_html_()
        assert text.count("data:image/svg+xml;base64") in (1, 2) and len(text) < 125_000, type(result)
        assert text.count("<table>") == text.count("</table>") > 0
    assert "<img" not in contacts[:0]._repr_html_()


def test_the_small_map_is_a_picture():
    from gfmd._show import _png

    data = _png(np.array(SMALL.heights))
    assert data.startswith(b"\x89PNG") and struct.unpack(">II", data[16:24]) == (32, 32)
    pillow = pytest.importorskip("PIL.Image")
    import io

    picture = np.asarray(pillow.open(io.BytesIO(data)), dtype=float)
    heights = SMALL.heights
    wanted = 255 * (heights - heights.min()) / (heights.max() - heights.min())
    assert np.abs(picture[::-1].T - wanted).max() < 1.01  # x to the right, y upwards


def test_xarray():
    pytest.importorskip("xarray")
    contacts = gfmd.contacts(SMALL, BODY, p_star=[0.01, 0.05])
    data = contacts.to_xarray()
    assert data.pressure.dims == ("load", "y", "x") and float(data.area_fraction[1]) == contacts[1].area_fraction
    assert float(data.x[1]) == 1 / 32 and "units" not in data.height.attrs
    assert contacts[0].to_xarray().gap.shape == (32, 32)
    loop = gfmd.friction(SMALL, BODY, coefficient=0.3, p_star=0.05, lateral=[0, 0.001], steps=2).to_xarray()
    assert loop.shear_x.dims == ("waypoint", "y", "x") and loop.lateral.dims == ("step", "axis")


def test_data_arrays_of_xarray_keep_their_axes_and_size():
    pytest.importorskip("xarray")
    wide = gfmd.self_affine(n=(24, 16), size=(3.0, 2.0), eps_f_inv=4, unit="um")
    height = wide.to_xarray().height
    assert height.dims == ("y", "x")
    for given in (height, height.transpose("x", "y")):
        assert gfmd.Surface(given) == wide
    assert gfmd.Surface(height.drop_vars(["x", "y"])).size == (1.0, 16 / 24)
    uneven = height.assign_coords(x=height.x**2)
    for wrong, reason in [
        (height.rename(x="a"), "heights has the dimensions"),
        (uneven, "the coordinates x of heights are uneven or fall"),
        (height.isel(y=slice(None, None, -1)), "the coordinates y of heights are uneven or fall"),
    ]:
        with pytest.raises(gfmd.InputError, match=reason):
            gfmd.Surface(wrong)


def test_pyvista():
    pytest.importorskip("pyvista")
    contact = gfmd.contact(gfmd.self_affine(n=(32, 16), size=(1.0, 2.0)), BODY, p_star=0.05)
    grid = contact.to_pyvista()
    assert grid.dimensions == (32, 16, 1) and grid.spacing[:2] == (1 / 32, 2 / 16)
    at = grid.find_closest_point((3 / 32, 5 * 2 / 16, 0.0))
    assert (
        grid.point_data["gap"][at] == contact.gap[3, 5]
        and grid.point_data["height"][at] == contact.surface.heights[3, 5]
    )
    assert contact.surface.to_pyvista().dimensions == (32, 16, 1)


@pytest.mark.parametrize("call", ["s.plot()", "c.to_xarray()", "c.to_pyvista()"])
def test_packages_that_are_not_installed_are_named(call):
    code = (
        "import sys\nfor name in ('matplotlib', 'xarray', 'pyvista'):\n    sys.modules[name] = None\n"
        "import gfmd\ns = gfmd.self_affine(n=16)\nc = gfmd.contact(s, gfmd.Body(), p_star=0.1)\n"
        f"try:\n    {call}\nexcept gfmd.Error as error:\n    print(error)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert "needs" in done.stdout and "pip install" in done.stdout, done.stderr


LONG = (
    "gfmd.contact(gfmd.self_affine(n=64), gfmd.Body(), p_star=0.02, solver='verlet-critical', tolerance=1e-15,"
    " max_iterations=10**9)"
)


@pytest.mark.parametrize(
    "shown, tqdm, wanted",
    [("True", True, "contact"), ("True", False, "contact: 0 of 1, iteration"), ("False", True, ""), ("None", True, "")],
)
def test_progress_is_shown_after_a_second(shown, tqdm, wanted):
    if tqdm:
        pytest.importorskip("tqdm")
    code = (
        "import gfmd, os, signal, threading, time\nimport sys\n"
        f"{'' if tqdm else 'sys.modules[chr(116) + chr(113) + chr(100) + chr(109)] = None'}\n"
        f"signal.signal(signal.SIGINT, signal.default_int_handler)\ngfmd.progress({shown})\n"
        f"threading.Timer(2.5, os.kill, (os.getpid(), signal.SIGINT)).start()\n"
        f"try:\n    {LONG}\nexcept gfmd.Interrupted:\n    pass\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert (wanted in done.stderr if wanted else not done.stderr) and done.stdout == ""


def test_height_parameters_and_spectrum_are_those_of_surface_topography():
    package = pytest.importorskip("SurfaceTopography")
    rough = gfmd.self_affine(n=64, eps_f_inv=8, size=3.0)
    skewed = gfmd.Surface(np.exp(8.0 * rough.heights), size=3.0)
    for surface in (rough, skewed):
        heights, found = np.array(surface.heights), surface.statistics()
        other = package.Topography(heights, (3.0, 3.0), periodic=True)
        assert found.rms_height == pytest.approx(other.rms_height_from_area(), rel=1e-12)
        # Its bearing area says how much lies above a height: the moments of the heights, by parts.
        levels = np.linspace(found.lowest, found.highest, 20_001)
        above = other.bearing_area(levels)
        low = np.trapezoid(1.0 - above, levels)
        assert found.highest - low == pytest.approx(found.mean, abs=2e-3 * found.peak_to_valley)
        distance = heights - heights.mean()
        assert found.sa == pytest.approx(np.abs(distance).mean(), rel=1e-12)
        assert found.ssk == pytest.approx((distance**3).mean() / distance.std() ** 3, rel=1e-9, abs=1e-12)
        assert found.sku == pytest.approx((distance**4).mean() / distance.std() ** 4, rel=1e-12)
        assert (found.sp, found.sv) == pytest.approx((distance.max(), -distance.min()))
        # The spectrum, of which theirs is an average over rings of another width; its integral over q is (2 pi)^2 times
        # the mean square.
        q, density = other.power_spectrum_from_area()
        own = surface.psd()
        band = (own.wavenumber > 8.0) & (own.wavenumber < 16.0)
        theirs = np.exp(np.interp(np.log(own.wavenumber[band]), np.log(q[1:]), np.log(density[1:])))
        assert np.abs(np.log((2.0 * np.pi) ** 2 * own.density[band] / theirs)).mean() < 0.1
    assert rough.statistics().sdr == pytest.approx(0.5 * rough.statistics().rms_gradient_inside ** 2, rel=0.02)


def test_both_directions_of_a_loop_and_the_contact_in_a_gap_are_told_apart():
    matplotlib = pytest.importorskip("matplotlib")
    surface = gfmd.self_affine(n=32, size="2 um", unit="m")
    loop = gfmd.path(surface, gfmd.Body(e_star="1 GPa"), p_star=[0.01, 0.1, 0.01], steps=3)
    ax = loop.plot("approach", "area_fraction")
    there, back = ax.lines
    assert [line.get_label() for line in ax.lines] == [
        "rising",
        "falling",
    ] and there.get_linestyle() != back.get_linestyle()
    assert (
        there.get_xdata()[-1] == back.get_xdata()[0]
        and len(there.get_xdata()) + len(back.get_xdata()) == len(loop.steps["approach"]) + 1
    )
    assert ax.get_xlabel() == "approach (nm)" and ax.get_ylabel() == "area fraction"
    contact = gfmd.contact(surface, gfmd.Body(e_star="1 GPa"), p_star=0.1)
    ax = contact.plot("gap")
    marked, gaps = (image.get_array() for image in ax.images)
    assert np.array_equal(np.ma.filled(np.ma.masked_invalid(marked), 0.0).T > 0.0, contact.touching)
    assert np.array_equal(np.ma.getmaskarray(np.ma.masked_invalid(gaps)).T, contact.touching)
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["contact"]
    matplotlib.pyplot.close("all")
