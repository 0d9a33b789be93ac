"""A first canopy: a net of springs between two rings, held outside, in the wind of 30 m/s."""

import numpy as np

import canopy_fem as cf

case = cf.Case(
    {
        "name": "first-canopy",
        "system": {
            "network": {
                "mesh": {"annulus": {"inner_radius": 0.1, "outer_radius": 1.0, "nodes": 300, "boundary_nodes": 80}},
                "mass": {"areal_density": 0.06},
                "springs": [{"on": "all", "stiffness": 5000.0, "dashpot": {"relative": {"time": 0.001}}}],
                "supports": [{"on": "outer", "fix": "xyz"}],
                "gravity": [0, 0, -9.81],
                "aero": {
                    "wind": [0, 0, 30.0],
                    "law": {"pressure_coefficient": {"cp": 1.2, "air_density": 1.225}},
                },
            }
        },
        "time": {"end": 0.5, "method": "newmark", "step": 1e-3},
        "output": {"frames": {"every": 0.05}, "fields": ["tension"]},
    }
)
report = cf.check(case)
print(f"{case}: {report['unknowns']} unknowns")

result = cf.run(case)
print(result)
print(f"energy error {result.summary['energy_error']:.1e} of the largest energy exchanged")

sim = cf.Simulation(case)
rim = sim.select("outer")
while sim.time < sim.end - 1e-9:
    sim.advance(0.1)
    height = sim.positions[:, 2].max()
    print(f"t {sim.time:.1f} s  height {height:.3f} m  pull at the rim {-sim.reactions[rim, 2].sum():.0f} N")
assert np.nanmax(sim.tension) > 0
