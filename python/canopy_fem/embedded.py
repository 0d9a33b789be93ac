"""A flow of Kratos about a thin surface on a fixed mesh; no porosity, friction, turbulence model or compressibility.

Cloth loses no air, and the fluid slips along it. Below the size of the mesh, the stabilisation of the elements is the
only model of turbulence. Nodes that a moving surface passes keep the velocity that they had on its other side.

The surface is a set of triangles that may go anywhere within a fixed box of tetrahedra. Elements that it cuts have
separate pressures and velocities on its two sides (Kratos' `embedded_weakly_compressible_navier_stokes_discontinuous`;
Zorrilla, Larese and Rossi 2019). At its edge, an element that is cut only in part counts as a whole in the forces.

>>> flow = Flow(mesh, points, triangles, stream=[0, 0, 10], step=0.005)      # doctest: +SKIP
>>> forces = flow.advance()                                                  # doctest: +SKIP

`canopy_fem.embedded_coupling` couples it with a scene.

Tested with Kratos 10.4.4, which has wheels for Python 3.11.
"""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import numpy.typing as npt

from .background import Box, nearest, nodal_forces
from .errors import CouplingError, FlowDiverged, KratosMissing, SurfaceOutside

__all__ = ["Flow", "FlowDiverged", "KratosMissing", "SurfaceOutside"]

_Array = npt.NDArray[np.float64]
_Indices = npt.NDArray[np.int64]
# [-] distance of a node from the surface, as a share of the size of bricks, below which it counts as on it.
_APART = 1e-3
# Barycentric coordinates of the centres of nine equal parts of a facet.
_PLACES = np.array(
    [[7, 1, 1], [1, 7, 1], [1, 1, 7], [4, 4, 1], [4, 1, 4], [1, 4, 4], [5, 2, 2], [2, 5, 2], [2, 2, 5]]
) / 9.0  # fmt: skip
_NEEDED = ("FluidDynamicsApplication", "LinearSolversApplication", "CoSimulationApplication")


class Flow:
    """A stream about a surface.

    Faces of the box where the stream enters have its velocity, those where it leaves have no pressure, and along those
    that it is parallel to the fluid slips. It starts everywhere with the velocity of the stream.

    Args:
        mesh: the box, of `canopy_fem.background.box`.
        points: [m] nodes of the surface, (n, 3).
        triangles: their numbers, (t, 3).
        stream: [m/s] (3,).
        step: [s] of the flow; `stream * step` of half a fine brick to a whole one is a good choice.
        density: [kg/m^3] of the fluid.
        viscosity: [Pa s] of the fluid.
        iterations: Newton's iterations of a step, at most.

    Raises:
        KratosMissing: Kratos is not installed, or not for this Python.
        SurfaceOutside: the surface leaves the box.
        ValueError: arrays of other shapes, or values that are not finite or not above 0.
    """

    def __init__(
        self,
        mesh: Box,
        points: npt.ArrayLike,
        triangles: npt.ArrayLike,
        *,
        stream: npt.ArrayLike,
        step: float,
        density: float = 1.225,
        viscosity: float = 1.8e-5,
        iterations: int = 5,
    ) -> None:
        self.mesh, self.stream = mesh, np.asarray(stream, dtype=float)
        self.triangles: _Indices = np.asarray(triangles, dtype=np.int64)
        if self.stream.shape != (3,) or not np.isfinite(self.stream).all() or not self.stream.any():
            raise ValueError(f"stream is {stream!r}: give three components [m/s], not all of them 0")
        for name, value in (("step", step), ("density", density), ("viscosity", viscosity)):
            if not (np.isfinite(value) and value > 0):
                raise ValueError(f"{name} is {value!r}: it must be above 0 and finite")
        if (
            self.triangles.ndim != 2
            or self.triangles.shape[1] != 3
            or not self.triangles.size
            or self.triangles.min() < 0
        ):
            raise ValueError(f"triangles have the shape {self.triangles.shape}: give (t, 3), numbers from 0")
        self.step, self.density, self._open = float(step), float(density), False
        self._points = self._checked(points)
        self._kratos()
        self._build_fluid(viscosity, iterations)
        self._build_surface()
        self._place(self._points, None)

    @property
    def time(self) -> float:
        """[s] end of the last step"""
        return float(self._part.ProcessInfo[self._km.TIME])

    @property
    def points(self) -> _Array:
        """[m] nodes of the surface, (n, 3)"""
        return self._points.copy()

    def begin(self) -> None:
        """Begins a step, which `solve` may compute several times and `accept` ends; or again one that did not end."""
        if self._open:
            read = self._km.VariableUtils()
            for variable, width in ((self._km.VELOCITY, (3,)), (self._km.PRESSURE, ())):
                before = read.GetSolutionStepValuesVector(self._part.Nodes, variable, 1, *width)
                read.SetSolutionStepValuesVector(self._part.Nodes, variable, before, 0)
            return
        self._solver.AdvanceInTime(self.time)
        self._solver.InitializeSolutionStep()
        self._open = True

    def solve(self, points: npt.ArrayLike, velocities: npt.ArrayLike | None = None) -> _Array:
        """[N] forces on the nodes of the surface, (n, 3), at the end of the step, where it is here by then.

        Args:
            points: [m] (n, 3).
            velocities: [m/s] (n, 3); left out, the surface is at rest.

        Raises:
            FlowDiverged: values of the flow that are not finite, or speeds above a hundred times the stream. `begin`
                then goes back to the start of the step.
            CouplingError: there is no step, or Kratos cannot solve it.
            SurfaceOutside: the surface leaves the box.
            ValueError: arrays of another shape.
        """
        if not self._open:
            raise CouplingError("a step of the flow begins with `begin`")
        moved = self._checked(points)
        speeds = None if velocities is None else np.asarray(velocities, dtype=float)
        if speeds is not None and (speeds.shape != moved.shape or not np.isfinite(speeds).all()):
            raise ValueError(f"velocities must be finite, and have the shape {moved.shape}")
        self._points = moved
        self._place(moved, speeds)
        try:
            self._solver.SolveSolutionStep()
        except RuntimeError as error:
            raise CouplingError(f"Kratos cannot solve the step to t = {self.time:g} s: {error}") from error
        self._check()
        at, forces = self.facets()
        return nodal_forces(moved, self.triangles, at, forces)

    def accept(self) -> None:
        """Ends the step."""
        self._solver.FinalizeSolutionStep()
        self._open = False

    def advance(self, points: npt.ArrayLike | None = None, velocities: npt.ArrayLike | None = None) -> _Array:
        """Makes a step, and returns the forces [N] on the nodes of the surface, (n, 3); see `solve`."""
        self.begin()
        forces = self.solve(self._points if points is None else points, velocities)
        self.accept()
        return forces

    def facets(self) -> tuple[_Array, _Array]:
        """Where the surface cuts the mesh: places [m] and forces [N] of the fluid there, (m, 3) each.

        A facet, where the surface cuts an element, is several places, as it may be larger than a triangle of the
        surface. The pressure is linear on it.
        """
        km = self._km
        self._skin.GenerateSkin()
        for side, variable in (("positive", km.POSITIVE_FACE_PRESSURE), ("negative", km.NEGATIVE_FACE_PRESSURE)):
            self._skin.InterpolateDiscontinuousMeshVariableToSkin(km.PRESSURE, variable, side)
        part, read = self._cut, km.VariableUtils()
        count = part.NumberOfNodes()
        if not count:
            return np.zeros((0, 3)), np.zeros((0, 3))
        front = np.array(read.GetSolutionStepValuesVector(part.Nodes, km.POSITIVE_FACE_PRESSURE, 0))
        back = np.array(read.GetSolutionStepValuesVector(part.Nodes, km.NEGATIVE_FACE_PRESSURE, 0))
        place = np.array(read.GetInitialPositionsVector(part.Nodes, 3)).reshape(count, 3)
        row = {node.Id: i for i, node in enumerate(part.Nodes)}
        corners = np.array([[row[node.Id] for node in cell.GetNodes()] for cell in part.Conditions])
        spots = place[corners]
        # The normal is towards the negative side.
        area = 0.5 * np.cross(spots[:, 1] - spots[:, 0], spots[:, 2] - spots[:, 0]) / len(_PLACES)
        jump = (front - back)[corners] @ _PLACES.T
        at = np.einsum("pc,fcx->fpx", _PLACES, spots)
        return at.reshape(-1, 3), (jump[:, :, None] * area[:, None, :]).reshape(-1, 3)

    def velocities(self) -> _Array:
        """[m/s] of the fluid at the nodes of the mesh, (n, 3)"""
        return self._values(self._km.VELOCITY, 3)

    def pressures(self) -> _Array:
        """[Pa] at the nodes of the mesh, (n,)"""
        return self._values(self._km.PRESSURE, 1)[:, 0]

    def _values(self, variable: Any, width: int) -> _Array:
        read = self._km.VariableUtils()
        given = (self._part.Nodes, variable, 0) + ((3,) if width == 3 else ())
        values: _Array = np.array(read.GetSolutionStepValuesVector(*given)).reshape(-1, width)
        return values

    def _checked(self, points: npt.ArrayLike) -> _Array:
        given = np.array(points, dtype=float)
        if given.ndim != 2 or given.shape[1] != 3 or len(given) <= self.triangles.max():
            raise ValueError(f"points have the shape {given.shape}: give (n, 3), with every node of the triangles")
        # Also true of what is not a number.
        wrong = np.flatnonzero(~((given > self.mesh.low) & (given < self.mesh.high)).all(axis=1))
        if len(wrong):
            first = int(wrong[0])
            raise SurfaceOutside(first, given[first], self.mesh.low, self.mesh.high)
        return given

    def _check(self) -> None:
        speed = np.sqrt((self.velocities() ** 2).sum(axis=1)).max()
        stream = float(np.linalg.norm(self.stream))
        if not (speed < 100 * stream and np.isfinite(self.pressures()).all()):
            raise FlowDiverged(self.time, float(speed), stream)

    def _kratos(self) -> None:
        import importlib

        missing = []
        for name in ("KratosMultiphysics", *_NEEDED):
            try:
                importlib.import_module(name if name == "KratosMultiphysics" else f"KratosMultiphysics.{name}")
            except ImportError:
                missing.append(name if name == "KratosMultiphysics" else f"Kratos{name}")
        if missing:
            raise KratosMissing(missing)
        import KratosMultiphysics as km

        self._km = km
        km.Logger.GetDefaultOutput().SetSeverity(km.Logger.Severity.WARNING)

    def _build_fluid(self, viscosity: float, iterations: int) -> None:
        km = self._km
        import KratosMultiphysics.FluidDynamicsApplication as fluid
        from KratosMultiphysics.FluidDynamicsApplication.navier_stokes_embedded_solver import CreateSolver

        self._model = km.Model()
        speed = float(np.linalg.norm(self.stream))
        settings = _settings(self.step, speed, self.density * speed**2, iterations)
        self._solver = CreateSolver(self._model, km.Parameters(json.dumps(settings)))
        self._part = part = self._model["Fluid"]
        self._solver.AddVariables()
        properties = part.CreateNewProperties(1)
        for variable, value in (
            (km.DENSITY, self.density),
            (km.DYNAMIC_VISCOSITY, viscosity),
            (km.SOUND_VELOCITY, 1e12),
        ):
            properties.SetValue(variable, value)
        properties.SetValue(km.CONSTITUTIVE_LAW, fluid.Newtonian3DLaw())
        for i, place in enumerate(self.mesh.nodes.tolist(), 1):
            part.CreateNewNode(i, *place)
        for i, cell in enumerate((self.mesh.tetrahedra + 1).tolist(), 1):
            part.CreateNewElement("Element3D4N", i, cell, properties)
        volume = part.CreateSubModelPart("Volume")
        volume.AddNodes(list(range(1, len(self.mesh.nodes) + 1)))
        volume.AddElements(list(range(1, len(self.mesh.tetrahedra) + 1)))
        part.CreateSubModelPart("Sides")
        self._solver.ImportModelPart()
        self._solver.PrepareModelPart()
        self._solver.AddDofs()
        self._bound()
        self._solver.Initialize()

    def _bound(self) -> None:
        """Conditions on the faces of the box, and the flow at the start."""
        km, write = self._km, self._km.VariableUtils()
        nodes = list(self._part.Nodes)
        every = np.tile(self.stream, len(nodes))
        for buffer in range(self._part.GetBufferSize()):
            write.SetSolutionStepValuesVector(self._part.Nodes, km.VELOCITY, km.Vector(every), buffer)
        axes = (km.VELOCITY_X, km.VELOCITY_Y, km.VELOCITY_Z)
        for axis in range(3):
            for end in (0, 1):
                # [m/s] out of the box
                out = self.stream[axis] * (2 * end - 1)
                fixed = axes if out < 0 else (km.PRESSURE,) if out > 0 else (axes[axis],)
                for node in self.mesh.side(axis, end):
                    for variable in fixed:
                        nodes[node].Fix(variable)

    def _build_surface(self) -> None:
        km = self._km
        self._surface = surface = self._model.CreateModelPart("Surface")
        for i, place in enumerate(self._points.tolist(), 1):
            surface.CreateNewNode(i, *place)
        properties = surface.CreateNewProperties(1)
        for i, cell in enumerate((self.triangles + 1).tolist(), 1):
            surface.CreateNewElement("Element3D3N", i, cell, properties)
        self._cut = cut = self._model.CreateModelPart("Cut")
        for variable in (km.NORMAL, km.POSITIVE_FACE_PRESSURE, km.NEGATIVE_FACE_PRESSURE):
            cut.AddNodalSolutionStepVariable(variable)
        volume = self._solver.GetComputingModelPart()
        both = '{"calculate_elemental_edge_distances": true, "calculate_elemental_edge_distances_extrapolated": true}'
        self._distance = km.CalculateDiscontinuousDistanceToSkinProcess3D(volume, surface, km.Parameters(both))
        self._elements, self._nodes = list(volume.Elements), list(volume.Nodes)
        corners = self.mesh.nodes[self.mesh.tetrahedra]
        self._first, self._last = corners.min(axis=1), corners.max(axis=1)
        self._skin = km.EmbeddedSkinUtility3D(volume, cut, "discontinuous")

    def _place(self, points: _Array, velocities: _Array | None) -> None:
        """Cuts the mesh where the surface is."""
        for node, place in zip(self._surface.Nodes, points.tolist(), strict=True):
            node.X, node.Y, node.Z = place
        self._distance.Execute()
        self._part_clearly()
        self._carry(points, velocities)

    def _carry(self, points: _Array, velocities: _Array | None) -> None:
        """Gives nodes of elements that are cut the velocity of the surface where it is nearest."""
        km = self._km
        variable = km.KratosGlobals.GetVariable("EMBEDDED_VELOCITY")
        km.VariableUtils().SetNonHistoricalVariableToZero(variable, self._part.Nodes)
        if velocities is None or not velocities.any():
            return
        near = self._near()
        cut = near[[self._elements[index].Is(km.TO_SPLIT) for index in near]]
        nodes = np.unique(self.mesh.tetrahedra[cut])
        which, share = nearest(points, self.triangles, self.mesh.nodes[nodes])
        moves = np.einsum("mc,mcx->mx", share, velocities[self.triangles[which]])
        for node, move in zip(nodes, moves.tolist(), strict=True):
            self._nodes[node].SetValue(variable, km.Array3(move))

    def _near(self) -> _Indices:
        """Elements that reach into the extent of the surface."""
        low, high = self._points.min(axis=0), self._points.max(axis=0)
        return np.flatnonzero(((self._first <= high) & (self._last >= low)).all(axis=1))

    def _part_clearly(self) -> None:
        """Mends what Kratos cannot divide: elements with a node on the surface, and those that it hardly touches."""
        km, least = self._km, _APART * self.mesh.size
        whole, uncut = km.Vector([-1.0] * 6), km.Vector([1.0] * 4)
        for index in self._near():
            element = self._elements[index]
            distances = np.array(element.GetValue(km.ELEMENTAL_DISTANCES))
            if element.Is(km.TO_SPLIT) and np.isfinite(distances).all():
                if np.abs(distances).min() >= least:
                    continue
                clear = np.where(np.abs(distances) >= least, distances, np.where(distances < 0, -least, least))
                element.SetValue(km.ELEMENTAL_DISTANCES, km.Vector(clear))
            elif np.abs(distances).min() < least or not np.isfinite(distances).all():
                element.SetValue(km.ELEMENTAL_DISTANCES, uncut)
                element.Set(km.TO_SPLIT, False)
            else:
                continue
            # What Kratos has made of the old distances.
            element.SetValue(km.ELEMENTAL_EDGE_DISTANCES_EXTRAPOLATED, whole)


def _settings(step: float, speed: float, pressure: float, iterations: int) -> dict[str, Any]:
    """Kratos' parameters, with tolerances for this speed [m/s] and pressure [Pa]."""
    return {
        "solver_type": "Embedded",
        "model_part_name": "Fluid",
        "domain_size": 3,
        "model_import_settings": {"input_type": "use_input_model_part"},
        "distance_reading_settings": {"import_mode": "from_mdpa"},
        # Done here, as it leaves elements that cannot be divided.
        "distance_modification_settings": {"distance_threshold": 1e-12},
        "maximum_iterations": iterations,
        "relative_velocity_tolerance": 1e-3,
        "absolute_velocity_tolerance": 1e-5 * speed,
        "relative_pressure_tolerance": 1e-3,
        "absolute_pressure_tolerance": 1e-5 * pressure,
        "volume_model_part_name": "Fluid.Volume",
        "skin_parts": ["Fluid.Sides"],
        "no_skin_parts": [],
        "assign_neighbour_elements_to_conditions": False,
        "time_stepping": {"automatic_time_step": False, "time_step": step},
        "formulation": {
            "element_type": "embedded_weakly_compressible_navier_stokes_discontinuous",
            "is_slip": True,
            "slip_length": 1e8,
            # What the penalty is divided by: a tenth lets 6 % of a disc's drag leak through it, ten a fifth.
            "penalty_coefficient": 0.01,
            "dynamic_tau": 1.0,
        },
        "linear_solver_settings": {
            "solver_type": "amgcl",
            "krylov_type": "lgmres",
            "smoother_type": "ilu0",
            "coarsening_type": "aggregation",
            "max_iteration": 200,
            "tolerance": 1e-4,
            "scaling": False,
        },
    }
