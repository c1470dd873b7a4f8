"""The contact as a JAX function, differentiable with respect to heights and load, also inside `jax.jit`. Needs jax."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Optional

import jax
import jax.numpy as jnp
import numpy as np

from ._body import Body
from ._contact import Contact
from ._differentiable import Outputs, Solver, controlled

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._options import ContactOptions

__all__ = ["contact"]


def contact(
    heights: Any,
    body: Body,
    *,
    pressure: Optional[Any] = None,
    approach: Optional[Any] = None,
    size: Any = None,
    **options: Unpack[ContactOptions],
) -> Outputs:
    """Solves the contact of a rigid surface with an elastic body: fields and numbers are differentiable arrays.

    Args:
        heights: heights [x, y] or [x], length, peaks towards the body. They should be float64 (`jax_enable_x64`).
        body: the elastic body.
        pressure, approach: load by one of the two, a number or a 0-D array.
        size: cell size, as in `gfmd.Surface`.
        options: further arguments of `gfmd.contact`.

    Raises:
        InputError: as in `gfmd.contact` and `Contact.vjp`.
    """
    control, load = controlled(pressure, approach)
    surface = jnp.asarray(heights)
    solver = Solver(body, size, control, dict(options))
    kind, shape = surface.dtype, surface.shape if surface.ndim == 2 else (*surface.shape, 1)
    types = [jax.ShapeDtypeStruct(shape, kind)] * 2 + [jax.ShapeDtypeStruct((), kind)] * 4
    kept: dict[bytes, Contact] = {}

    def solved(heights: Any, load: Any) -> Contact:
        """Solves the contact, or returns the last one for the same arguments."""
        key = np.asarray(heights).tobytes() + np.asarray(load).tobytes()
        if key not in kept:
            kept.clear()
            kept[key] = solver(np.asarray(heights), float(load))
        return kept[key]

    def ahead(heights: Any, load: Any) -> list[Any]:
        return [np.asarray(value, dtype=kind) for value in solver.outputs(solved(heights, load))]

    def back(heights: Any, load: Any, given: Any) -> list[Any]:
        pulled = solver.pull(solved(heights, load), list(given))
        return [np.asarray(pulled.heights, dtype=kind).reshape(surface.shape), np.asarray(pulled.load, dtype=kind)]

    @jax.custom_vjp  # type: ignore[untyped-decorator]
    def outputs(heights: Any, load: Any) -> Any:
        return tuple(jax.pure_callback(ahead, types, heights, load))

    def forward(heights: Any, load: Any) -> Any:
        return outputs(heights, load), (heights, load)

    def backward(kept: Any, given: Any) -> Any:
        results = [jax.ShapeDtypeStruct(surface.shape, kind), jax.ShapeDtypeStruct((), kind)]
        return tuple(jax.pure_callback(back, results, *kept, list(given)))

    outputs.defvjp(forward, backward)
    return Outputs(*outputs(surface, jnp.asarray(load, dtype=kind)))
