"""A sensor at a serial port, or a simulated board at a pseudo-terminal."""

from __future__ import annotations

from collections.abc import Iterator
from os import PathLike, fspath
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._goldtof import _Device

__all__ = ["Device", "open"]


def open(port: str, scene: str | PathLike[str] | None = None, *, baud: int = 3_000_000) -> Device:
    """Opens the port of a device, and asks what is there.

    With the file of a ``scene`` a device that was built from another one is refused. A port that is not there, another
    protocol and another scene are a :class:`GoldtofError`, a silent device is a ``TimeoutError``.
    """
    return Device(port, scene, baud=baud)


class Device:
    """A device, which a thread reads from the moment that it is open, whatever Python does meanwhile.

    ``identity`` is what it says of itself, ``tally`` how much has come and how much is missing. A device that was
    unplugged raises ``ConnectionError`` as soon as all scans that came before have been taken.
    """

    def __init__(
        self, port: str, scene: str | PathLike[str] | None = None, *, baud: int = 3_000_000
    ) -> None:
        self._device = _Device(port, scene=None if scene is None else fspath(scene), baud=baud)

    @property
    def identity(self) -> dict[str, Any]:
        """What the device says of itself when it is asked."""
        return self._device.identity

    @property
    def tally(self) -> dict[str, int]:
        """How much has come so far, and how much has not: frames, results, losses."""
        return self._device.tally

    def scan(self, *, detector: int = 0, timeout_s: float = 10.0) -> dict[str, Any]:
        """The next scan that comes whole.

        ``signed`` has its counts, one for each of ``phase_step``, and ``total`` the total counts, where the hardware
        sends them; of a histogram there are ``bins``. ``time_s`` is when its last result came, in seconds since 1970;
        ``scan`` its number, which scans that did not come whole have, too. Scans wait for whoever asks, so that one
        may be older than the call. Without one for ``timeout_s`` there is a ``TimeoutError``.
        """
        return self._device._scan(detector, timeout_s)

    def scans(
        self, count: int, *, detector: int = 0, timeout_s: float = 10.0
    ) -> dict[str, NDArray[Any]]:
        """The next ``count`` scans: arrays ``signed`` and ``total`` of (scans, phase steps), or ``bins`` of (scans,
        bins), as :func:`goldtof.scans` gives simulated ones; ``scan`` and ``time_s`` of (scans,).

        ``timeout_s`` is for each of them.
        """
        if count < 1:
            raise ValueError("count is at least 1")
        told = [self.scan(detector=detector, timeout_s=timeout_s) for _ in range(count)]
        arrays = {name: np.array([scan[name] for scan in told]) for name in told[0]}
        if "phase_step" in arrays and (arrays["phase_step"] == arrays["phase_step"][0]).all():
            arrays["phase_step"] = arrays["phase_step"][0]
        return arrays

    def read(self, address: int) -> int:
        """The register at a byte address (docs/registers.md)."""
        return self._device.read(address)

    def write(self, address: int, data: int, *, force: bool = False) -> None:
        """Writes the register at a byte address.

        Of a device that was opened with its scene, a code's taps that are no primitive polynomial of its degree are
        refused (``ValueError``), unless ``force`` is true: docs/registers.md.
        """
        self._device.write(address, data, force=force)

    def close(self) -> None:
        """Gives the port back."""
        self._device.close()

    def __iter__(self) -> Iterator[dict[str, Any]]:
        """Scans as they come, until the device is silent for ten seconds or gone."""
        while True:
            yield self.scan()

    def __enter__(self) -> Device:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()
