"""A scene and the flow about a thin surface of it, which agree in every step; see `canopy_fem.embedded` for its limits.

>>> structure = Structure("canopy.json", ["canopy"])                                   # doctest: +SKIP
>>> points, triangles = Coupled.surface(structure, "canopy")                           # doctest: +SKIP
>>> flow = Flow(mesh, points, triangles, stream=[0, 0, 10], step=0.005)                # doctest: +SKIP
>>> coupled = Coupled(flow, structure, "canopy")                                       # doctest: +SKIP
>>> coupled.advance()                                                                  # doctest: +SKIP
"""

from __future__ import annotations

import json

import numpy as np
import numpy.typing as npt

from .coupling import Structure
from .embedded import Flow
from .errors import CouplingError, NotCoupled

__all__ = ["Coupled", "NotCoupled"]

_Array = npt.NDArray[np.float64]
_Indices = npt.NDArray[np.int64]


class Coupled:
    """A flow and a structure that exchange forces and positions in every step until they agree.

    The unknown is where the surface is at the end of the step. Iterations are quasi-Newton (IQN-ILS, Degroote 2009, as
    Kratos has it), since cloth is lighter than the air that it moves: with one exchange a step it would diverge.

    Args:
        flow: the flow, whose surface is that of the interface: `Coupled.surface`.
        structure: the scene, at the time at which the surface is let go.
        group: its interface.
        tolerance: [-] change of positions in an iteration: root of their mean square, over the size of fine bricks.
        iterations: at most so many in a step.
        relaxation: [-] share of the first correction of all that is made; small for light cloth.
        horizon: from so many steps before iterations learn.

    Raises:
        CouplingError: another number of nodes, or a surface elsewhere.
    """

    def __init__(
        self,
        flow: Flow,
        structure: Structure,
        group: str,
        *,
        tolerance: float = 2e-2,
        iterations: int = 20,
        relaxation: float = 0.1,
        horizon: int = 4,
    ) -> None:
        import KratosMultiphysics as km
        from KratosMultiphysics.CoSimulationApplication.convergence_accelerators import iqnils

        self.flow, self.structure, self.group = flow, structure, group
        self.tolerance, self.iterations = tolerance, iterations
        points, _ = self.surface(structure, group)
        if points.shape != flow.points.shape or np.abs(points - flow.points).max() > 1e-6 * flow.mesh.size:
            raise CouplingError(f'the surface of the flow is not that of the interface "{group}": make it of `surface`')
        settings = {"type": "iqnils", "iteration_horizon": 20, "timestep_horizon": horizon, "alpha": relaxation}
        self._quasi = iqnils.Create(km.Parameters(json.dumps(settings)))
        self._quasi.Initialize()
        self.forces = np.zeros_like(points)

    @staticmethod
    def surface(structure: Structure, group: str) -> tuple[_Array, _Indices]:
        """Points [m] and triangles of an interface, for `Flow`."""
        interface = structure.interfaces[group]
        return interface.points + structure.displacements(group), interface.triangles

    def advance(self) -> int:
        """Makes a step of the flow's size, and returns the number of iterations. `forces` are those at its end.

        Raises:
            NotCoupled: the iterations do not converge. `advance` may be called again, with more of them.
            FlowDiverged, SurfaceOutside: as `Flow.solve`.
            Diverged: the structure cannot be solved under the forces.
        """
        self.structure.rewind()
        self.flow.begin()
        self._quasi.InitializeSolutionStep()
        try:
            return self._iterate()
        finally:
            self._quasi.FinalizeSolutionStep()

    def _iterate(self) -> int:
        flow, structure, rest = self.flow, self.structure, self.structure.interfaces[self.group].points
        start, residual = structure.displacements(self.group), np.inf
        trial = start + flow.step * structure.velocities(self.group)
        for iteration in range(1, self.iterations + 1):
            self.forces = flow.solve(rest + trial, (trial - start) / flow.step)
            structure.push(self.group, self.forces)
            structure.solve(flow.step)
            change = structure.displacements(self.group) - trial
            residual = float(np.sqrt((change**2).sum(axis=1).mean()) / flow.mesh.size)
            if residual <= self.tolerance:
                structure.accept()
                flow.accept()
                return iteration
            trial = trial + self._quasi.UpdateSolution(change.ravel(), trial.ravel()).reshape(trial.shape)
        raise NotCoupled(flow.time, self.iterations, residual, self.tolerance)
