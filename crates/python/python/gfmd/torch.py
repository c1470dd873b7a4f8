"""The contact as a PyTorch function, differentiable with respect to heights and load. Needs torch."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Optional

import numpy as np
import torch

from ._body import Body
from ._differentiable import Outputs, Solver, controlled

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._options import ContactOptions

__all__ = ["contact"]


class _Contact(torch.autograd.Function):  # type: ignore[misc]
    @staticmethod
    def forward(context: Any, heights: Any, load: Any, solver: Solver) -> Any:
        found = solver(heights.detach().cpu().numpy(), float(load))
        context.solver, context.found, context.like = solver, found, (heights, load)
        like = {"dtype": heights.dtype, "device": heights.device}
        return tuple(torch.as_tensor(np.array(value), **like) for value in solver.outputs(found))

    @staticmethod
    def backward(context: Any, *given: Any) -> Any:
        pulled = context.solver.pull(context.found, [value.detach().cpu().numpy() for value in given])
        heights, load = context.like
        by_heights = torch.as_tensor(np.array(pulled.heights), dtype=heights.dtype, device=heights.device)
        by_load = torch.as_tensor(pulled.load, dtype=load.dtype, device=load.device)
        return by_heights.reshape(heights.shape), by_load, None


def contact(
    heights: Any,
    body: Body,
    *,
    pressure: Optional[Any] = None,
    approach: Optional[Any] = None,
    size: Any = None,
    **options: Unpack[ContactOptions],
) -> Outputs:
    """Solves the contact of a rigid surface with an elastic body: fields and numbers are differentiable tensors.

    Args:
        heights: heights [x, y] or [x], length, peaks towards the body, a tensor. It should be float64.
        body: the elastic body.
        pressure, approach: load by one of the two, a number or a 0-D tensor.
        size: cell size, as in `gfmd.Surface`.
        options: further arguments of `gfmd.contact`.

    Raises:
        InputError: as in `gfmd.contact` and `Contact.vjp`.
    """
    control, load = controlled(pressure, approach)
    given = torch.as_tensor(load, dtype=heights.dtype, device=heights.device)
    return Outputs(*_Contact.apply(heights, given, Solver(body, size, control, dict(options))))
