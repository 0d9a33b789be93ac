"""A C-9 parachute opens, with and without a gust from below of 6 m/s: the load in the riser."""

from pathlib import Path

import canopy_fem as cf

C9 = Path(__file__).resolve().parents[2] / "assets" / "cases" / "parachute" / "c9-drop.json"
GUST = {"gust": {"velocity": [0, 0, 6.0], "start": 0.6, "duration": 0.8}}

calm = cf.Case(C9, {"time.end": 1.5})
gusty = calm.with_overrides({"system.network.aero.wind": GUST})

for name, case in (("calm", calm), ("gust", gusty)):
    result = cf.run(case)
    t, tension = result.gauge("riser", "tension_max")
    print(f"{name}: {tension.max():.0f} N at t = {t[tension.argmax()]:.3f} s; at the end {tension[-1]:.0f} N")
