"""A scene as a participant of a simulation that preCICE couples: ``python -m canopy_fem.precice adapter.json``.

The file is that of preCICE's adapter configuration schema (version 0.4, github.com/precice/adapter-schema). It names
participant, meshes and data as preCICE's own configuration has them, a group of nodes for each mesh, and the case:

.. code-block:: json

    {
        "participant_name": "Solid",
        "precice_config_file_path": "../precice-config.xml",
        "interfaces": [
            {
                "mesh_name": "Solid-Mesh",
                "location_names": ["surface"],
                "read_data": [{"name": "Force"}],
                "write_data": [{"name": "Displacement"}]
            }
        ],
        "canopy_fem": {"case": "flap.json"}
    }

Data whose names begin with Force are read, in newtons on each vertex; those that begin with Displacement or Velocity
are written. Where preCICE calls them otherwise, ``"solver_name"`` beside ``"name"`` says which they are. Meshes may
have two dimensions; forces are then per metre of depth.

It speaks to version 3 of preCICE, and was tried with 3.4.1; its tests have a stand-in for the library.
"""

from __future__ import annotations

import importlib
import json
import os
import sys
from collections.abc import Callable, Mapping
from contextlib import nullcontext, suppress
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from .coupling import Structure, command, frames
from .errors import CanopyError, CouplingError, CouplingLost, Diverged

__all__ = ["Adapter", "run"]

# How many times a step that cannot be solved is halved.
_CUTS = 8
_KEYS = {"participant_name", "precice_config_file_path", "interfaces", "canopy_fem"}
_OWN_KEYS = {
    "case", "overrides", "depth", "num_threads", "frames_every", "frames_folder", "resume", "save_file"
}  # fmt: skip
_INTERFACE_KEYS = {"mesh_name", "location_names", "location_type", "read_data", "write_data", "is_received"}
_DATA_KEYS = {"name", "solver_name", "operation", "flip-normal"}
# Of earlier versions of the schema, and of this module.
_RENAMED = {
    "precice_config_file_name": '"precice_config_file_path"',
    "patches": '"location_names"',
    "read_data_names": '"read_data": [{"name": "Force"}]',
    "write_data_names": '"write_data": [{"name": "Displacement"}]',
} | {key: f'"canopy_fem": {{"{key}": …}}' for key in _OWN_KEYS}


class Adapter:
    """The participant.

    Args:
        config: the file above, or a dictionary with its keys; paths in it are relative to its folder. Further keys of
            ``canopy_fem``: ``overrides`` (values of the case by dotted path), ``depth`` [m] of the scene in two
            dimensions, ``num_threads``, ``frames_every`` [s] and ``frames_folder`` (where the scene is, for ParaView),
            ``resume`` (a saved state to begin from), ``save_file`` (where the state at the end goes, and that at the
            start of a window in which a step fails, or which a partner does not survive).
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
        _known(given, _KEYS, "the configuration", needed=("participant_name", "precice_config_file_path", "canopy_fem"))
        own = given["canopy_fem"]
        if not isinstance(own, Mapping):
            raise CouplingError('"canopy_fem" is an object, such as {"case": "flap.json"}')
        _known(own, _OWN_KEYS, '"canopy_fem"', needed=("case",))
        self._given, self._meshes = own, _meshes(given.get("interfaces"))
        precice = _library()
        config_file = str(self._folder / given["precice_config_file_path"])
        try:
            library = precice.Participant(given["participant_name"], config_file, 0, 1)
        except Exception as error:
            raise CouplingError(f"{config_file}: {_line(error)}") from error
        self.participant: Any = _Participant(library)
        sizes = {self.participant.get_mesh_dimensions(mesh) for mesh in self._meshes}
        if len(sizes) > 1:
            raise CouplingError(f"the meshes have {sorted(sizes)} dimensions: all of a participant must have the same")
        case: Any = own["case"] if isinstance(own["case"], Mapping) else self._folder / own["case"]
        self.structure = Structure(
            case,
            [mesh.group for mesh in self._meshes.values()],
            dimensions=sizes.pop(),
            depth=own.get("depth"),
            overrides=own.get("overrides"),
            threads=own.get("num_threads", 1),
            cuts=0,
        )
        self._checkpoint: bytes | None = None
        # At the start of the window, where a coupling asks for no checkpoint.
        self._start: bytes | None = None
        if own.get("resume"):
            self.structure.resume(self._folder / own["resume"])

    def run(self, each_window: Callable[[Structure], object] | None = None) -> Structure:
        """Takes part until the coupling ends.

        Args:
            each_window: called with the structure after each time window.

        Raises:
            CouplingError: forces that are not finite, or data of other sizes.
            CouplingLost: preCICE has failed, as where a partner has gone.
            Diverged: a step that cannot be solved, in shorter ones either.
        """
        whole = False
        try:
            self._connect()
            every = float(self._given.get("frames_every", 0.0))
            record = frames(self.structure, self._folder / self._given.get("frames_folder", "frames"), every)
            begins = True
            while self.participant.is_coupling_ongoing():
                if self.participant.requires_writing_checkpoint():
                    self._checkpoint = self.structure.snapshot()
                elif begins and self._given.get("save_file"):
                    self._start = self.structure.snapshot()
                self.participant.advance(self._step())
                if self.participant.requires_reading_checkpoint() and self._checkpoint is not None:
                    self.structure.restore(self._checkpoint)
                    begins = False
                elif begins := bool(self.participant.is_time_window_complete()):
                    if record is not None:
                        record.look()
                    if each_window is not None:
                        each_window(self.structure)
            self._save(self.structure.snapshot())
            whole = True
        except CanopyError as error:
            # Within a window the state is not yet that of the coupled problem.
            if saved := self._save(self._checkpoint or self._start or self.structure.snapshot()):
                error.args = (f"{error.args[0]}; the state at the start of the window is in {saved}", *error.args[1:])
            raise
        finally:
            # After a failure the library may refuse this too, which says nothing new.
            with nullcontext() if whole else suppress(CouplingLost):
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
            for data in (*mesh.reads, *(name for name, _ in mesh.writes)):
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
            for data, quantity in mesh.writes:
                of = self.structure.velocities if quantity == "Velocity" else self.structure.displacements
                self.participant.write_data(name, data, mesh.vertices, of(mesh.group))

    def _save(self, state: bytes) -> Path | None:
        if not self._given.get("save_file"):
            return None
        path: Path = self._folder / self._given["save_file"]
        path.write_bytes(state)
        return path


class _Participant:
    """preCICE's participant, whose exceptions of any kind become one of ours, in one line."""

    def __init__(self, library: Any) -> None:
        self._library = library

    def __getattr__(self, name: str) -> Any:
        call = getattr(self._library, name)

        def told(*arguments: Any) -> Any:
            try:
                return call(*arguments)
            except Exception as error:
                raise CouplingLost(f"preCICE has failed in {name}: {_line(error)}") from error

        return told


def _line(error: Exception) -> str:
    """What an exception says, in one line."""
    return " ".join(str(error).split()) or type(error).__name__


class _Mesh:
    """One interface of the configuration."""

    vertices: npt.NDArray[Any]

    def __init__(self, name: str, given: Mapping[str, Any]) -> None:
        groups = given["location_names"]
        if not isinstance(groups, list) or len(groups) != 1 or not isinstance(groups[0], str):
            raise CouplingError(
                f'"location_names" of "{name}" is {groups!r}: give one group of the case, such as ["canopy"]'
            )
        if given.get("location_type", "nodes") != "nodes":
            raise CouplingError(f'"location_type" of "{name}" is {given["location_type"]!r}: forces act on "nodes"')
        if given.get("is_received"):
            raise CouplingError(f'"{name}" is received: this participant provides its meshes')
        self.group = groups[0]
        self.reads = [data for data, _ in _data(given, "read_data", ("Force",))]
        self.writes = _data(given, "write_data", ("Displacement", "Velocity"))


def _data(given: Mapping[str, Any], key: str, quantities: tuple[str, ...]) -> list[tuple[str, str]]:
    """Names of data, each with what it is."""
    listed = given.get(key, [])
    found = []
    for entry in listed if isinstance(listed, list) else [listed]:
        if not isinstance(entry, Mapping):
            raise CouplingError(f'"{key}" is a list such as [{{"name": "{quantities[0]}"}}], and holds {entry!r}')
        _known(entry, _DATA_KEYS, f'an entry of "{key}"', needed=("name",))
        name, what = entry["name"], str(entry.get("solver_name", entry["name"]))
        quantity = next((quantity for quantity in quantities if what.startswith(quantity)), None)
        if quantity is None or what.startswith("DisplacementDelta"):
            verb = "read" if key == "read_data" else "written"
            raise CouplingError(
                f'"{what}" cannot be {verb}: such names begin with {" or ".join(quantities)}; "solver_name" may say '
                "which of them it is"
            )
        if entry.get("operation", "value") != "value" or entry.get("flip-normal"):
            raise CouplingError(f'"{name}": data are values, without another operation or direction')
        found.append((name, quantity))
    return found


def _meshes(given: Any) -> dict[str, _Mesh]:
    if not isinstance(given, list) or not given:
        raise CouplingError('"interfaces" must be a list with at least one mesh')
    meshes = {}
    for entry in given:
        if not isinstance(entry, Mapping):
            raise CouplingError(f'"interfaces" holds objects with {", ".join(sorted(_INTERFACE_KEYS))}')
        _known(entry, _INTERFACE_KEYS, "an interface", needed=("mesh_name", "location_names"))
        meshes[entry["mesh_name"]] = _Mesh(entry["mesh_name"], entry)
    return meshes


def _known(given: Mapping[str, Any], known: set[str], what: str, *, needed: tuple[str, ...]) -> None:
    unknown, missing = sorted(set(given) - known), [key for key in needed if key not in given]
    if unknown or missing:
        wrong = [_unknown(key) for key in unknown] + [f'"{key}" is missing' for key in missing]
        raise CouplingError(f"{what}: {'; '.join(wrong)}; known keys: {', '.join(sorted(known))}")


def _unknown(key: str) -> str:
    return f'"{key}" is written {_RENAMED[key]} here' if key in _RENAMED else f'"{key}" is unknown'


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
