"""What canopy_fem raises.

`CanopyError` is above all of them. Where an argument has the wrong type or shape, it is `TypeError` or `ValueError`;
where a file cannot be read or written, `OSError`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

__all__ = [
    "CanopyError",
    "CaseError",
    "CouplingError",
    "Diverged",
    "Ended",
    "Fault",
    "InternalError",
    "SimulationError",
]


@dataclass(frozen=True)
class Fault:
    """One thing that is wrong with a case."""

    pointer: str
    """where, as a JSON pointer: /time/step"""
    value: str
    """what is there, shortened"""
    allowed: str
    """what is allowed there"""
    hint: str | None = None
    """advice"""


class CanopyError(Exception):
    """Whatever canopy_fem raises of its own."""


class CaseError(CanopyError, ValueError):
    """A case, a mesh or a network that cannot be used; `faults` lists what is wrong with a case."""

    def __init__(self, message: str = "", faults: Iterable[Mapping[str, Any] | Fault] = ()) -> None:
        super().__init__(message)
        self.faults: list[Fault] = [fault if isinstance(fault, Fault) else Fault(**fault) for fault in faults]


class CouplingError(CanopyError, RuntimeError):
    """What another program of a coupling gives or asks, and cannot be used: an interface of another size, forces that
    are not finite, a program that is not installed. The structure is where its last whole step ended."""


class SimulationError(CanopyError, RuntimeError):
    """A simulation that refuses a request, e.g. a step while an attempted one waits."""


class Diverged(SimulationError):
    """A step that diverged, or an implicit step that could not be solved. The state is that before the step.

    `report` is the post-mortem: a dictionary with `time` [s], `step`, `node`, `spring`, `term`, `cause`, `advice`, …;
    `result` is the `Result` of a run with files, else None.
    """

    def __init__(self, message: str = "", report: Mapping[str, Any] | None = None) -> None:
        super().__init__(message)
        self.report: dict[str, Any] = dict(report or {})
        self.result: Any = None


class Ended(SimulationError):
    """A simulation that has reached its end."""


class InternalError(CanopyError, RuntimeError):
    """A defect of the engine. Make a new simulation: the one at hand may be broken."""
