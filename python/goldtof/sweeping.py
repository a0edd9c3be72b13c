"""A scene simulated over and over, some of its keys with every combination of values."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal

from ._goldtof import Scene, simulate

if TYPE_CHECKING:
    import pandas
    import xarray


def sweep(
    scene: Scene,
    over: Mapping[str, Sequence[Any]],
    *,
    to: Literal["pandas", "xarray"] = "pandas",
    fidelity: str = "expected",
    repetitions: int = 1,
    seed: int = 1,
    estimator: str | None = None,
    on_progress: Callable[[int, int], object] | None = None,
) -> pandas.DataFrame | xarray.Dataset:
    """Simulates every combination of the values that ``over`` has for keys of the scene.

    As a pandas frame: a row for each combination and path, the keys' values first. As an
    xarray Dataset: a dimension for each key and one for the paths. The scene is left as it
    is. ``on_progress`` hears how many combinations are done, of how many.
    """
    if to not in ("pandas", "xarray"):
        raise ValueError(f"there is no {to!r}; there are pandas and xarray")
    if not over:
        raise ValueError("over has no key; write for example {'path.distance': ['1 m', '2 m']}")
    import pandas

    keys = list(over)
    combinations = list(itertools.product(*over.values()))
    rows = []
    for done, values in enumerate(combinations):
        point = scene.copy()
        for key, value in zip(keys, values):
            point[key] = value
        result = simulate(
            point, fidelity=fidelity, repetitions=repetitions, seed=seed, estimator=estimator
        )
        for number, path in enumerate(result["estimates"]):
            rows.append(dict(zip(keys, values)) | {"estimate": number} | path)
        if on_progress is not None:
            on_progress(done + 1, len(combinations))
    frame = pandas.DataFrame(rows)
    if to == "pandas":
        return frame.drop(columns="estimate")
    return frame.set_index([*keys, "estimate"]).to_xarray()
