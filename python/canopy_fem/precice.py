"""A scene as a participant of a simulation that preCICE couples: ``python -m canopy_fem.precice adapter.json``.

The file names participant, meshes and data as preCICE's own configuration has them, the case, and a group of its nodes
for each mesh:

.. code-block:: json

    {
        "participant_name": "Solid",
        "precice_config_file_name": "../precice-config.xml",
        "interfaces": [
            {
                "mesh_name": "Solid-Mesh",
                "patches": ["surface"],
                "read_data_names": ["Force"],
                "write_data_names": ["Displacement"]
            }
        ],
        "case": "flap.json"
    }

Data whose names begin with Force are read, in newtons on each vertex; those that begin with Displacement or Velocity
are written. Meshes may have two dimensions; forces are then per metre of depth.

It speaks to version 3 of preCICE. It is tested with a stand-in for the library, not with the library itself.
"""

from __future__ import annotations

import importlib
import json
import os
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from .coupling import Structure, command, frames
from .errors import CanopyError, CouplingError, Diverged

__all__ = ["Adapter", "run"]

# How many times a step that cannot be solved is halved.
_CUTS = 8
_KEYS = {
    "participant_name",
    "precice_config_file_name",
    "interfaces",
    "case",
    "overrides",
    "depth",
    "num_threads",
    "frames_every",
    "frames_folder",
    "resume",
    "save_file",
}
_INTERFACE_KEYS = {"mesh_name", "patches", "read_data_names", "write_data_names"}


class Adapter:
    """The participant.

    Args:
        config: the file above, or a dictionary with its keys; paths in it are relative to its folder. Further keys:
            ``overrides`` (values of the case by dotted path), ``depth`` [m] of the scene in two dimensions,
            ``num_threads``, ``frames_every`` [s] and ``frames_folder`` (where the scene is, for ParaView), ``resume``
            (a saved state to begin from), ``save_file`` (where the state at the end goes, and that at the start of a
            window in which a step fails).
        folder: to which paths in a dictionary are relative.

    Raises:
        CaseError: the case has faults.
        CouplingError: a configuration that cannot be used, or preCICE is not installed.
        OSError: a file that cannot be read.
    """

    def __init__(
        self, config: str | os.PathLike[str] | Mapping[str, Any], *, folder: str | os.PathLike[str] = "."
    ) -> None:
        if isinstance(config, Mapping):
            given, self._folder = dict(config), Path(folder)
        else:
            path = Path(config)
            self._folder = path.parent
            try:
                given = dict(json.loads(path.read_text(encoding="utf-8")))
            except (ValueError, TypeError) as error:
                raise CouplingError(f"{path}: it is no JSON object: {error}") from None
        _known(given, _KEYS, "the configuration", needed=("participant_name", "precice_config_file_name", "case"))
        self._given, self._meshes = given, _meshes(given.get("interfaces"))
        precice = _library()
        config_file = str(self._folder / given["precice_config_file_name"])
        self.participant = precice.Participant(given["participant_name"], config_file, 0, 1)
        sizes = {self.participant.get_mesh_dimensions(mesh) for mesh in self._meshes}
        if len(sizes) > 1:
            raise CouplingError(f"the meshes have {sorted(sizes)} dimensions: all of a participant must have the same")
        case = given["case"]
        self.structure = Structure(
            case if isinstance(case, Mapping) else self._folder / case,
            [mesh.group for mesh in self._meshes.values()],
            dimensions=sizes.pop(),
            depth=given.get("depth"),
            overrides=given.get("overrides"),
            threads=given.get("num_threads", 1),
            cuts=0,
        )
        self._checkpoint: bytes | None = None
        if given.get("resume"):
            self.structure.restore((self._folder / given["resume"]).read_bytes())

    def run(self, each_window: Callable[[Structure], object] | None = None) -> Structure:
        """Takes part until the coupling ends.

        Args:
            each_window: called with the structure after each time window.

        Raises:
            CouplingError: forces that are not finite, or data of other sizes.
            Diverged: a step that cannot be solved, in shorter ones either.
        """
        try:
            self._connect()
            every = float(self._given.get("frames_every", 0.0))
            record = frames(self.structure, self._folder / self._given.get("frames_folder", "frames"), every)
            while self.participant.is_coupling_ongoing():
                if self.participant.requires_writing_checkpoint():
                    self._checkpoint = self.structure.snapshot()
                self.participant.advance(self._step())
                if self.participant.requires_reading_checkpoint() and self._checkpoint is not None:
                    self.structure.restore(self._checkpoint)
                elif self.participant.is_time_window_complete():
                    if record is not None:
                        record.look()
                    if each_window is not None:
                        each_window(self.structure)
            self._save(self.structure.snapshot())
        except CanopyError as error:
            # Within an iteration the state is not yet that of the coupled problem.
            if saved := self._save(self._checkpoint or self.structure.snapshot()):
                error.args = (f"{error.args[0]}\nthe state at the start of the window: {saved}", *error.args[1:])
            raise
        finally:
            self.participant.finalize()
        return self.structure

    def _connect(self) -> None:
        for name, mesh in self._meshes.items():
            interface = self.structure.interfaces[mesh.group]
            mesh.vertices = np.asarray(self.participant.set_mesh_vertices(name, interface.points))
            if len(mesh.vertices) != len(interface):
                raise CouplingError(f'"{name}": preCICE has {len(mesh.vertices)} of {len(interface)} vertices')
            if self.participant.requires_mesh_connectivity_for(name):
                if len(interface.triangles):
                    self.participant.set_mesh_triangles(name, mesh.vertices[interface.triangles])
                else:
                    self.participant.set_mesh_edges(name, mesh.vertices[interface.edges])
            for data in (*mesh.reads, *mesh.writes):
                size = self.participant.get_data_dimensions(name, data)
                if size != interface.dimensions:
                    raise CouplingError(
                        f'"{data}" on "{name}" has {size} dimensions, the mesh {interface.dimensions}: '
                        "declare it as data:vector"
                    )
        if self.participant.requires_initial_data():
            self._write()
        self.participant.initialize()

    def _step(self) -> float:
        """Makes a step that the window and the case allow; its size [s]. preCICE is told of it with `advance`."""
        step = float(self.participant.get_max_time_step_size())
        step = min(step, self.structure.case.step or step)
        for cut in range(_CUTS + 1):
            self._read(step)
            try:
                self.structure.solve(step)
                self.structure.accept()
                break
            except Diverged:
                if cut == _CUTS:
                    raise
                step /= 2
        self._write()
        return step

    def _read(self, step: float) -> None:
        for name, mesh in self._meshes.items():
            if mesh.reads:
                forces = [self.participant.read_data(name, data, mesh.vertices, step) for data in mesh.reads]
                try:
                    self.structure.push(mesh.group, np.sum(forces, axis=0))
                except CouplingError as error:
                    read = ", ".join(mesh.reads)
                    raise CouplingError(f'"{read}" on "{name}" at t = {self.structure.time:g} s: {error}') from None

    def _write(self) -> None:
        for name, mesh in self._meshes.items():
            for data in mesh.writes:
                of = self.structure.velocities if data.startswith("Velocity") else self.structure.displacements
                self.participant.write_data(name, data, mesh.vertices, of(mesh.group))

    def _save(self, state: bytes) -> Path | None:
        if not self._given.get("save_file"):
            return None
        path: Path = self._folder / self._given["save_file"]
        path.write_bytes(state)
        return path


class _Mesh:
    """One interface of the configuration."""

    vertices: npt.NDArray[Any]

    def __init__(self, name: str, given: Mapping[str, Any]) -> None:
        patches = given["patches"]
        if not isinstance(patches, list) or len(patches) != 1 or not isinstance(patches[0], str):
            raise CouplingError(f'"patches" of "{name}" is {patches!r}: give one group of the case, such as ["canopy"]')
        self.group = patches[0]
        self.reads: list[str] = given.get("read_data_names", [])
        self.writes: list[str] = given.get("write_data_names", [])
        for data in self.reads:
            if not data.startswith("Force"):
                raise CouplingError(f'"{data}" cannot be read: names of data that are read begin with Force')
        for data in self.writes:
            if not data.startswith(("Displacement", "Velocity")) or data.startswith("DisplacementDelta"):
                raise CouplingError(f'"{data}" cannot be written: such names begin with Displacement or Velocity')


def _meshes(given: Any) -> dict[str, _Mesh]:
    if not isinstance(given, list) or not given:
        raise CouplingError('"interfaces" must be a list with at least one mesh')
    meshes = {}
    for entry in given:
        if not isinstance(entry, Mapping):
            raise CouplingError(f'"interfaces" holds objects with {", ".join(sorted(_INTERFACE_KEYS))}')
        _known(entry, _INTERFACE_KEYS, "an interface", needed=("mesh_name", "patches"))
        meshes[entry["mesh_name"]] = _Mesh(entry["mesh_name"], entry)
    return meshes


def _known(given: Mapping[str, Any], known: set[str], what: str, *, needed: tuple[str, ...]) -> None:
    unknown, missing = sorted(set(given) - known), [key for key in needed if key not in given]
    if unknown or missing:
        wrong = [f'"{key}" is unknown' for key in unknown] + [f'"{key}" is missing' for key in missing]
        raise CouplingError(f"{what}: {'; '.join(wrong)}; known keys: {', '.join(sorted(known))}")


def _library() -> Any:
    try:
        precice = importlib.import_module("precice")
    except ImportError as error:
        raise CouplingError(
            f"preCICE's module for Python is not installed here: {error}\n"
            "Install the library (precice.org), then: pip install pyprecice"
        ) from None
    if not hasattr(precice, "Participant"):
        raise CouplingError("preCICE is older than version 3 here: it has no Participant")
    return precice


def run(config: str | os.PathLike[str] | Mapping[str, Any], **more: Any) -> Structure:
    """Takes part in a coupling from its start to its end; arguments and exceptions as `Adapter` and its `run`."""
    return Adapter(config, **more).run()


def main() -> int:
    """The command."""
    return command("python -m canopy_fem.precice ADAPTER.json", run)


if __name__ == "__main__":
    sys.exit(main())
