"""Runs without files, what is logged, and how progress is shown."""

import copy
import logging
import pickle
import sys
import types

import numpy as np
import pytest
from conftest import CASES, cloth

import canopy_fem as cf

GAUGES = [{"name": "cloth", "on": "all", "of": "tension", "every": 3}]
COSTS = {"cpu_seconds", "wall_seconds", "peak_memory_bytes", "startup"}


@pytest.fixture
def gauged():
    probes = [{"name": "corner, low", "on": {"ids": [48, 6]}}, {"name": "middle", "on": {"ids": [24]}}]
    return cloth(output={"gauges": GAUGES, "probes": probes, "frames": {"every": 0.05}, "history": {"every": 7}})


def same(one, other):
    assert {key: value for key, value in one.summary.items() if key not in COSTS} == {
        key: value for key, value in other.summary.items() if key not in COSTS
    }
    for table in ("history", "probes", "gauges", "modes"):
        here, there = getattr(one, table), getattr(other, table)
        assert here.dtype == there.dtype and here.tobytes() == there.tobytes(), table


def test_a_run_in_memory_has_the_values_of_the_files(gauged, tmp_path, monkeypatch):
    """Tables and summary are equal to those of a run with files, and no file is written."""
    files = cf.run(gauged, tmp_path / "run")
    (tmp_path / "empty").mkdir()
    monkeypatch.chdir(tmp_path / "empty")
    result = cf.run(gauged, files=False)
    same(result, files)
    assert len(result.history) > 10 and len(result.probes) == 15 and len(result.gauges) > 100
    assert result.peaks == files.peaks and result.gauge("cloth", "tension_max")[1].any()
    assert not list((tmp_path / "empty").iterdir())
    assert not result.history.flags.writeable
    for again in (pickle.loads(pickle.dumps(result)), copy.copy(result), copy.deepcopy(result)):
        same(again, files)
        assert not again.history.flags.writeable


def test_a_run_in_memory_has_no_folder(gauged, tmp_path):
    result = cf.run(gauged, files=False)
    for ask in (lambda: result.folder, lambda: result.frame(), lambda: result.save(tmp_path / "a"), result.show):
        with pytest.raises(cf.CanopyError, match="files=False"):
            ask()
    assert not len(result.times) and "none" in result._repr_html_()
    result.close()
    assert len(result.history)
    for more in ({"out": tmp_path}, {"replace": True}, {"resume": True}):
        with pytest.raises(ValueError, match="without files"):
            cf.run(gauged, files=False, **more)


def test_a_failure_in_memory_is_that_of_the_files(gauged, tmp_path):
    gauged["time"] |= {"step": 0.05, "end": 5.0}
    results = []
    for how in ({"out": tmp_path / "run"}, {"files": False}):
        with pytest.raises(cf.Diverged) as raised, pytest.warns(cf.CaseWarning):
            cf.run(gauged, **how)
        results.append(raised.value.result)
    same(*results)


def test_advice_names_keys_of_the_case(gauged):
    """A program in Python has no command line."""
    gauged["time"] |= {"step": 0.05, "end": 5.0}
    with pytest.raises(cf.Diverged) as raised, pytest.warns(cf.CaseWarning) as warned:
        cf.run(gauged, files=False)
    told = [str(raised.value), *(str(one.message) for one in warned)]
    assert "time.method=" in raised.value.report["advice"] and not any("--" in text for text in told), told


def test_earlier_results_are_told_in_words_of_python(small, tmp_path):
    cf.run(small, tmp_path)
    with pytest.raises(OSError, match="give replace=True") as raised:
        cf.run(small, tmp_path)
    assert "--" not in str(raised.value)


def test_runs_are_logged(gauged, caplog):
    """Start and end of runs, doubts, failures; what the engine says comes from its own logger, events among it."""
    caplog.set_level(logging.INFO, logger="canopy_fem")
    cf.run(gauged, files=False)
    told = [(one.name, one.levelname) for one in caplog.records]
    assert told[0] == ("canopy_fem", "INFO") and "begins" in caplog.messages[0]
    assert caplog.messages[-1] == "run of square completed at t = 0.2 s after 200 steps"
    caplog.clear()
    cf.rollout(gauged, overrides=[{}, {"time.step": 0.05, "time.end": 5.0}], threads=2)
    own = [one.message for one in caplog.records if one.name == "canopy_fem"]
    assert own[0].startswith("rollout of 2 runs begins") and any("of 2 runs ended" in text for text in own)
    assert [one.levelname for one in caplog.records if one.message.startswith("run 1 diverged")] == ["WARNING"]
    caplog.clear()
    gauged["time"] |= {"step": 0.05, "end": 5.0}
    with pytest.warns(cf.CaseWarning):
        cf.run(gauged, files=False, check=False)
    doubts = [one for one in caplog.records if one.levelname == "WARNING" and one.name == "canopy_fem"]
    assert any("step" in one.message for one in doubts) and any("diverged at" in one.message for one in doubts)


def test_events_are_logged(caplog):
    """An event of the case is told with its time, from a whole run and from a simulation; not at a higher level."""
    case = cf.Case(CASES.parents[1] / "docs" / "guide" / "cases" / "two-stage.json")
    caplog.set_level(logging.INFO, logger="canopy_fem")
    events = cf.run(case, files=False).summary["events"]
    told = [one.message for one in caplog.records if one.name == "canopy_fem.engine" and "disreef" in one.message]
    assert told and any(event["name"] == "disreef" for event in events)
    caplog.clear()
    sim = cf.Simulation(case)
    sim.run_until(events[-1]["time"])
    assert any("disreef" in one.message for one in caplog.records)
    caplog.clear()
    caplog.set_level(logging.WARNING, logger="canopy_fem")
    cf.run(case, files=False)
    assert not caplog.records


class Shell:
    kernel = object()


def test_progress_is_a_bar_in_a_notebook(small, monkeypatch):
    """In a notebook one display is updated, up to the end; elsewhere a line is written."""
    shown = []

    class Handle:
        def update(self, drawn):
            shown.append(drawn)

    def display(drawn, display_id):
        shown.append(drawn)
        return Handle()

    parts = types.SimpleNamespace(HTML=str, display=display)
    monkeypatch.setitem(sys.modules, "IPython", types.SimpleNamespace(get_ipython=Shell))
    monkeypatch.setitem(sys.modules, "IPython.display", parts)
    cf.Simulation(small).run(progress=True)
    assert 'value="1.0000"' in shown[-1] and "0.2 of 0.2 s" in shown[-1]
    shown.clear()
    cf.rollout(small, overrides=[{}] * 3, progress=True)
    assert 'value="1.0000"' in shown[-1] and "3 of 3 runs" in shown[-1]


def test_progress_is_a_line_elsewhere(small, capsys):
    cf.Simulation(small).run(progress=True)
    assert capsys.readouterr().err.endswith("100 %  t 0.2 of 0.2 s\n")
    with pytest.raises(TypeError, match="progress"):
        cf.run(small, progress="yes")
    assert np.isfinite(cf.rollout(small, progress=True).energies).all()
