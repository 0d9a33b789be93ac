#!/usr/bin/env python3
"""Measured, ours, ratio: flies every set of measurements that we know, and shows each as a row, also where it misses.

    docs/validation.py                   flies all sets (some minutes) and prints them; fails where the guide has other numbers
    docs/validation.py drops falls       these sets only
    docs/validation.py --write           writes tables and plots into docs/guide/src
    docs/validation.py --program PATH    another program than target/release/canopy-fem

Needs the program and Python alone. A set is a function that gives rows; their tables stand in docs/guide/src/validated.md between
marks, the mean of all drops also in the page on air and in docs/limits.md. Measured numbers are facts, typed in beside their
sources. Flights (docs/flights.py) are those of shipped cases with other values.
"""

import argparse
import copy
import math
import sys
from pathlib import Path

import flights
from flights import ROOT, Chart, Row, fly, hold, page, pool, shipped, table

PAGE = ROOT / "docs/guide/src/validated.md"
# Pages that tell the mean and the deviation of all drops.
TOLD = [ROOT / "docs/guide/src/air.md", ROOT / "docs/limits.md"]
PICTURES = ROOT / "docs/guide/src/pictures"
# [m/s^2], [kg/m^3] at sea level, [m]
G, SEA_LEVEL, FOOT = 9.81, 1.225, 0.3048

# --- drops of rescue parachutes ---

# [kg] and [g]: mass, and the largest felt acceleration of each drop. EN 12491 load tests, sessions of 2020-11-11 and 2020-12-21 of
# github.com/fredvol/logger_200hz: an accelerometer on the dummy at 200 Hz, whose single samples of 5 ms count.
DROPS = {80: [11.8, 13.59], 90: [16.74], 100: [11.7, 9.54, 13.1, 13.8], 115: [17.3, 10.89, 15.38], 120: [16.7, 14.49],
         125: [13.7, 17.61, 14.3], 135: [13.1], 140: [10.23], 210: [5.43], 220: [19, 9.8, 9.36, 9.55, 10.72], 230: [12.5, 8.89]}


def rescue(mass, area=0.30, speed=38.0, rows=12, step=2e-3):
    """The shipped rescue parachute for another mass [kg]; its D0 [m] by the cloth for a kilogram [m^2/kg]."""
    case, network, pattern = shipped("rescue-115kg")
    diameter = math.sqrt(4 * area * mass / math.pi)
    pattern.update(nominal_diameter=diameter, vent_diameter=0.05 * diameter, radial_segments=rows)
    pattern["lines"]["length"] = 0.75 * diameter
    network["mass"]["points"][0]["mass"] = mass
    network["initial"]["velocity"] = [0, 0, -speed]
    case["time"].update(step=step, end=0.28 * diameter)
    case["name"] = f"rescue of {mass} kg"
    return case


def felt(case):
    """[g] The largest felt acceleration."""
    flight = fly(case)
    mass = case["system"]["network"]["mass"]["points"][0]["mass"]
    return flight and max(flight.load) / (mass * G)


def of_other_law(mass, law):
    """The same with another law, from a skirt of 0.14 D0."""
    case = rescue(mass)
    network = case["system"]["network"]
    pattern = network["mesh"]["parachute"]
    pattern.pop("start_radius")
    pattern.update(start="inflated", reefing={"diameter": 0.14 * pattern["nominal_diameter"]})
    network["aero"]["canopy"] = {"on": {"group": "canopy"}} | law
    case["time"].update(step=1e-3, end=0.4 * pattern["nominal_diameter"])
    return case


OTHERS = {
    "`schedule` with n 8": {"schedule": {"drag_coefficient": 0.75, "filling_constant": 8, "exponent": 2}},
    "`cavity` with an inflow of 0.4": {"cavity": {"inflow": 0.4, "outer_pressure_coefficient": -0.6}},
    "`table` with dCp 1.74": {"table": {"pressure_coefficient": 1.74}},
}


def drops():
    """Measured and ours by mass, and the mean and spread of ours/measured over all."""
    spread = lambda all: "1 drop" if len(all) == 1 else f"{len(all)} drops, {min(all):.1f} to {max(all):.1f}"
    mean = lambda all: sum(all) / len(all)
    ours = dict(zip(DROPS, pool.map(felt, map(rescue, DROPS))))
    row = lambda how, mass, value: Row(f"{how}, {mass} kg, felt g", mean(DROPS[mass]), value, 1, "fredvol", words=spread(DROPS[mass]))
    rows = [row("`filling`", mass, value) for mass, value in ours.items()]
    ratios = [ours[mass] / g for mass, all in DROPS.items() for g in all if ours[mass]]
    middle = mean(ratios)
    deviation = math.sqrt(mean([(r - middle) ** 2 for r in ratios]))
    within = sum(abs(r - 1) < 0.2 for r in ratios)
    what = f"**`filling`, all {len(ratios)} drops: mean of ours/measured**, standard deviation {deviation:.2f}, {within} within 20 %"
    rows.append(Row(what, 1.0, middle, 2, "fredvol"))
    told = f"Over the {len(ratios)} drops ours over the measured load is {middle:.2f} in the mean, with a standard deviation of {deviation:.2f}. "
    others = [(name, mass) for name, masses in zip(OTHERS, ([80, 115, 220], [115], [115])) for mass in masses]
    cases = [of_other_law(mass, OTHERS[name]) for name, mass in others]
    rows += [row(name, mass, value) for (name, mass), value in zip(others, pool.map(felt, cases))]
    return rows, {path: told for path in TOLD}


def assumptions():
    """What the unknown inputs of the drops move, at 115 kg: ours over ours."""
    changes = {"as above": {}, "34 m/s": {"speed": 34.0}, "40 m/s": {"speed": 40.0}, "0.25 m²/kg": {"area": 0.25},
               "0.40 m²/kg": {"area": 0.40}, "24 rows of cloth": {"rows": 24}, "steps of 1 ms": {"step": 1e-3}}
    ours = list(pool.map(lambda change: felt(rescue(115, **change)), changes.values()))
    rows = [Row(f"115 kg, {name}, felt g", ours[0], g, 2, "ours, as above") for name, g in zip(changes, ours)]
    return rows[1:], {}


# Two of these drops over time: [s] from the peak, felt [g], a few points read from the curves (drop 12 of the first session, one of
# 100 kg of the second).
HISTORIES = {
    80: [(-0.40, 0.8), (-0.35, 1.4), (-0.30, 2.6), (-0.25, 2.9), (-0.20, 3.8), (-0.15, 4.3), (-0.10, 5.2), (-0.06, 7.8), (-0.03, 10.6),
         (0, 11.9), (0.02, 10.3), (0.04, 8.7), (0.06, 4.2), (0.08, 2.5), (0.15, 1.9), (0.25, 1.5)],
    100: [(-0.42, 1.1), (-0.36, 0.6), (-0.30, 1.1), (-0.25, 2.2), (-0.20, 4.1), (-0.15, 4.8), (-0.10, 5.9), (-0.05, 8.1), (-0.02, 10.2),
          (0, 11.7), (0.03, 7.4), (0.05, 10.4), (0.07, 6.3), (0.10, 2.8), (0.20, 2.2), (0.30, 1.5)],
}


def rise(points):
    """[s] From a quarter of the peak to the peak, by straight lines between points."""
    t_peak, peak = max(points, key=lambda point: point[1])
    least = 0.25 * peak
    # The last time that it passes this before the peak: what comes earlier is noise.
    crossings = [(a, b) for a, b in zip(points, points[1:]) if a[1] < least <= b[1] and b[0] <= t_peak]
    (ta, a), (tb, b) = crossings[-1]
    return t_peak - (ta + (tb - ta) * (least - a) / (b - a))


def histories():
    """Two measured histories, and ours beside them from peak to peak."""
    rows, charts = [], []
    for mass, flight in zip(HISTORIES, pool.map(fly, map(rescue, HISTORIES))):
        measured = HISTORIES[mass]
        ours = [(t - flight.t[flight.peak()], load / (mass * G)) for t, load in zip(flight.t, flight.load)]
        rows.append(Row(f"{mass} kg, largest felt g on the curve", max(g for _, g in measured), max(g for _, g in ours), 1, "fredvol"))
        rows.append(Row(f"{mass} kg, from a quarter of the peak to the peak [s]", rise(measured), rise(ours), 2, "fredvol"))
        shown = [point for point in ours if -0.6 <= point[0] <= 0.4]
        charts.append(Chart(f"rescue parachute, {mass} kg", "time from the peak [s]", "felt acceleration [g]",
                            [("ours", shown, "line"), ("measured", measured, "dots")]))
    return rows, {"validated-histories.svg": page(charts)}


# --- canopies in a stream that no load brakes, and a C-9 that brakes ---

# Overshoot Cx, filling constant n, CD0, Dp/D0: T. W. Knacke, Parachute Recovery Systems Design Manual, 1991, tables 5-1, 5-2 and 5-6,
# quoted by way of public codes; Cx 1.5 of a flat canopy of 8.53 m in wind tunnels: J. S. Lingard. Exponents of growth: Ludtke 1972, in
# public codes.
TYPES = {
    "flat, cloth of the C-9": dict(cx=(1.5, 1.7), n=8, j=6, cd=(0.75, 0.80), dp=(0.64, 0.70)),
    "flat, tight": dict(tight=True, cx=(1.5, 1.7), n=8, j=6, cd=(0.75, 0.80), dp=(0.64, 0.70)),
    "extended skirt, cloth of the C-9": dict(pattern={"type": "extended-skirt"}, cx=1.4, n=10, cd=(0.78, 0.87), dp=(0.66, 0.70)),
    "conical, 25 degrees, cloth of the C-9": dict(pattern={"type": "conical", "cone_angle": 0.436}, cx=1.8, cd=(0.75, 0.90), dp=0.70),
    "hemispherical, cloth of the C-9": dict(pattern={"type": "hemispherical"}, by_cd=True, cx=1.6, cd=(0.62, 0.77), dp=0.66),
    "ringsail, slots 0.08": dict(tight=True, slots=0.08, cx=1.10, n=7, cd=(0.75, 0.85)),
    "ringslot, slots 0.18": dict(tight=True, slots=0.18, outer=-0.45, cx=1.05, n=14, cd=(0.56, 0.65), dp=(0.67, 0.70)),
    "ribbon, slots 0.20": dict(tight=True, slots=0.20, outer=-0.3, cx=1.05, n=14, j=1, cd=(0.45, 0.50), dp=0.67),
}
STREAM, STEP = 20.0, 2e-3


def slope(points):
    """Of the straight line of least squares."""
    mx, my = (sum(p[i] for p in points) / len(points) for i in (0, 1))
    return sum((x - mx) * (y - my) for x, y in points) / sum((x - mx) ** 2 for x, _ in points)


def opening(item):
    """Rows of a type, held in a stream of 20 m/s at sea level."""
    name, of = item
    case, network, pattern = shipped("c9-filling")
    case["name"] = name
    pattern.update(of.get("pattern", {}))
    hold(network, STREAM)
    filling = network["aero"]["canopy"]["filling"]
    if of.get("tight"):
        filling.pop("law")
    if "slots" in of:
        filling.update(geometric_porosity=of["slots"])
    if "outer" in of:
        filling.update(outer_pressure_coefficient=of["outer"])
    diameter = pattern["nominal_diameter"]
    case["time"] = {"end": 16 * diameter / STREAM, "method": "newmark", "step": STEP}
    flight = fly(case)
    if flight is None:
        return [Row(f"{name}: Cx", of["cx"], None, 2, "Knacke")]
    steady, filled = flight.steady(flight.load), flight.filled()
    # Means over 10 ms: the springs' own oscillation is no overshoot of the air.
    few = round(10e-3 / STEP)
    most = max(sum(flight.load[i:i + few]) / few for i in range(len(flight.load) - few))
    rows = [Row(f"{name}: Cx", of["cx"], most / steady, 2, "Knacke, Lingard" if isinstance(of["cx"], tuple) else "Knacke")]
    if "n" in of:
        rows.append(Row(f"{name}: n", of["n"], filled * STREAM / diameter, 1, "Knacke"))
    if "j" in of:
        points = [(math.log(t), math.log(load)) for t, load in zip(flight.t, flight.load)
                  if 0.6 * filled < t < 0.95 * filled and load > 1e-3 * steady]
        rows.append(Row(f"{name}: exponent of growth", of["j"], slope(points), 1, "Ludtke"))
    shared = "Cb, by CD0" if "outer" in of or "by_cd" in of else "none"
    rows.append(Row(f"{name}: CD0", of["cd"], flight.steady(flight.drag), 2, "Knacke", shared))
    if "dp" in of:
        rows.append(Row(f"{name}: Dp/D0", of["dp"], flight.steady(flight.width), 2, "Knacke"))
    return rows


def openings():
    """By type."""
    return [row for rows in pool.map(opening, TYPES.items()) for row in rows], {}


def c9():
    """The C-9 with its payload, by speed at line stretch. Full is 0.97 of 0.66 D0: it goes on widening as it slows."""
    def flown(speed):
        case, network, _ = shipped("c9-filling")
        network["initial"]["velocity"] = [0, 0, -speed]
        case["time"]["end"] = 4.0
        return fly(case)
    speeds = [45.0, 60.0, 80.0]
    flights = list(pool.map(flown, speeds))
    diameter = shipped("c9-filling")[2]["nominal_diameter"]
    times = [flight.filled(0.66) for flight in flights]
    rows = [Row(f"C-9, 90.7 kg, {v:g} m/s: n", 8, t * v / diameter, 1, "Knacke", "start radius") for v, t in zip(speeds, times)]
    power = slope([(math.log(v), math.log(t)) for v, t in zip(speeds, times)])
    rows.append(Row("C-9: power of the speed in the filling time", -0.85, power, 2, "Knacke"))
    rows += [Row(f"C-9, {v:g} m/s: peak of the riser [kN]", None, 1e-3 * max(f.load), 2, "") for v, f in zip(speeds, flights)]
    return rows, {}


# --- steady falls ---

def falling(stem, canopy, speed, density=SEA_LEVEL):
    """A shipped parachute near its steady fall [m/s], in calm air of a density [kg/m^3]. A number as the canopy is a CD0."""
    case, network, pattern = shipped(stem)
    pattern["start"] = "inflated"
    pattern.pop("reefing", None)
    pattern.pop("start_radius", None)
    network["springs"] = [rule for rule in network["springs"] if rule["on"] != {"group": "reefing"}]
    network["aero"].update(canopy=even(1.7) if isinstance(canopy, float) else canopy, atmosphere={"density": density})
    for key in ("wind", "altitude"):
        network["aero"].pop(key, None)
    network["initial"]["velocity"] = [0, 0, -speed]
    case.pop("acknowledge", None)
    case["time"] = {"end": 10.0, "method": "backward-euler", "step": 0.01}
    return by_drag(case, canopy) if isinstance(canopy, float) else case


def by_drag(case, coefficient):
    """With the even pressure of a CD0 on the skirt of the open shape, dCp = CD0 S0/A_s."""
    start = copy.deepcopy(case)
    start["time"]["end"] = start["time"]["step"]
    ratio = fly(start).skirt[0] / case["system"]["network"]["mesh"]["parachute"]["nominal_diameter"]
    case["system"]["network"]["aero"]["canopy"] = even(coefficient / ratio**2)
    return case


def even(coefficient):
    """An even pressure."""
    return {"on": {"group": "canopy"}, "table": {"pressure_coefficient": coefficient}}


def cross():
    """A T-11 as a cross with 28 % more area than a T-10, and lines of 0.75 D0: nothing else of its pattern is known."""
    case = falling("t10-drop", even(1.7), 6.0)
    network = case["system"]["network"]
    old = network["mesh"]["parachute"]
    diameter = old["nominal_diameter"] * math.sqrt(1.28)
    network["mesh"]["parachute"] = {
        "type": "cruciform", "nominal_diameter": diameter, "gores": 28, "radial_segments": 14, "arm_ratio": 0.33, "start": "flat",
        "lines": {"length": 0.75 * diameter, "segments": 2}, "riser": old["riser"], "payload": old["payload"]}
    network["springs"] = [rule for rule in network["springs"] if rule["on"]["group"] not in ("vent", "vent-lines")]
    network["mass"]["points"][0]["total"] = 166.0
    return case


def rocket(drag_area, speed, density):
    """A flat canopy with a drag area [m^2] under a rocket of 20.846 kg."""
    case = falling("rescue-115kg", even(1.7), speed, density)
    network = case["system"]["network"]
    diameter = math.sqrt(4 * drag_area / (math.pi * 0.75))
    pattern = network["mesh"]["parachute"]
    pattern.update(nominal_diameter=diameter, vent_diameter=0.05 * diameter, lines={"length": diameter, "segments": 3})
    network["mass"]["points"][0]["mass"] = 20.846
    network["aero"]["drag"] = []
    return by_drag(case, 0.75)


def falls():
    """T-10: Mills Manufacturing's data sheet and Army manuals. T-11: Army briefings, 18 to 19 ft/s with 385 lb. G-12: Knacke 1991. NDRT: a
    rocket of the Notre Dame Rocket Team, slopes of its altimeter, mass and drag areas in RocketPy's data."""
    filling = shipped("c9-filling")[1]["aero"]["canopy"]
    feet = lambda low, high: (low * FOOT, high * FOOT)
    all = [
        ("T-10, 163 kg, `table`", falling("t10-drop", 0.78, 6.5), feet(19, 23), "T-10", "CD0"),
        ("T-10, `filling`, cloth of the C-9", falling("t10-drop", filling, 6.5), feet(19, 23), "T-10", "none"),
        ("G-12, 998 kg, `table`", falling("g12-reefed", 0.75, 8.5), feet(27.5, 28.5), "G-12", "CD0"),
        ("G-12, `filling`, cloth of the C-9", falling("g12-reefed", filling, 8.5), feet(27.5, 28.5), "G-12", "none"),
        ("T-11, 175 kg, a cross, `table` with dCp 1.7", cross(), feet(18, 19), "T-11", "none"),
        ("NDRT 2020 drogue, `table`", rocket(0.4378, 25.0, 1.12), (24.6, 25.6), "RocketPy", "drag area"),
        ("NDRT 2020 main, `table`", rocket(16.05, 5.0, 1.19), (3.9, 5.2), "RocketPy", "drag area"),
    ]
    flights = pool.map(fly, [case for _, case, *_ in all])
    rows = [Row(f"{name} [m/s]", measured, flight and flight.steady(flight.speed), 2, source, shared)
            for (name, _, measured, source, shared), flight in zip(all, flights)]
    return rows, {}


# --- steady drag and width ---

def held(keys, stream=7.0):
    """The C-9 with other keys of its pattern, held in a stream [m/s], at dCp 1.7."""
    case, network, pattern = shipped("c9-filling")
    case["name"] = keys["type"]
    pattern.pop("start_radius")
    pattern.update({"start": "flat", "lines": {"length": D0, "segments": 3}} | keys)
    if keys["type"] in ("cruciform", "square", "triangular"):
        pattern.pop("vent_diameter")
    hold(network, stream)
    network["aero"]["canopy"] = even(1.7)
    lines = next(rule for rule in network["springs"] if rule["on"]["group"] == "lines")
    drop, add = {"annular": (["vent-lines"], ["inner-lines"]), "cruciform": (["vent", "vent-lines"], []),
                 "ringslot": ([], ["rims"]), "disk-gap-band": ([], ["rims"]), "ribbon": ([], ["rims", "verticals"]),
                 "ringsail": ([], ["rims"]), "toroidal": (["vent-lines"], ["inner-lines"]), "square": (["vent", "vent-lines"], []),
                 "triangular": (["vent", "vent-lines"], [])}.get(keys["type"], ([], []))
    network["springs"] = [rule for rule in network["springs"] if rule["on"]["group"] not in drop]
    network["springs"] += [copy.deepcopy(lines) | {"on": {"group": group}} for group in add]
    case["time"] = {"end": 6.0, "method": "backward-euler", "step": 5e-3}
    return case


D0 = 28 * FOOT
# CD0 and Dp/D0. Those of the disk-gap-band are from memory: nothing was found to read.
FORMS = {
    "flat": (dict(type="flat-circular", start="inflated"), (0.75, 0.80), (0.64, 0.70)),
    "conical, 25 degrees": (dict(type="conical", cone_angle=0.436), (0.75, 0.90), 0.70),
    "extended skirt": (dict(type="extended-skirt", start="inflated"), (0.78, 0.87), (0.66, 0.70)),
    "hemispherical": (dict(type="hemispherical"), (0.62, 0.77), 0.66),
    "cross": (dict(type="cruciform", arm_ratio=0.33), (0.60, 0.85), (0.66, 0.72)),
    "ringslot, slots 0.16": (dict(type="ringslot", rings=4, slot_porosity=0.16), (0.56, 0.65), (0.67, 0.70)),
    "disk-gap-band": (dict(type="disk-gap-band", lines={"length": 1.7 * D0, "segments": 3}), (0.52, 0.58), 0.65),
    "annular, vent 0.4 D0, inner lines as long as lines":
        (dict(type="annular", vent_diameter=0.4 * D0, inner_lines={"length": D0}), (0.85, 0.95), 0.94),
    # The maker's Cd of 1.5 to 1.6 on the skirt's circle, which is S0/1.615 at this height.
    "elliptical, height 0.7": (dict(type="elliptical", height_ratio=0.7), (0.93, 0.99), None),
    "toroidal, vent 0.15 D0, inner lines as long as lines":
        (dict(type="toroidal", vent_diameter=0.15 * D0, inner_lines={"length": D0}), None, None),
    "ribbon, slots 0.20, 2 verticals":
        (dict(type="ribbon", rings=8, slot_porosity=0.20, verticals=2, gore_segments=3), (0.45, 0.50), 0.67),
    "ribbon, cone of 20 degrees, slots 0.20":
        (dict(type="ribbon", rings=8, slot_porosity=0.20, cone_angle=0.349, verticals=1, gore_segments=2), (0.50, 0.55), None),
    "ringsail, slots 0.07":
        (dict(type="ringsail", rings=8, sails=5, slot_porosity=0.07, fullness=0.1, gore_segments=2), (0.75, 0.85), None),
    "square, corners cut at 0.08": (dict(type="square", corner_cut=0.08), None, None),
    "triangular, corners cut at 0.12": (dict(type="triangular", corner_cut=0.12, gores=27), None, None),
}
# Sources of forms that are not in Knacke's tables as they were read.
READ_ELSEWHERE = {"disk-gap-band": "not verified", "elliptical, height 0.7": "maker, by OpenRocket's data file"}


def forms():
    """CD0 and Dp/D0 by type, at one pressure coefficient for all."""
    rows = []
    for (name, (_, cd, dp)), flight in zip(FORMS.items(), pool.map(fly, [held(keys) for keys, *_ in FORMS.values()])):
        source = lambda measured: READ_ELSEWHERE.get(name, "Knacke") if measured else ""
        rows.append(Row(f"{name}: CD0", cd, flight and flight.steady(flight.drag), 2, source(cd)))
        rows.append(Row(f"{name}: Dp/D0", dp, flight and flight.steady(flight.width), 2, source(dp)))
    return rows, {}


def lines():
    """CD0 of a flat canopy by the length of its lines. Wind tunnel of a student's UAV (tailieusinhvien.net 9580): it grows with this
    length, about 0.85 above 6 m/s."""
    lengths = [0.6, 0.8, 1.0, 1.5]
    cases = [held(dict(type="flat-circular", start="inflated", lines={"length": share * D0, "segments": 3})) for share in lengths]
    rows = [Row(f"flat, lines of {share} D0: CD0", 0.85, flight and flight.steady(flight.drag), 2, "UAV tunnel", words="grows with it")
            for share, flight in zip(lengths, pool.map(fly, cases))]
    return rows, {}


# --- loads over time ---

def loads():
    """The riser of four parachutes that fill by themselves. Of the rescue parachute's load alone there is a measurement."""
    def refilled(stem, end):
        case, network, pattern = shipped(stem)
        pattern["start"] = "stretched"
        network["aero"]["canopy"] = shipped("c9-filling")[1]["aero"]["canopy"]
        case.pop("acknowledge", None)
        case["time"].update(step=2e-3, end=end)
        return case
    t10 = refilled("t10-drop", 4.0)
    t10["system"]["network"]["mesh"]["parachute"].pop("reefing")
    (nine, *_), (rescued, *_) = shipped("c9-filling"), shipped("rescue-115kg")
    nine["time"]["end"] = rescued["time"]["end"] = 4.0
    all = {"C-9, 90.7 kg, 45 m/s": nine, "T-10, 155 kg, 40 m/s, cloth of the C-9": t10, "rescue parachute, 115 kg, 38 m/s, tight": rescued,
           "G-12, 998 kg, 60 m/s, reefed until 4 s, cloth of the C-9": refilled("g12-reefed", 9.0)}
    rows, charts = [], []
    for name, flight in zip(all, pool.map(fly, all.values())):
        at = flight and f", at {flight.t[flight.peak()]:.2f} s"
        # The mean of three drops.
        measured = 1e-3 * sum(DROPS[115]) / 3 * 115 * G if "rescue" in name else None
        what = f"{name}: largest load [kN]{at or ''}"
        rows.append(Row(what, measured, flight and 1e-3 * max(flight.load), 2, "fredvol" if measured else ""))
        if flight:
            charts.append(Chart(name, "time from line stretch [s]", "riser [kN]",
                                [("", [(t, 1e-3 * load) for t, load in zip(flight.t, flight.load)], "line")]))
    return rows, {"validated-loads.svg": page(charts)}


def between(text, name, new):
    """A text with something new between the marks of a name; exits where it has none."""
    start, end = f"<!-- validation: {name} -->", f"<!-- validation: end of {name} -->"
    before, mark, rest = text.partition(start)
    _, closing, after = rest.partition(end)
    if not (mark and closing):
        sys.exit(f"no marks of {name}")
    return f"{before}{start}{new}{end}{after}"


SETS = dict(drops=drops, assumptions=assumptions, histories=histories, openings=openings, c9=c9, falls=falls, forms=forms, lines=lines,
            loads=loads)


def main():
    parser = argparse.ArgumentParser(description="Flies every set of measurements that we know.")
    parser.add_argument("sets", nargs="*", help=f"of {', '.join(SETS)}; all if not given")
    parser.add_argument("--write", action="store_true", help="write tables and plots into the guide")
    parser.add_argument("--program", type=Path, default=flights.program, help="the program")
    given = parser.parse_args()
    flights.program = given.program
    unknown = [name for name in given.sets if name not in SETS]
    if unknown or not flights.program.exists():
        sys.exit(f"no such set: {unknown}" if unknown else "build the program first: cargo build --release")
    other = []
    for name in given.sets or SETS:
        rows, more = SETS[name]()
        text = table(rows)
        print(f"\n{name}\n\n{text}", flush=True)
        page_text = PAGE.read_text()
        files = {PAGE: between(page_text, name, f"\n\n{text}\n")}
        for file, content in more.items():
            files[PICTURES / file] = between(file.read_text(), name, content) if file in TOLD else content
        if any(not path.exists() or path.read_text() != content for path, content in files.items()):
            other.append(name)
        for path, content in files.items() if given.write else []:
            path.write_text(content)
    if other and not given.write:
        sys.exit(f"{PAGE.name} has other numbers of {', '.join(other)}: --write replaces them")


if __name__ == "__main__":
    main()
