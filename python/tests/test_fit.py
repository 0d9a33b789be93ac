"""Values from measured curves."""

import json

import numpy as np
import pytest
from conftest import ROOT

import canopy_fem as cf

CHAIN = ROOT / "docs" / "guide" / "cases" / "fit-chain.json"
STIFFNESS, MASS = "system.network.springs.0.stiffness", "system.network.mass.nodal"
RANGES = {STIFFNESS: (100.0, 900.0), MASS: "log:0.1..2"}


@pytest.fixture(scope="module")
def curves():
    """What the chain with 300 N/m and 0.5 kg shows, with noise: height of its tip [m], force in its line [N]."""
    sim = cf.Simulation(cf.Case(CHAIN, {STIFFNESS: 300.0, MASS: 0.5}))
    noise = np.random.default_rng(7)
    t, rows = [], []
    while sim.time < 1.49:
        sim.advance(0.05)
        t.append(sim.time)
        rows.append([sim.gauges["tip position_z"], sim.gauges["line tension_max"]])
    tip, line = np.array(rows).T
    return {
        "tip.position_z": (np.array(t), tip + noise.normal(0, 2e-3, tip.size)),
        "line.tension": (np.array(t), line + noise.normal(0, 0.2, line.size), np.full(line.size, 0.2)),
    }


def test_a_fit_finds_the_values_within_their_intervals(curves, tmp_path):
    """Arrays, with and without standard deviations; everything that the program says is there."""
    found = cf.fit(CHAIN, curves, RANGES, out=tmp_path / "fit")
    for key, true in ((STIFFNESS, 300.0), (MASS, 0.5)):
        low, high = found.intervals[key]
        assert low < true < high and high - low < 0.1 * true
        assert found.errors[key] == pytest.approx((high - low) / 4, rel=0.05)
    assert list(found.values) == [STIFFNESS, MASS] and found.doubts == []
    assert found.correlation.shape == (2, 2) and (np.diag(found.correlation) == 1).all()
    points = found.residuals
    assert list(points["of"]) == ["tip.position_z"] * 30 + ["line.tension"] * 30
    assert (points["t"][:30] == curves["tip.position_z"][0]).all()
    assert np.allclose(points["residual"], points["data"] - points["model"], atol=1e-9)
    assert points["residual"][:30].std() == pytest.approx(2e-3, rel=0.5)
    assert found.case.to_dict()["system"]["network"]["mass"]["nodal"] == found.values[MASS]
    assert found.report == json.loads((tmp_path / "fit" / "fit.json").read_text())
    assert "0.5" in repr(found) and (tmp_path / "fit" / "fit.html").exists()


def test_files_and_arrays_say_the_same(curves, tmp_path):
    """A csv file stands for the arrays; a factor changes the unit of its values."""
    t, tension, sigma = curves["line.tension"]
    file = tmp_path / "line.csv"
    np.savetxt(file, np.column_stack([t, tension / 1000, sigma / 1000]), delimiter=",", fmt="%.17g")
    by_file = cf.fit(CHAIN, {"line.tension*1000": file}, {STIFFNESS: RANGES[STIFFNESS]})
    by_arrays = cf.fit(CHAIN, {"line.tension": (t, tension, sigma)}, {STIFFNESS: RANGES[STIFFNESS]})
    assert by_file.values[STIFFNESS] == pytest.approx(by_arrays.values[STIFFNESS], rel=1e-6)
    assert by_file.report["reduced_chi_square"] == pytest.approx(by_arrays.report["reduced_chi_square"], rel=1e-6)


def test_an_offset_of_times_is_found(curves):
    """It is a value beside the others, and no key of the case."""
    t, tension, sigma = (column[3:25] for column in curves["line.tension"])
    late = {"line.tension": (t + 0.1, tension, sigma)}
    found = cf.fit(CHAIN, late, {STIFFNESS: (200.0, 400.0), MASS: (0.3, 0.8)}, offset=(-0.2, 0.1), starts=2)
    low, high = found.intervals["offset"]
    assert list(found.values)[-1] == "offset" and low < -0.1 < high
    assert "offset" not in found.case.to_dict()


def test_what_the_data_do_not_determine_has_no_error(curves):
    """From positions alone only the ratio of stiffness and mass follows."""
    found = cf.fit(
        CHAIN,
        {"tip.position_z": curves["tip.position_z"]},
        RANGES | {"system.network.springs.0.dashpot.axial.coefficient": (0.1, 5.0)},
    )
    assert found.doubts and any("determined" in doubt or "together" in doubt for doubt in found.doubts)


def test_tables_for_pandas(curves):
    pandas = pytest.importorskip("pandas")
    found = cf.fit(CHAIN, curves, RANGES)
    values, points = found.to_pandas(), found.to_pandas("residuals")
    assert list(values.columns) == ["value", "standard_error", "low", "high"]
    assert values.loc[MASS, "low"] < values.loc[MASS, "value"] == found.values[MASS]
    assert isinstance(points, pandas.DataFrame) and list(points.columns) == list(found.residuals.dtype.names)
    with pytest.raises(KeyError, match="residuals"):
        found.to_pandas("history")


def test_an_earlier_fit_and_its_data_stay(curves, tmp_path):
    """Without `replace` a second fit into the same folder is refused, and the data of the first stay."""
    vary = {STIFFNESS: RANGES[STIFFNESS]}
    cf.fit(CHAIN, {"line.tension": curves["line.tension"]}, vary, out=tmp_path)
    before = (tmp_path / "data-1.csv").read_bytes()
    shorter = tuple(column[:20] for column in curves["line.tension"])
    with pytest.raises(cf.CaseError, match="fit.json"):
        cf.fit(CHAIN, {"line.tension": shorter}, vary, out=tmp_path)
    assert (tmp_path / "data-1.csv").read_bytes() == before
    again = cf.fit(CHAIN, {"line.tension": shorter}, vary, out=tmp_path, replace=True)
    assert len(again.residuals) == 20 and (tmp_path / "data-1.csv").read_bytes() != before


def test_bad_data_are_told(curves):
    t = np.linspace(0.1, 1.0, 5)
    vary = {STIFFNESS: RANGES[STIFFNESS]}
    for data, error, words in (
        ({"line.tension": (t, t[:3])}, ValueError, "arrays of 5, 3 numbers"),
        ({"line.tension": (t,)}, TypeError, "arrays"),
        ({"line.tension": (t, np.full(5, np.nan))}, cf.CaseError, "line 1.*not finite"),
        ({"line.tension": (t[::-1], t)}, cf.CaseError, "must ascend"),
        ({"sail.tension": (t, t)}, cf.CaseError, "sail"),
        ({"line.tension": "missing.csv"}, cf.CaseError, "missing.csv"),
        ([("line.tension", (t, t))], TypeError, "dictionary"),
    ):
        with pytest.raises(error, match=words):
            cf.fit(CHAIN, data, vary)
    for wrong, error in (
        ({STIFFNESS: (1.0,)}, ValueError),
        ({STIFFNESS: (9.0, 1.0)}, cf.CaseError),
        ({}, cf.CaseError),
    ):
        with pytest.raises(error):
            cf.fit(CHAIN, {"line.tension": (t, t)}, wrong)
