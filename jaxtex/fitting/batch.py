"""Many masks fitted by one call, in the way that suits the device.

A least-squares solve under ``vmap`` runs until its slowest member ends, and on a processor its wide arithmetic gains
nothing: there fits run side by side on threads, as compiled code lets go of Python's lock. On an accelerator one small
solve leaves most of the device idle: there the same threads hand their solves to one that gathers what is waiting and
solves it by one batched call. Either way each fit takes the very steps that :func:`jaxtex.fitting.tiling.fit_tiling`
takes.
"""

import contextvars
import os
import queue
import threading
from collections import defaultdict
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from jaxtex.core.errors import InputError
from jaxtex.fitting.solve import SOLVER, Problem, Solution, solve
from jaxtex.fitting.tiling import TilingFit, fit_tiling

_SIZES = (1, 4, 16, 64)  # batches are filled up to one of these, so that few programs are compiled

solve_many = eqx.filter_jit(jax.vmap(solve))


def fit_tiling_masks(
    masks: NDArray[np.floating], *, report: Callable[[float, float], None] | None = None
) -> list[TilingFit]:
    """Fit a tiling to each of many masks, seen straight on.

    Parameters
    ----------
    masks
        [B, H, W], 1 on tiles and 0 on joints, at least 32 x 32 each.
    report
        Called with (done, total) as fits end.

    Returns
    -------
    list of TilingFit
        In the order of the masks; each what ``fit_tiling(mask, mask=mask, perspective=False)`` gives.

    Raises
    ------
    InputError
        Not a stack of masks, or one of them is out of range or the same everywhere; nothing has been fitted then.

    Examples
    --------
    >>> import numpy as np
    >>> y, x = np.mgrid[0:64, 0:64] + 0.5
    >>> walls = [(y % pitch > 2) & (x % 16 > 2) for pitch in (10, 12)]
    >>> [round(float(fit.tiling.tile_height)) for fit in fit_tiling_masks(np.array(walls, float))]
    [10, 12]
    """
    masks = _check_masks(masks)
    accelerated = jax.default_backend() != "cpu"
    workers = _SIZES[-1] if accelerated else os.cpu_count() or 1
    with gathered_solves(accelerated), ThreadPoolExecutor(workers) as pool:
        ended = [pool.submit(contextvars.copy_context().run, _fit_one, mask) for mask in masks]
        try:
            fits = []
            for each in ended:
                fits.append(each.result())
                if report:
                    report(len(fits), len(ended))
        except BaseException:
            pool.shutdown(wait=True, cancel_futures=True)
            raise
    return fits


@contextmanager
def gathered_solves(wanted: bool = True) -> Iterator[None]:
    """Within it, solves asked for by several threads at once are solved together."""
    if not wanted:
        yield
        return
    asked: queue.SimpleQueue[tuple[Problem, Future[Solution]] | None] = queue.SimpleQueue()

    def ask(problem: Problem) -> Solution:
        answer: Future[Solution] = Future()
        asked.put((problem, answer))
        return answer.result()

    gatherer = threading.Thread(target=_gather, args=(asked,), daemon=True)
    gatherer.start()
    token = SOLVER.set(ask)
    try:
        yield
    finally:
        SOLVER.reset(token)
        asked.put(None)
        gatherer.join()


def _fit_one(mask: NDArray[np.float32]) -> TilingFit:
    return fit_tiling(mask, mask=mask, perspective=False)


def _gather(asked: "queue.SimpleQueue[tuple[Problem, Future[Solution]] | None]") -> None:
    """Take what is waiting, solve it, and look again: while the device works, the next batch comes together."""
    open_for_more = True
    while open_for_more:
        waiting = [asked.get()]
        while len(waiting) < _SIZES[-1] and not asked.empty():
            waiting.append(asked.get())
        open_for_more = None not in waiting
        alike = defaultdict(list)
        for each in waiting:
            if each is not None:
                alike[tuple(leaf.shape for leaf in jax.tree.leaves(each[0]))].append(each)
        for group in alike.values():
            _answer(group)


def _answer(group: list[tuple[Problem, Future[Solution]]]) -> None:
    try:
        size = next(size for size in _SIZES if size >= len(group))
        problems = [problem for problem, _ in group]
        problems += problems[:1] * (size - len(group))
        with jax.enable_x64():
            solutions = jax.device_get(solve_many(jax.tree.map(lambda *leaves: jnp.stack(leaves), *problems)))
        for index, (_, answer) in enumerate(group):
            answer.set_result(jax.tree.map(lambda leaf, index=index: leaf[index], solutions))
    except BaseException as error:  # whoever waits must hear of it
        for _, answer in group:
            if not answer.done():
                answer.set_exception(error)


def _check_masks(masks: NDArray[np.floating]) -> NDArray[np.float32]:
    try:
        masks = np.asarray(masks, np.float32)
    except (TypeError, ValueError):
        raise InputError("the masks are not numbers in a box; they must be [B, H, W], all of one size") from None
    if masks.ndim != 3:
        raise InputError(f"the masks have shape {masks.shape}; they must be [B, H, W], all of one size")
    if min(masks.shape[1:]) < 32:
        raise InputError(f"the masks have {masks.shape[2]} x {masks.shape[1]} pixels; they must have 32 x 32 at least")
    for index, mask in enumerate(masks):
        if not np.isfinite(mask).all() or mask.min() < 0 or mask.max() > 1:
            raise InputError(f"mask {index} must lie between 0 (joint) and 1 (tile)")
        if mask.max() - mask.min() < 0.5:
            raise InputError(f"mask {index} is the same everywhere; it must be 1 on tiles and 0 on joints")
    return masks
