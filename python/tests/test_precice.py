"""The participant of preCICE, against a stand-in for the library."""

import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import precice_stand_in
import pytest
from conftest import ROOT

import canopy_fem as cf
from canopy_fem import precice
from canopy_fem.errors import CouplingLost

# As in preCICE's tutorial "perpendicular flap", with fewer windows.
CONFIG = """<?xml version="1.0" encoding="UTF-8" ?>
<precice-configuration>
  <data:vector name="Force" />
  <data:vector name="Displacement" />
  <mesh name="Fluid-Mesh" dimensions="2">
    <use-data name="Force" />
    <use-data name="Displacement" />
  </mesh>
  <mesh name="Solid-Mesh" dimensions="2">
    <use-data name="Displacement" />
    <use-data name="Force" />
  </mesh>
  <participant name="Fluid">
    <provide-mesh name="Fluid-Mesh" />
    <receive-mesh name="Solid-Mesh" from="Solid" />
    <write-data name="Force" mesh="Fluid-Mesh" />
    <read-data name="Displacement" mesh="Fluid-Mesh" />
  </participant>
  <participant name="Solid">
    <provide-mesh name="Solid-Mesh" />
    <write-data name="Displacement" mesh="Solid-Mesh" />
    <read-data name="Force" mesh="Solid-Mesh" />
  </participant>
  <m2n:sockets acceptor="Fluid" connector="Solid" exchange-directory=".." />
  <coupling-scheme:parallel-implicit>
    <time-window-size value="0.01" />
    <max-time value="0.1" />
    <participants first="Fluid" second="Solid" />
    <exchange data="Force" mesh="Solid-Mesh" from="Fluid" to="Solid" />
    <exchange data="Displacement" mesh="Solid-Mesh" from="Solid" to="Fluid" />
    <max-iterations value="50" />
    <relative-convergence-measure limit="5e-3" data="Displacement" mesh="Solid-Mesh" />
  </coupling-scheme:parallel-implicit>
</precice-configuration>
"""


def flap(step=0.01):
    """The flap: 1 m high, 0.1 m thick, of 3000 kg/m^3, 4 MPa and Poisson's ratio 0.3, as plane stress of unit depth."""
    nodes = [[-0.05 + 0.05 * i, 0.05 * j, 0.0] for j in range(21) for i in range(3)]
    cells = [3 * j + i for j in range(20) for i in range(2)]
    triangles = [t for a in cells for t in ([a, a + 1, a + 4], [a, a + 4, a + 3])]
    surface = sorted({3 * j + i for j in range(21) for i in (0, 2)} | {60, 61, 62})
    return {
        "name": "flap",
        "acknowledge": ["areal-density"],
        "system": {
            "network": {
                "mesh": {
                    "explicit": {"nodes": nodes, "triangles": triangles, "groups": {"surface": {"nodes": surface}}}
                },
                "mass": {"areal_density": 3000.0},
                "membranes": [{"on": "all", "thickness": 1.0, "modulus": 4e6, "poisson": 0.3}],
                "supports": [{"on": {"ids": [0, 1, 2]}, "fix": "xyz"}, {"on": "all", "fix": "z"}],
            }
        },
        "time": {"end": 5.0, "method": "newmark", "step": step},
    }


def channel(t, points, moved):
    """A push along x that grows with the height, and gives way to the flap."""
    force = np.zeros_like(points)
    force[:, 0] = points[:, 1] * (40.0 * min(1.0, t / 0.05) - 200.0 * moved[:, 0])
    return force


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """The tutorial's folders, with the stand-in in the library's place."""
    monkeypatch.setitem(sys.modules, "precice", precice_stand_in)
    monkeypatch.setattr(precice_stand_in, "flow", channel)
    (tmp_path / "precice-config.xml").write_text(CONFIG)
    solid = tmp_path / "solid-canopy"
    solid.mkdir()
    write(solid)
    return solid


def write(folder, case=None, **changes):
    interface = {
        "mesh_name": "Solid-Mesh",
        "location_names": ["surface"],
        "read_data": [{"name": "Force"}],
        "write_data": [{"name": "Displacement"}],
    }
    config = {
        "participant_name": "Solid",
        "precice_config_file_path": "../precice-config.xml",
        "interfaces": [interface | changes.pop("interface", {})],
        "canopy_fem": {"case": "flap.json"},
    }
    for key in ("save_file", "resume"):
        if key in changes:
            config["canopy_fem"][key] = changes.pop(key)
    (folder / "adapter.json").write_text(json.dumps(config | changes))
    (folder / "flap.json").write_text(json.dumps(case or flap()))


def reconfigure(folder, old, new):
    path = folder.parent / "precice-config.xml"
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))


def tip(structure):
    return structure.displacements("surface")[-2]


def test_the_guide_shows_this_configuration(folder):
    page = (ROOT / "docs" / "guide" / "src" / "coupling.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```jsonc\n(.*?)```", page, flags=re.DOTALL)
    shown = next(block for block in blocks if "participant_name" in block)
    assert json.loads(shown) == json.loads((folder / "adapter.json").read_text())


def test_the_flap_of_the_tutorial(folder):
    """Iterations end where the forces and the displacement of a window agree: as a step with the force at its end."""
    heights = []
    adapter = precice.Adapter(folder / "adapter.json")
    structure = adapter.run(lambda s: heights.append(tip(s)[0]))
    stand_in = precice_stand_in.last
    assert structure.time == pytest.approx(0.1, rel=1e-12)
    assert stand_in.finalized and len(stand_in.iterations) == len(heights) == 10
    assert min(stand_in.iterations) > 1
    points, force = structure.interfaces["surface"].points, np.zeros((43, 2))
    sim = cf.Simulation(flap())
    for window, height in enumerate(heights, 1):
        for _ in range(60):
            sim.forces["flow"] = structure.interfaces["surface"].spread(force)
            moved = structure.interfaces["surface"].displacements(sim.attempt().positions)
            sim.drop()
            force = channel(window * 0.01, points, moved)
        sim.step()
        assert structure.interfaces["surface"].displacements(sim.positions)[-2][0] == pytest.approx(height, rel=1e-7)
    assert heights[-1] > 1e-4


@pytest.mark.parametrize("method", ["newmark", "velocity-verlet"])
def test_shorter_steps_than_the_window(folder, method):
    """The window is 2.5 steps of the case: the last is cut to it, in every iteration."""
    case = flap()
    case["time"] = {"end": 5.0, "method": method, "step": 4e-3 if method == "newmark" else 1e-4}
    write(folder, case)
    structure = precice.run(folder / "adapter.json")
    assert structure.time == pytest.approx(0.1, rel=1e-12)
    if method == "newmark":
        assert sorted(set(np.round(precice_stand_in.last.steps, 9))) == [0.002, 0.004]
    fine = tip(structure)[0]
    write(folder)
    assert tip(precice.run(folder / "adapter.json"))[0] == pytest.approx(fine, rel=0.1)


def test_explicit_coupling(folder):
    reconfigure(folder, "parallel-implicit", "parallel-explicit")
    structure = precice.run(folder / "adapter.json")
    assert precice_stand_in.last.iterations == [1] * 10
    assert tip(structure)[0] > 1e-4


def test_connectivity_and_initial_data(folder):
    reconfigure(
        folder,
        "<coupling-scheme:parallel-implicit>",
        '<coupling-scheme:parallel-implicit stand-in-connectivity="true">',
    )
    reconfigure(folder, 'from="Solid" to="Fluid" />', 'from="Solid" to="Fluid" initialize="true" />')
    structure = precice.run(folder / "adapter.json")
    edges = precice_stand_in.last.connectivity
    lengths = np.linalg.norm(np.diff(structure.interfaces["surface"].points[edges], axis=1), axis=2)
    assert len(edges) >= 42 and lengths.max() < 0.12


def test_a_saved_state_is_where_another_run_begins(folder):
    """Two runs of 0.05 s, the second from the state of the first, are one of 0.1 s under a steady flow."""
    precice_stand_in.flow = lambda t, points, moved: channel(1.0, points, moved)
    whole = precice.run(folder / "adapter.json").sim.positions
    reconfigure(folder, 'max-time value="0.1"', 'max-time value="0.05"')
    write(folder, save_file="flap.state")
    precice.run(folder / "adapter.json")
    write(folder, resume="flap.state")
    assert precice.run(folder / "adapter.json").sim.positions == pytest.approx(whole, rel=1e-9, abs=1e-12)


def test_a_step_that_cannot_be_solved_is_made_shorter(folder):
    """preCICE is told of the shorter steps, which it takes."""
    write(folder, {**flap(), "solver": {"newton": {"max_iterations": 4, "strategy": "full"}}})
    reconfigure(folder, 'max-time value="0.1"', 'max-time value="0.02"')
    precice_stand_in.flow = lambda t, points, moved: 1e4 * channel(1.0, points, 0.0 * moved)
    structure = precice.run(folder / "adapter.json")
    assert min(precice_stand_in.last.steps) < 0.01
    assert structure.time == pytest.approx(0.02, rel=1e-12)


def breaks(t, points, moved):
    """The channel, whose solver diverges at 0.045 s."""
    return channel(t, points, moved) * (np.nan if t > 0.045 else 1.0)


@pytest.mark.parametrize("scheme", ["parallel-implicit", "parallel-explicit"])
@pytest.mark.parametrize("refuses_to_end", [False, True])
def test_a_partner_that_dies_loses_nothing(folder, scheme, refuses_to_end, monkeypatch):
    """The state at the start of the window is saved, and a run goes on from it."""
    reconfigure(folder, "parallel-implicit", scheme)
    precice_stand_in.flow = breaks
    if refuses_to_end:
        monkeypatch.setattr(precice_stand_in.Participant, "finalize", lambda self: 1 / 0)
    write(folder, save_file="flap.state")
    with pytest.raises(CouplingLost, match="failed in advance: .*End of file; the state at .* flap.state|flap.state$"):
        precice.run(folder / "adapter.json")
    write(folder, resume="flap.state")
    precice_stand_in.flow = channel
    assert precice.Adapter(folder / "adapter.json").structure.time == pytest.approx(0.04, rel=1e-12)


def test_the_command_ends_with_one_line(folder, monkeypatch, capsys):
    """3 where a partner dies, 2 where the configuration cannot be used."""
    precice_stand_in.flow = breaks
    write(folder, save_file="flap.state")
    monkeypatch.setattr(sys, "argv", ["precice", str(folder / "adapter.json")])
    assert precice.main() == 3
    told = capsys.readouterr().err
    assert told.startswith("error: preCICE has failed in advance") and told.count("\n") == 1
    (folder / "flap.state").write_bytes(b"damaged")
    write(folder, resume="flap.state")
    assert precice.main() == 2
    told = capsys.readouterr().err
    assert '"resume"' in told and told.count("\n") == 1
    reconfigure(folder, 'participant name="Solid"', 'participant name="Sail"')
    assert precice.main() == 2
    assert "no participant Solid" in capsys.readouterr().err


def test_forces_that_are_not_finite_are_told(folder, monkeypatch):
    """Should the library give some, as a mapping may."""
    read = precice_stand_in.Participant.read_data
    monkeypatch.setattr(precice_stand_in.Participant, "read_data", lambda *given: read(*given) * np.nan)
    with pytest.raises(cf.CouplingError, match='"Force" on "Solid-Mesh" at t = 0 s.*43 of 43 points'):
        precice.run(folder / "adapter.json")


def test_the_file_is_one_of_precices_schema(folder):
    schema = pytest.importorskip("preciceadapterschema")
    jsonschema = pytest.importorskip("jsonschema")
    text = (Path(schema.__file__).parent / "precice_adapter_config.schema.json").read_text(encoding="utf-8")
    write(folder, save_file="flap.state")
    jsonschema.validate(json.loads((folder / "adapter.json").read_text()), json.loads(text))


def test_data_of_other_names(folder):
    """ "solver_name" says what they are."""
    path = folder.parent / "precice-config.xml"
    path.write_text(path.read_text().replace('"Force"', '"Load"'))
    write(folder, interface={"read_data": [{"name": "Load", "solver_name": "Force"}]})
    assert tip(precice.run(folder / "adapter.json"))[0] > 1e-4


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"interface": {"location_names": ["surfaces"]}}, "groups here: surface"),
        ({"interface": {"location_names": ["surface", "tip"]}}, 'give one group of the case, such as \\["canopy"\\]'),
        ({"interface": {"location_type": "faceCenters"}}, 'forces act on "nodes"'),
        ({"interface": {"is_received": True}}, "provides its meshes"),
        ({"interface": {"read_data": [{"name": "Stress"}]}}, '"Stress" cannot be read'),
        ({"interface": {"read_data": ["Force"]}}, "holds 'Force'"),
        ({"interface": {"write_data": [{"name": "Temperature"}]}}, '"Temperature" cannot be written'),
        ({"interface": {"write_data": [{"name": "Velocity", "operation": "gradient"}]}}, "without another operation"),
        ({"interface": {"mesh": "Solid-Mesh"}}, '"mesh" is unknown; known keys: is_received'),
        ({"interface": {"read_data_names": ["Force"]}}, 'written "read_data": '),
        ({"interfaces": []}, "at least one mesh"),
        ({"overrides": {}}, 'written "canopy_fem": {"overrides"'),
        ({"canopy_fem": {"cas": "flap.json"}}, '"cas" is unknown; "case" is missing'),
    ],
)
def test_configurations_that_cannot_be_used(folder, changes, words):
    write(folder, **changes)
    with pytest.raises(cf.CouplingError, match=words):
        precice.Adapter(folder / "adapter.json")


def test_scalar_data_and_other_files(folder):
    reconfigure(folder, '<data:vector name="Force" />', '<data:scalar name="Force" />')
    with pytest.raises(cf.CouplingError, match="declare it as data:vector"):
        precice.run(folder / "adapter.json")
    (folder / "adapter.json").write_text("[1")
    with pytest.raises(cf.CouplingError, match="no JSON object"):
        precice.Adapter(folder / "adapter.json")


def test_without_preCICE_the_command_says_so(folder):
    """And how to get it."""
    done = subprocess.run(
        [sys.executable, "-m", "canopy_fem.precice", "adapter.json"], cwd=folder, capture_output=True, text=True
    )
    assert done.returncode == 2
    assert "preCICE's module for Python is not installed here" in done.stderr
    assert "Traceback" not in done.stderr
