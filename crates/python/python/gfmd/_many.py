"""Contacts of many surfaces, side by side."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Iterable, Iterator, Sized
from concurrent.futures import Future, ThreadPoolExecutor
from threading import Event
from typing import TYPE_CHECKING, Any, Optional, Union

from ._body import Body
from ._check import integer
from ._contact import Contact, Contacts
from ._errors import InputError, Interrupted, NotConverged
from ._progress import BESIDE, Progress
from ._solve import contact
from ._surface import Surface, as_surface

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._options import ContactOptions


def many(
    surfaces: Iterable[Any],
    body: Body,
    *,
    pressure: Any = None,
    p_star: Any = None,
    force: Any = None,
    approach: Any = None,
    workers: Optional[int] = None,
    **options: Unpack[ContactOptions],
) -> Iterator[Union[Contact, Contacts]]:
    """Computes the contacts of many surfaces with one body in parallel, each on one thread.

    Yields the contacts in the order of the surfaces while computing the next. At most two contacts per worker are in
    memory, unless the caller keeps them. Surfaces may come from a generator. Results do not depend on the number of
    workers.

    Args:
        surfaces: surfaces as in `contact`.
        body: the elastic body.
        pressure, p_star, force, approach: load by one of the four, one number or several (stress, 1, stress * length^2,
            length).
        workers: number of contacts computed at once; by default the cores available to this process.
        options: further arguments of `contact`, except `threads` and `start`.

    Raises:
        InputError, NotConverged, Interrupted: as in `contact`, raised in place of that contact; the message has the
            surface number, from 0. An exception of the generator is raised after all earlier contacts.

    Example:
        >>> rough = (gfmd.self_affine(n=64, seed=seed) for seed in range(4))
        >>> [round(c.area_fraction, 3) for c in gfmd.many(rough, gfmd.Body(), p_star=0.05)]
        [0.132, 0.128, 0.121, 0.122]
    """
    for name in ("threads", "start"):
        if options.get(name) is not None:
            raise InputError(
                f"{name} is given; it must be left out of many contacts, each of which has one thread and starts by"
                " itself"
            )
    if workers is None:
        workers = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    loads = {"pressure": pressure, "p_star": p_star, "force": force, "approach": approach}
    return _solved(surfaces, body, integer("workers", workers, 1, 4096), {**loads, **options})


def _solved(
    surfaces: Iterable[Any], body: Body, workers: int, options: dict[str, Any]
) -> Iterator[Union[Contact, Contacts]]:
    ending = Event()

    def look() -> None:
        if ending.is_set():
            raise KeyboardInterrupt

    def solve(index: int, surface: Surface) -> Union[Contact, Contacts]:
        BESIDE.set(look)
        try:
            found: Union[Contact, Contacts] = contact(surface, body, threads=1, **options)
            return found
        except InputError as error:
            raise InputError(f"surface {index}: {error}") from error
        except (NotConverged, Interrupted) as error:
            raise type(error)(f"surface {index}: {error}", error.state) from error

    pool = ThreadPoolExecutor(workers, thread_name_prefix="gfmd.many")
    running: deque[Future[Union[Contact, Contacts]]] = deque()
    try:
        with Progress("contacts", len(surfaces) if isinstance(surfaces, Sized) else 0) as progress:
            made = enumerate(surfaces)
            broken: Optional[Exception] = None
            while True:
                try:
                    index, given = next(made)
                    surface = _copied(index, given)
                except StopIteration:
                    break
                except Exception as error:  # of the generator or a surface: yield the earlier contacts first
                    broken = error
                    break
                running.append(pool.submit(solve, index, surface))
                if len(running) == 2 * workers:
                    yield _next(running, progress)
            while running:
                yield _next(running, progress)
            if broken is not None:
                raise broken
    except KeyboardInterrupt as error:
        raise error if isinstance(error, Interrupted) else Interrupted("interrupted") from error
    finally:
        ending.set()
        pool.shutdown(wait=True, cancel_futures=True)


def _copied(index: int, surface: Any) -> Surface:
    """Copies heights before the generator goes on, which may reuse its array."""
    try:
        return as_surface(surface)
    except InputError as error:
        raise InputError(f"surface {index}: {error}") from error


def _next(running: deque[Future[Union[Contact, Contacts]]], progress: Progress) -> Union[Contact, Contacts]:
    found = running.popleft().result()
    progress.tick()
    progress.piece()
    return found
