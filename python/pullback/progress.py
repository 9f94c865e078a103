"""A line that shows progress."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable


class Progress:
    """A line on a terminal with the part that is done and the time left; none if `end` is not a number.

    `done` of `end` was there before.
    """

    def __init__(self, end: float, done: float = 0.0) -> None:
        self._end, self._done, self._start = end, done, time.monotonic()
        self._shown = end > done and sys.stderr.isatty()

    def __enter__(self) -> Callable[[float], None] | None:
        return self._show if self._shown else None

    def _show(self, at: float) -> None:
        part = min((at - self._done) / (self._end - self._done), 1.0)
        left = f", {(time.monotonic() - self._start) * (1 / part - 1):.0f} s left" if part > 0 else ""
        sys.stderr.write(f"\r{100 * min(at / self._end, 1.0):5.1f} %{left} ")
        sys.stderr.flush()

    def __exit__(self, *_: object) -> None:
        if self._shown:
            sys.stderr.write("\r" + " " * 40 + "\r")
