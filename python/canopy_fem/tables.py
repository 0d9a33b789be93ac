"""Tables of runs as numpy structured arrays: from their files, and from columns in memory."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

__all__ = ["empty", "of_columns", "read"]

_WHOLE = {"step", "newton_iterations", "node", "mode"}
_TEXT = {"name", "quantity", "axis"}
_HEADERS = {
    "probes": "t,name,node,x,y,z,vx,vy,vz",
    "gauges": "t,name,quantity,value",
    "modes": "mode,frequency,omega_squared,node,axis,mass_x,mass_y,mass_z,growth,error",
}


def empty(table: str) -> npt.NDArray[Any]:
    """One of these tables without rows."""
    return _table_of({name: [] for name in _HEADERS[table].split(",")})


def read(path: Path, table: str) -> npt.NDArray[Any]:
    """A .csv file as a structured array; an empty one where the case asked for none."""
    if not path.exists() and table in _HEADERS:
        return empty(table)
    with path.open(encoding="utf-8", newline="") as file:
        names, *rows = csv.reader(file)
    return _table_of({name: [row[place] for row in rows] for place, name in enumerate(names)})


def of_columns(tables: Mapping[str, Any]) -> dict[str, npt.NDArray[Any]]:
    """The tables of a run in memory, as its files would have them."""
    probes, gauges = dict(tables["probes"]), dict(tables["gauges"])
    probes["name"] = np.array(tables["followed"] or [""])[probes["name"]]
    channels = np.array(tables["channels"] or [("", "")])[gauges.pop("channel")]
    gauges = {"t": gauges["t"], "name": channels[:, 0], "quantity": channels[:, 1], "value": gauges["value"]}
    return {
        name: _table_of(of) for name, of in (("history", tables["history"]), ("probes", probes), ("gauges", gauges))
    }


def _table_of(columns: Mapping[str, Any]) -> npt.NDArray[Any]:
    """A structured array of columns, which are texts or numbers; read-only."""

    def kind(name: str) -> str:
        if name in _TEXT:
            return f"U{max((len(text) for text in columns[name]), default=1)}"
        return "i8" if name in _WHOLE else "f8"

    rows = len(next(iter(columns.values())))
    made = np.empty(rows, dtype=[(name, kind(name)) for name in columns])
    for name, values in columns.items():
        made[name] = np.array(values, dtype=made.dtype[name]) if rows else []
    made.flags.writeable = False
    return made
