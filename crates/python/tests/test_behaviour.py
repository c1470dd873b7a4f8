"""Input, errors, interruption, threads, pickles, files."""

import multiprocessing
import pickle
import sys
import threading
import time

import gfmd
import h5py
import numpy as np
import pytest

BODY = gfmd.Body(young=1.0, poisson=0.3)
SMALL = gfmd.self_affine(n=32)


def solved(**options):
    return gfmd.contact(SMALL, BODY, p_star=0.05, **options)


def heights():
    return np.array(SMALL.heights)


@pytest.mark.parametrize(
    "given",
    [
        heights(),
        np.asfortranarray(heights()),
        heights().T.copy().T,
        np.concatenate([heights(), heights()], axis=1)[:, ::2][:, :16],
        heights().tolist(),
        heights()[::-1],
        heights().astype(">f8"),
        np.ma.array(heights()),
    ],
)
def test_layouts_of_one_array_are_one_surface(given):
    assert np.array_equal(gfmd.Surface(given).heights, np.asarray(given, dtype=float))
    assert gfmd.contact(given, BODY, p_star=0.05).area_fraction > 0.0


@pytest.mark.parametrize("kind", [np.float32, np.float16, np.int8, np.int64, np.uint16])
def test_other_real_types_work(kind):
    given = (np.arange(64).reshape(8, 8) % 7).astype(kind)
    assert gfmd.Surface(given).heights.dtype == np.float64
    assert gfmd.contact(given, BODY, p_star=0.1).converged


def test_a_read_only_array_works_and_the_copy_is_our_own():
    given = heights()
    surface = gfmd.Surface(given)
    given[:] = 0.0
    assert np.array_equal(surface.heights, SMALL.heights)
    given.flags.writeable = False
    gfmd.Surface(SMALL.heights)


@pytest.mark.parametrize(
    "given",
    [
        "text",
        b"text",
        None,
        1.0,
        [],
        [[]],
        [[1.0, 2.0], [3.0]],
        np.zeros((2, 2, 2)),
        np.zeros((0, 4)),
        np.zeros((1, 4)),
        np.zeros((4, 4), dtype=complex),
        np.zeros((4, 4), dtype=bool),
        np.array([["a", "b"], ["c", "d"]]),
        np.array([[None, 1], [2, 3]]),
        np.full((4, 4), np.nan),
        np.array([[0.0, np.inf], [1.0, 2.0]]),
        np.ma.array(np.zeros((4, 4)), mask=np.eye(4)),
        {"a": 1},
        object(),
    ],
)
def test_unusable_heights_are_refused_in_one_line(given):
    with pytest.raises(gfmd.InputError) as reported:
        gfmd.Surface(given)
    assert "\n" not in str(reported.value) and str(reported.value).startswith("heights ")
    assert isinstance(reported.value, ValueError) and isinstance(reported.value, gfmd.Error)


@pytest.mark.parametrize(
    "call, words",
    [
        (lambda: gfmd.contact(SMALL, BODY), "the load is given by none"),
        (lambda: gfmd.contact(SMALL, BODY, p_star=1, approach=1), "the load is given by p_star, approach"),
        (lambda: gfmd.contact(SMALL, BODY, p_star=-1), "p_star is -1.0; it must be positive and finite"),
        (lambda: gfmd.contact(SMALL, BODY, pressure="1"), "pressure is '1'"),
        (lambda: gfmd.contact(SMALL, BODY, pressure=np.nan), "pressure is nan"),
        (lambda: gfmd.contact(SMALL, BODY, approach=1e9), "approach: the approach is 1000000000"),
        (lambda: gfmd.contact(SMALL, 1.0, p_star=1), "body is float"),
        (lambda: gfmd.contact(SMALL, BODY, p_star=1, solver="best"), 'solver is "best": it must be one of auto, cg'),
        (lambda: gfmd.contact(SMALL, BODY, p_star=1, solver="newton"), "solver: the solver is newton"),
        (
            lambda: gfmd.contact(SMALL, BODY, p_star=1, tolerance=1.0),
            "tolerance: the tolerance is 1e0; it must be between",
        ),
        (
            lambda: gfmd.contact(SMALL, BODY, p_star=1, dt=0.1),
            'dt is 0.1; it must be left out without solver="verlet-critical"',
        ),
        (lambda: gfmd.contact(SMALL, BODY, p_star=1, threads=-1), "threads is -1"),
        (lambda: gfmd.contact(SMALL, BODY, p_star=1, threads=10**9), "threads is 1000000000"),
        (lambda: gfmd.contact(SMALL, BODY, p_star=1, max_iterations=1.5), "max_iterations is 1.5"),
        (lambda: gfmd.contact(SMALL, BODY, p_star=1, law=3), "law is 3"),
        (lambda: gfmd.contact(SMALL, BODY, p_star=1, law="glue"), 'the law is "glue"'),
        (lambda: gfmd.contact(SMALL, BODY, p_star=1, start=3), "start is int"),
        (lambda: gfmd.contact(np.zeros((8, 8)), BODY, p_star=1), "surface: "),
        (lambda: gfmd.contacts(SMALL, BODY, p_star=[]), "p_star is empty"),
        (lambda: gfmd.contacts(SMALL, BODY, p_star=[0.1, None]), "p_star is None"),
        (lambda: gfmd.contact(SMALL, BODY, pressure=np.array(True)), "pressure is array(True); it must be a number"),
        (lambda: gfmd.interior(None, quantities=np.array(1.0)), "quantities is array(1.); it must be texts"),
        (
            lambda: gfmd.slide(SMALL, gfmd.Body(prony=[(1.0, 0.5)]), p_star=1, velocity=1, heat=np.array(1.0)),
            "heat is array(1.); it must be two numbers",
        ),
        (lambda: gfmd.Body(young=-1), "young is -1.0"),
        (lambda: gfmd.Body(poisson=0.6), "poisson is 0.6"),
        (lambda: gfmd.Body(height=0), "height is 0.0"),
        (lambda: gfmd.Body(1, e_star=1), "young and e_star"),
        (lambda: gfmd.law("morse", gamma=1), "the law morse needs"),
        (lambda: gfmd.law("morse", gamma=1, range=-1), ""),
        (lambda: gfmd.self_affine(n=1), "n is 1; it must be at least 2"),
        (lambda: gfmd.self_affine(n="64"), "n is '64'"),
        (lambda: gfmd.self_affine(n=-64), "n is -64"),
        (lambda: gfmd.self_affine(n=2**40), "n: "),
        (lambda: gfmd.self_affine(n=64, hurst=2), "hurst: "),
        (lambda: gfmd.self_affine(n=64, method="x"), "method is"),
        (lambda: gfmd.self_affine(n=64, eps_t_inv=0.1), "eps_t_inv is 0.1; it must be between 1 and"),
        (lambda: gfmd.Surface(np.eye(4), size=(1, 2, 3)), "size is (1, 2, 3)"),
        (lambda: gfmd.Surface(np.eye(4), size=-1), "size is -1"),
        (lambda: gfmd.read("nowhere.npy"), "nowhere.npy"),
        (lambda: gfmd.read(3), "name is 3"),
        (lambda: SMALL.detrend("bow"), "detrend: it must be none, plane"),
        (lambda: gfmd.kappa_sweep("nothing"), 'preset is "nothing": it must be one of smoke, default'),
        (
            lambda: gfmd.kappa_sweep({"loads": {"p_star": 2**63}}),
            "p_star is 9223372036854775808; it must be between -9223372036854775808 and 9223372036854775807",
        ),
        (lambda: gfmd.load("nowhere.h5"), "cannot open nowhere.h5"),
        (lambda: gfmd.green(BODY, qx=np.nan), "qx is nan"),
        (lambda: gfmd.punch(n=2**40), ""),
    ],
)
def test_unusable_arguments_are_named(call, words):
    with pytest.raises(gfmd.InputError) as reported:
        call()
    text = str(reported.value)
    assert text.startswith(words) and "\n" not in text and "--" not in text, text


def test_a_search_that_gives_up_keeps_its_state():
    with pytest.raises(gfmd.NotConverged, match="did not converge") as reported:
        solved(max_iterations=1)
    state = reported.value.state
    assert not state.converged and 0.0 < state.area_fraction < 1.0
    again = pickle.loads(pickle.dumps(reported.value))
    assert again.state.area_fraction == state.area_fraction
    with pytest.raises(gfmd.NotConverged, match="load 0") as reported:
        gfmd.contacts(SMALL, BODY, p_star=[0.1, 0.2], max_iterations=1)
    assert len(reported.value.state) == 1


def test_results_are_frozen_and_pickle():
    contact = solved()
    for name in ("pressure", "gap", "area_fraction", "news"):
        with pytest.raises(AttributeError):
            setattr(contact, name, 1)
    with pytest.raises(ValueError):
        contact.pressure[0, 0] = 1.0
    with pytest.raises(ValueError):
        contact.surface.heights[0, 0] = 1.0
    for result in (
        contact,
        gfmd.contacts(SMALL, BODY, p_star=[0.01, 0.02]),
        SMALL,
        BODY,
        gfmd.law("morse", gamma=1, range=1),
        SMALL.statistics(),
    ):
        again = pickle.loads(pickle.dumps(result))
        assert repr(again) == repr(result) and type(again) is type(result)
    assert gfmd.Body(e_star=2.0, poisson=0.2) == pickle.loads(pickle.dumps(gfmd.Body(e_star=2.0, poisson=0.2)))
    assert float(contact.residual) <= 1e-8


def test_a_start_spares_iterations():
    first = gfmd.contact(SMALL, BODY, p_star=0.05)
    near = gfmd.contact(SMALL, BODY, p_star=0.0501, start=first)
    cold = gfmd.contact(SMALL, BODY, p_star=0.0501)
    assert near.iterations < cold.iterations
    resumed = gfmd.contact(SMALL, BODY, p_star=0.0501, start=pickle.loads(pickle.dumps(first)))
    assert resumed.iterations < cold.iterations
    law = gfmd.law("morse", gamma=1e-4, range=5e-3)
    with pytest.raises(gfmd.InputError, match="hard wall"):
        gfmd.contact(SMALL, BODY, p_star=0.05, law=law, start=first)
    with pytest.raises(gfmd.InputError, match="start has"):
        gfmd.contact(gfmd.self_affine(n=64), BODY, p_star=0.05, start=first)


def test_threads_change_no_bit():
    one, two = solved(threads=1), solved(threads=2)
    assert one.pressure.tobytes() == two.pressure.tobytes()


def test_other_python_threads_run_while_it_computes():
    large = gfmd.self_affine(n=512)
    counts, stop = [0], threading.Event()

    def count():
        while not stop.is_set():
            counts[0] += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    started = time.perf_counter()
    gfmd.contact(large, BODY, p_star=0.05, threads=1, tolerance=1e-12)
    seconds, counted = time.perf_counter() - started, counts[0]
    stop.set()
    thread.join()
    assert counted > 50.0 * seconds


def _area(n):
    return gfmd.contact(gfmd.self_affine(n=n), BODY, p_star=0.05).area_fraction


@pytest.mark.skipif(sys.platform == "win32", reason="no fork")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_forked_processes_compute_too():
    here = _area(32)
    with multiprocessing.get_context("fork").Pool(2) as pool:
        assert pool.map_async(_area, [32, 32]).get(60) == [here, here]


def test_files_come_back(tmp_path):
    contacts = gfmd.contacts(SMALL, BODY, p_star=[0.01, 0.05])
    contacts.save(tmp_path / "c.h5")
    again = gfmd.load(tmp_path / "c.h5")
    assert len(again) == 2 and np.array_equal(again.gap, contacts.gap) and again[0].body == BODY
    law = gfmd.law("morse", gamma=2e-4, range=2e-3)
    apart = gfmd.contact(SMALL, BODY, approach=-0.001, law=law)
    apart.save(tmp_path / "e.h5")
    again = gfmd.load(tmp_path / "e.h5")
    assert (
        again.law == law and again.interface_energy == apart.interface_energy and repr(again.kappa) == repr(apart.kappa)
    )


def test_warnings_of_the_libraries_are_warnings():
    with pytest.warns(UserWarning, match="trap|grid|range") as reported:
        gfmd.contact(
            SMALL,
            BODY,
            approach=0.0005,
            law=gfmd.law("exponential", gamma=2e-4, range=1e-4),
            max_iterations=10**4,
            coarse=True,
        )
    assert reported[0].filename == __file__


def test_what_comes_out_is_c_ordered_float64():
    contact = solved()
    for field in (contact.pressure, contact.gap, contact.displacement_z):
        assert field.dtype == np.float64 and field.flags.c_contiguous and field.shape == (32, 32)


def test_the_overhead_of_a_call_is_small():
    surface = gfmd.self_affine(n=256)
    start = gfmd.contact(surface, BODY, p_star=0.05)
    best = np.inf
    for _ in range(40):
        before = time.perf_counter()
        contact = gfmd.contact(surface, BODY, p_star=0.05, start=start, threads=1)
        best = min(best, time.perf_counter() - before - contact.seconds)
    # About 1 ms on a quiet machine, with the scalars measured on the fields; a busy one takes some times that.
    assert best < 1e-2, best


def test_a_step_of_a_path_has_the_numbers_of_the_contact():
    slab, base = gfmd.Body(young=1.0, poisson=0.3, height=0.5), np.zeros((32, 32, 3))
    base[:, 0, 2] = 1e-3
    rubber = gfmd.Body(young=1.0, poisson=0.3)
    same = dict(p_star=0.05, tolerance=1e-9)
    for body, options in ((slab, {"base_displacement": base}), (rubber, {"components": "held"}), (rubber, {})):
        pressed = gfmd.contact(SMALL, body, **same, **options)
        path = gfmd.path(SMALL, body, **same, **options, statistics=True, conductivity=[3.0, 0.5], conductor_height=0.3)
        step = path.steps
        assert abs(step.approach[0] / pressed.approach - 1) < 1e-6 and np.allclose(
            path.displacement_z[0], pressed.displacement_z, atol=1e-7
        )
        patches = pressed.patches()
        assert step.patches[0] == len(patches.area) and step.largest_patch_fraction[0] == patches.area.max()
        conductance = pressed.conductance(conductor_height=0.3)
        assert abs(step.conductance[0] / conductance - 1) < 1e-6
        assert abs(step.contact_conductance[0] / pressed.conductance(3.0, 0.5, conductor_height=0.3) - 1) < 1e-6
        assert step.percolates_x.shape == (1,)


def test_every_option_of_the_description_is_one_of_python(tmp_path):
    slab, base = gfmd.Body(young=1.0, poisson=0.3, height=0.5), np.zeros((32, 32, 3))
    base[..., 2] = 1e-3
    moved, still = (
        gfmd.contact(SMALL, slab, p_star=0.05, tolerance=1e-10, **given) for given in ({"base_displacement": base}, {})
    )
    # A base that moves as a whole takes the slab along.
    assert np.abs(moved.displacement_z - still.displacement_z - 1e-3).max() < 1e-8 and np.allclose(
        moved.gap, still.gap, atol=1e-8
    )
    base[:, 0, 2] += 1e-4
    moved = gfmd.contact(SMALL, slab, p_star=0.05, base_displacement=base)
    moved.save(tmp_path / "moved.h5")
    again = gfmd.load(tmp_path / "moved.h5")
    assert np.array_equal(again.displacement_z, moved.displacement_z)
    warm, cold = (
        gfmd.contact(SMALL, slab, p_star=0.0501, base_displacement=base, start=start) for start in (again, None)
    )
    assert warm.iterations < cold.iterations and abs(warm.area_fraction - cold.area_fraction) < 1e-3
    damped = [
        gfmd.contact(SMALL, slab, p_star=0.05, components="all", solver="verlet-critical", **options)
        for options in ({}, {"damping": [1.0, 1.0, 0.9]})
    ]
    assert damped[0].iterations != damped[1].iterations
