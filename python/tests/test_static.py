"""Equilibria: the files of the program, closed forms, findings and failures."""

import json
import subprocess

import numpy as np
import pytest
from test_results import files

import canopy_fem as cf

G = 9.81


def weight():
    """2 kg on a spring of 100 N/m and 1 m, started beside its anchor; without a `time` section."""
    network = {
        "mesh": {"explicit": {"nodes": [[0, 0, 0], [0.5, 0, 0]], "springs": [[0, 1]]}},
        "mass": {"nodal": 2.0},
        "springs": [{"on": "all", "stiffness": 100.0, "rest_length": 1.0}],
        "supports": [{"on": {"ids": [0]}, "fix": "xyz"}],
        "gravity": [0, 0, -G],
    }
    gauges = [{"name": "spring", "on": "all", "of": "tension"}]
    return {"name": "weight", "system": {"network": network}, "output": {"gauges": gauges}}


def test_equilibrium_and_modes():
    """Tension, swing and bounce of a hanging weight."""
    result = cf.static(weight(), modes=3)
    assert result.status == "completed" and result.equilibrium["stability"] == "stable"
    np.testing.assert_allclose(result.gauge("spring", "tension_max")[1], [2 * G], rtol=1e-9)
    length = 1 + 2 * G / 100
    rates = [(G / length) ** 0.5] * 2 + [50**0.5]
    np.testing.assert_allclose(2 * np.pi * result.modes["frequency"], rates, rtol=1e-9)
    assert result.modes["axis"][2] == "z" and result.modes["mode"].tolist() == [1, 2, 3]


def test_same_bytes_as_the_program(tmp_path):
    """`static` writes what the program writes, byte for byte but for costs, and a run begins there."""
    path = tmp_path / "weight.json"
    path.write_text(json.dumps(weight()))
    cf.static(path, tmp_path / "python", modes=2)
    call = [cf.program(), "static", path, "--out", tmp_path / "program", "--modes", "2", "--quiet"]
    subprocess.run(call, check=True)
    ours, theirs = files(tmp_path / "python"), files(tmp_path / "program")
    assert list(ours) == list(theirs) and "modes.csv" in ours
    for name, data in theirs.items():
        assert ours[name] == data, name
    case = weight() | {"time": {"end": 1, "method": "rk4", "step": 0.01}}
    case["system"]["network"]["initial"] = {"from": str(tmp_path / "python")}
    assert cf.run(case).history["max_speed"].max() < 1e-6


def test_findings_and_failures():
    """What is unstable is a warning; what falls is an exception with its place."""
    pole = weight()
    pole["system"]["network"]["mesh"]["explicit"]["nodes"][1] = [0, 0, 1]
    with pytest.warns(cf.CaseWarning, match="unstable"):
        result = cf.static(pole)
    assert [finding["kind"] for finding in result.equilibrium["findings"]] == ["unstable"]
    free = weight()
    del free["system"]["network"]["supports"]
    with pytest.raises(cf.Diverged, match="no support holds the scene in z") as caught:
        cf.static(free)
    assert caught.value.result.status == "not-converged"
    assert cf.static(free, check=False).failure["node"] == 0
    with pytest.raises(ValueError, match="4 modes were asked for"):
        cf.static(weight(), modes=4)
    with pytest.raises(ValueError, match="at is -1"):
        cf.static(weight(), at=-1.0)
