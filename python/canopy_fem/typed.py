"""Types of arguments, for checkers such as mypy and pyright. Nothing here is needed at run time."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, TypeAlias, TypedDict

import numpy as np
import numpy.typing as npt

from .case_types import CaseDict

__all__ = [
    "CaseDict", "CaseSource", "DashpotKind", "EnergyColumn", "Force", "Gauge", "GaugeQuantity", "Graded", "Initial",
    "Kept", "Kind", "Law", "Method", "Parachute", "Pattern", "Slack", "Table",
]  # fmt: skip

CaseSource: TypeAlias = "str | os.PathLike[str] | CaseDict"
"""a case file, or a dictionary with its keys"""
Method: TypeAlias = Literal[
    "explicit-euler",
    "euler-cromer",
    "euler-richardson",
    "improved-euler",
    "improved-euler-pec",
    "velocity-verlet",
    "beeman",
    "rk4",
    "dormand-prince",
    "dop853",
    "newmark",
    "hht",
    "kang",
    "backward-euler",
    "generalized-alpha",
    "esdirk4",
    "central-difference",
    "multirate",
    "energy-momentum",
    "xpbd",
    "vbd",
]
"""name of a method: those of `canopy_fem.methods`"""
Law: TypeAlias = Literal["linear", "green"]
Slack: TypeAlias = Literal["none", "tension-only", "compression-only"]
DashpotKind: TypeAlias = Literal["axial", "relative"]
Kind: TypeAlias = Literal["nodes", "edges", "triangles"]
Table: TypeAlias = Literal["history", "probes", "gauges", "modes"]
GaugeQuantity: TypeAlias = Literal[
    "tension",
    "force",
    "reaction",
    "acceleration",
    "velocity",
    "speed",
    "displacement",
    "position",
    "crossings",
    "stress",
    "strain",
    "wrinkling",
    "gas",
    "contact",
]
Kept: TypeAlias = Literal["positions", "velocities", "gauges", "energies", "peaks", "peak_times"]
"""what `canopy_fem.rollout` keeps"""
EnergyColumn: TypeAlias = Literal["kinetic", "elastic", "gravity", "external_work", "dissipated", "numerical"]
Rows: TypeAlias = npt.NDArray[Any] | Sequence[Sequence[float]]
"""(n, 3); not numpy's ArrayLike, which a text is too"""
Initial: TypeAlias = tuple[npt.ArrayLike, npt.ArrayLike] | Mapping[str, npt.ArrayLike] | bytes | list[bytes]
"""positions [m] and velocities [m/s], or snapshots"""
Force: TypeAlias = Rows | Callable[[float, npt.NDArray[np.float64], npt.NDArray[np.float64]], npt.ArrayLike]
"""[N] (n, 3), or a function of time [s], positions [m] and velocities [m/s]"""


class Gauge(TypedDict, total=False):
    """An entry of "output.gauges" of a case; `name`, `on` and `of` are needed."""

    name: str
    on: str | Mapping[str, Any]
    of: GaugeQuantity
    every: int


class Graded(TypedDict, total=False):
    """Of discs and rings, beside their sizes."""

    boundary_nodes: int
    seams: int
    seed: int
    grading: float


class Pattern(TypedDict, total=False):
    """Of rectangles, beside their sizes."""

    pattern: str


class Parachute(TypedDict, total=False):
    """The section "parachute" of a case."""

    type: str
    nominal_diameter: float
    constructed_diameter: float
    cloth: str
    tapes: Mapping[str, str]
    gores: int
    vent_diameter: float | None
    radial_segments: int
    gore_segments: int
    coarsen: bool
    cone_angle: float | None
    cone_angles: Sequence[float] | None
    cone_breaks: Sequence[float] | None
    skirt_extension: float | None
    skirt_angle: float | None
    arm_ratio: float | None
    rings: int | None
    slot_porosity: float | None
    sails: int | None
    verticals: int | None
    fullness: float | None
    cap_angle: float | None
    height_ratio: float | None
    pull_down: float | None
    corner_cut: float | None
    disk: float | None
    gap: float | None
    band: float | None
    vent_lines: bool | None
    lines: Mapping[str, Any] | None
    inner_lines: Mapping[str, Any] | None
    centre_line: Mapping[str, Any] | None
    riser: Mapping[str, Any] | None
    payload: Mapping[str, Any] | None
    cluster: Mapping[str, Any] | None
    reefing: Mapping[str, Any] | None
    start: str | Mapping[str, Any]
    start_radius: float | None
    axis: Sequence[float]
    at: Sequence[float]
