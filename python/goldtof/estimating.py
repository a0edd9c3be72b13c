"""Distances from recorded counts, whatever holds them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from os import PathLike, fspath
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, overload

import numpy as np
from numpy.typing import NDArray

from ._goldtof import Scene, _estimate, _recorded
from .reports import Estimate, Estimates

if TYPE_CHECKING:
    import pandas

    Column: TypeAlias = Sequence[int] | pandas.Series
    Counts: TypeAlias = NDArray[Any] | Column | Sequence[Sequence[int]]


@overload
def estimate(
    scene: Scene,
    counts: Column | pandas.DataFrame | str | PathLike[str],
    *,
    total: Counts | None = None,
    bins: None = None,
    detector: str | None = None,
    estimator: Literal["fft", "model"] | None = None,
    on_progress: Callable[[int, int], object] | None = None,
) -> Estimate: ...
@overload
def estimate(
    scene: Scene,
    counts: Sequence[Sequence[int]],
    *,
    total: Counts | None = None,
    bins: None = None,
    detector: str | None = None,
    estimator: Literal["fft", "model"] | None = None,
    on_progress: Callable[[int, int], object] | None = None,
) -> Estimates: ...
# The dimensions of an array are not in its type: an Estimate of one, Estimates of two.
@overload
def estimate(
    scene: Scene,
    counts: NDArray[Any] | None = None,
    *,
    total: Counts | None = None,
    bins: Counts | None = None,
    detector: str | None = None,
    estimator: Literal["fft", "model"] | None = None,
    on_progress: Callable[[int, int], object] | None = None,
) -> Any: ...
def estimate(
    scene: Scene,
    counts: Counts | pandas.DataFrame | str | PathLike[str] | None = None,
    *,
    total: Counts | None = None,
    bins: Counts | None = None,
    detector: str | None = None,
    estimator: Literal["fft", "model"] | None = None,
    on_progress: Callable[[int, int], object] | None = None,
) -> Estimate | Estimates:
    """The distance that the counts of a real sensor's scan give, and what seems wrong.

    ``counts`` are the signed counts of all phase steps and ``total`` the total ones, if the
    hardware sends them; of a sensor that keeps a histogram ``bins`` are its bins. They are whole
    numbers: arrays, lists, series. A frame has columns ``count`` and, if there are any,
    ``total_count``; a path is that of a CSV file as ``goldtof estimate`` reads it. Arrays of
    (scans, phase steps) or (scans, bins) give :class:`Estimates`, one for each scan, on all
    processors.

    >>> scene = Scene.parse(QUICK, "quick.toml")
    >>> counted = scans(scene, fidelity="counts", repetitions=3, seed=1)
    >>> told = estimate(scene, counted["signed"], total=counted["total"], estimator="model")
    >>> told.distance_m.round(1)
    array([3.2, 3.2, 3.2])
    >>> told[0].diagnosis.causes
    []
    """
    given: dict[str, Any] = {"counts": counts, "total": total, "bins": bins}
    if isinstance(counts, (str, PathLike)):
        if total is not None or bins is not None:
            raise ValueError("a file has its own total counts and bins; give it alone")
        given = _recorded(scene, fspath(counts), detector=detector)
    elif hasattr(counts, "columns"):
        given |= _columns(counts)
    kinds: dict[str, type[np.int64] | type[np.uint64]]
    kinds = {"counts": np.int64, "total": np.uint64, "bins": np.uint64}
    arrays = {name: _whole(given[name], kind, name) for name, kind in kinds.items() if given.get(name) is not None}
    dimensions = {array.ndim for array in arrays.values()}
    if not dimensions <= {1} and not dimensions <= {2}:
        raise ValueError("counts are of one dimension (phase steps) or two (scans, phase steps), and totals alike")
    told = _estimate(
        scene,
        **{name: np.atleast_2d(array) for name, array in arrays.items()},
        detector=detector,
        estimator=estimator,
        on_progress=on_progress,
    )
    estimates = Estimates(Estimate(one) for one in told)
    return estimates if dimensions == {2} else estimates[0]


def _columns(frame: Any) -> dict[str, Any]:
    """The columns of a frame that are counts."""
    if "count" not in frame.columns:
        names = ", ".join(map(str, frame.columns))
        raise ValueError(f"a frame of counts has a column 'count'; this one has {names}")
    total = frame["total_count"] if "total_count" in frame.columns else None
    return {"counts": frame["count"], "total": total}


def _whole(values: Any, kind: type[np.int64] | type[np.uint64], name: str) -> NDArray[Any]:
    """Whole numbers of any kind as those of one; nothing is rounded, and nothing wraps."""
    array = np.asarray(values)
    if array.dtype.kind == "O":
        try:
            array = np.array([[int(v) for v in row] if np.ndim(row) else int(row) for row in array])
        except (TypeError, ValueError):
            raise ValueError(f"{name} are whole numbers; these are {type(values).__name__}") from None
    if array.dtype.kind not in "iufb":
        raise ValueError(f"{name} are whole numbers; these are {array.dtype}")
    with np.errstate(invalid="ignore"):
        whole = array.astype(kind)
    wrong = np.argwhere(whole != array)
    negative = np.argwhere(array < 0) if kind is np.uint64 else np.empty((0, array.ndim), int)
    for place in [*wrong, *negative][:1]:
        where = tuple(int(index) for index in place)
        raise ValueError(f"{name}{list(where)} is {array[where]}, and counts are whole numbers of 64 bits")
    return np.ascontiguousarray(whole)
