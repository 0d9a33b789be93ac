"""A stand-in for preCICE's module for Python, version 3, for one participant; the other is a function.

It reads what it needs of a real configuration file, and is strict where the library is: about names, sizes, the order
of calls, numbers that are not finite, and that checkpoints are written and read; what it refuses is a `RuntimeError`,
as there. A partner that writes such numbers ends, which this side learns in `advance`. Its implicit coupling iterates,
with constant relaxation of the forces, until they rest.
"""

import xml.etree.ElementTree as ET

import numpy as np

# The flow: forces (k, d) on vertices at `points` with displacements `u`, both (k, d), at time t [s]. A test sets it.
flow = None
# What the last participant has seen: an object with iterations, steps, connectivity, finalized and windows.
last = None


def refuse_unless(right, text):
    if not right:
        raise RuntimeError(f"ERROR:  {text}")


class Participant:
    def __init__(self, solver_name, configuration_file_name, solver_process_index, solver_process_size):
        global last
        last = self
        refuse_unless((solver_process_index, solver_process_size) == (0, 1), "this call is not allowed")
        # Names such as data:vector have prefixes that the file does not declare.
        with open(configuration_file_name, encoding="utf-8") as file:
            root = ET.fromstring(
                file.read().replace("data:", "data-").replace("scheme:", "scheme-").replace("m2n:", "")
            )
        participant = root.find(f"participant[@name='{solver_name}']")
        refuse_unless(participant is not None, f"no participant {solver_name}")
        self._mesh = participant.find("provide-mesh").get("name")
        self._dimensions = int(root.find(f"mesh[@name='{self._mesh}']").get("dimensions"))
        self._size = {e.get("name"): self._dimensions for e in root.findall("data-vector")}
        self._size |= {e.get("name"): 1 for e in root.findall("data-scalar")}
        self._reads = [e.get("name") for e in participant.findall("read-data")]
        self._writes = [e.get("name") for e in participant.findall("write-data")]
        scheme = next(e for e in root if e.tag.startswith("coupling-scheme"))
        self._implicit = scheme.tag.endswith("implicit")
        self._window = float(scheme.find("time-window-size").get("value"))
        self._end = float(scheme.find("max-time").get("value"))
        self._most = int(scheme.find("max-iterations").get("value")) if self._implicit else 1
        self._connectivity = scheme.get("stand-in-connectivity") == "true"
        self._initial = any(e.get("initialize") == "true" for e in scheme.findall("exchange"))
        self.iterations, self.steps, self.connectivity = [], [], None
        self.finalized = self._ready = self._reading = False
        self._t = self._begun = 0.0
        self._writing = self._implicit
        self._complete = False
        self._count = 0

    def _known(self, mesh, data=None, among=None):
        refuse_unless(mesh == self._mesh, f"no mesh {mesh}")
        refuse_unless(data is None or data in among, f"no data {data}")

    def get_mesh_dimensions(self, mesh_name):
        self._known(mesh_name)
        return self._dimensions

    def get_data_dimensions(self, mesh_name, data_name):
        self._known(mesh_name, data_name, self._reads + self._writes)
        return self._size[data_name]

    def set_mesh_vertices(self, mesh_name, positions):
        self._known(mesh_name)
        refuse_unless(not self._ready, "this call is not allowed")
        self._points = np.array(positions, dtype=float)
        refuse_unless(self._points.shape[1] == self._dimensions, "this call is not allowed")
        # Numbers that are no row numbers, as the library may give.
        self._ids = np.arange(len(self._points)) * 2 + 7
        self._force = np.zeros_like(self._points)
        self._data = dict.fromkeys(self._writes)
        return self._ids.copy()

    def requires_mesh_connectivity_for(self, mesh_name):
        self._known(mesh_name)
        return self._connectivity

    def set_mesh_edges(self, mesh_name, vertices):
        refuse_unless(np.isin(vertices, self._ids).all() and np.shape(vertices)[1] == 2, "this call is not allowed")
        self.connectivity = np.searchsorted(self._ids, vertices)

    def set_mesh_triangles(self, mesh_name, vertices):
        refuse_unless(np.isin(vertices, self._ids).all() and np.shape(vertices)[1] == 3, "this call is not allowed")
        self.connectivity = np.searchsorted(self._ids, vertices)

    def requires_initial_data(self):
        refuse_unless(not self._ready, "this call is not allowed")
        return self._initial

    def initialize(self):
        refuse_unless(
            not self._initial or all(value is not None for value in self._data.values()), "this call is not allowed"
        )
        self._ready = True
        self._force = self._flow(0.0)

    def _flow(self, t):
        moved = next((v for k, v in self._data.items() if k.startswith("Displacement") and v is not None), None)
        force = flow(t, self._points, np.zeros_like(self._points) if moved is None else moved)
        gone = "receiving data from another participant (using sockets) failed with a system error: read: End of file"
        refuse_unless(np.isfinite(force).all(), gone)
        return force

    def is_coupling_ongoing(self):
        refuse_unless(self._ready, "this call is not allowed")
        return self._t < self._end - 1e-12

    def is_time_window_complete(self):
        return self._complete

    def get_max_time_step_size(self):
        return self._begun + self._window - self._t

    def requires_writing_checkpoint(self):
        wanted, self._writing = self._writing, False
        return wanted

    def requires_reading_checkpoint(self):
        wanted, self._reading = self._reading, False
        return wanted

    def read_data(self, mesh_name, data_name, vertex_ids, relative_read_time):
        self._known(mesh_name, data_name, self._reads)
        refuse_unless((np.asarray(vertex_ids) == self._ids).all(), "this call is not allowed")
        refuse_unless(0 <= relative_read_time <= self.get_max_time_step_size() + 1e-12, "this call is not allowed")
        return self._force.copy()

    def write_data(self, mesh_name, data_name, vertex_ids, values):
        self._known(mesh_name, data_name, self._writes)
        refuse_unless((np.asarray(vertex_ids) == self._ids).all(), "this call is not allowed")
        refuse_unless(np.shape(values) == self._points.shape, "data have another size")
        refuse_unless(np.isfinite(values).all(), "one of the given data values is either plus or minus infinity or NaN")
        self._data[data_name] = np.array(values)

    def advance(self, computed_timestep_length):
        refuse_unless(not self._writing and not self._reading, "a checkpoint was asked for")
        refuse_unless(0 < computed_timestep_length <= self.get_max_time_step_size() + 1e-12, "this call is not allowed")
        self.steps.append(computed_timestep_length)
        self._t += computed_timestep_length
        self._complete = False
        if self.get_max_time_step_size() > 1e-12:
            return
        self._count += 1
        force = self._flow(self._t)
        change = np.linalg.norm(force - self._force)
        rests = change <= 1e-10 * max(1.0, np.linalg.norm(force))
        # Explicit: the forces at this end act in the next window.
        self._force = force if not self._implicit else 0.5 * (force + self._force)
        if not self._implicit or rests or self._count >= self._most:
            self._begun, self._complete, self._writing = self._t, True, self._implicit
            self.iterations.append(self._count)
            self._count = 0
        else:
            self._t, self._reading = self._begun, True

    def finalize(self):
        self.finalized = True
