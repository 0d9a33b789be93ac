"""A scene as a solver of Kratos' CoSimulationApplication: `"type": "canopy_fem.kratos"`.

In the parameters of a coupled simulation, a solver of this type is a case file, and names groups of its nodes:

.. code-block:: json

    "structure": {
        "type": "canopy_fem.kratos",
        "solver_wrapper_settings": {"input_file": "structure.json", "domain_size": 3},
        "data": {
            "disp": {"model_part_name": "Structure.canopy", "variable_name": "DISPLACEMENT", "dimension": 3},
            "load": {"model_part_name": "Structure.canopy", "variable_name": "POINT_LOAD", "dimension": 3}
        }
    }

The part `canopy` of the model `Structure` has the nodes of that group, in the order of the mesh, with lines, or
triangles in three dimensions, between them, for mappers. Forces on them are the variables FORCE, REACTION, or
POINT_LOAD of Kratos' StructuralMechanicsApplication. DISPLACEMENT, VELOCITY, MESH_DISPLACEMENT and MESH_VELOCITY come
from the scene.

Tested with Kratos 10.4.4, which has wheels for Python 3.11.
"""

from __future__ import annotations

import difflib
import importlib.util
import json
import os
import re
import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np

from .coupling import Structure, command, frames
from .errors import CanopyError, CaseWarning, CouplingError, Diverged

try:
    import KratosMultiphysics as KM
    from KratosMultiphysics.CoSimulationApplication.base_classes.co_simulation_solver_wrapper import (
        CoSimulationSolverWrapper,
    )
except ImportError:
    # Said by `run`: where Kratos imports this module, it is there.
    KM, CoSimulationSolverWrapper = None, object

__all__ = ["Create", "Wrapper", "run"]

_MODEL = "Structure"
_FORCES = ("POINT_LOAD", "REACTION", "FORCE")
_DISPLACEMENTS = ("DISPLACEMENT", "MESH_DISPLACEMENT")
_VELOCITIES = ("VELOCITY", "MESH_VELOCITY")
# What Kratos says, and what helps.
_TOLD = {
    "sizes of the data are not matching": "the interfaces have other points: use kratos_mapping, not copy",
    "Solver time mismatch": 'the solvers make steps of different sizes: give "time_step" of canopy_fem.kratos the step '
    "of the flow",
}
# Applications of Kratos that parameters need without naming them.
_NEEDED = {
    "fluid_dynamics_wrapper": "FluidDynamicsApplication",
    "structural_mechanics_wrapper": "StructuralMechanicsApplication",
    "kratos_mapping": "MappingApplication",
    "ale_fluid": "MeshMovingApplication",
}


def Create(settings: Any, model: Any, solver_name: str) -> Wrapper:
    """The solver of these parameters; Kratos calls this."""
    return Wrapper(settings, model, solver_name)


class Wrapper(CoSimulationSolverWrapper):  # type: ignore[misc]
    """The solver. `solver_wrapper_settings`:

    =================  ============================================================================================
    ``input_file``     the case file; ".json" may be left out
    ``domain_size``    3, or 2 for a flow in the x-y plane
    ``depth``          [m] along z, in two dimensions; 0 is the extent of the interface in z, or 1 where that is 0
    ``time_step``      [s] step of the coupling; 0 is the step of the case. The case's is the longest within it
    ``num_threads``    threads of scenes above 2,000 nodes
    ``overrides``      other values of the case by dotted path
    ``frames_every``   [s] writes where the scene is so often, for ParaView, into ``frames_folder``; 0 is never
    ``save_every``     [-] saves the state every so many steps of the coupling into ``save_folder``; 0 is never
    ``save_folder``    the folder; also where the last state goes when a step fails
    ``resume``         a file of a saved state to go on from
    =================  ============================================================================================

    Raises:
        CaseError: the case has faults.
        CouplingError: parameters that cannot be used.
    """

    time_step: float
    """[s] step of the coupling; who drives it may change it between two steps, and after one that was refused"""

    def __init__(self, settings: Any, model: Any, solver_name: str) -> None:
        super().__init__(settings, model, solver_name)
        own = self.settings["solver_wrapper_settings"]
        known = self._own_defaults()
        for key in set(own.keys()) - set(known.keys()):
            near = difflib.get_close_matches(key, known.keys(), 1) or sorted(known.keys())
            raise CouplingError(f'"{solver_name}": "{key}" is no setting; did you mean {" or ".join(near)}?')
        own.ValidateAndAssignDefaults(known)
        size = own["domain_size"].GetInt()
        depth = own["depth"].GetDouble()
        parts = self._parts()
        self.structure = Structure(
            self._case_file(own["input_file"].GetString()),
            parts.values(),
            dimensions=size,
            depth=depth if depth != 0 else None,
            overrides=_overrides(own["overrides"]),
            threads=own["num_threads"].GetInt(),
        )
        self.time_step = own["time_step"].GetDouble() or self.structure.case.step or 0.0
        if not self.time_step > 0:
            raise CouplingError(f'"{self.name}": give "time_step", or a case with a fixed time.step')
        self._groups = parts
        self._every, self._folder = own["save_every"].GetInt(), Path(own["save_folder"].GetString())
        self._steps = 0
        self._build(size)
        if own["resume"].GetString():
            self.structure.resume(own["resume"].GetString())
        self._frames = frames(self.structure, own["frames_folder"].GetString(), own["frames_every"].GetDouble())

    def _parts(self) -> dict[str, str]:
        """The group of each model part that the data name."""
        parts = {}
        for name, data in self.settings["data"].items():
            full = data["model_part_name"].GetString()
            model, _, group = full.partition(".")
            if model != _MODEL or not group:
                raise CouplingError(
                    f'"{self.name}", data "{name}": model_part_name is "{full}"; '
                    f'give "{_MODEL}." and the name of a group of the case'
                )
            parts[full] = group
        if not parts:
            raise CouplingError(f'"{self.name}" has no "data": it would not be coupled')
        return parts

    def _case_file(self, name: str) -> Path:
        if not name:
            raise CouplingError(f'"{self.name}": "input_file" in "solver_wrapper_settings" must name the case file')
        return Path(name if name.endswith(".json") else f"{name}.json")

    def _build(self, size: int) -> None:
        """The model part of each group."""
        root = self.model.CreateModelPart(_MODEL)
        root.ProcessInfo[KM.DOMAIN_SIZE] = size
        for _, data in self.settings["data"].items():
            name = data["variable_name"].GetString()
            if name not in _FORCES + _DISPLACEMENTS + _VELOCITIES:
                known = ", ".join(_FORCES + _DISPLACEMENTS + _VELOCITIES)
                raise CouplingError(f'"{self.name}": "{name}" is no variable of the coupling; known: {known}')
            root.AddNodalSolutionStepVariable(self._variable(name))
        properties = root.CreateNewProperties(1)
        node = element = 0
        for full, group in self._groups.items():
            interface = self.structure.interfaces[group]
            part = root.CreateSubModelPart(full.partition(".")[2])
            first = node + 1
            for point in interface.points:
                node += 1
                part.CreateNewNode(node, *(float(x) for x in (*point, 0.0)[:3]))
            cells, kind = interface.triangles, "Element3D3N"
            if not len(cells):
                cells, kind = interface.edges, f"Element{size}D2N"
            for cell in cells:
                element += 1
                part.CreateNewElement(kind, element, [int(first + corner) for corner in cell], properties)

    def _variable(self, name: str) -> Any:
        if not KM.KratosGlobals.HasVariable(name):
            try:
                # Which has POINT_LOAD.
                import KratosMultiphysics.StructuralMechanicsApplication  # noqa: F401
            except ImportError:
                raise CouplingError(
                    f'"{self.name}": {name} is a variable of the StructuralMechanicsApplication, which is not '
                    "installed; install it, or use FORCE"
                ) from None
        return KM.KratosGlobals.GetVariable(name)

    def Check(self) -> None:
        """Nothing that was not checked when it was made."""

    def AdvanceInTime(self, current_time: float) -> float:
        """[s] The end of the next step.

        Raises:
            CouplingError: the coupling is at another time than the structure.
        """
        if abs(current_time - self.structure.time) > 1e-6 * self.time_step:
            raise CouplingError(
                f'"{self.name}" is at t = {self.structure.time:g} s, the coupling at {current_time:g} s: '
                'start_time of the coupling, "resume" and the saved states of all solvers must belong together'
            )
        self._until = current_time + self.time_step
        root = self.model[_MODEL]
        root.CloneTimeStep(self._until)
        root.ProcessInfo[KM.STEP] += 1
        return self._until

    def SolveSolutionStep(self) -> None:
        """Computes the step under the present forces, without accepting it.

        Raises:
            CouplingError: forces that are not finite.
            Diverged: the step cannot be solved, in shorter parts either; `report` says why.
        """
        try:
            self._push()
            self.structure.solve(self._until - self.structure.time)
        except (CouplingError, Diverged) as error:
            self._keep(error)
            raise
        self._show()

    def FinalizeSolutionStep(self) -> None:
        """Accepts the step."""
        try:
            self.structure.accept()
        except Diverged as error:
            self._keep(error)
            raise
        self._steps += 1
        if self._every and self._steps % self._every == 0:
            self._save()

    def OutputSolutionStep(self) -> None:
        """Writes a frame where one is due."""
        if self._frames is not None:
            self._frames.look()

    def _push(self) -> None:
        total: dict[str, Any] = {}
        for data in self.data_dict.values():
            if data.variable.Name() in _FORCES:
                group = self._groups[data.model_part_name]
                total[group] = total.get(group, 0.0) + self._rows(data)
        for group, forces in total.items():
            self.structure.push(group, forces)

    def _rows(self, data: Any) -> Any:
        interface = self.structure.interfaces[self._groups[data.model_part_name]]
        given = np.asarray(data.GetData()).reshape(len(interface), data.dimension)
        rows = np.zeros((len(interface), interface.dimensions))
        rows[:, : data.dimension] = given[:, : interface.dimensions]
        return rows

    def _show(self) -> None:
        for data in self.data_dict.values():
            name, group = data.variable.Name(), self._groups[data.model_part_name]
            if name in _FORCES:
                continue
            rows = self.structure.displacements(group) if name in _DISPLACEMENTS else self.structure.velocities(group)
            data.SetData(rows[:, : data.dimension].ravel())

    def _save(self) -> Path:
        self._folder.mkdir(parents=True, exist_ok=True)
        path = self._folder / f"{self.name}_{self.structure.time:.6g}.state"
        fresh = path.with_suffix(".part")
        fresh.write_bytes(self.structure.snapshot())
        os.replace(fresh, path)
        return path

    def _keep(self, error: Exception) -> None:
        """Saves the state before a step that failed, and says so."""
        where = f'solver "{self.name}", step of the coupling from t = {self.structure.time:g} s'
        try:
            where += f"; the state there is saved in {self._save()}"
        except OSError as failed:
            where += f"; the state there could not be saved: {failed}"
        error.args = (f"{where}\n{error.args[0]}", *error.args[1:])

    def _own_defaults(self) -> Any:
        return KM.Parameters(
            """{
            "input_file": "", "domain_size": 3, "depth": 0.0, "time_step": 0.0, "num_threads": 1, "overrides": {},
            "frames_every": 0.0, "frames_folder": "frames", "save_every": 0, "save_folder": "saved", "resume": ""
        }"""
        )


def _overrides(given: Any) -> dict[str, Any]:
    return dict(json.loads(given.WriteJsonString()))


def run(parameters: str | os.PathLike[str]) -> None:
    """Runs a coupled simulation of Kratos: ``python -m canopy_fem.kratos ProjectParametersCoSim.json`` in its folder.

    As Kratos' own main program does, after a look at what the parameters need.

    Raises:
        CouplingError: Kratos or an application that the parameters need is not installed; or as `Wrapper`.
        Diverged: a step of the structure cannot be solved.
        OSError: the file cannot be read.
    """
    text = Path(parameters).read_text(encoding="utf-8")
    missing = sorted(name for name in _applications(text, Path(".")) if not _is_installed(name))
    if missing:
        wheels = " ".join(name if name == "KratosMultiphysics" else f"Kratos{name}" for name in missing)
        raise CouplingError(
            f"{parameters} needs {', '.join(missing)}, which is not installed here\n"
            f"Kratos 10.4.4 has wheels for Python 3.11: pip install {wheels}"
        )
    from KratosMultiphysics.CoSimulationApplication.co_simulation_analysis import CoSimulationAnalysis

    if "OMP_NUM_THREADS" not in os.environ:
        warnings.warn(
            f"OMP_NUM_THREADS is not set: Kratos takes all {os.cpu_count()} processors, and can be ten times slower "
            "where they are busy; set it, for example to 1",
            CaseWarning,
            stacklevel=2,
        )
    try:
        settings = KM.Parameters(text)
    except Exception as error:
        raise CouplingError(f"{parameters}: Kratos cannot read it as JSON: {_line(error)}") from error
    try:
        CoSimulationAnalysis(settings).Run()
    except CanopyError:
        raise
    except Exception as error:
        for told, advice in _TOLD.items():
            if told in str(error):
                raise CouplingError(f"{_line(error)}: {advice}") from error
        raise


def _line(error: Exception) -> str:
    """What an exception says first."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    return lines[0].removeprefix("Error: ") if lines else type(error).__name__


def _applications(text: str, folder: Path, depth: int = 2) -> set[str]:
    """What parameters need of Kratos, with the files that they name."""
    names = {"KratosMultiphysics", "CoSimulationApplication", *re.findall(r"\b[A-Z]\w*Application\b", text)}
    names |= {application for word, application in _NEEDED.items() if word in text}
    for name in re.findall(r'"input_file"\s*:\s*"([^"]+)"', text) if depth else ():
        path = folder / (name if name.endswith(".json") else f"{name}.json")
        if path.is_file():
            names |= _applications(path.read_text(encoding="utf-8"), folder, depth - 1)
    return names


def _is_installed(name: str) -> bool:
    module = name if name == "KratosMultiphysics" else f"KratosMultiphysics.{name}"
    try:
        return importlib.util.find_spec(module) is not None
    except ImportError:
        return False


def main() -> int:
    """The command."""
    return command("python -m canopy_fem.kratos PROJECT_PARAMETERS.json", run)


if __name__ == "__main__":
    sys.exit(main())
