"""Checkers of types refuse what the engine would refuse."""

import importlib.util
import subprocess
import sys
from typing import get_args

import pytest
from conftest import ROOT

import canopy_fem as cf
from canopy_fem import typed

MISTAKES = """
import canopy_fem as cf

case = cf.Case("c.json")
net = cf.Network([[0, 0, 0]], mass=1.0)
cf.Simulation(42)
cf.Simulation(net, method="newmrk", step=1.0, end=1.0)
net.springs(stiffness=1.0, slack="tensiononly")
cf.run(case).to_pandas("histroy")
cf.mesh.parachute(nominal_diamter=3)
cf.Simulation(case).select("a", kind="node")
cf.tradeoff(case, arguments="--methods rk4")
cf.Simulation(case).forces["c"] = "wrong"
cf.Case({"name": "x", "sytem": {}})
cf.Case({"time": {"methd": "rk4"}})
cf.Case({"time": {"method": "newmrk"}})
cf.Case({"output": {"fields": ["tensions"]}})
cf.rollout(case, keep=["position"])
"""
RIGHT = """
import numpy as np

import canopy_fem as cf
from canopy_fem.typed import CaseDict

case = cf.Case({"name": "a"}, {"time.step": 1e-3})
net = cf.Network(np.zeros((1, 3)), mass=[1.0])
net.springs(stiffness=1.0, slack="tension-only")
sim = cf.Simulation(net, method={"hht": {"alpha": -0.1}}, step=1.0, end=1.0)
sim.forces["a"] = np.zeros((1, 3))
sim.forces["b"] = [[0.0, 0.0, 1.0]]
sim.forces["c"] = lambda t, x, v: -v
cf.mesh.parachute(type="flat-circular", nominal_diameter=3.0, gores=12, radial_segments=4, gore_segments=1)
cf.mesh.disc(radius=1.0, nodes=100, seed=3)
cf.run({"name": "a"}).to_pandas("probes")
cf.tradeoff("c.json", arguments=["--methods", "rk4"])
whole: CaseDict = {
    "name": "whole",
    "system": {
        "network": {
            "mesh": cf.mesh.disc(radius=1.0, nodes=100),
            "mass": {"areal_density": 0.1},
            "springs": [{"on": "all", "stiffness": 1e3, "slack": "tension-only"}],
            "supports": [{"on": {"ids": [0]}, "fix": "xyz"}],
            "gravity": np.array([0.0, 0.0, -9.81]),
        }
    },
    "time": {"end": 1.0, "method": {"hht": {"alpha": -0.1}}, "step": 1e-3},
    "output": {"fields": ["tension"], "gauges": [{"name": "a", "on": "all", "of": "tension"}]},
}
cf.Case(whole)
cf.Case(case.to_dict(), base="cases")
batch = cf.rollout(case, every=0.1, wind=[0.0, 0.0, 1.0], forces={"skirt": np.zeros((2, 3, 3))}, initial=b"")
batch.energy("kinetic").sum()
[run.status for run in cf.rollout([case, case], every=0.1)]
cf.rollout(["a.json", "b.json"], times=[0.0, 1.0]).to_pandas()
"""


def checked(text, tmp_path):
    path = tmp_path / "program.py"
    path.write_text(text)
    call = [sys.executable, "-m", "mypy", "--config-file", str(ROOT / "python" / "pyproject.toml"), str(path)]
    return subprocess.run(call, capture_output=True, text=True, check=False).stdout


def test_mypy_refuses_mistakes(tmp_path):
    pytest.importorskip("mypy")
    told = checked(MISTAKES, tmp_path)
    found = {int(line.split(":")[1]) for line in told.splitlines() if ": error:" in line}
    assert found == set(range(6, 19)), told
    assert "Success" in checked(RIGHT, tmp_path)


def test_arguments_of_commands_are_a_list(small):
    for study in (
        cf.tradeoff,
        cf.stability,
        lambda case, arguments: cf.sweep(case, {"time.end": [1]}, arguments=arguments),
    ):
        with pytest.raises(TypeError, match="a list of texts, such as"):
            study(small, arguments="--methods rk4")


def test_types_of_a_case_are_those_of_its_schema():
    """python/tools/case_types.py makes the file that is there."""
    spec = importlib.util.spec_from_file_location("case_types", ROOT / "python" / "tools" / "case_types.py")
    tool = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(tool)
    assert tool.TARGET.read_text(encoding="utf-8") == tool.Types(cf.schema()).text()


def test_types_name_what_the_engine_has():
    """All methods, and all keys of a parachute and of the other generators."""
    assert list(get_args(typed.Method)) == [method["name"] for method in cf.methods()]
    definitions = cf.schema()["$defs"]
    parachute = next(entry for entry in definitions.values() if "gores" in entry.get("properties", {}))
    assert set(parachute["properties"]) <= set(typed.Parachute.__annotations__)
    gauges = [choice["const"] for choice in definitions["GaugeQuantity"]["oneOf"]]
    assert gauges == list(get_args(typed.GaugeQuantity))
    assert set(typed.Gauge.__annotations__) == set(definitions["Gauge"]["properties"])
    disc = next(entry for entry in definitions.values() if "boundary_nodes" in entry.get("properties", {}))
    assert set(typed.Graded.__annotations__) <= set(disc["properties"])
