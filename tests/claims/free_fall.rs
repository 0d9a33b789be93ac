//! A porous cloth falling flat through still air, held flat: nothing else would keep a free one from tumbling.
//! Per area s v' = s g - e (A v + B v^2) with Ergun's A and B, a Riccati equation:
//! with v1 > 0 > v2 the roots of v' = 0, v = v1 (1 - E)/(1 - (v1/v2) E), E = exp(-(e B/s) (v1 - v2) t).

use crate::claim::Claim;
use crate::common::run::{case_of, changed, follow};
use serde_json::{Value, json};

/// [kg/m^2]
const DENSITY: f64 = 0.05;
/// [m/s^2]
const G: f64 = 9.81;
/// [-], [m], [m], [kg/m^3], [Pa s] of the cloth and the air
const AIR: Ergun = Ergun { porosity: 0.9, pore: 1e-3, thickness: 1e-4, density: 1.225, viscosity: 1.81e-5 };

struct Ergun {
    porosity: f64,
    pore: f64,
    thickness: f64,
    density: f64,
    viscosity: f64,
}

struct Fall {
    v1: f64,
    v2: f64,
    /// [1/s]
    rate: f64,
}

impl Fall {
    /// Ergun 1952, Eq. 10, with the superficial velocity.
    fn of(e: &Ergun) -> Self {
        let solid = 1.0 - e.porosity;
        let a = 150.0 * e.viscosity * solid.powi(2) / (e.pore.powi(2) * e.porosity.powi(3));
        let b = 1.75 * e.density * solid / (e.pore * e.porosity.powi(3));
        let (a, b) = (e.thickness * a / DENSITY, e.thickness * b / DENSITY);
        let root = (a * a + 4.0 * b * G).sqrt();
        Fall { v1: (root - a) / (2.0 * b), v2: (-root - a) / (2.0 * b), rate: root }
    }

    fn speed(&self, t: f64) -> f64 {
        let e = (-self.rate * t).exp();
        self.v1 * (1.0 - e) / (1.0 - self.v1 / self.v2 * e)
    }
}

fn cloth() -> Value {
    json!({
        "name": "fall",
        "system": {"network": {
            "mesh": {"rectangle": {"width": 1.0, "height": 1.0, "columns": 4, "rows": 4}},
            "mass": {"areal_density": DENSITY},
            "springs": [],
            "supports": [{"on": "all", "fix": "xy"}],
            "gravity": [0, 0, -G],
            "aero": {"wind": [0, 0, 0], "law": {"ergun": {
                "porosity": AIR.porosity, "pore_diameter": AIR.pore, "thickness": AIR.thickness,
                "air_density": AIR.density, "air_viscosity": AIR.viscosity
            }}}
        }},
        "time": {"end": 1.0, "method": "rk4", "step": 0.0005}
    })
}

/// [-] Share of the terminal speed by which `method` is off at worst, and its last speed over the terminal one.
fn error(method: &str, end: f64, step: f64) -> (f64, f64) {
    let fall = Fall::of(&AIR);
    let sets = [("time.method", method), ("time.end", &end.to_string()), ("time.step", &step.to_string())];
    let (mut worst, mut last) = (0.0_f64, 0.0);
    follow(&changed(&case_of(&cloth(), &[]), &sets), |seen| {
        for v in seen.velocities {
            worst = worst.max((-v[2] - fall.speed(seen.t)).abs() / fall.v1);
            last = -v[2] / fall.v1;
        }
    });
    (worst, last)
}

pub fn claims() -> Vec<Claim> {
    let fall = Fall::of(&AIR);
    // [s] the cloth's own time; steps are a share of it
    let tau = 1.0 / fall.rate;
    let mut claims = Vec::new();
    // Error of a scheme of order p at h/tau = 0.02, with constants below 1.
    for (method, tolerance) in [
        ("rk4", 1e-9),
        ("esdirk4", 1e-9),
        ("beeman", 4e-6),
        ("velocity-verlet", 4e-5),
        ("euler-richardson", 4e-5),
        ("improved-euler", 4e-5),
        ("improved-euler-pec", 4e-5),
        ("newmark", 4e-5),
        ("hht", 4e-5),
        ("generalized-alpha", 4e-5),
        ("energy-momentum", 4e-5),
        ("explicit-euler", 4e-3),
        ("euler-cromer", 4e-3),
        ("central-difference", 4e-3),
        ("multirate", 4e-3),
        ("kang", 4e-3),
        ("xpbd", 4e-3),
        ("vbd", 4e-3),
        ("backward-euler", 4e-3),
    ] {
        let (worst, _) = error(method, 10.0 * tau, 0.02 * tau);
        claims.push(Claim::below(
            format!("{method}: speed of fall, h = tau/50, worst error over the terminal speed"),
            worst,
            tolerance,
        ));
        // Twenty times tau leaves exp(-20) of the way; every scheme has the same rest point.
        let (_, last) = error(method, 30.0 * tau, 0.2 * tau);
        claims.push(Claim::absolute(
            format!("{method}: speed reached over the terminal speed {:.2} m/s", fall.v1),
            last,
            1.0,
            1e-9,
        ));
    }
    claims
}
