//! Parachutes of the field, from Taylor's shape near their steady speed to their steady fall in the standard
//! atmosphere, with their own weight, their apparent mass, and the drag of lines and payload. The pressure coefficient
//! is that of the drag coefficient CD0 on Taylor's skirt, dCp = CD0 S0/A_s. Shape, drag and speed are what the run
//! makes of it: the weight of the cloth and the stretch of radials and lines widen the skirt by some 2 %.
//!
//! CD0 and Dp/D0: T. W. Knacke, Parachute Recovery Systems Design Manual, 1991, tables 5-1 and 5-2. The T-10: Mills
//! Manufacturing's data sheet, 360 lb at 22 ft/s; 19 to 23 ft/s by weight and density. The G-12: 2,200 lb at 28 ft/s.
//! Of the C-9 we know no measured speed; it must lie between those of the drag coefficients.

use crate::claim::Claim;
use crate::common::run::case_of;
use crate::parachute::standard_density;
use canopy_fem::case::Case;
use canopy_fem::case::spec::SystemSpec;
use canopy_fem::model::spec::NetworkSpec;
use canopy_fem::simulation::Simulation;
use nalgebra::Vector3;
use serde_json::{Value, json};
use std::f64::consts::PI;

type Vector = Vector3<f64>;

/// [m/s^2]
const G: f64 = 9.81;
/// [kg/m^3] at sea level
const SEA_LEVEL: f64 = 1.225;
/// [m] height at the start
const ALTITUDE: f64 = 100.0;
/// [m^2] drag area of the payload
const PAYLOAD: f64 = 0.3;
/// [m] and [-] diameter of the lines, and their drag coefficient on the speed across them
const LINE: [f64; 2] = [0.004, 1.1];
/// [s]
const END: f64 = 8.0;
/// [m]
const FOOT: f64 = 0.3048;

struct Parachute {
    name: &'static str,
    kind: &'static str,
    /// [m] D0
    nominal_diameter: f64,
    gores: usize,
    /// [m]
    vent_diameter: f64,
    /// [m] length of the lines
    lines: f64,
    /// [kg/m]
    line_density: f64,
    /// [kg/m^2]
    cloth: f64,
    /// [kg]
    payload: f64,
    /// [-] CD0
    drag_coefficient: f64,
    /// [m/s] steady speeds at sea level
    speeds: [f64; 2],
    /// [-] Dp/D0
    projected: [f64; 2],
}

const PARACHUTES: [Parachute; 3] = [
    Parachute {
        name: "C-9, 90.7 kg with its own weight",
        kind: "flat-circular",
        nominal_diameter: 28.0 * FOOT,
        gores: 28,
        vent_diameter: 0.85,
        lines: 0.9 * 28.0 * FOOT,
        line_density: 0.0066,
        cloth: 0.0534,
        payload: 86.2,
        drag_coefficient: 0.75,
        // CD0 0.80 and 0.75
        speeds: [5.633, 5.818],
        projected: [0.64, 0.70],
    },
    Parachute {
        name: "T-10, 163.3 kg suspended",
        kind: "extended-skirt",
        nominal_diameter: 35.0 * FOOT,
        gores: 30,
        vent_diameter: 20.0 * FOOT / 12.0,
        lines: 25.5 * FOOT,
        line_density: 0.0056,
        cloth: 0.0373,
        payload: 163.3,
        drag_coefficient: 0.78,
        speeds: [19.0 * FOOT, 23.0 * FOOT],
        projected: [0.66, 0.70],
    },
    Parachute {
        name: "G-12, 998 kg suspended",
        kind: "flat-circular",
        nominal_diameter: 64.0 * FOOT,
        gores: 64,
        vent_diameter: 1.9,
        lines: 0.8 * 64.0 * FOOT,
        line_density: 0.0066,
        cloth: 0.0542,
        payload: 998.0,
        drag_coefficient: 0.75,
        // 28 ft/s, to a whole number
        speeds: [27.5 * FOOT, 28.5 * FOOT],
        projected: [0.64, 0.70],
    },
];

impl Parachute {
    /// [m^2] CD0 S0
    fn drag_area(&self) -> f64 {
        self.drag_coefficient * 0.25 * PI * self.nominal_diameter.powi(2)
    }

    /// A fall in the air of its canopy.
    fn case(&self, pressure_coefficient: f64, speed: f64) -> Case {
        let aero = json!({
            "atmosphere": "isa", "altitude": ALTITUDE,
            "canopy": {"on": {"group": "canopy"}, "apparent_mass": 1.0,
                       "table": {"pressure_coefficient": pressure_coefficient}},
            "drag": [
                {"on": {"group": "lines"}, "diameter": LINE[0], "coefficient": LINE[1]},
                {"on": {"group": "payload"}, "drag_area": PAYLOAD}
            ]
        });
        self.case_in(&aero, speed)
    }

    /// A fall with `speed` [m/s] at the start.
    fn case_in(&self, aero: &Value, speed: f64) -> Case {
        let dashpot = json!({"relative": {"time": 1e-3}});
        let tape = |group: &str, density: f64| {
            json!({"on": {"group": group}, "axial_rigidity": 8e3, "linear_density": density, "slack": "tension-only",
                   "dashpot": dashpot})
        };
        let json = json!({
            "name": "descent",
            "system": {"network": {
                "mesh": {"parachute": {
                    "type": self.kind, "nominal_diameter": self.nominal_diameter, "gores": self.gores,
                    "vent_diameter": self.vent_diameter, "radial_segments": 12,
                    "lines": {"length": self.lines, "segments": 4}, "start": "inflated"
                }},
                "mass": {"areal_density": self.cloth, "points": [{"on": {"group": "payload"}, "mass": self.payload}]},
                "springs": [
                    tape("radials", 0.0), tape("lines", self.line_density), tape("vent-lines", self.line_density),
                    {"on": {"group": "cloth"}, "membrane": {"modulus": 4.309e8, "thickness": 1e-4},
                     "slack": "tension-only", "dashpot": dashpot}
                ],
                "gravity": [0, 0, -G],
                "aero": aero,
                "initial": {"velocity": [0, 0, -speed]}
            }},
            "time": {"end": END, "method": "backward-euler", "step": 0.01}
        });
        case_of(&json, &[])
    }

    fn claims(&self) -> Vec<Claim> {
        let start = Shape::of(network(&self.case(1.0, 1.0)), None);
        let guess = (2.0 * self.payload * G / (SEA_LEVEL * self.drag_area())).sqrt();
        let case = self.case(self.drag_area() / start.mouth, guess);
        let network = network(&case);
        let mut simulation = Simulation::from_case(case.problem(), 1).expect("it starts");
        let payload = network.mesh.groups["payload"].nodes[0] as usize;
        let mut fall = |t: f64| {
            simulation.run_until(t).unwrap_or_else(|error| panic!("{}: {error}", self.name));
            let (positions, speed) = (simulation.positions(), -simulation.velocities()[payload][2]);
            let skirt = Shape::of(network, Some(&positions));
            let density = standard_density(ALTITUDE + skirt.height);
            (skirt, density, speed * (density / SEA_LEVEL).sqrt())
        };
        let (_, _, before) = fall(END - 2.0);
        let (skirt, density, speed) = fall(END);
        // Lines across the wind by the half cone angle: the square of the speed across them, and its share of the axis.
        let lean = (skirt.diameter / 2.0 / self.lines).powi(3);
        let lines = self.gores as f64 * LINE[0] * LINE[1] * self.lines * lean;
        let weight = network.mass.iter().sum::<f64>() * G;
        let expected = (2.0 * weight / (SEA_LEVEL * (self.drag_area() + PAYLOAD + lines))).sqrt();
        let [slow, fast] = self.speeds;
        let [narrow, wide] = self.projected;
        let name = self.name;
        vec![
            Claim::relative(format!("{name}: steady, speed at sea level 2 s before [m/s]"), before, speed, 3e-4),
            Claim::relative(format!("{name}: sqrt(2 W/(rho (CD0 S0 + others))) [m/s]"), speed, expected, 0.01),
            Claim::between(format!("{name}: speed at sea level [m/s] in the field"), speed, slow, fast),
            Claim::relative(format!("{name}: skirt of Taylor's shape [m]"), skirt.diameter, start.diameter, 0.025),
            Claim::between(format!("{name}: Dp/D0"), skirt.widest / self.nominal_diameter, narrow, wide),
            Claim::between(format!("{name}: density there [kg/m^3]"), density, 1.213, SEA_LEVEL),
        ]
    }
}

fn network(case: &Case) -> &NetworkSpec {
    match &case.problem().system {
        SystemSpec::Network(network) => network,
        SystemSpec::Pendulum(_) => panic!("a network"),
    }
}

/// A canopy's shape.
struct Shape {
    /// [m] height of the skirt
    height: f64,
    /// [m] mean diameter of the skirt
    diameter: f64,
    /// [m^2] area of the polygon of the skirt's corners
    mouth: f64,
    /// [m] largest diameter
    widest: f64,
}

impl Shape {
    /// At `positions`, or at the start.
    fn of(network: &NetworkSpec, positions: Option<&[[f64; 3]]>) -> Self {
        let at = |node: usize| match positions {
            Some(positions) => Vector::from(positions[node]),
            None => Vector::from(network.mesh.nodes[node]) + Vector::from(network.displacement[node]),
        };
        let corners: Vec<Vector> = network.mesh.groups["skirt"].nodes.iter().map(|&node| at(node as usize)).collect();
        let n = corners.len() as f64;
        let middle = corners.iter().sum::<Vector>() / n;
        let from_axis = |place: &Vector| (place - middle).xy().norm();
        let cloth = network.mesh.triangles.iter().flatten().map(|&node| from_axis(&at(node as usize)));
        let next = corners.iter().skip(1).chain(corners.first());
        let mouth = corners.iter().zip(next).map(|(a, b)| 0.5 * (a - middle).xy().perp(&(b - middle).xy())).sum();
        Shape {
            height: middle.z,
            diameter: 2.0 * corners.iter().map(from_axis).sum::<f64>() / n,
            mouth,
            widest: 2.0 * cloth.fold(0.0, f64::max),
        }
    }
}

pub fn claims() -> Vec<Claim> {
    PARACHUTES.iter().flat_map(Parachute::claims).collect()
}

/// What the warnings of laws of a free stream warn of, on the C-9 that falls at 5.8 m/s in the air of its canopy: a
/// pressure coefficient lets it close, and cloth that lets so little air through holds it far too well.
pub fn free_stream() -> Vec<Claim> {
    let [c9, ..] = &PARACHUTES;
    let fall = |law: Value| {
        let case = c9.case_in(&json!({"law": law}), 5.8);
        let mut simulation = Simulation::from_case(case.problem(), 1).expect("it starts");
        simulation.run_until(END).expect("it falls");
        let network = network(&case);
        let payload = network.mesh.groups["payload"].nodes[0] as usize;
        let diameter = Shape::of(network, Some(&simulation.positions())).diameter;
        (-simulation.velocities()[payload][2], diameter / c9.nominal_diameter)
    };
    let (fast, closed) = fall(json!({"pressure_coefficient": {"cp": 1.2, "air_density": 1.225}}));
    let (slow, _) = fall(json!({"permeable": {"a": 1.599e6, "b": 4.805e5, "thickness": 1e-4}}));
    vec![
        Claim::below("pressure coefficient 1.2: skirt over D0 after 8 s", closed, 0.2),
        Claim::between("pressure coefficient 1.2: speed after 8 s [m/s]", fast, 20.0, 60.0),
        Claim::between("measured permeability: speed after 8 s [m/s]", slow, 0.1, 1.0),
    ]
}
