"""Flights of shipped parachutes with other values, and how docs/validation.py shows them: rows of a table, charts."""

import csv
import json
import math
import os
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
CASES = ROOT / "assets/cases/parachute"

program = ROOT / "target/release/canopy-fem"
pool = ThreadPoolExecutor(os.cpu_count())


class Swinging(float):
    """The mean of what does not settle."""


@dataclass
class Flight:
    """Gauges of a run over its steps."""
    # [s], [N] of the riser, [m/s] of the canopy along its axis, [-] Dp/D0 and CD0, [m] of the skirt
    t: list = field(default_factory=list)
    load: list = field(default_factory=list)
    speed: list = field(default_factory=list)
    width: list = field(default_factory=list)
    drag: list = field(default_factory=list)
    skirt: list = field(default_factory=list)

    def peak(self):
        """Number of the step with the largest load."""
        return max(range(len(self.load)), key=self.load.__getitem__)

    def steady(self, quantity):
        """The mean of a quantity over the last seventh of the flight; one that still changes by a tenth says so."""
        last = quantity[len(quantity) * 6 // 7:]
        mean = sum(last) / len(last)
        return Swinging(mean) if max(last) - min(last) > 0.1 * abs(mean) else mean

    def filled(self, width=None):
        """[s] When the canopy first has 97 % of a Dp/D0, that of its end if not given."""
        least = 0.97 * (width or self.steady(self.width))
        return next(t for t, w in zip(self.t, self.width) if w >= least)


GAUGES = {("riser", "tension_sum"): "load", ("canopy", "axial_speed"): "speed",
          ("canopy", "projected_ratio"): "width", ("canopy", "drag_coefficient"): "drag",
          ("canopy", "skirt_diameter"): "skirt"}


def fly(case):
    """Solves a case and reads its gauges; nothing where it does not reach its end."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "case.json"
        network = case["system"]["network"]
        case["output"] = {"frames": {"every": case["time"]["end"]},
                          "gauges": [{"name": "riser", "on": {"group": "riser"}, "of": "tension"}]}
        path.write_text(json.dumps(case))
        done = subprocess.run([program, "solve", path, "--out", f"{folder}/out", "--quiet"], capture_output=True, text=True)
        if done.returncode != 0:
            print(f"{case['name']}: {done.stderr.strip()[:600]}", file=sys.stderr)
            return None
        flight = Flight()
        with open(f"{folder}/out/gauges.csv") as file:
            for t, name, quantity, value in csv.reader(file):
                key = GAUGES.get((name, quantity))
                if key:
                    getattr(flight, key).append(float(value or "nan"))
                    if key == "load":
                        flight.t.append(float(t))
        return flight


def shipped(stem):
    """A shipped parachute: its case, its network, its pattern."""
    case = json.loads((CASES / f"{stem}.json").read_text())
    network = case["system"]["network"]
    return case, network, network["mesh"]["parachute"]


def hold(network, speed):
    """Holds the payload in a stream from below [m/s], without weight: a mass that no load brakes."""
    network["supports"] = [{"on": {"group": "payload"}, "fix": "xyz"}]
    network["gravity"] = [0, 0, 0]
    network.pop("initial")
    network["aero"].pop("drag")
    network["aero"]["wind"] = [0, 0, speed]


# --- rows ---

@dataclass
class Row:
    """A row of a table. `measured` is a number, a band of two, or none."""
    what: str
    measured: object
    ours: float
    digits: int
    source: str
    # inputs of the flight that come from the same measurement
    shared: str = "none"
    # words behind the measured number
    words: str = ""

    def line(self):
        """Of the table."""
        show = lambda value: f"{value:.{self.digits}f}"
        ours = "fails" if self.ours is None else show(self.ours)
        ours += ", swings" if isinstance(self.ours, Swinging) else ""
        if self.measured is None:
            return f"| {self.what} | none found | {ours} | | {self.source} | {self.shared} |"
        low, high = self.measured if isinstance(self.measured, tuple) else (self.measured, self.measured)
        measured = show(low) if low == high else f"{show(low)} to {show(high)}"
        words = f" ({self.words})" if self.words else ""
        ratio = ""
        if self.ours is not None:
            # To the middle of a band; the numbers as they are shown decide whether it is inside.
            ratio = f"{self.ours / (0.5 * (low + high)):.2f}"
            inside = float(show(low)) <= float(show(self.ours)) <= float(show(high))
            ratio += ", inside" if low != high and inside else ""
        return f"| {self.what} | {measured}{words} | {ours} | {ratio} | {self.source} | {self.shared} |"


def table(rows):
    """Markdown."""
    head = ["| case | measured | ours | ratio | source | inputs from it |", "|---|---|---|---|---|---|"]
    return "\n".join(head + [row.line() for row in rows]) + "\n"


# --- plots ---

@dataclass
class Chart:
    """A title, labels of the axes, and lines or dots: name, points, form."""
    title: str
    x: str
    y: str
    lines: list


def ticks(low, high):
    """Round numbers between two."""
    step = 10 ** math.floor(math.log10(high - low))
    step = next(step * f for f in (0.1, 0.2, 0.5, 1, 2) if (high - low) / (step * f) <= 7)
    return [round(i * step, 9) for i in range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1)]


def page(charts, width=480, height=300):
    """Charts as an SVG picture, two in a row."""
    left, right, top, bottom = 52, 14, 30, 44
    rows = -(-len(charts) // 2)
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {2 * width} {rows * height}" font-family="sans-serif" font-size="12">',
           f'<rect width="{2 * width}" height="{rows * height}" fill="white"/>']
    for number, chart in enumerate(charts):
        points = [point for _, of, _ in chart.lines for point in of]
        x0, x1 = min(x for x, _ in points), max(x for x, _ in points)
        y1 = 1.05 * max(y for _, y in points)
        px = lambda x: left + (x - x0) / (x1 - x0) * (width - left - right)
        py = lambda y: height - bottom - y / y1 * (height - top - bottom)
        out.append(f'<g transform="translate({number % 2 * width} {number // 2 * height})">')
        out.append(f'<text x="{left}" y="18" font-weight="bold">{chart.title}</text>')
        for x in ticks(x0, x1):
            out.append(f'<path d="M{px(x):.1f} {top}V{height - bottom}" stroke="#ddd"/>')
            out.append(f'<text x="{px(x):.1f}" y="{height - bottom + 15}" text-anchor="middle">{x:g}</text>')
        for y in ticks(0, y1):
            out.append(f'<path d="M{left} {py(y):.1f}H{width - right}" stroke="#ddd"/>')
            out.append(f'<text x="{left - 5}" y="{py(y) + 4:.1f}" text-anchor="end">{y:g}</text>')
        out.append(f'<text x="{(left + width - right) / 2}" y="{height - 8}" text-anchor="middle">{chart.x}</text>')
        out.append(f'<text transform="translate(13 {(top + height - bottom) / 2}) rotate(-90)" text-anchor="middle">{chart.y}</text>')
        for place, (name, of, form) in enumerate(chart.lines):
            colour = "#1f5fa8" if form == "line" else "#c4450c"
            if form == "line":
                # Every point that a picture of this size can show.
                every = max(1, len(of) // 1000)
                path = "L".join(f"{px(x):.1f} {py(y):.1f}" for x, y in of[::every])
                out.append(f'<path d="M{path}" fill="none" stroke="{colour}" stroke-width="1.6"/>')
            else:
                out += [f'<circle cx="{px(x):.1f}" cy="{py(y):.1f}" r="3" fill="{colour}"/>' for x, y in of]
            if name:
                out.append(f'<text x="{left + 10}" y="{top + 16 + 16 * place}" fill="{colour}">{name}</text>')
        out.append("</g>")
    return "\n".join(out + ["</svg>"]) + "\n"
