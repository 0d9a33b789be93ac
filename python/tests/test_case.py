"""Cases from files and dictionaries, and their faults."""

import numpy as np
import pytest
from conftest import CASES, cloth

import canopy_fem as cf


def test_file_and_dictionary_are_the_same_case():
    """A case keeps what a dictionary says, and a file gives the same run as its content does."""
    file = cf.Case(CASES / "cloth-k1000.json")
    again = cf.Case(file.to_dict())
    assert again.to_dict() == file.to_dict()
    assert (file.name, file.method, file.step, file.end) == ("cloth-k1000", "velocity-verlet", 5e-4, 2.0)


def test_overrides_replace_and_remove(small):
    """Overrides change values by dotted path, None removes, and they add up."""
    case = cf.Case(small, {"time.step": 2e-3, "system.network.springs.0.stiffness": 300.0})
    assert case.step == 2e-3
    later = case.with_overrides({"time.method": {"hht": {"alpha": -0.2}}, "output": None})
    assert later.to_dict()["system"]["network"]["springs"][0]["stiffness"] == 300.0
    assert later.method == "hht" and "output" not in later.to_dict()


def test_faults_have_their_place(small):
    """All faults come at once, each with its place, value and what is allowed; a misspelt key has the nearest one."""
    small["time"]["stpe"] = small["time"].pop("step")
    small["system"]["network"]["springs"][0]["stiffness"] = -1
    with pytest.raises(cf.CaseError) as caught:
        cf.Case(small)
    faults = {fault.pointer: fault for fault in caught.value.faults}
    assert "step" in faults["/time/stpe"].hint
    assert faults["/system/network/springs/0/stiffness"].value.startswith("-1")
    assert isinstance(caught.value, ValueError)


def test_arrays_and_meshes_stand_in_cases(small):
    """Arrays of any real type stand for lists, and a mesh for its section."""
    mesh = cf.mesh.rectangle(width=1, height=1, columns=6, rows=6)
    network = small["system"]["network"]
    as_made = cf.Simulation(small).run_until(0.05).energies.as_dict()
    network["mesh"] = mesh
    network["gravity"] = np.array([0, 0, -9.81], dtype=np.float64)
    assert cf.Simulation(small).run_until(0.05).energies.as_dict() == as_made


def test_what_json_cannot_hold_is_refused_with_its_place(small):
    small["time"]["end"] = float("nan")
    with pytest.raises(cf.CaseError) as caught:
        cf.Case(small)
    assert caught.value.faults[0].pointer == "/time/end"
    endless = cloth()
    endless["system"]["network"]["self"] = endless
    with pytest.raises(cf.CaseError, match="contain itself"):
        cf.Case(endless)


def test_schema_and_methods_are_those_of_the_program():
    assert "system" in cf.schema()["properties"]
    names = {method["name"] for method in cf.methods()}
    assert {"newmark", "velocity-verlet", "kang"} <= names


def test_missing_files_are_os_errors(tmp_path):
    with pytest.raises(FileNotFoundError):
        cf.Case(tmp_path / "none.json")
