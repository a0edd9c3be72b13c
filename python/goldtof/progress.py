"""How far a job has come, in a terminal or a notebook."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

_WIDTH = 30
_SOON_S = 1.0
"""Jobs that are over by then show nothing."""
_BETWEEN_S = 0.1


def _is_seen() -> bool:
    """Whether somebody reads standard error: at a terminal, or below the cell of a notebook."""
    stream = sys.stderr
    if stream is None:
        return False
    return stream.isatty() or type(stream).__module__.startswith("ipykernel")


def bar() -> Callable[[int, int], None] | None:
    """What shows a job's progress on standard error; None where nobody reads it.

    The line goes when the job is done.
    """
    if not _is_seen():
        return None
    begun = shown = time.monotonic()
    length = 0

    def show(done: int, all: int) -> None:
        nonlocal shown, length
        now = time.monotonic()
        if all == 0 or (done < all and (now - begun < _SOON_S or now - shown < _BETWEEN_S)):
            return
        shown = now
        line = ""
        if done < all:
            full = _WIDTH * done // all
            left_s = (now - begun) * (all - done) / max(done, 1)
            line = f"[{'#' * full}{' ' * (_WIDTH - full)}] {done} of {all}, {left_s:.0f} s left"
        if line or length:
            print(f"\r{line:{length}}", end="" if line else "\r", file=sys.stderr, flush=True)
        length = len(line)

    return show
