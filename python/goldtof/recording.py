"""Photons that an instrument recorded, in files or arrays."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ._goldtof import Scene, _replay


def replay(
    scene: Scene,
    tags: str | PathLike[str] | tuple[ArrayLike, ArrayLike],
    *,
    photons: str | int | Mapping[str, str | int],
    epoch: str | int = "m1",
    epoch_periods: int = 1,
    tick_s: float = 1e-12,
) -> dict[str, Any]:
    """What recorded photons say, as ``goldtof replay --json`` has it.

    ``tags`` is a file of time tags (PTU in T2 mode, or pairs of 64-bit numbers, picoseconds and channel), or
    two arrays of whole numbers: times in ticks of ``tick_s`` seconds, and channels. ``photons`` is the
    channel of the detector, or a channel for each detector's name; ``epoch`` that of the marks at
    the code's epochs, ``epoch_periods`` code periods apart. Each of ``detectors`` also has its ``bins``, the
    counts of all code periods by sample.

    >>> import numpy as np
    >>> times = np.arange(0, 10**9, 248_000)                  # the epochs of 31 chips of 8 ns
    >>> photons = times + 20_000 + np.arange(len(times)) * 7919 % 200_000
    >>> channels = np.repeat([2, 1], len(times))
    >>> told = replay(Scene.parse(QUICK), (np.concatenate([times, photons]), channels),
    ...               photons=1, epoch=2)
    >>> told["file"]["epochs"]["epochs"], len(told["detectors"][0]["bins"])
    (4033, 248)
    """
    named = photons if isinstance(photons, Mapping) else None
    options: dict[str, Any] = {
        "photons": [f"{name}={channel}" for name, channel in named.items()]
        if named is not None
        else [str(photons)],
        "epoch": str(epoch),
        "epoch_periods": epoch_periods,
    }
    if not isinstance(tags, tuple):
        return _replay(scene, path=tags, **options)
    times, channels = (np.asarray(array) for array in tags)
    if times.shape != channels.shape or times.ndim != 1:
        raise ValueError("times and channels are two arrays of one length")
    for name, array in (("times", times), ("channels", channels)):
        if array.dtype.kind not in "iu" or (array.size > 0 and array.min() < 0):
            raise ValueError(f"{name} are whole numbers from 0 up")
    picoseconds = np.rint(times * (tick_s * 1e12)) if tick_s != 1e-12 else times
    order = np.argsort(picoseconds, kind="stable")
    pairs = np.column_stack([picoseconds, channels])[order].astype("<u8")
    return _replay(scene, pairs=pairs.tobytes(), **options)
