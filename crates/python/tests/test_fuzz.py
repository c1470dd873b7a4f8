"""Whatever comes in, a result or an exception of the package comes out, in one line.

GFMD_FUZZ is the number of calls, 300 by default; `GFMD_FUZZ=10000 pytest -s tests/test_fuzz.py` is the long run, which
prints how each entry point answered.
"""

import inspect
import math
import os
import warnings
from collections import Counter
from datetime import timedelta

import gfmd
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

CALLS = int(os.environ.get("GFMD_FUZZ", "300"))
TALLY = {}

BODY = gfmd.Body(young=1.0, poisson=0.3)
SURFACE = gfmd.self_affine(n=8, eps_t_inv=1)
LAW = gfmd.law("morse", gamma=1e-3, range=0.1)
CONTACT = gfmd.contact(SURFACE, BODY, p_star=0.1)
CONTACTS = gfmd.contacts(SURFACE, BODY, p_star=[0.1, 0.2])
ADHESIVE = gfmd.contact(SURFACE, BODY, approach=0.01, law=LAW)
PUNCH = gfmd.punch(n=8)
FILE = "contact.h5"


class Field(np.ndarray):
    """A subclass of the arrays."""


def read_only(array):
    array.flags.writeable = False
    return array


LAYOUTS = [
    np.asfortranarray,
    np.ascontiguousarray,
    memoryview,
    read_only,
    list,
    gfmd.Surface,
    lambda a: a[::-1],
    lambda a: a[:, ::2],
    lambda a: a.astype(np.float32),
    lambda a: a.astype(np.float16),
    lambda a: (10 * a).astype(np.int16),
    lambda a: a.astype(">f8"),
    lambda a: a.tolist(),
    lambda a: a.view(Field),
    lambda a: np.ma.array(a, mask=np.zeros(a.shape, bool)),
    lambda a: np.ma.array(a, mask=a > 0),
    lambda a: a.astype(complex),
    lambda a: a.astype(object),
    lambda a: a.astype(str),
    lambda a: a > 0,
    lambda a: a[np.newaxis],
    lambda a: a[:0],
    lambda a: np.where(a > 0.3, np.nan, a),
    lambda a: 1e300 * a,
    lambda a: a.astype("datetime64[s]"),
]

grids = arrays.arrays(np.float64, st.tuples(st.integers(2, 12), st.integers(2, 12)), elements=st.floats(-1.0, 1.0))
lines = arrays.arrays(np.float64, st.integers(2, 32), elements=st.floats(-1.0, 1.0))
heights = st.one_of(
    st.just(SURFACE), grids, lines, st.tuples(grids, st.sampled_from(LAYOUTS)).map(lambda pair: pair[1](pair[0]))
)
# Not between 40 and 10^9: a number of steps, points or threads that is allowed may take its time.
wholes = st.one_of(st.integers(-3, 40), st.sampled_from([-(2**63), -(10**9), 2**31, 2**32, 2**63, 2**64, 10**30]))
anything = st.one_of(
    st.none(),
    st.booleans(),
    wholes,
    st.floats(),
    st.complex_numbers(),
    st.text(max_size=6),
    st.binary(max_size=6),
    st.lists(st.floats(), max_size=3),
    st.lists(st.lists(st.floats(), max_size=3), max_size=3),
    st.dictionaries(st.text(max_size=3), st.integers(), max_size=2),
    arrays.arrays(
        st.one_of(arrays.scalar_dtypes(), arrays.unicode_string_dtypes()),
        arrays.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=4),
    ),
    st.sampled_from(
        [
            object(),
            int,
            np.float32(0.1),
            np.int8(-3),
            np.array(0.5),
            np.nan,
            "0.1",
            timedelta(1),
            BODY,
            SURFACE,
            LAW,
            CONTACT,
            CONTACTS,
            PUNCH,
            (),
            {},
            set(),
            iter([1.0]),
            float("inf"),
        ]
    ),
)
positive = st.floats(1e-3, 1.0)
signed = st.floats(-0.05, 0.05)
loads = st.one_of(
    positive, st.lists(positive, min_size=1, max_size=3), st.lists(positive, max_size=3).map(np.array), signed
)
bodies = st.sampled_from(
    [BODY, BODY, gfmd.Body(e_star=2.0), gfmd.Body(poisson=0.5, height=0.3), gfmd.Body(height=1.0, base="sliding")]
)
laws = st.sampled_from(
    [
        None,
        None,
        "hard-wall",
        LAW,
        gfmd.law("dugdale", gamma=1e-3, range=0.05),
        gfmd.law("exponential", gamma=1e-3, range=0.1),
    ]
)
files = st.sampled_from(
    [
        FILE,
        "heights.npy",
        "heights.txt",
        "noise.h5",
        "noise.npy",
        "noise.txt",
        "nowhere",
        ".",
        "",
        "a/b.h5",
        f"{FILE}:/surface/height",
        f"{FILE}:/fields/pressure",
        f"{FILE}:/no",
        "\0",
        "ö.txt",
    ]
)
solve = dict(
    law=laws,
    solver=st.sampled_from(["auto", "auto", "auto", "cg", "fire", "newton"]),
    tolerance=st.floats(1e-10, 0.1),
    max_iterations=st.integers(0, 300),
    threads=st.integers(0, 3),
    coarse=st.booleans(),
    range_continuation=st.sampled_from([False, False, True]),
    finite_slope=st.sampled_from([False, False, True]),
    lower_surface=st.sampled_from([None, None, SURFACE, np.zeros((8, 8))]),
)
one_load = dict(pressure=positive, p_star=positive, approach=signed)
load = dict(pressure=loads, p_star=loads, approach=st.one_of(signed, st.lists(signed, min_size=1, max_size=3)))
sweep = st.fixed_dictionaries(
    {
        "points": st.just({"eps_t_inv": [1, 2], "eps_f_inv": [2], "eps_c_inv": [2], "centre": [1, 2, 2]}),
        "statistics": st.just({"realisations": 1}),
        "fit": st.just({"resamples": 10, "p_star": 0.02}),
    },
    optional={
        "loads": st.fixed_dictionaries({"p_star": st.one_of(loads, anything)}),
        "body": st.dictionaries(st.sampled_from(["young", "poisson", "height", "x"]), anything, max_size=2),
        "": anything,
    },
)

studies = st.fixed_dictionaries(
    {
        "command": st.just("contact"),
        "contact": st.fixed_dictionaries(
            {"n": st.just(8), "eps_f_inv": st.just(2), "p_star": st.one_of(loads, anything)}
        ),
    },
    optional={
        "study": st.dictionaries(st.sampled_from(["surface", "seed", "body", "x"]), anything, max_size=2),
        "": anything,
    },
)

# Each entry point, and good values of its arguments; the others come from `anything`.
ENTRIES = {
    "Surface": (
        gfmd.Surface,
        dict(heights=heights, size=st.one_of(positive, st.tuples(positive, positive)), unit=st.just("m")),
    ),
    "self_affine": (
        gfmd.self_affine,
        dict(
            n=st.one_of(st.integers(16, 24), st.tuples(st.integers(16, 24), st.integers(16, 24))),
            hurst=st.floats(0.0, 1.0),
            rms_gradient=positive,
            rms_height=positive,
            seed=st.integers(0, 2**64),
            size=positive,
            unit=st.just("m"),
            eps_t_inv=st.floats(1.0, 2.0),
            eps_f_inv=st.floats(1.0, 2.0),
            eps_c_inv=st.floats(2.0, 4.0),
            dim=st.just(3),
            method=st.sampled_from(["psd", "sra", "rmd"]),
            roll_off=positive,
            roll_off_shape=st.sampled_from(["plateau", "smooth"]),
            amplitudes=st.sampled_from(["gaussian", "fixed"]),
        ),
    ),
    "read": (gfmd.read, dict(name=files, size=positive, unit=st.just("m"))),
    "read_heights": (gfmd.read_heights, dict(name=files)),
    "Surface.statistics": (SURFACE.statistics, dict(fit_range=st.tuples(st.floats(0.1, 1.0), st.floats(0.1, 1.0)))),
    "Surface.detrend": (SURFACE.detrend, dict(trend=st.sampled_from(["mean", "plane", "slope", "quadratic"]))),
    "Surface.periodise": (SURFACE.periodise, dict(way=st.sampled_from(["mirror", "as-is"]))),
    "Body": (
        gfmd.Body,
        dict(
            young=positive,
            poisson=st.floats(-1.0, 0.5),
            e_star=positive,
            height=st.one_of(positive, st.just(math.inf)),
            base=st.sampled_from(["bonded", "sliding", "free"]),
        ),
    ),
    "Body, coated": (
        gfmd.Body,
        dict(
            young=positive,
            poisson=st.floats(-1.0, 0.5),
            height=positive,
            base=st.just("half-space"),
            base_young=positive,
            base_poisson=st.floats(0.0, 0.5),
        ),
    ),
    "law": (gfmd.law, dict(name=st.sampled_from(["morse", "exponential", "dugdale"]), gamma=positive, range=positive)),
    "law, mixed": (
        gfmd.law,
        dict(
            name=st.sampled_from(["xu-needleman", "bsg", "c3d", "npb", "npc"]),
            phi_n=positive,
            phi_t=positive,
            delta_n=positive,
            delta_t=positive,
        ),
    ),
    "contact": (gfmd.contact, dict(surface=heights, body=bodies, **one_load, **solve)),
    "contact, started": (
        gfmd.contact,
        dict(
            surface=st.one_of(st.just(SURFACE), grids),
            body=bodies,
            **one_load,
            law=laws,
            start=st.sampled_from([CONTACT, ADHESIVE]),
        ),
    ),
    "contacts": (gfmd.contacts, dict(surface=heights, body=bodies, **load, **solve)),
    "path": (
        gfmd.path,
        dict(
            surface=heights,
            body=bodies,
            **load,
            lateral=st.lists(signed, max_size=3),
            direction=st.floats(-360, 360),
            law=laws,
            friction=positive,
            shear_strength=positive,
            steps=st.integers(1, 3),
            tolerance=st.floats(1e-8, 0.1),
            max_iterations=st.integers(1, 200),
            energy_tolerance=st.floats(1e-4, 1e-1),
            energy_solves=st.integers(0, 2),
            threads=st.integers(0, 3),
        ),
    ),
    "friction": (
        gfmd.friction,
        dict(
            surface=heights,
            body=bodies,
            coefficient=positive,
            shear_strength=positive,
            **load,
            lateral=st.lists(signed, min_size=1, max_size=3),
        ),
    ),
    "punch": (
        gfmd.punch,
        dict(
            body=bodies,
            size=positive,
            n=st.integers(4, 16),
            dim=st.integers(2, 3),
            punch_fraction=st.floats(0.1, 0.9),
            depth=st.floats(1e-4, 1e-2),
            contact=st.sampled_from(["sticking", "frictionless"]),
            nodes=st.sampled_from(["strict", "inclusive"]),
            solver=st.sampled_from(["auto", "cg", "fire", "verlet", "verlet-critical", "verlet-modes"]),
            dt=st.floats(0.05, 1.1),
            damping=st.one_of(positive, st.lists(positive, min_size=1, max_size=3)),
            history=st.booleans(),
            history_modes=st.lists(
                st.tuples(st.integers(-2, 2), st.integers(-2, 2), st.sampled_from(["x", "y", "z"])), max_size=2
            ),
            history_points=st.lists(st.tuples(signed, signed, st.sampled_from(["x", "z"])), max_size=2),
            tolerance=st.floats(1e-8, 0.1),
            max_iterations=st.integers(1, 200),
            refine=st.integers(1, 2),
            threads=st.integers(0, 3),
        ),
    ),
    "interior": (
        gfmd.interior,
        dict(
            source=st.sampled_from([CONTACT, PUNCH, ADHESIVE]),
            depths=st.lists(positive, min_size=1, max_size=3),
            levels=st.integers(1, 3),
            deepest=positive,
            quantities=st.lists(st.sampled_from(["stress", "von-mises", "strain"]), min_size=1, max_size=3),
            along=st.sampled_from(["x=0.5", "y=0.1", "z=1"]),
            threads=st.integers(0, 3),
        ),
    ),
    "Contact.interior": (CONTACT.interior, dict(depths=st.lists(positive, min_size=1, max_size=3))),
    "Contact.save": (
        CONTACT.save,
        dict(path=st.one_of(st.just("saved.h5"), files.filter(lambda name: not name.startswith(FILE)))),
    ),
    "Contacts.save": (CONTACTS.save, dict(path=st.just("saved.h5"))),
    "Contact.plot": (CONTACT.plot, dict(field=st.sampled_from(["pressure", "gap"]))),
    "green": (
        gfmd.green,
        dict(
            body=bodies,
            qx=st.floats(-100, 100),
            qy=st.floats(-100, 100),
            dim=st.integers(2, 3),
            z=positive,
            depth=positive,
        ),
    ),
    "kappa_sweep": (
        gfmd.kappa_sweep,
        dict(
            config=sweep,
            out=st.sampled_from(["k.h5", "", ".", "no/k.h5"]),
            resume=st.booleans(),
            threads=st.integers(0, 3),
        ),
    ),
    "study": (
        gfmd.study,
        dict(
            config=studies,
            out=st.sampled_from(["study.h5", "", ".", "no/study.h5"]),
            resume=st.booleans(),
            progress=st.booleans(),
            threads=st.integers(0, 3),
        ),
    ),
    "load": (gfmd.load, dict(path=files)),
    "cite": (gfmd.cite, dict(results=st.sampled_from([CONTACT, CONTACTS, ADHESIVE, PUNCH]))),
    "progress": (gfmd.progress, dict(shown=st.one_of(st.booleans(), st.none()))),
}
WRITERS = (CONTACT.save, CONTACTS.save, gfmd.kappa_sweep, gfmd.study)
# At most one of these is meant; the strategy leaves most of the others out.
CHOICES = [
    {"pressure", "p_star", "approach"},
    {"rms_gradient", "rms_height"},
    {"young", "e_star"},
    {"coefficient", "shear_strength"},
    {"friction", "law", "shear_strength"},
    {"depths", "levels"},
    {"z", "depth"},
]
# Nothing works without these, or their defaults take minutes.
NEEDED = {
    "config",
    "n",
    "base_young",
    "base_poisson",
    "surface",
    "steps",
    "max_iterations",
    "gamma",
    "range",
    "phi_n",
    "phi_t",
    "delta_n",
    "delta_t",
}


@st.composite
def calls(draw, name):
    """Arguments of one call: most of them good."""
    function, good = ENTRIES[name]
    signature = inspect.signature(function).parameters
    wild = draw(st.sampled_from([0, 0, 0, 1, 4]))
    dropped = set()
    for choice in CHOICES:
        kept = draw(st.sampled_from(sorted(choice)))
        dropped |= choice - {kept} if draw(st.integers(0, 7)) else set()
    given_ones = {}
    for key, strategy in good.items():
        parameter = signature.get(key)
        optional = key not in NEEDED and (
            parameter is None
            or parameter.default is not inspect.Parameter.empty
            or parameter.kind == inspect.Parameter.VAR_POSITIONAL
        )
        if optional and (key in dropped or (key not in set().union(*CHOICES) and draw(st.integers(0, 2)) == 0)):
            continue
        given_ones[key] = draw(anything if draw(st.integers(0, 11)) < wild else strategy)
    first = [
        given_ones.pop(key)
        for key in list(given_ones)
        if key in signature
        and signature[key].kind in (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.VAR_POSITIONAL)
    ]
    return first, given_ones


@pytest.fixture(scope="module", autouse=True)
def folder(tmp_path_factory):
    """Files to read, good and bad, in a folder that may be written to."""
    before, place = os.getcwd(), tmp_path_factory.mktemp("fuzz")
    os.chdir(place)
    CONTACTS.save(FILE)
    np.save("heights.npy", SURFACE.heights)
    np.savetxt("heights.txt", SURFACE.heights)
    noise = np.random.default_rng(1).bytes(300)
    for name in ("noise.h5", "noise.npy", "noise.txt"):
        with open(name, "wb") as file:
            file.write(
                (b"\x89HDF\r\n\x1a\n" if name.endswith("h5") else b"\x93NUMPY\x01\x00" if name.endswith("npy") else b"")
                + noise
            )
    yield
    os.chdir(before)
    gfmd.progress(None)
    print(
        "\n" + "\n".join(f"{name:<20} {sum(found.values()):>6} calls: {dict(found)}" for name, found in TALLY.items())
    )
    print(f"{sum(sum(found.values()) for found in TALLY.values())} calls")


def finite(result):
    if isinstance(result, gfmd.Contact):
        result = gfmd.Contacts([result])
    if isinstance(result, gfmd.Contacts):
        for contact in result:
            assert contact.converged and contact.pressure.shape == contact.surface.n
            for field in (contact.pressure, contact.gap, contact.displacement_z):
                assert np.isfinite(field).all() and not field.flags.writeable
    if isinstance(result, gfmd.Surface):
        assert np.isfinite(result.heights).all() and all(length > 0 for length in result.size)


@pytest.mark.parametrize("name", ENTRIES)
def test_entry(name):
    function, _ = ENTRIES[name]
    tally = TALLY.setdefault(name, Counter())

    @settings(
        max_examples=max(1, -(-CALLS // len(ENTRIES))),
        deadline=None,
        database=None,
        suppress_health_check=list(HealthCheck),
    )
    @given(calls(name))
    def run(call):
        first, rest = call
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                result = function(*first, **rest)
        except gfmd.Error as error:
            text = str(error)
            assert text and "\n" not in text and "defect" not in text and len(text) < 1000, text
            assert isinstance(error, (gfmd.InputError, gfmd.NotConverged)) or function in WRITERS, repr(error)
            tally[type(error).__name__] += 1
        else:
            finite(result)
            repr(result)
            tally["result"] += 1
            getattr(getattr(result, "figure", None), "clear", int)()

    run()
    assert tally


@pytest.mark.parametrize(
    "call",
    [
        lambda: gfmd.contact(),
        lambda: gfmd.contact(SURFACE, BODY, 0.1),
        lambda: gfmd.contact(SURFACE, BODY, mean_pressure=0.1),
        lambda: gfmd.contacts(SURFACE, BODY, p_star=[1], e_star=1),
        lambda: gfmd.law(),
        lambda: SURFACE.detrend(1, 2),
    ],
)
def test_arguments_that_do_not_exist_are_type_errors(call):
    with pytest.raises(TypeError):
        call()


def test_an_option_that_does_not_exist_is_named_with_those_that_do():
    with pytest.raises(
        TypeError, match="contact has no argument 'best'; it must be one of pressure, p_star, .*, solver, tolerance, "
    ):
        gfmd.contact(SURFACE, BODY, best=1)
