"""The public names of canopy_fem. The package itself gets them when one is asked for."""

from . import mesh
from ._core import Energies, Rollout, Step, __version__, methods, schema
from .batch import ENERGIES, Batch
from .case import Case
from .errors import (
    CanopyError,
    CaseError,
    CaseWarning,
    CouplingError,
    Diverged,
    Ended,
    Fault,
    InternalError,
    SimulationError,
)
from .fitting import Fit, fit
from .results import Result, load
from .runs import run, static
from .simulation import Motion, Network, Simulation
from .studies import Sample, check, gradient, program, rollout, sample, stability, sweep, tradeoff

__all__ = [
    "ENERGIES",
    "Batch",
    "CanopyError",
    "Case",
    "CaseError",
    "CaseWarning",
    "CouplingError",
    "Diverged",
    "Ended",
    "Energies",
    "Fault",
    "Fit",
    "InternalError",
    "Motion",
    "Network",
    "Result",
    "Rollout",
    "Sample",
    "Simulation",
    "SimulationError",
    "Step",
    "__version__",
    "check",
    "fit",
    "gradient",
    "load",
    "mesh",
    "methods",
    "program",
    "rollout",
    "run",
    "sample",
    "schema",
    "stability",
    "static",
    "sweep",
    "tradeoff",
]
