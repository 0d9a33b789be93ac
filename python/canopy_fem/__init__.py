"""Parachute canopies and cloth as mass-spring networks, integrated the way a finite-element code would.

The engine of the program ``canopy-fem``. Units are SI; nodes, edges and triangles count from 0, as in the mesh.

=================================  ===================================================================
`Case`                             a case: a file or a dictionary, with other values
`run`, `load`, `Result`            a whole run with the files of ``canopy-fem solve``; its tables
`static`                           the equilibrium of a case, and the modes about it
`Simulation`                       a scene in motion: step by step, with forces and changes from outside
`Network`                          masses and springs from arrays
`rollout`, `Batch`                 many runs at once, on a pool of threads
`check`, `tradeoff`, `sweep`, …    studies
`coupling`, `kratos`, `precice`    couplings with flow solvers
`embedded`, `embedded_coupling`    thin surfaces in a flow of Kratos
`mesh`                             generators, files, meshio, pyvista
`CaseError`, `Diverged`, …         exceptions
=================================  ===================================================================
"""

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
