"""The solver for Kratos' CoSimulation. Most need Kratos, and run where `.ci/kratos` installs it."""

import json
import re
import subprocess
import sys

import numpy as np
import pytest
from conftest import ROOT, cloth
from test_coupling import strip

import canopy_fem as cf

CAVITY = ROOT / "examples" / "flexible-cavity" / "cavity.py"


def needs_kratos():
    return pytest.importorskip("KratosMultiphysics.CoSimulationApplication")


def command(*words, folder):
    return subprocess.run([sys.executable, *map(str, words)], cwd=folder, capture_output=True, text=True)


def parameters(end=0.5, transfer="mapper", cells=8, flow=None, **settings):
    """A coupled simulation of the strip with the stand-in for a flow."""
    load = {"swap_sign": True, "use_transpose": transfer == "mapper"}
    moves = {"data_transfer_operator": transfer}
    options = {"data_transfer_operator_options": [option for option, used in load.items() if used]}
    data = {"dimension": 2, "model_part_name": "Flow"}
    own = {"dimension": 2, "model_part_name": settings.pop("part", "Structure.bottom")}
    force = settings.pop("force", "FORCE")
    given = {"cells": cells, "step": 0.0625, "push": 0.05, "give": 1.0, "breaks": 1e9, **(flow or {})}
    solvers = {
        "flow": {
            "type": "kratos_stand_in",
            "solver_wrapper_settings": given,
            "data": {
                "disp": {**data, "variable_name": "MESH_DISPLACEMENT"},
                "load": {**data, "variable_name": "REACTION"},
            },
        },
        "structure": {
            "type": "canopy_fem.kratos",
            "solver_wrapper_settings": {"input_file": "strip", "domain_size": 2, **settings},
            "data": {"disp": {**own, "variable_name": "DISPLACEMENT"}, "load": {**own, "variable_name": force}},
        },
    }
    moved = {"data": "disp", "from_solver": "structure", "from_solver_data": "disp", **moves}
    pushed = {"data": "load", "from_solver": "flow", "from_solver_data": "load", **moves, **options}
    rests = {"solver": "structure", "data_name": "disp"}
    operators = {"mapper": {"type": "kratos_mapping", "mapper_settings": {"mapper_type": "nearest_element"}}}
    return {
        "problem_data": {
            "problem_name": "test", "start_time": 0.0, "end_time": end, "echo_level": 0, "print_colors": False,
            "parallel_type": "OpenMP",
        },
        "solver_settings": {
            "type": "coupled_solvers.gauss_seidel_strong",
            "echo_level": 0,
            "num_coupling_iterations": 60,
            "convergence_accelerators": [{"type": "constant_relaxation", "alpha": 0.5, **rests}],
            "convergence_criteria": [
                {"type": "relative_norm_previous_residual", "abs_tolerance": 1e-13, "rel_tolerance": 1e-11, **rests}
            ],
            "data_transfer_operators": operators if transfer == "mapper" else {"copy": {"type": "copy"}},
            "coupling_sequence": [
                {"name": "flow", "input_data_list": [moved], "output_data_list": []},
                {"name": "structure", "input_data_list": [pushed], "output_data_list": []},
            ],
            "solvers": solvers,
        },
    }  # fmt: skip


def run(folder, given, case=None):
    """Runs it, and returns the structure."""
    import KratosMultiphysics as KM
    from KratosMultiphysics.CoSimulationApplication.co_simulation_analysis import CoSimulationAnalysis

    (folder / "strip.json").write_text(json.dumps(case or strip()))
    KM.Logger.GetDefaultOutput().SetSeverity(KM.Logger.Severity.WARNING)
    analysis = CoSimulationAnalysis(KM.Parameters(json.dumps(given)))
    analysis.Run()
    return analysis._GetSolver("structure").structure


@pytest.fixture
def folder(tmp_path, monkeypatch):
    needs_kratos()
    monkeypatch.chdir(tmp_path)
    return tmp_path


def alone(steps, give=1.0, push=0.05):
    """The strip under the same forces at the end of each step, found by iteration."""
    sim, structure = cf.Simulation(strip()), cf.coupling.Structure(strip(), ["bottom"], dimensions=2)
    interface, share = structure.interfaces["bottom"], np.array([0.5] + [1.0] * 7 + [0.5]) / 8
    for _ in range(steps):
        force, moved = np.zeros((9, 2)), np.zeros((9, 2))
        for _ in range(200):
            force[:, 1] = share * (push - give * moved[:, 1])
            sim.forces["flow"] = interface.spread(force)
            moved = 0.5 * (moved + interface.displacements(sim.attempt().positions))
            sim.drop()
        sim.step()
    return sim


@pytest.mark.parametrize("transfer", ["copy", "mapper"])
@pytest.mark.parametrize("force", ["FORCE", "REACTION", "POINT_LOAD"])
def test_strong_coupling(folder, transfer, force):
    """Each step ends under the forces at its end, as in a program that knows both sides."""
    structure = run(folder, parameters(transfer=transfer, force=force))
    assert structure.time == pytest.approx(0.5, rel=1e-12)
    # The case's step of 0.0625 s is that of the coupling, and each is accepted once.
    assert structure.sim.step_count == 8
    assert structure.sim.positions == pytest.approx(alone(8).positions, rel=1e-7, abs=1e-9)
    assert structure.displacements("bottom")[4, 1] > 1e-3


def test_a_flow_with_other_points(folder):
    """Forces are kept in sum, and displacements interpolated."""
    structure = run(folder, parameters(cells=13, flow={"give": 0.0}))
    total = structure._forces["coupling bottom"].sum(axis=0)
    # 0.05 N/m on a strip of 0.25 m.
    assert total == pytest.approx([0.0, 0.25 * 0.05, 0.0], abs=1e-12)


def test_surfaces_in_three_dimensions(folder):
    """Kratos maps between two cloths of other cells: linear displacements exactly, forces with sum and moment."""
    import KratosMultiphysics as KM
    import KratosMultiphysics.MappingApplication  # noqa: F401
    from KratosMultiphysics.MappingApplication import python_mapper_factory

    from canopy_fem.kratos import Create

    parts = []
    for cells in (5, 8):
        case = cloth(output={})
        case["system"]["network"]["mesh"]["rectangle"] |= {"columns": cells, "rows": cells}
        (folder / "cloth.json").write_text(json.dumps(case))
        data = {"dimension": 3, "model_part_name": "Structure.all"}
        settings = {
            "type": "canopy_fem.kratos",
            "solver_wrapper_settings": {"input_file": "cloth"},
            "data": {"x": {**data, "variable_name": "DISPLACEMENT"}, "f": {**data, "variable_name": "FORCE"}},
        }
        solver = Create(KM.Parameters(json.dumps(settings)), None, "structure")
        parts.append(solver.model["Structure.all"])
        assert parts[-1].NumberOfElements() == 2 * cells**2
    mapper = python_mapper_factory.CreateMapper(*parts, KM.Parameters('{"mapper_type": "nearest_element"}'))
    for node in parts[0].Nodes:
        node.SetSolutionStepValue(KM.DISPLACEMENT, [node.X, 2 * node.Y, node.X - node.Y])
    mapper.Map(KM.DISPLACEMENT, KM.DISPLACEMENT)
    for node in parts[1].Nodes:
        assert list(node.GetSolutionStepValue(KM.DISPLACEMENT)) == pytest.approx([node.X, 2 * node.Y, node.X - node.Y])
        node.SetSolutionStepValue(KM.FORCE, [0.0, node.X, 1.0])
    mapper.InverseMap(KM.FORCE, KM.FORCE, KM.Mapper.USE_TRANSPOSE)
    sums = [
        np.sum(
            [[*f, node.X * f[2], node.Y * f[2]] for node in part.Nodes for f in [node.GetSolutionStepValue(KM.FORCE)]],
            0,
        )
        for part in parts
    ]
    assert sums[0] == pytest.approx(sums[1])


def test_it_goes_on_from_a_saved_state(folder):
    whole = run(folder, parameters()).sim.positions
    run(folder, parameters(end=0.25, save_every=2, save_folder="states"))
    assert sorted(path.name for path in (folder / "states").iterdir()) == [
        "structure_0.125.state",
        "structure_0.25.state",
    ]
    again = parameters(resume="states/structure_0.25.state")
    with pytest.raises(cf.CouplingError, match="is at t = 0.25 s, the coupling at 0 s"):
        run(folder, again)
    again["problem_data"]["start_time"] = 0.25
    assert run(folder, again).sim.positions == pytest.approx(whole, rel=1e-9, abs=1e-12)


def test_another_step_than_that_of_the_case(folder):
    """Steps of the coupling that are not those of the case are made in parts, again in every iteration."""
    case = strip(step=0.02)
    structure = run(folder, parameters(time_step=0.0625, frames_every=0.1), case)
    assert structure.sim.step_count == 8 * 4
    times = re.findall('timestep="([^"]+)"', (folder / "frames" / "strip.pvd").read_text())
    assert [float(t) for t in times] == pytest.approx([0.0, 0.125, 0.25, 0.375, 0.5])
    assert structure.sim.positions == pytest.approx(alone(8).positions, abs=2e-4)


def test_forces_that_are_not_finite_lose_nothing(folder):
    with pytest.raises(
        cf.CouplingError, match='solver "structure".*from t = 0.25 s(.|\n)*saved(.|\n)*point 2 at'
    ) as told:
        run(folder, parameters(transfer="copy", flow={"breaks": 0.26}))
    state = folder / "saved" / "structure_0.25.state"
    assert str(state.relative_to(folder)) in str(told.value)
    sim = cf.Simulation(strip(), free_steps=True)
    sim.restore(state.read_bytes())
    assert sim.time == pytest.approx(0.25)


def test_a_step_that_cannot_be_solved_is_cut_or_told(folder):
    """In parts it can be solved. Where no part can be, the coupling gets the report, and may catch it."""
    case = {**strip(step=0.5), "solver": {"newton": {"max_iterations": 5, "strategy": "full"}}}
    hard = {"push": 40.0, "give": 0.0, "step": 0.5}
    structure = run(folder, parameters(time_step=0.5, flow=hard), case)
    assert structure.sim.step_count > 1
    case["solver"]["newton"]["max_iterations"] = 1
    with pytest.raises(cf.Diverged, match="Newton(.|\n)*") as told:
        run(folder, parameters(time_step=0.5, flow=hard), case)
    assert told.value.report["cause"] and "structure_0.state" in str(told.value)


def test_a_coupling_may_cut_a_step_that_was_refused(folder):
    """A program that drives the solver itself catches the refusal, and asks for a shorter step from the same start."""
    import KratosMultiphysics as KM

    from canopy_fem.kratos import Create

    case = {**strip(step=0.5), "solver": {"newton": {"max_iterations": 2, "strategy": "full"}}}
    (folder / "strip.json").write_text(json.dumps(case))
    settings = parameters(time_step=0.5)["solver_settings"]["solvers"]["structure"]
    solver = Create(KM.Parameters(json.dumps(settings)), None, "structure")
    solver.Initialize()
    load, shown = solver.GetInterfaceData("load"), solver.GetInterfaceData("disp")
    assert solver.AdvanceInTime(0.0) == 0.5
    load.SetData(np.tile([0.0, 5.0], 9))
    with pytest.raises(cf.Diverged):
        solver.SolveSolutionStep()
    solver.time_step = 0.005
    assert solver.AdvanceInTime(0.0) == 0.005
    load.SetData(np.tile([0.0, 5.0], 9))
    solver.SolveSolutionStep()
    solver.FinalizeSolutionStep()
    assert solver.structure.time == 0.005
    assert shown.GetData().reshape(9, 2)[4, 1] > 0


def test_interfaces_of_other_sizes(folder):
    with pytest.raises(Exception, match="sizes of the data are not matching: 18 != 28"):
        run(folder, parameters(transfer="copy", cells=13))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"part": "Structure.botom"}, "groups here: bottom"),
        ({"part": "Sheet.bottom"}, 'give "Structure." and the name of a group'),
        ({"force": "TEMPERATURE"}, "no variable of the coupling; known: POINT_LOAD, REACTION, FORCE"),
        ({"input_file": ""}, '"input_file"'),
        ({"domain_size": 1}, "2 or 3 dimensions"),
        ({"sav_every": 3}, '"sav_every" is no setting; did you mean save_every'),
        ({"resume": "none.state"}, "none.state"),
        ({"overrides": {"time.method": "newmrk"}}, "newmark"),
    ],
)
def test_parameters_that_cannot_be_used(folder, changes, words):
    with pytest.raises((cf.CanopyError, OSError), match=words):
        run(folder, parameters(**changes))


def test_the_command_runs_and_tells(folder, monkeypatch):
    """Its status is 0, 2 for what cannot be used, 3 for a step that cannot be solved. It names missing wheels."""
    monkeypatch.setenv("PYTHONPATH", str(ROOT / "python" / "tests"))
    (folder / "strip.json").write_text(json.dumps(strip()))
    for given, status, words in (
        (parameters(), 0, ""),
        (parameters(transfer="copy", flow={"breaks": 0.26}), 2, "not finite"),
        (parameters(transfer="copy", cells=13), 2, "18 != 28 for interface data"),
        (parameters(overrides={"solver.newton.max_iterations": 1}, flow={"push": 400.0}), 3, "Newton"),
    ):
        (folder / "both.json").write_text(json.dumps(given))
        done = command("-m", "canopy_fem.kratos", "both.json", folder=folder)
        assert (done.returncode, words in done.stderr) == (status, True), done.stderr
        assert "Traceback" not in done.stderr
    text = json.dumps(parameters()).replace("kratos_stand_in", "KratosMultiphysics.DEMApplication.dem")
    (folder / "both.json").write_text(text)
    done = command("-m", "canopy_fem.kratos", "both.json", folder=folder)
    assert done.returncode == 2
    assert "both.json needs DEMApplication, which is not installed here" in done.stderr
    assert "pip install KratosDEMApplication" in done.stderr


def test_without_Kratos_the_command_says_how_to_get_it(tmp_path):
    try:
        import KratosMultiphysics  # noqa: F401
    except ImportError:
        (tmp_path / "both.json").write_text(json.dumps(parameters()))
        done = command("-m", "canopy_fem.kratos", "both.json", folder=tmp_path)
        assert done.returncode == 2
        assert "Python 3.11: pip install" in done.stderr and "KratosMultiphysics" in done.stderr
    else:
        pytest.skip("Kratos is installed")


def snippet(word):
    """The block of the guide's page that holds a word."""
    page = (ROOT / "docs" / "guide" / "src" / "coupling.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```jsonc\n(.*?)```", page, flags=re.DOTALL)
    return next(block for block in blocks if word in block)


def test_the_guide_shows_the_solver_of_the_cavity(tmp_path):
    assert command(CAVITY, "make", tmp_path, folder=tmp_path).returncode == 0
    made = json.loads((tmp_path / "ProjectParametersCoSim.json").read_text())
    shown = json.loads("{" + snippet("canopy_fem.kratos") + "}")
    assert shown["structure"] == made["solver_settings"]["solvers"]["structure"]
    assert cf.Case(tmp_path / "structure.json").name == "cavity-bars"


@pytest.mark.parametrize("structure", ["bars", "membrane"])
def test_a_cavity_with_a_flexible_bottom(tmp_path, structure):
    """Its first 20 steps. The values are those of the first run; a fluid of Kratos has no closed form."""
    needs_kratos()
    pytest.importorskip("KratosMultiphysics.FluidDynamicsApplication")
    pytest.importorskip("matplotlib")
    made, drawn = ["make", tmp_path, "--structure", structure, "--end", "2.0"], ["plot", tmp_path / "p.svg", tmp_path]
    for words in (made, ["run", tmp_path], drawn):
        done = command(CAVITY, *words, folder=tmp_path)
        assert done.returncode == 0, done.stderr
    rows = np.loadtxt(tmp_path / "midpoint.dat")
    assert rows[[9, 14, 19], 2] == pytest.approx([-0.002525, -0.003690, -0.000541], abs=2e-5)
