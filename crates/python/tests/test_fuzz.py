"""Whatever comes in, a result or an exception of the package comes out. GFMD_FUZZ is the number of calls, 300 by default."""

import os

import gfmd
import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

CALLS = int(os.environ.get("GFMD_FUZZ", "300"))
BODY = gfmd.Body()
EXPECTED = (gfmd.Error,)

fuzz = settings(max_examples=max(1, CALLS // 3), deadline=None, suppress_health_check=list(HealthCheck))

scalars = st.one_of(
    st.floats(width=64),
    st.floats(0.001, 1.0),
    st.integers(),
    st.integers(0, 40),
    st.booleans(),
    st.none(),
    st.text(max_size=4),
    st.sampled_from([np.float32(0.1), np.int8(-3), np.array(0.5), np.array([0.1, 0.2]), np.nan, "0.1", 1j, object()]),
    st.lists(st.floats(), max_size=3),
)
fields = st.one_of(
    arrays.arrays(
        st.one_of(arrays.floating_dtypes(), arrays.integer_dtypes(), arrays.boolean_dtypes(), arrays.complex_number_dtypes(), arrays.unicode_string_dtypes()),
        arrays.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=6),
    ),
    arrays.arrays(np.float64, st.tuples(st.integers(2, 12), st.integers(1, 12)), elements=st.floats(-1.0, 1.0)),
    arrays.arrays(np.float64, st.tuples(st.integers(2, 8), st.integers(2, 8)), elements=st.floats(allow_nan=False, allow_infinity=False)),
    st.lists(st.lists(scalars, max_size=4), max_size=4),
    scalars,
)
orders = st.sampled_from([lambda a: a, np.asfortranarray, lambda a: a[::-1] if getattr(a, "ndim", 0) else a])


@fuzz
@given(fields, orders, scalars, scalars, st.sampled_from(["p_star", "mean_pressure", "approach"]), st.sampled_from([None, "morse", "glue"]))
def test_contacts(heights, order, size, load, control, law):
    try:
        heights = order(heights) if isinstance(heights, np.ndarray) else heights
        surface = gfmd.Surface(heights, size=size)
        made = gfmd.law(law, gamma=1e-3, range=0.1) if law else None
        contact = gfmd.contact(surface, BODY, law=made, max_iterations=30, **{control: load})
        assert contact.pressure.shape == surface.n and np.isfinite(contact.pressure).all()
    except EXPECTED as error:
        assert "\n" not in str(error) and "defect" not in str(error), error


@fuzz
@given(st.lists(scalars, min_size=8, max_size=8), st.one_of(st.none(), st.integers(-2, 48), scalars))
def test_surfaces(values, n):
    names = ("hurst", "rms_gradient", "seed", "size", "eps_t_inv", "eps_f_inv", "roll_off", "dim")
    given_ones = {name: value for name, value in zip(names, values) if value is not None}
    try:
        gfmd.self_affine(n=n if not isinstance(n, int) or n < 200 else 64, **given_ones).statistics()
    except EXPECTED as error:
        assert "\n" not in str(error) and "defect" not in str(error), error


@fuzz
@given(scalars, scalars, scalars, scalars, scalars, st.sampled_from(["morse", "npc", "dugdale", "", "hard-wall"]))
def test_bodies_and_laws(young, poisson, height, gamma, distance, name):
    for make in (
        lambda: gfmd.contact(gfmd.self_affine(n=8, eps_t_inv=1), gfmd.Body(young, poisson, height=height), p_star=0.1, max_iterations=30),
        lambda: gfmd.law(name, gamma=gamma, range=distance),
        lambda: gfmd.green(gfmd.Body(young, poisson, height=height), qx=gamma, qy=distance),
    ):
        try:
            make()
        except EXPECTED as error:
            assert "\n" not in str(error) and "defect" not in str(error), error
