"""Ctrl-C, and other exceptions while it computes: it stops, and what is done is kept."""

import gc
import os
import pickle
import signal
import sys
import threading
import time
from pathlib import Path

import gfmd
import numpy as np
import pytest

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="no such signals")

BODY = gfmd.Body(poisson=0.3)
SMALL = gfmd.self_affine(n=32)
ENDLESS = dict(solver="verlet-critical", tolerance=1e-15, max_iterations=10**9)


@pytest.fixture
def no_finalisers():
    """Python loses an exception that a signal raises in a finaliser, such as those of figures of other tests."""
    gc.collect()
    gc.disable()
    yield
    gc.enable()


@pytest.fixture
def ctrl_c(no_finalisers):
    """Presses Ctrl-C some time after it is called. A shell in the background has the signal ignored, Python then
    too.
    """
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    over = threading.Event()

    def press(seconds=0.5, when=None):
        def wait():
            if when is None:
                over.wait(seconds)
            while when is not None and not when() and not over.wait(0.005):
                pass
            if not over.is_set():
                os.kill(os.getpid(), signal.SIGINT)

        threading.Thread(target=wait).start()

    yield press
    over.set()
    signal.signal(signal.SIGINT, before)


def interrupted(call):
    started = time.perf_counter()
    with pytest.raises(gfmd.Interrupted) as reported:
        call()
    assert time.perf_counter() - started < 20.0
    assert isinstance(reported.value, KeyboardInterrupt) and not isinstance(reported.value, Exception)
    assert str(reported.value).count("\n") == 0
    return reported.value


def test_a_contact_keeps_its_state_and_goes_on(ctrl_c):
    ctrl_c()
    error = interrupted(lambda: gfmd.contact(SMALL, BODY, p_star=0.02, **ENDLESS))
    state = error.state
    assert state.iterations > 0 and state.pressure.shape == (32, 32) and not state.converged
    assert pickle.loads(pickle.dumps(error)).state.iterations == state.iterations
    assert gfmd.contact(SMALL, BODY, p_star=0.02, start=state).converged


def test_contacts_keep_the_loads_that_are_done(ctrl_c):
    ctrl_c(1.0)
    loads = np.linspace(0.01, 0.1, 20_000)
    error = interrupted(lambda: gfmd.contacts(SMALL, BODY, p_star=loads))
    done = error.state
    assert isinstance(done, gfmd.Contacts) and 1 < len(done) < len(loads)
    assert all(contact.converged for contact in done[:-1])
    assert np.allclose(done[:-1].p_star, loads[: len(done) - 1])


@pytest.mark.parametrize(
    "options",
    [
        dict(law=gfmd.law("exponential", gamma=1e-4, range=5e-3), approach=[-0.003, 0.01]),
        dict(friction=0.3, p_star=0.05, lateral=[0.0, 0.01]),
    ],
)
def test_a_path_keeps_the_steps_that_are_done(options, ctrl_c):
    ctrl_c(3.0)
    error = interrupted(lambda: gfmd.path(SMALL, BODY, steps=200_000, **options))
    done = error.state
    assert isinstance(done, gfmd.Path) and 1 < len(done.steps.mean_pressure) < 200_000
    assert done.steps.converged[:-1].all() and done.pressure.shape == (2, 32, 32)
    assert np.isfinite(done.pressure[0]).all() and np.isnan(done.pressure[1]).all()
    assert "kept in" not in str(error)  # a file of ours, which is gone


SWEEP = {
    "points": {"eps_t_inv": [1, 2], "eps_f_inv": [4, 8], "eps_c_inv": [2, 4], "centre": [1, 4, 2]},
    "statistics": {"realisations": 5000},
}


@pytest.mark.parametrize("named", [True, False])
def test_a_sweep_keeps_the_runs_that_are_done_and_goes_on(named, ctrl_c, tmp_path):
    out = tmp_path / "k.h5" if named else None
    ctrl_c()
    first = interrupted(lambda: gfmd.kappa_sweep(SWEEP, out=out)).state
    assert first.runs > 0 and (out is None or first.out == str(out)) and Path(first.out + ".journal").exists()
    ctrl_c()
    second = interrupted(lambda: gfmd.kappa_sweep(SWEEP, out=first.out, resume=True)).state
    assert second.runs > first.runs and second.out == first.out


@pytest.mark.parametrize("named", [True, False])
def test_a_study_keeps_its_finished_members_and_goes_on(named, ctrl_c, tmp_path):
    config = {"command": "contact", "contact": {"n": 64, "p_star": 0.05}, "study": {"seed": "1:300"}}
    ctrl_c()
    error = interrupted(lambda: gfmd.study(config, out=tmp_path / "s.h5" if named else None))
    out = error.state.out
    assert Path(out + ".journal").exists() and f"out={out!r}, resume=True" in str(error)
    found = gfmd.study(config, out=out, resume=True)
    assert (found.status == "solved").all() and not Path(out + ".journal").exists()


def test_a_sweep_that_goes_on_ends_as_one_in_one_go(ctrl_c, tmp_path):
    config = {**SWEEP, "statistics": {"realisations": 30}}
    wanted = gfmd.kappa_sweep(config)
    journal = tmp_path / "k.h5.journal"
    ctrl_c(when=lambda: journal.exists() and journal.read_bytes().count(b"\n") > 10)
    error = interrupted(lambda: gfmd.kappa_sweep(config, out=tmp_path / "k.h5"))
    assert error.state.runs >= 10 and "resume=True" in str(error)
    found = gfmd.kappa_sweep(config, out=tmp_path / "k.h5", resume=True)
    assert found.fit.kappa_tfc == wanted.fit.kappa_tfc and not journal.exists()


@pytest.mark.parametrize(
    "call",
    [
        lambda: gfmd.contact(SMALL, BODY, p_star=0.02, **ENDLESS),
        lambda: gfmd.path(SMALL, BODY, p_star=[0.01, 0.1], steps=500_000),
    ],
    ids=["contact", "path"],
)
def test_exceptions_of_other_signals_come_as_they_are(call, no_finalisers):
    class Late(Exception):
        pass

    def late(*_):
        raise Late

    before = signal.signal(signal.SIGALRM, late)
    signal.setitimer(signal.ITIMER_REAL, 0.3)
    try:
        with pytest.raises(Late):
            call()
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
