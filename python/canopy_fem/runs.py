"""Whole runs and equilibria, with files or in memory."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import TYPE_CHECKING

from . import _core
from .case import Case, as_case
from .errors import Diverged
from .logs import doubt, listen, log
from .results import Result, folder_of
from .simulation import told_time

if TYPE_CHECKING:
    from .typed import CaseSource

__all__ = ["run", "static"]


def run(
    case: Case | CaseSource,
    out: str | os.PathLike[str] | None = None,
    *,
    files: bool = True,
    threads: int = 1,
    replace: bool = False,
    resume: bool = False,
    keep_going: bool = False,
    progress: bool | Callable[[float, float], object] = False,
    check: bool = True,
) -> Result:
    """Runs a case to its end and writes the files of ``canopy-fem solve``, byte for byte.

    Each warning of the program is a `CaseWarning`.

    Args:
        case: a `Case`, a case file or a dictionary.
        out: folder for the files; a temporary one, which the result removes with itself, if left out.
        files: False writes nothing: summary, history, probes and gauges are kept in memory, with the same values, and
            frames are not. `out`, `replace` and `resume` are then of no use.
        threads: threads of scenes above 2,000 nodes; results do not depend on it.
        replace: replace earlier results in the folder.
        resume: go on from the checkpoint in the folder.
        keep_going: go on past a divergence until a value is not finite.
        progress: True for a line on standard error, in a notebook a bar; or a function of time [s] and end [s], called
            ten times a second.
        check: raise Diverged for a run that fails; its ``result`` has the files up to there.

    Raises:
        CaseError: a case with faults.
        Diverged: a run that diverged or could not be solved.
        OSError: a folder with earlier results, or files that cannot be written.
        KeyboardInterrupt: Ctrl-C; the folder then has a checkpoint.
        ValueError: replace and resume at once, or one of them or a folder without files.
    """
    case = as_case(case)
    if replace and resume:
        raise ValueError("give either replace or resume")
    if not files and (out is not None or replace or resume):
        raise ValueError("a run without files has no folder: leave out, replace and resume away")
    folder, keeper = folder_of(out) if files else (None, None)
    earlier = "resume" if resume else "replace" if replace else "keep"
    listen()
    log.info("run of %s begins: %s, end %g s", case.name, case.method, case.end)
    summary, found, tables = _core.record(
        case._core, folder, earlier=earlier, threads=threads, keep_going=keep_going, progress=told_time(progress)
    )
    log.info(
        "run of %s %s at t = %g s after %d steps", case.name, summary["status"], summary["t_end"], summary["steps"]
    )
    for warning in found:
        doubt(warning, stacklevel=2)
    return _checked(Result(folder, summary, keeper, tables), check)


def static(
    case: Case | CaseSource,
    out: str | os.PathLike[str] | None = None,
    *,
    at: float = 0.0,
    modes: int = 0,
    load_steps: int = 1,
    threads: int = 1,
    replace: bool = False,
    check: bool = True,
) -> Result:
    """Finds the equilibrium of a case and writes the files of ``canopy-fem static``, byte for byte.

    Args:
        case: a `Case`, a case file or a dictionary; its `time` section is not needed.
        out: folder for the files; a temporary one, which the result removes with itself, if left out.
        at: time of loads, wind and supports [s].
        modes: number of vibration modes to find about the equilibrium: `Result.modes`.
        load_steps: steps in which the loads are applied; 1 applies them at once, and in steps if that fails.
        threads: threads of scenes above 2,000 nodes; results do not depend on it.
        replace: replace earlier results in the folder.
        check: raise Diverged where no equilibrium is found; its ``result`` has the files.

    Parts that no force keeps in place are named in a `CaseWarning` and in ``result.equilibrium["findings"]``.

    Raises:
        CaseError: a case with faults.
        Diverged: no equilibrium was found.
        OSError: a folder with earlier results, or files that cannot be written.
        ValueError: a number out of range, or more modes than the scene has.
        KeyboardInterrupt: Ctrl-C.
    """
    case = as_case(case, at_rest=True)
    folder, keeper = folder_of(out)
    listen()
    log.info("equilibrium of %s is searched for", case.name)
    summary, found = _core.record_static(
        case._core, folder, replace=replace, threads=threads, at=at, load_steps=load_steps, modes=modes
    )
    log.info("equilibrium of %s: %s", case.name, summary["status"])
    for warning in found:
        doubt(warning, stacklevel=2)
    return _checked(Result(folder, summary, keeper), check)


def _checked(result: Result, check: bool) -> Result:
    failure = result.failure
    if failure is not None:
        log.warning("%s at t = %g s: %s", result.status, failure["time"], failure["cause"])
    if check and failure is not None:
        error = Diverged(
            f"{result.status} at t = {failure['time']} s: {failure['cause']}; {failure['advice']}", failure
        )
        error.result = result
        raise error
    return result
