from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from typing import Any, Literal, final

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "__version__",
    "SPEED_OF_LIGHT_M_PER_S",
    "GoldtofError",
    "SceneError",
    "ToolError",
    "Scene",
    "ReferenceModel",
    "Scoreboard",
    "codes",
    "correlation",
    "emit",
    "expected",
    "simulate",
    "scans",
    "_estimate",
    "_recorded",
    "_replay",
    "_Device",
    "read_tags",
    "_scene",
    "cosim",
]
__version__: str
SPEED_OF_LIGHT_M_PER_S: float

_Fidelity = Literal["expected", "counts", "events", "sampled", "rtl"]
_Engine = Literal["auto", "lanes", "lockstep"]
_Estimator = Literal["fft", "model"]
_Progress = Callable[[int, int], object]
_Words = NDArray[np.uint8] | NDArray[np.uint16] | NDArray[np.uint32] | NDArray[np.uint64]
_Levels = NDArray[np.bool_] | NDArray[np.uint8]

class GoldtofError(Exception): ...
class SceneError(GoldtofError):
    places: list[dict[str, Any]]

class ToolError(GoldtofError): ...

@final
class Scene:
    @staticmethod
    def load(path: str | PathLike[str]) -> Scene: ...
    @staticmethod
    def parse(text: str, name: str = "scene.toml") -> Scene: ...
    @staticmethod
    def from_dict(tables: dict[str, Any], name: str = "scene.toml") -> Scene: ...
    def copy(self) -> Scene: ...
    def __copy__(self) -> Scene: ...
    def __deepcopy__(self, _memo: Any) -> Scene: ...
    def __reduce__(self) -> tuple[Any, ...]: ...
    def __eq__(self, other: object) -> bool: ...
    def __hash__(self) -> int: ...
    def __getitem__(self, key: str) -> Any: ...
    def __setitem__(self, key: str, value: Any) -> None: ...
    def about(self, key: str) -> dict[str, Any]: ...
    def _repr_html_(self) -> str: ...
    @property
    def name(self) -> str: ...
    @property
    def text(self) -> str: ...
    @property
    def settings(self) -> list[str]: ...
    @property
    def phase_steps(self) -> int: ...
    @property
    def samples_per_chip(self) -> int: ...
    @property
    def chip_period_s(self) -> float: ...
    @property
    def integration_s(self) -> float: ...
    @property
    def scan_clocks(self) -> int: ...
    @property
    def sources(self) -> list[str]: ...
    @property
    def detectors(self) -> list[str]: ...
    @property
    def path_distances_m(self) -> list[float]: ...
    @property
    def ports(self) -> list[tuple[str, int]]: ...
    @property
    def result_latency_clocks(self) -> int: ...

@final
class ReferenceModel:
    def __new__(
        cls,
        scene: Scene,
        *,
        result_latency_clocks: int | None = None,
        peak_latency_clocks: int | None = None,
    ) -> ReferenceModel: ...
    def clock(
        self,
        samples: _Words,
        reset: _Levels | None = None,
        ready: _Levels | None = None,
        host: Mapping[str, NDArray[Any]] | None = None,
    ) -> dict[str, _Words]: ...
    def take_results(self) -> dict[str, NDArray[Any]]: ...
    @property
    def clocks(self) -> int: ...

@final
class Scoreboard:
    def __new__(
        cls,
        scene: Scene,
        ports: Sequence[tuple[str, int]],
        *,
        result_latency_clocks: int | Literal["auto"] | None = None,
        peak_latency_clocks: int | None = None,
        is_idle_payload_free: bool = True,
        batch_clocks: int = 4096,
    ) -> Scoreboard: ...
    @property
    def words(self) -> int: ...
    def push(self, words: NDArray[np.uint64]) -> bool: ...
    def summary(self) -> dict[str, Any]: ...

def codes(
    family: str,
    *,
    degree: int | None = None,
    index: int | None = None,
    interleave: int = 0,
    polynomials: str | None = None,
    seeds: str | None = None,
    chips: str | None = None,
    allow_non_preferred: bool = False,
) -> dict[str, Any]: ...
def correlation(a: NDArray[np.uint8], b: NDArray[np.uint8]) -> NDArray[np.int64]: ...
def emit(scene: Scene, out: str | PathLike[str], *, prefix: str | None = None) -> dict[str, Any]: ...
def expected(
    scene: Scene,
    *,
    detector: str | None = None,
    fidelity: _Fidelity = "expected",
    estimator: _Estimator | None = None,
) -> dict[str, Any]: ...
def simulate(
    scene: Scene,
    *,
    fidelity: _Fidelity | str = "expected",
    repetitions: int = 1,
    seed: int = 1,
    engine: _Engine = "auto",
    estimator: _Estimator | str | None = None,
    on_progress: _Progress | None = None,
) -> dict[str, Any]: ...
def scans(
    scene: Scene,
    *,
    fidelity: _Fidelity = "sampled",
    repetitions: int = 1,
    seed: int = 1,
    detector: str | None = None,
    on_progress: _Progress | None = None,
) -> dict[str, NDArray[Any]]: ...
def _estimate(
    scene: Scene,
    counts: NDArray[np.int64] | None = None,
    *,
    total: NDArray[np.uint64] | None = None,
    bins: NDArray[np.uint64] | None = None,
    detector: str | None = None,
    estimator: _Estimator | None = None,
    on_progress: _Progress | None = None,
) -> list[dict[str, Any]]: ...
def _recorded(
    scene: Scene, path: str | PathLike[str], *, detector: str | None = None
) -> dict[str, NDArray[Any]]: ...
def _replay(
    scene: Scene,
    *,
    path: str | PathLike[str] | None = None,
    pairs: bytes | None = None,
    photons: Sequence[str],
    epoch: str,
    epoch_periods: int,
) -> dict[str, Any]: ...

@final
class _Device:
    def __new__(
        cls, port: str, *, scene: str | PathLike[str] | None = None, baud: int = 3_000_000
    ) -> _Device: ...
    @property
    def identity(self) -> dict[str, Any]: ...
    @property
    def tally(self) -> dict[str, int]: ...
    def _scan(self, detector: int, timeout_s: float) -> dict[str, Any]: ...
    def read(self, address: int) -> int: ...
    def write(self, address: int, data: int, *, force: bool = False) -> None: ...
    def close(self) -> None: ...

def read_tags(path: str | PathLike[str]) -> dict[str, Any]: ...
def _scene(file_name: str, text: str, settings: Sequence[tuple[str, str]]) -> Scene: ...
def cosim(
    scene: Scene,
    *,
    rtl: str | PathLike[str] | None = None,
    file_lists: Sequence[str | PathLike[str]] = ...,
    top: str | None = None,
    include_folders: Sequence[str | PathLike[str]] = ...,
    defines: Sequence[str] = ...,
    stimulus: Literal["photons", "adversarial"] = "photons",
    clocks: int | None = None,
    seed: int = 1,
    latency: str | None = None,
    engine: _Engine = "auto",
    on_progress: _Progress | None = None,
) -> dict[str, Any]: ...
