"""How far runs are: a line on standard error, or a bar in a notebook."""

from __future__ import annotations

import html
import sys
import time
from collections.abc import Callable
from importlib import import_module
from typing import Any

__all__ = ["teller"]

# [s] between two looks of the line or bar
_EVERY = 0.1


def teller(progress: Any, text: Callable[[Any, Any], str], what: str) -> Callable[[Any, Any], object] | None:
    """The function that is told how far runs are, of a number and its end; None if nobody is.

    Args:
        progress: what a user gave: True, False, None or a function.
        text: what a line shows.
        what: the two numbers, in words.
    """
    if progress is False or progress is None:
        return None
    if callable(progress):
        return progress  # type: ignore[no-any-return]
    if progress is not True:
        raise TypeError(f"progress is True, False or a function of {what}")
    show, last = _notebook() or _line, [0.0]

    def tell(now: Any, end: Any) -> None:
        clock = time.monotonic()
        if clock - last[0] >= _EVERY or now >= end:
            last[0] = clock
            show(now / end if end else 1.0, text(now, end))

    return tell


def _line(share: float, text: str) -> None:
    print(f"\r{100 * share:3.0f} %  {text}", end="\n" if share >= 1 else "", file=sys.stderr, flush=True)


def _notebook() -> Callable[[float, str], None] | None:
    """What draws a bar in the notebook that this runs in; None elsewhere."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    if getattr(shell, "kernel", None) is None:
        return None
    parts = import_module("IPython.display")
    handle: list[Any] = []

    def show(share: float, text: str) -> None:
        drawn = parts.HTML(f'<progress value="{share:.4f}" max="1"></progress> {html.escape(text)}')
        if handle:
            handle[0].update(drawn)
        else:
            handle.append(parts.display(drawn, display_id=True))

    return show
