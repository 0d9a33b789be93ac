"""Whole runs: the same files as the program writes, and what is read of them."""

import json
import os
import subprocess
import warnings

import numpy as np
import pytest
from conftest import CASES, cloth

import canopy_fem as cf

COSTS = {"cpu_seconds", "wall_seconds", "peak_memory_bytes", "startup"}


def files(folder):
    """All result files by name, with the summary without costs."""
    found = {}
    for path in sorted(folder.rglob("*")):
        if path.is_file() and path.name != "checkpoint.bin":
            data = path.read_bytes()
            if path.name == "summary.json":
                data = {key: value for key, value in json.loads(data).items() if key not in COSTS}
            found[str(path.relative_to(folder))] = data
    return found


@pytest.mark.parametrize("method", [method["name"] for method in cf.methods()])
def test_same_bytes_as_the_program(method, tmp_path):
    """A run of every method writes what `canopy-fem solve` writes, byte for byte but for costs."""
    case = cloth(time={"end": 0.1, "method": method, "step": 1e-3})
    case["output"]["gauges"] = [{"name": "top", "on": {"ids": [0, 1]}, "of": "reaction"}]
    path = tmp_path / "square.json"
    path.write_text(json.dumps(case))
    cf.run(path, tmp_path / "python", check=False)
    subprocess.run([cf.program(), "solve", path, "--out", tmp_path / "program", "--quiet"], check=False)
    ours, theirs = files(tmp_path / "python"), files(tmp_path / "program")
    assert list(ours) == list(theirs) and len(ours) >= 7
    for name, data in theirs.items():
        assert ours[name] == data, name


def test_a_case_of_the_project_has_the_same_bytes(tmp_path):
    """So does the opening of a C-9, with overrides on both sides."""
    path = CASES / "parachute" / "c9-drop.json"
    cf.run(cf.Case(path, {"time.end": 0.05}), tmp_path / "python")
    call = [cf.program(), "solve", path, "--set", "time.end=0.05", "--out", tmp_path / "program", "--quiet"]
    subprocess.run(call, check=True)
    assert files(tmp_path / "python") == files(tmp_path / "program")


def test_one_file_for_all_frames(small, tmp_path):
    """A run whose frames are in one file has the times and the grids of one with a file for each."""
    many = cf.run(small, tmp_path / "many")
    small["output"]["format"] = "vtkhdf"
    one = cf.run(small, tmp_path / "one")
    np.testing.assert_array_equal(one.times, many.times)
    with pytest.raises(cf.CanopyError, match="to_pyvista"):
        one.frame(0.1)
    pytest.importorskip("pyvista")
    for t in (0.1, None):
        found, expected = one.to_pyvista(t), many.to_pyvista(t)
        np.testing.assert_array_equal(found.points, expected.points)
        assert set(found.point_data.keys()) == set(expected.point_data.keys())
        for name, values in expected.cell_data.items():
            np.testing.assert_array_equal(found.cell_data[name], values)
    again = cf.run(small, tmp_path / "again")
    assert files(again.folder) == files(one.folder)


def test_tables(small, tmp_path):
    """The tables have the columns of the files, with numbers that are numbers."""
    small["output"]["gauges"] = [{"name": "top", "on": {"ids": [0]}, "of": "reaction"}]
    result = cf.run(small, tmp_path / "out")
    history = result.history
    assert history["t"][-1] == 0.2 and history["step"].tolist() == list(range(201))
    total = history["kinetic"] + history["elastic"] + history["gravity"] - history["external_work"]
    total = total + history["dissipated"] + history["numerical"]
    np.testing.assert_allclose(total, total[0], atol=1e-9)
    assert result.probes["name"].tolist() == ["corner"] * 5 and result.probes["node"][0] == 48
    t, values = result.gauge("top", "reaction_z")
    assert t[-1] == 0.2 and values.shape == t.shape
    with pytest.raises(KeyError, match="several quantities: .*reaction_max"):
        result.gauge("top")
    with pytest.raises(KeyError, match="no gauge 'bottom'; there are: top"):
        result.gauge("bottom")
    with pytest.raises(KeyError, match="has no quantity 'tension'"):
        result.gauge("top", "tension")
    np.testing.assert_allclose(result.times, [0, 0.05, 0.1, 0.15, 0.2], atol=1e-12)
    assert cf.mesh.read(result.frame(0.1)).nodes.shape == (49, 3)
    assert "reaction_max" in " ".join(result.peaks)
    # What the report says of a gauge, by the name that a study takes.
    assert result.quantities["top.reaction.peak"] == (result.peaks["top reaction_total"], "N", None)
    assert result.quantities["displacement_end"].unit == "m"
    assert "completed" in result._repr_html_() and "&lt;Result" in result._repr_html_()
    again = cf.load(tmp_path / "out")
    assert again.summary == json.loads((tmp_path / "out" / "summary.json").read_text())


def test_added_mass_is_told():
    """What mass scaling adds stands in the words of a run, and only there where it adds some."""
    time = {"end": 0.01, "method": "central-difference", "step": 1e-3}
    scaled = cf.run(cloth(time=time | {"mass_scaling": {"step": 0.1}}))
    added = scaled.summary["mass_scaling"]["added"]
    assert added > 0 and f"with {added:.3g} kg of added mass" in repr(scaled)
    assert "added mass" not in repr(cf.run(cloth(time=time)))


def test_warnings_are_those_of_the_program(tmp_path):
    """A run warns of what `canopy-fem solve` warns of, in its words: of the case, on the way and of the end."""
    # A mass between two springs, pulled across by a growing force until the step is too long.
    case = {
        "name": "pulled",
        "system": {
            "network": {
                "mesh": {"explicit": {"nodes": [[-1, 0, 0], [0, 0, 0], [1, 0, 0]], "springs": [[0, 1], [1, 2]]}},
                "mass": {"nodal": 0.5},
                "springs": [{"on": "all", "stiffness": 50}],
                "supports": [
                    {"on": {"ids": [0, 2]}, "fix": "xyz", "until": 200},
                    {"on": {"ids": [1]}, "fix": "xy"},
                ],
                "loads": [{"on": {"ids": [1]}, "force": [0, 0, 1], "table": [[0, 0], [100, 400]]}],
            }
        },
        "time": {"end": 100, "method": "velocity-verlet", "step": 0.16},
        "output": {"frames": {"every": 10}},
    }
    path = tmp_path / "pulled.json"
    path.write_text(json.dumps(case))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        result = cf.run(path, tmp_path / "python", check=False)
    ours = [str(warning.message) for warning in caught if warning.category is cf.CaseWarning]
    command = [cf.program(), "solve", path, "--out", tmp_path / "program"]
    unwrapped = {key: value for key, value in os.environ.items() if key not in {"COLUMNS", "CLICOLOR_FORCE"}}
    done = subprocess.run(command, check=False, capture_output=True, text=True, encoding="utf-8", env=unwrapped)
    theirs = [line.removeprefix("warning: ") for line in done.stderr.splitlines() if line.startswith("warning: ")]
    assert ours == theirs
    codes = ["event-beyond-end", "step-above-critical", "energy-made"]
    assert [text.rsplit("[", 1)[1].rstrip("]") for text in ours] == codes and result.status == "diverged"
    assert files(tmp_path / "python") == files(tmp_path / "program")


def test_absent_tables_are_empty(small):
    del small["output"]
    result = cf.run(small)
    assert len(result.gauges) == 0 and "value" in result.gauges.dtype.names and len(result.probes) == 0
    folder = result.folder
    assert folder.exists()
    del result
    assert not folder.exists()


def test_earlier_results_are_kept(small, tmp_path):
    """A folder with results is refused, replaced or gone on from, as asked."""
    small["output"]["checkpoint"] = {"every": 0.05}
    whole = cf.run(small, tmp_path / "whole")
    with pytest.raises(OSError, match="whole"):
        cf.run(small, tmp_path / "whole")
    cf.run(small, tmp_path / "whole", replace=True)
    cf.run(small, tmp_path / "part")
    resumed = cf.run(cf.Case(small, {"time.end": 0.3}), tmp_path / "part", resume=True)
    assert 0.15 <= resumed.summary["resumed_from"] <= 0.2 and resumed.history["t"][-1] == pytest.approx(0.3)
    np.testing.assert_array_equal(resumed.history["kinetic"][:201], whole.history["kinetic"])


def test_a_failed_run_raises_and_has_files(small, tmp_path):
    small["time"] = {"end": 10.0, "method": "velocity-verlet", "step": 0.05}
    with pytest.warns(cf.CaseWarning), pytest.raises(cf.Diverged) as caught:
        cf.run(small, tmp_path / "out")
    assert caught.value.result.failure["cause"] == caught.value.report["cause"]
    assert (tmp_path / "out" / "history.csv").exists()
    with pytest.warns(cf.CaseWarning):
        assert cf.run(small, check=False).status == "diverged"


def test_progress_is_told(tmp_path):
    """The function of a run hears of growing times; an exception of it ends the run."""
    case = cf.Case(CASES / "cloth-k1000.json", {"time.end": 100.0, "output": None})
    seen = []

    def enough(t, end):
        seen.append(t)
        assert end == 100.0
        if len(seen) == 3:
            raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        cf.run(case, tmp_path / "out", progress=enough)
    assert 0.0 < seen[1] < seen[2]


def test_other_packages(small):
    """Tables go to pandas, frames to pyvista, energies to matplotlib, where these are installed."""
    result = cf.run(small)
    pandas = pytest.importorskip("pandas")
    frame = result.to_pandas()
    assert isinstance(frame, pandas.DataFrame) and frame["t"].iloc[-1] == 0.2
    pytest.importorskip("pyvista")
    grid = result.to_pyvista(0.2)
    assert grid.n_points == 49 and "velocity" in grid.point_data
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    axes = result.plot()
    assert axes.get_ylabel() == "energy [J]" and len(axes.lines) >= 3


def test_page_of_a_run(tmp_path):
    result = cf.run(cloth(), tmp_path / "out")
    page = result.show(height=500)
    assert page.html.startswith("<!DOCTYPE html>") and not (tmp_path / "out" / "view.html").exists()
    shown = page._repr_html_()
    assert shown.startswith("<iframe srcdoc=") and "height: 500px" in shown and "<canvas" not in shown
    for frame in (tmp_path / "out" / "frames").iterdir():
        frame.unlink()
    with pytest.raises(cf.CanopyError, match="is not there"):
        result.show()


def test_results_are_saved_and_closed(small, tmp_path):
    """A block ends with its temporary folder; what was saved stays, and is the same to the byte."""
    with cf.run(small) as result:
        folder = result.folder
        saved = result.save(tmp_path / "kept")
        names = sorted(path.relative_to(folder) for path in folder.rglob("*") if path.is_file())
        assert sorted(path.relative_to(saved.folder) for path in saved.folder.rglob("*") if path.is_file()) == names
        assert all((saved.folder / name).read_bytes() == (folder / name).read_bytes() for name in names)
        history = result.history
    assert not folder.exists() and result.status == "completed" and (result.history == history).all()
    with pytest.raises(FileNotFoundError, match="gone"):
        result.save(tmp_path / "again")
    with pytest.raises(FileExistsError, match="replace=True"):
        saved.save(tmp_path / "kept")
    with pytest.raises(OSError):
        (tmp_path / "mine").mkdir()
        (tmp_path / "mine" / "letter.txt").write_text("mine")
        saved.save(tmp_path / "mine", replace=True)
    assert (tmp_path / "mine" / "letter.txt").exists()
    assert cf.load(tmp_path / "kept").save(tmp_path / "other").history.tobytes() == history.tobytes()


def test_tables_go_to_polars_and_xarray(small):
    pytest.importorskip("polars")
    pytest.importorskip("xarray")
    small["output"]["gauges"] = [{"name": "cloth", "on": "all", "of": "tension", "every": 5}]
    result = cf.run(small)
    assert result.to_polars()["kinetic"].to_list() == result.history["kinetic"].tolist()
    assert result.to_polars("gauges").columns == ["t", "name", "quantity", "value"]
    data = result.to_xarray()
    t, values = result.gauge("cloth", "tension_max")
    shown = data["cloth tension_max"]
    assert (shown.values == values).all() and (shown[shown.dims[0]].values == t).all()
    assert (data.kinetic.values == result.history["kinetic"]).all()


def test_grids_are_updated_in_place(small):
    pytest.importorskip("pyvista")
    result = cf.run(small)
    grid = result.to_pyvista(0.0)
    first = grid.points.copy()
    assert result.to_pyvista(0.2, into=grid) is grid and (grid.points != first).any()
    sim = cf.Simulation(small)
    mesh = sim.to_pyvista()
    sim.step(20)
    assert sim.to_pyvista(mesh) is mesh
    np.testing.assert_allclose(mesh.points, sim.positions)
    np.testing.assert_allclose(mesh.point_data["velocity"], sim.velocities)
