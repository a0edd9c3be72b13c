"""What jobs report: dicts whose fields are attributes, too."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, SupportsIndex, overload

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import pandas
    from matplotlib.axes import Axes


class Report(dict[str, Any]):
    """A report of a job, with the names of the command line's JSON.

    Fields are items and attributes: ``told["estimate"]["distance_m"]`` is
    ``told.estimate.distance_m``.
    """

    def __init__(self, fields: dict[str, Any]) -> None:
        super().__init__((name, _report(value)) for name, value in fields.items())

    def __getattr__(self, name: str) -> Any:
        try:
            return self[name]
        except KeyError:
            names = ", ".join(self)
            raise AttributeError(f"there is no {name!r} in the report; there are {names}") from None

    def __dir__(self) -> Iterable[str]:
        return [*super().__dir__(), *self]

    def to_dict(self) -> dict[str, Any]:
        """The same as plain dicts and lists; arrays stay."""
        plain: dict[str, Any] = _plain(self)
        return plain


class Estimate(Report):
    """What a scan says of the distance (m, half the optical path), and what seems wrong with it.

    ``estimate`` has the scene's estimator's answer beside truth and expectation, ``chi_square``
    how well the scene explains the counts, ``diagnosis`` what does not fit, ``phase_steps`` or
    ``bins`` arrays with what was counted, what is expected, and the residuals in standard
    deviations.
    """

    @property
    def distance_m(self) -> float | None:
        """The distance that the scene's estimator finds; None where it finds none."""
        distance_m: float | None = self["estimate"]["distance_m"]
        return distance_m

    def to_pandas(self) -> pandas.DataFrame:
        """A row for each phase step, or bin."""
        import pandas

        table = self["phase_steps"] if len(self["phase_steps"]["count"]) else self["bins"]
        frame = pandas.DataFrame(dict(table))
        frame.attrs = {"detector": self["detector"], "distance_m": self.distance_m}
        return frame

    def plot(self, axes: tuple[Axes, Axes] | None = None) -> tuple[Axes, Axes]:
        """Counts, and the expected ones with a band of two standard deviations; below them the
        residuals. Needs matplotlib."""
        frame = self.to_pandas()
        if axes is None:
            import matplotlib.pyplot as plt

            shape: dict[str, Any] = {"sharex": True, "height_ratios": (2, 1)}
            both = plt.subplots(2, 1, layout="constrained", **shape)[1]
            axes = (both[0], both[1])
        of_counts, of_residuals = axes
        along = "phase_step" if "phase_step" in frame else "bin"
        x, expected = frame[along], frame["expected_count"]
        band = 2 * frame["expected_count_std"]
        of_counts.fill_between(
            x, expected - band, expected + band, color="C1", alpha=0.4, linewidth=0,
            label="expected, with two standard deviations",
        )
        of_counts.plot(x, frame["count"], ".", color="C0", markersize=4, label="counted")
        of_counts.set(ylabel="count", title=_title(self))
        of_counts.legend()
        of_residuals.axhline(0, color="0.5", linewidth=1)
        of_residuals.plot(x, frame["residual_in_std"], ".", color="C0", markersize=4)
        of_residuals.set(xlabel=along.replace("_", " "), ylabel="residual (std)")
        return axes


class Estimates(list[Estimate]):
    """Estimates of several scans, in their order."""

    @property
    def distance_m(self) -> NDArray[np.float64]:
        """The distance of each scan; nan where the estimator finds none."""
        distances = [np.nan if one.distance_m is None else one.distance_m for one in self]
        return np.array(distances, np.float64)

    @overload
    def __getitem__(self, index: SupportsIndex) -> Estimate: ...
    @overload
    def __getitem__(self, index: slice) -> Estimates: ...
    def __getitem__(self, index: SupportsIndex | slice) -> Estimate | Estimates:
        got = super().__getitem__(index)
        return Estimates(got) if isinstance(got, list) else got

    def to_pandas(self) -> pandas.DataFrame:
        """A row for each scan: the estimator's answer, and how well the scene explains it."""
        import pandas

        fit = ["fitted_distance_m", "fitted_distance_std_m", "chi_square", "degrees_of_freedom", "p_value"]
        rows = [
            {name: value for name, value in one["estimate"].items() if not isinstance(value, dict)}
            | {name: one[name] for name in fit}
            for one in self
        ]
        frame = pandas.DataFrame(rows)
        frame.index.name = "scan"
        return frame


def _title(told: Estimate) -> str:
    distance_m = told.distance_m
    answer = "no distance" if distance_m is None else f"{distance_m:.4f} m"
    return f"{told['detector']}: {answer}"


def _report(value: Any) -> Any:
    if type(value) is dict:
        return Report(value)
    if type(value) is list:
        return [_report(item) for item in value]
    return value


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _plain(item) for name, item in value.items()}
    if isinstance(value, list):
        return [_plain(item) for item in value]
    return value
