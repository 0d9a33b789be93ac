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
    "CaseWarning",
    "CouplingError",
    "CouplingLost",
    "Diverged",
    "Ended",
    "Fault",
    "FlowDiverged",
    "InternalError",
    "KratosMissing",
    "NotCoupled",
    "SimulationError",
    "SurfaceOutside",
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

    def __reduce__(self) -> tuple[Any, ...]:
        # Python's own way calls the class with `args`, which fails for a class that makes its message itself. A pool of
        # processes then breaks, or waits for ever.
        return _again, (type(self), self.args), self.__dict__


def _again(kind: type[CanopyError], args: tuple[Any, ...]) -> CanopyError:
    """An exception of a pickle, before its attributes."""
    error = kind.__new__(kind)
    error.args = args
    return error


class CaseWarning(UserWarning):
    """Something doubtful about a case or a run."""


class CaseError(CanopyError, ValueError):
    """A case, a mesh or a network that cannot be used; `faults` lists what is wrong with a case."""

    def __init__(self, message: str = "", faults: Iterable[Mapping[str, Any] | Fault] = ()) -> None:
        super().__init__(message)
        self.faults: list[Fault] = [fault if isinstance(fault, Fault) else Fault(**fault) for fault in faults]


class CouplingError(CanopyError, RuntimeError):
    """What another program of a coupling gives or asks, and cannot be used: an interface of another size, forces that
    are not finite, a program that is not installed. The structure is where its last whole step ended."""


class CouplingLost(CouplingError):
    """A coupling that has ended before its time: its library has failed in the middle of it, as preCICE does where a
    partner has gone. The structure is where its last whole step ended."""


class KratosMissing(CouplingError):
    """Kratos, or applications of it, are not installed; `packages` lists them."""

    def __init__(self, packages: list[str]) -> None:
        super().__init__(
            f"this needs {', '.join(packages)}, which cannot be imported here\n"
            f"Kratos 10.4.4 has wheels for Python 3.11: pip install {' '.join(packages)}"
        )
        self.packages = packages


class FlowDiverged(CouplingError):
    """A flow with values that are not finite, or beyond all measure: `time` [s], `speed` [m/s] and `stream` [m/s]."""

    def __init__(self, time: float, speed: float, stream: float) -> None:
        super().__init__(
            f"the flow has diverged in the step to t = {time:g} s: its greatest speed is {speed:g} m/s in a stream of "
            f"{stream:g} m/s\nMake the step smaller, or the mesh finer about the surface"
        )
        self.time, self.speed, self.stream = time, speed, stream


class SurfaceOutside(CouplingError):
    """A surface that leaves the box: `node`, its `position` [m], and `low` and `high` [m] of the box."""

    def __init__(self, node: int, position: Any, low: Any, high: Any) -> None:
        where = [[round(float(x), 6) for x in row] for row in (position, low, high)]
        super().__init__(
            f"node {node} of the surface is at {where[0]} m, outside the box from {where[1]} to {where[2]} m"
        )
        self.node, self.position, self.low, self.high = node, position, low, high


class NotCoupled(CouplingError):
    """Iterations of flow and structure that have not converged: `time` [s], `residual` and `tolerance` [-]."""

    def __init__(self, time: float, iterations: int, residual: float, tolerance: float) -> None:
        super().__init__(
            f"flow and structure do not agree in the step to t = {time:g} s: after {iterations} iterations the "
            f"positions change by {residual:.2g} of the size of the mesh, the tolerance is {tolerance:.2g}"
        )
        self.time, self.iterations, self.residual, self.tolerance = time, iterations, residual, tolerance


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
