"""Errors, medians, and how long a program takes to an accuracy."""

import math
import statistics
from dataclasses import dataclass, field

import numpy as np


@dataclass
class Run:
    """One program with one method and one step or tolerance, in all rounds."""

    peer: str
    method: str
    kind: str
    value: float
    status: str = "not run"
    note: str = ""
    error: float = math.nan
    error_max: float = math.nan
    seconds: list = field(default_factory=list)
    whole: list = field(default_factory=list)  # [s] of processes of their own, from start to end

    @property
    def median(self):
        return statistics.median(self.seconds) if self.seconds else math.nan

    @property
    def whole_median(self):
        return statistics.median(self.whole) if self.whole else math.nan

    @property
    def done(self):
        return self.status == "done" and math.isfinite(self.error)

    @property
    def pace(self):
        return f"{'h' if self.kind == 'step' else 'tol'} {self.value:.4g}"


class Reference:
    """A solution all are measured against, with the definition of `canopy-fem tradeoff`: the root mean square over
    frames and nodes of the distance, over that of the motion from the start; and the largest distance over the
    largest motion."""

    def __init__(self, frames, start, free):
        self.frames = frames.reshape(-1, *start.shape)
        self.free = free
        motion = np.linalg.norm((self.frames - start)[:, free], axis=2)
        self.squares, self.largest = np.sum(motion**2), np.max(motion)

    def errors(self, frames):
        """Root mean square and largest, or NaN if frames are missing."""
        if frames.size != self.frames.size:
            return math.nan, math.nan
        with np.errstate(all="ignore"):
            distance = np.linalg.norm((frames.reshape(self.frames.shape) - self.frames)[:, self.free], axis=2)
            return math.sqrt(np.sum(distance**2) / self.squares), float(np.max(distance) / self.largest)


def time_to(target, runs):
    """[s] Least time in which one method's runs reach an error, with the run that gave it, or None.

    Between two steps the time is read off the straight line in logarithms; a method whose cheapest run is better than
    asked costs what that run costs, because larger steps diverged or were not tried.
    """
    best = None
    for key in sorted({(r.method, r.kind) for r in runs}):
        # What is dearer and no better than another run of the method says nothing.
        line, least = [], math.inf
        for run in sorted((r for r in runs if r.done and (r.method, r.kind) == key), key=lambda r: r.median):
            if run.error < least:
                line.append(run)
                least = run.error
        found = first_below(target, line)
        if found and (best is None or found[0] < best[0]):
            best = found
    return best


def cheapest(target, runs):
    """The run that reaches an error in the least time of integration, or None."""
    return min((r for r in runs if r.done and r.error <= target), key=lambda r: r.median, default=None)


def first_below(target, line):
    """Time and run at which a falling line of runs passes the target."""
    for before, run in zip([None, *line], line, strict=False):
        if run.error > target:
            continue
        if before is None:
            return run.median, run, False
        share = math.log(before.error / target) / math.log(before.error / run.error)
        return math.exp(math.log(before.median) * (1 - share) + math.log(run.median) * share), run, True
    return None
