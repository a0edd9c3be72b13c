"""A scene simulated over and over, some of its keys with every combination of values."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, overload

import numpy as np
from numpy.typing import NDArray

from . import progress
from ._goldtof import Scene, simulate

if TYPE_CHECKING:
    import pandas
    import xarray

# What names of results end in, and the unit that this is; the longest first.
_UNITS = {
    "_m_per_s": "m s-1",
    "_fraction": "1",
    "_in_std": "1",
    "_ps": "ps",
    "_m": "m",
    "_s": "s",
}


@overload
def sweep(
    scene: Scene,
    over: Mapping[str, Sequence[Any] | NDArray[Any] | tuple[Any, str]],
    *,
    to: Literal["pandas"] = "pandas",
    fidelity: str = ...,
    repetitions: int = ...,
    seed: int = ...,
    estimator: str | None = ...,
    on_progress: Callable[[int, int], object] | None = ...,
) -> pandas.DataFrame: ...
@overload
def sweep(
    scene: Scene,
    over: Mapping[str, Sequence[Any] | NDArray[Any] | tuple[Any, str]],
    *,
    to: Literal["xarray"],
    fidelity: str = ...,
    repetitions: int = ...,
    seed: int = ...,
    estimator: str | None = ...,
    on_progress: Callable[[int, int], object] | None = ...,
) -> xarray.Dataset: ...
def sweep(
    scene: Scene,
    over: Mapping[str, Sequence[Any] | NDArray[Any] | tuple[Any, str]],
    *,
    to: Literal["pandas", "xarray"] = "pandas",
    fidelity: str = "expected",
    repetitions: int = 1,
    seed: int = 1,
    estimator: str | None = None,
    on_progress: Callable[[int, int], object] | None = None,
) -> pandas.DataFrame | xarray.Dataset:
    """Simulates every combination of the values that ``over`` has for keys of the scene.

    Values are as :class:`Scene` takes them: texts with a unit, numbers in SI units; or an array
    and its unit, ``(np.linspace(1, 10, 50), "m")``. In the table they are numbers in SI units;
    what is not a number is its text.

    As a pandas frame: a row for each combination and path, the keys' values first. As an
    xarray Dataset: a dimension for each key, numbers in ascending order, and one for the paths.
    ``attrs`` have units and long names. The scene is left as it is. ``on_progress`` hears how
    many combinations are done, of how many.

    >>> scene = Scene.parse(QUICK, "quick.toml")
    >>> data = sweep(scene, {"path.distance": ["1 m", "2 m", "10 m"]}, to="xarray")
    >>> data["path.distance"].values, data["path.distance"].attrs["units"]
    (array([ 1.,  2., 10.]), 'm')
    """
    if to not in ("pandas", "xarray"):
        raise ValueError(f"there is no {to!r}; there are pandas and xarray")
    if not over:
        raise ValueError("over has no key; write for example {'path.distance': ['1 m', '2 m']}")
    import pandas

    keys = list(over)
    combinations = list(itertools.product(*(_values(key, over[key]) for key in keys)))
    tell = on_progress or progress.bar()
    rows = []
    for done, values in enumerate(combinations):
        point = scene.copy()
        for key, value in zip(keys, values):
            point[key] = value
        told = {key: _told(point[key]) for key in keys}
        result = simulate(
            point,
            fidelity=fidelity,
            repetitions=repetitions,
            seed=seed,
            estimator=estimator,
            on_progress=_nothing,
        )
        for number, path in enumerate(result["estimates"]):
            rows.append(told | {"estimate": number} | path)
        if tell is not None:
            tell(done + 1, len(combinations))
    frame = pandas.DataFrame(rows)
    about = {key: _about(scene, key) for key in keys}
    about |= {name: _of_result(name) for name in frame.columns if name not in about}
    if to == "xarray":
        return _dataset(frame, keys, about, scene.name)
    frame = frame.drop(columns="estimate")
    frame.attrs = {
        "scene": scene.name,
        "units": {name: one["units"] for name, one in about.items() if "units" in one},
        "long_names": {name: one["long_name"] for name, one in about.items()},
    }
    return frame


def _values(key: str, values: Any) -> Iterable[Any]:
    """The values of a key, of which some may be an array and its unit."""
    match values:
        case (array, str(unit)) if not isinstance(array, str) and np.ndim(array) == 1:
            return [f"{float(value)!r} {unit}" for value in np.asarray(array)]
        case str() | bytes():
            raise ValueError(f"{key}: {values!r} is one value; write a list, [{values!r}]")
    return list(values)


def _told(value: Any) -> Any:
    """What a table has of a value."""
    return value if isinstance(value, (bool, int, float, str)) else str(value)


def _about(scene: Scene, key: str) -> dict[str, str]:
    about = scene.about(key)
    told = {"long_name": about["meaning"]}
    return told | {"units": about["unit"]} if about["unit"] else told


def _of_result(name: str) -> dict[str, str]:
    ends = (end for end in _UNITS if name.endswith(end))
    end = next(ends, "")
    long_name = name.removesuffix(end).replace("_", " ")
    return {"long_name": long_name} | ({"units": _UNITS[end]} if end else {})


def _nothing(done: int, all: int) -> None:
    pass


def _dataset(frame: pandas.DataFrame, keys: list[str], about: dict[str, dict[str, str]], name: str) -> xarray.Dataset:
    dataset: xarray.Dataset = frame.set_index([*keys, "estimate"]).to_xarray()
    # Texts in the order that they were given in; numbers ascend.
    for key in keys:
        if dataset[key].dtype.kind not in "iuf":
            dataset = dataset.reindex({key: list(dict.fromkeys(frame[key]))})
    for variable in dataset.variables:
        dataset[variable].attrs = dict(about[str(variable)])
    dataset.attrs = {"scene": name}
    return dataset
