"""Studies of many contacts."""

import pickle
import re
import subprocess
import sys

import numpy as np
import pytest

import gfmd

STUDY = {
    "command": "contact",
    "contact": {"n": 16, "eps_f_inv": 4, "p_star": [0.02, 0.1]},
    "study": {
        "surface": [{"name": "smooth", "hurst": 0.9}, {"name": "rough", "hurst": 0.3}],
        "seed": "1:3",
        "body": [{"name": "soft", "young": 1.0}, {"name": "thin", "height": 0.1, "poisson": 0.3}],
    },
}


@pytest.fixture(scope="module")
def made():
    return gfmd.study(STUDY)


def test_a_study_has_the_numbers_of_single_contacts(made):
    surface = gfmd.self_affine(n=16, eps_f_inv=4, hurst=0.3, seed=2)
    alone = gfmd.contacts(surface, gfmd.Body(height=0.1, poisson=0.3), p_star=[0.02, 0.1])
    assert made.numbers.area_fraction.shape == (2, 3, 2, 2)
    for name in ("area_fraction", "mean_gap", "approach"):
        assert made.numbers[name][1, 1, 1].tolist() == [getattr(c, name) for c in alone]
    assert (made.status == "solved").all() and not any(made.error.ravel())
    assert made.coordinates.seed.tolist() == [1, 2, 3] and made.coordinates.load.tolist() == [0.02, 0.1]
    row = next(row for row in made.means if (row.surface, row.body, row.load) == ("rough", "thin", 0.1))
    values = made.numbers.area_fraction[1, :, 1, 1]
    assert row.numbers.area_fraction.mean == pytest.approx(values.mean(), rel=1e-14)
    assert row.numbers.area_fraction.standard_error == pytest.approx(values.std(ddof=1) / np.sqrt(3), rel=1e-12)


def test_the_file_opens_in_xarray_as_the_same_cube(made, tmp_path):
    xarray = pytest.importorskip("xarray")
    engine = next((name for name in ("h5netcdf", "netcdf4") if name in xarray.backends.list_engines()), None)
    made.save(tmp_path / "study.h5")
    cube = made.to_xarray()
    assert cube.area_fraction.dims == ("surface", "seed", "body", "load")
    assert cube.mean_gap.units == "length" and cube.mean_gap.long_name
    assert float(cube.area_fraction.sel(surface="rough", seed=2, body="thin", load=0.1)) > 0
    if engine is None:
        pytest.skip("neither h5netcdf nor netCDF4 is installed")
    stored = xarray.open_dataset(tmp_path / "study.h5", group="study", engine=engine)
    for name in ("area_fraction", "mean_gap", "iterations"):
        assert stored[name].dims == cube[name].dims
        np.testing.assert_array_equal(stored[name].values, cube[name].values)
    assert stored.body.values.tolist() == ["soft", "thin"] and stored["load"].values.tolist() == [0.02, 0.1]


def test_dimension_scales_have_their_names(made, tmp_path):
    h5py = pytest.importorskip("h5py")
    made.save(tmp_path / "study.h5")
    with h5py.File(tmp_path / "study.h5") as file:
        values = file["study/area_fraction"]
        assert [dim[0].name.split("/")[-1] for dim in values.dims] == ["surface", "seed", "body", "load"]


def test_a_study_is_shown_kept_and_compared(made, tmp_path):
    assert len(repr(made).splitlines()) <= 15 and "12 members, 0 failed" in repr(made)
    assert pickle.loads(pickle.dumps(made)) == made
    again = gfmd.study(STUDY, out=tmp_path / "s.h5", threads=1, progress=False)
    assert again == made and (tmp_path / "s.h5").exists()
    assert not (tmp_path / "s.h5.journal").exists()
    assert gfmd.load(tmp_path / "s.h5") == made
    made.report(tmp_path / "s.html")
    assert len(made.figures()) >= 3
    pytest.importorskip("matplotlib")
    assert len(made.plot("mean_gap").get_legend().get_texts()) == 4
    with pytest.raises(gfmd.InputError, match="nothing is no number of the study|no number of the study"):
        made.plot("nothing")


LONG = {"command": "contact", "contact": {"n": 512, "p_star": [0.02, 0.1]}, "study": {"seed": "1:4"}}


@pytest.mark.parametrize(
    ("shown", "call", "wanted"),
    [
        (True, f"study({LONG}, threads=1)", r"study: 2 of 4, .*seed 3, .*: [01] of 2 loads"),
        (True, "kappa_sweep('smoke', threads=1)", r"kappa-sweep: [1-9]\d* of \d\d+, H = 0\.8, n = \d+"),
        (True, f"study({LONG}, progress=False)", ""),
        (False, f"study({LONG})", ""),
    ],
)
def test_progress_counts_members_and_runs(shown, call, wanted):
    code = (
        "import sys\nsys.modules['tqdm'] = None\nimport gfmd, gfmd._progress\ngfmd._progress._PATIENCE = 0.0\n"
        f"gfmd.progress({shown})\ngfmd.{call}\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0 and done.stdout == "", done.stderr
    lines = done.stderr.splitlines()
    assert any(re.match(wanted, line) for line in lines) if wanted else not done.stderr, lines[-5:]


def test_a_member_that_fails_is_in_the_state():
    config = {**STUDY, "study": {"body": [{"name": "one", "young": 1.0}, {"name": "none", "max_iterations": 1}]}}
    with pytest.raises(gfmd.NotConverged, match="1 of 2 members failed") as raised:
        gfmd.study(config)
    assert raised.value.state.status.ravel().tolist() == ["solved", "failed"]
    assert np.isnan(raised.value.state.numbers.area_fraction[0, 0, 1]).all()


@pytest.mark.parametrize(
    ("config", "text"),
    [
        ({"command": "punch"}, "contact"),
        ({**STUDY, "x": 1}, "must be one of command, contact, study"),
        ({**STUDY, "study": {"seed": []}}, "seed is empty"),
        ({**STUDY, "study": {"seed": [1, 1]}}, "twice"),
        ("absent.toml", "absent.toml"),
    ],
)
def test_bad_studies_are_refused(config, text):
    with pytest.raises(gfmd.InputError, match=text):
        gfmd.study(config)
