"""What couplings are made of: interfaces, steps that are made again, and free steps."""

import re

import numpy as np
import pytest
from conftest import cloth

import canopy_fem as cf
from canopy_fem.coupling import Interface, Structure, frames


def strip(**time):
    """A strip two nodes wide along z, in the x-y plane of a flow, held at its ends; its depth is 0.25 m."""
    nodes = [[i / 8, 0.0, 0.25 * row] for i in range(9) for row in (0, 1)]
    triangles = [t for i in range(0, 16, 2) for t in ([i, i + 2, i + 3], [i, i + 3, i + 1])]
    groups = {"bottom": {"nodes": list(range(18))}, "none": {"triangles": [0]}}
    return {
        "name": "strip",
        "acknowledge": ["areal-density"],
        "system": {
            "network": {
                "mesh": {"explicit": {"nodes": nodes, "triangles": triangles, "groups": groups}},
                "mass": {"areal_density": 1.0},
                "membranes": [{"on": "all", "thickness": 0.002, "modulus": 250.0, "poisson": 0.0}],
                "supports": [{"on": {"ids": [0, 1, 16, 17]}, "fix": "xyz"}, {"on": "all", "fix": "z"}],
            }
        },
        "time": {"end": 10.0, "method": "newmark", "step": 0.0625, **time},
    }


def push(structure, size=0.1):
    forces = np.zeros((len(structure.interfaces["bottom"]), 2))
    forces[:, 1] = size
    structure.push("bottom", forces)


def test_an_interface_in_two_dimensions_joins_nodes_along_z():
    sim = cf.Simulation(strip())
    interface = Interface(sim, "bottom", dimensions=2)
    assert interface.points.tolist() == [[i / 8, 0.0] for i in range(9)]
    assert interface.edges.tolist() == [[i, i + 1] for i in range(8)]
    assert len(interface.triangles) == 0
    assert len(Interface(sim, "bottom")) == 18


def test_forces_do_the_same_work_on_both_sides():
    sim = cf.Simulation(strip())
    rng = np.random.default_rng(1)
    for dimensions, depth in ((2, 0.25), (3, 1.0)):
        interface = Interface(sim, "bottom", dimensions=dimensions)
        force = rng.normal(size=(len(interface), dimensions))
        moved = sim.reference + rng.normal(size=(18, 3))
        mine = np.sum(interface.spread(force) * (moved - sim.reference))
        assert mine == pytest.approx(depth * np.sum(force * interface.displacements(moved)), rel=1e-12)
        assert interface.spread(force).sum(axis=0)[:dimensions] == pytest.approx(depth * force.sum(axis=0))


def test_nodes_share_a_force_by_their_part_of_the_depth():
    """Three nodes at z = 0, 0.1 and 0.4 m have 0.05, 0.2 and 0.15 m of it."""
    nodes = [[0, 0, 0], [0, 0, 0.1], [0, 0, 0.4], [1, 0, 0.2]]
    net = cf.Network(nodes, mass=1.0)
    net.springs([[0, 3], [1, 3], [2, 3]], stiffness=1.0)
    sim = cf.Simulation(net, method="newmark", step=0.1, end=1.0)
    interface = Interface(sim, "all", dimensions=2)
    assert interface.points.tolist() == [[0, 0], [1, 0]]
    assert interface.spread([[1.0, 0.0], [0.0, 1.0]])[:, 0] == pytest.approx([0.05, 0.2, 0.15, 0.0])
    assert interface.spread([[1.0, 0.0], [0.0, 1.0]])[3].tolist() == [0.0, 0.4, 0.0]


@pytest.mark.parametrize("step", [0.0625, 0.25], ids=["one part", "four parts"])
def test_iterations_leave_no_trace(step):
    """Steps that were solved again have the bits of steps of a simulation that knew the force at once."""
    coupled, plain = Structure(strip(), ["bottom"], dimensions=2), cf.Simulation(strip())
    for k in range(1, 6):
        for wrong in (3.0, -0.5):
            push(coupled, wrong)
            coupled.solve(step)
        push(coupled, 0.1 * k)
        coupled.solve(step)
        shown = coupled.displacements("bottom")
        coupled.accept()
        plain.forces["flow"] = coupled.interfaces["bottom"].spread(np.tile([0.0, 0.1 * k], (9, 1)))
        plain.run_until(k * step)
        assert (coupled.sim.positions == plain.positions).all()
        assert (coupled.displacements("bottom") == shown).all()
        assert coupled.time == plain.time


def test_a_snapshot_goes_on_with_the_same_bits():
    first, second = (Structure(strip(), ["bottom"], dimensions=2) for _ in range(2))
    push(first)
    first.solve(0.1)
    first.accept()
    first.solve(0.1)  # given up by the snapshot
    second.restore(first.snapshot())
    assert second.time == first.time == 0.1
    for structure in (first, second):
        push(structure, 0.2)
        structure.solve(0.03)
        structure.accept()
    assert (first.sim.positions == second.sim.positions).all()


def test_a_step_ends_at_an_event_and_goes_on():
    case = strip()
    case["system"]["network"]["supports"].append({"on": {"ids": [8, 9]}, "fix": "xyz", "until": 0.03})
    structure = Structure(case, ["bottom"], dimensions=2)
    for _ in range(2):
        push(structure)
        structure.solve(0.0625)
        assert structure.displacements("bottom")[4, 1] > 0
    structure.accept()
    assert (structure.time, structure.sim.step_count) == (0.0625, 2)


def weak():
    """The strip with a solver that gives up on large steps."""
    return {**strip(step=1.0), "solver": {"newton": {"max_iterations": 5, "strategy": "full"}}}


def test_a_step_that_cannot_be_solved_is_cut():
    structure = Structure(weak(), ["bottom"], dimensions=2)
    push(structure, 5.0)
    structure.solve(1.0)
    structure.accept()
    assert structure.sim.step_count > 1
    assert structure.time == pytest.approx(1.0, rel=1e-12)


def test_a_step_that_is_refused_leaves_the_structure_as_it_was():
    structure = Structure(weak(), ["bottom"], dimensions=2, cuts=0)
    push(structure, 0.01)
    structure.solve(0.01)
    structure.accept()
    before = structure.sim.positions
    push(structure, 5.0)
    with pytest.raises(cf.Diverged) as refused:
        structure.solve(1.0)
    assert refused.value.report["cause"]
    assert structure.time == 0.01
    assert (structure.sim.positions == before).all()
    structure.solve(0.01)
    structure.accept()
    assert structure.time == 0.02


def test_explicit_steps_that_blow_up_are_refused():
    """Its first part is far above the largest stable step; the coupling is told before it accepts."""
    structure = Structure(cloth(time={"end": 1.0, "method": "velocity-verlet", "step": 1e3}), ["all"], cuts=1)
    before = structure.sim.positions
    with pytest.raises(cf.Diverged):
        for _ in range(20):
            structure.solve(1e3)
            structure.accept()
    assert np.isfinite(structure.sim.positions).all()
    assert structure.sim.attempted_time is None and before.shape == structure.sim.positions.shape


@pytest.mark.parametrize(
    ("forces", "words"),
    [
        (np.zeros((8, 2)), "9 points in 2 dimensions, the forces have the shape \\(8, 2\\)"),
        (np.full((9, 2), np.nan), "9 of 9 points have a force that is not finite"),
        (np.array([[0.0, np.inf if i == 3 else 0.0] for i in range(9)]), "point 3 at \\[0.375, 0.0\\] m"),
    ],
)
def test_forces_that_cannot_be_used(forces, words):
    structure = Structure(strip(), ["bottom"], dimensions=2)
    with pytest.raises(cf.CouplingError, match=words):
        structure.push("bottom", forces)
    structure.solve(0.1)
    assert (structure.displacements("bottom") == 0).all()


def test_interfaces_that_cannot_be_made():
    for group, more, words in (
        ("botom", {}, "groups here: bottom, none"),
        ("bottom", {"dimensions": 1}, "2 or 3 dimensions, not 1"),
        ("bottom", {"dimensions": 2, "depth": -1.0}, "a length \\[m\\] above 0"),
    ):
        with pytest.raises(cf.CouplingError, match=words):
            Structure(strip(), [group], **more)
    with pytest.raises(cf.CouplingError, match="at least one interface"):
        Structure(strip(), [])
    swing = {"pendulum": {"length": 1, "mass": 2, "damping": 0, "gravity": 9.81, "angle": 0.5}}
    with pytest.raises(cf.CouplingError, match='"swing" cannot be coupled: this scene has no forces from outside'):
        Structure({"name": "swing", "system": swing, "time": {"end": 1, "step": 0.1, "method": "rk4"}}, ["all"])


@pytest.mark.parametrize("step", [0.0, -1.0, float("nan"), float("inf")])
def test_steps_of_no_size(step):
    with pytest.raises(cf.CouplingError, match="must be above 0 and finite"):
        Structure(strip(), ["bottom"]).solve(step)
    with pytest.raises(ValueError, match="above 0"):
        cf.Simulation(strip(), free_steps=True).attempt(step)


def test_frames_show_where_the_scene_is(tmp_path):
    structure = Structure(strip(), ["bottom"], dimensions=2)
    record = frames(structure, tmp_path / "frames", 0.125)
    for _ in range(5):
        push(structure)
        structure.solve(0.0625)
        structure.accept()
        record.look()
    files = sorted(path.name for path in (tmp_path / "frames").iterdir())
    assert files == ["strip.pvd", *(f"strip_00000{i}.vtu" for i in range(3))]
    times = re.findall('timestep="([^"]+)".*file="([^"]+)"', (tmp_path / "frames" / "strip.pvd").read_text())
    assert times == [("0", files[1]), ("0.125", files[2]), ("0.25", files[3])]
    last = cf.mesh.read(tmp_path / "frames" / files[3])
    assert 0 < last.nodes[8, 1] < structure.sim.positions[8, 1]
    assert (last.triangles == structure.sim.triangles).all()
    assert frames(structure, tmp_path, 0) is None
    with pytest.raises(cf.CouplingError, match="give one above 0"):
        frames(structure, tmp_path, -1.0)


def test_free_steps_are_asked_for():
    sim = cf.Simulation(strip())
    with pytest.raises(cf.SimulationError, match="free steps"):
        sim.attempt(0.1)
    assert sim.attempted_time is None


def test_free_steps_of_one_size_have_the_bits_of_fixed_ones(small):
    for method in ("velocity-verlet", "newmark", "rk4"):
        small["time"] = {"end": 1.0, "method": method, "step": 2.0**-10}
        free, fixed = cf.Simulation(small, free_steps=True), cf.Simulation(small)
        for _ in range(20):
            free.attempt(2.0**-10)
            assert free.attempted_time == free.time + 2.0**-10
            free.accept()
        fixed.step(20)
        assert free.time == fixed.time
        assert (free.positions == fixed.positions).all()
        free.step(5)  # those without a size are as long as the case's
        fixed.step(5)
        assert (free.positions == fixed.positions).all()


def test_free_steps_go_beyond_the_end_of_the_case(small):
    sim = cf.Simulation(small, free_steps=True)
    sim.run_until(0.2)
    with pytest.raises(cf.Ended):
        sim.step()
    sim.attempt(0.0005)
    assert sim.accept().time == pytest.approx(0.2005)
