"""Contacts of many surfaces, side by side."""

import gc
import itertools

import numpy as np
import pytest

import gfmd

BODY = gfmd.Body(young=1.0, poisson=0.3)


def rough(seeds):
    return [gfmd.self_affine(n=32, seed=seed) for seed in seeds]


def test_they_have_the_bits_of_one_after_the_other_whatever_the_workers():
    surfaces = rough(range(7))
    alone = [gfmd.contact(surface, BODY, p_star=0.05) for surface in surfaces]
    for workers in (1, 3, 16, None):
        found = list(gfmd.many(surfaces, BODY, p_star=0.05, workers=workers))
        assert all(
            np.array_equal(a.pressure, b.pressure) and a.stiffness == b.stiffness
            for a, b in zip(alone, found, strict=True)
        )
    several = list(gfmd.many(surfaces[:2], BODY, p_star=[0.01, 0.05]))
    assert [[c.p_star for c in cs] for cs in several] == [pytest.approx([0.01, 0.05])] * 2
    assert list(gfmd.many([], BODY, p_star=0.05)) == []


def test_surfaces_are_taken_as_they_are_needed():
    taken = itertools.count()
    surfaces = (gfmd.self_affine(n=16, seed=next(taken)) for _ in range(100))
    first = next(gfmd.many(surfaces, BODY, p_star=0.05, workers=2))
    gc.collect()
    assert first.converged and next(taken) == 4


def test_what_fails_is_named_when_its_turn_comes():
    surfaces = [*rough([1, 2]), np.zeros((8, 8)), *rough([3])]
    found = gfmd.many(surfaces, BODY, p_star=0.05, workers=2)
    assert next(found).converged and next(found).converged
    with pytest.raises(gfmd.InputError, match="^surface 2: "):
        next(found)
    assert list(found) == []
    with pytest.raises(gfmd.NotConverged, match="^surface 0: ") as reported:
        next(gfmd.many(rough([1]), BODY, p_star=0.05, max_iterations=1))
    assert not reported.value.state.converged
    for options, words in [({"threads": 2}, "threads is given"), ({"workers": 0}, "workers is 0")]:
        with pytest.raises(gfmd.InputError, match=words):
            gfmd.many(rough([1]), BODY, p_star=0.05, **options)
    with pytest.raises(TypeError, match="no argument 'p_sta'; write p_star"):
        next(gfmd.many(rough([1]), BODY, p_sta=0.05))


def test_a_generator_may_reuse_its_array():
    heights = [np.array(surface.heights) for surface in rough(range(5))]
    wanted = [gfmd.contact(each, BODY, p_star=0.05).approach for each in heights]
    buffer = np.empty_like(heights[0])

    def reused():
        for each in heights:
            buffer[:] = each
            yield buffer

    for workers in (1, 3):
        found = [c.approach for c in gfmd.many(reused(), BODY, p_star=0.05, workers=workers)]
        assert found == wanted
