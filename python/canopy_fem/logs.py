"""What goes to the logger `canopy_fem` of the standard library.

``canopy_fem``: the start and the end of runs (INFO), doubts about a case and runs that fail (WARNING).
``canopy_fem.engine``: what the engine says on the way, events among it (INFO, DEBUG).
"""

from __future__ import annotations

import logging
import warnings

from ._core import _listen
from .errors import CaseWarning

__all__ = ["doubt", "listen", "log"]

log = logging.getLogger("canopy_fem")
log.addHandler(logging.NullHandler())


def listen() -> None:
    """The engine says from now on what the present level of its logger lets through."""
    _listen()


def doubt(text: str, stacklevel: int) -> None:
    """Tells a doubt, as a `CaseWarning` of the caller that many levels up and in the log."""
    log.warning("%s", text)
    warnings.warn(text, CaseWarning, stacklevel=stacklevel + 1)
