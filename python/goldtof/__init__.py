"""Golden model, simulation and estimation of DS-CDMA indirect time-of-flight sensors.

A scene says what there is; everything else is done with it:

>>> scene = Scene.parse(QUICK, "quick.toml")
>>> scene
<goldtof.Scene 'quick': 248 phase steps, 1 detector>
>>> path = simulate(scene)["estimates"][0]          # what theory expects
>>> round(path["true_distance_m"], 3)
3.2

Quantities are in SI units, which their names end in. What jobs report has the names of the
command line's JSON; errors are :class:`GoldtofError` with the words of the command line.
"""

from . import device
from ._goldtof import (
    SPEED_OF_LIGHT_M_PER_S,
    GoldtofError,
    ReferenceModel,
    Scene,
    SceneError,
    Scoreboard,
    ToolError,
    __version__,
    codes,
    correlation,
    cosim,
    emit,
    expected,
    read_tags,
    scans,
    simulate,
)
from .estimating import estimate
from .recording import replay
from .reports import Estimate, Estimates, Report
from .sweeping import sweep

__all__ = [
    "SPEED_OF_LIGHT_M_PER_S",
    "Estimate",
    "Estimates",
    "GoldtofError",
    "ReferenceModel",
    "Report",
    "Scene",
    "SceneError",
    "Scoreboard",
    "ToolError",
    "__version__",
    "codes",
    "correlation",
    "cosim",
    "device",
    "emit",
    "estimate",
    "expected",
    "read_tags",
    "replay",
    "scans",
    "simulate",
    "sweep",
]
