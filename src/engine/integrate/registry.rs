//! The table of methods: one entry per scheme. Case files, `canopy-fem methods`, the JSON Schema and the tests all read
//! it, so a scheme is registered here and nowhere else.

use super::backward_euler::BackwardEuler;
use super::beeman::Beeman;
use super::central_difference::CENTRAL_DIFFERENCE;
use super::energy_momentum::EnergyMomentum;
use super::euler_cromer::EULER_CROMER;
use super::generalized_alpha::GeneralizedAlpha;
use super::hht::Hht;
use super::implicit::{Implicit, SolverSpec};
use super::improved_euler_pec::ImprovedEulerPec;
use super::kang::Kang;
use super::linear_step::{LinearStep, Pencil};
use super::multirate::Multirate;
use super::newmark::Newmark;
use super::stage::NewmarkParameters;
use super::stepper::Scheme;
use super::vbd::Vbd;
use super::velocity_verlet::VELOCITY_VERLET;
use super::xpbd::Xpbd;
use super::{dop853, dormand_prince, esdirk4, euler_richardson, explicit_euler, improved_euler, rk4};

mod method;
mod other_names;

pub use method::{Family, MethodChoice, MethodError, MethodInfo, ParameterInfo};
pub use other_names::{OtherName, other_name};

/// All methods, in the order `canopy-fem methods` prints them.
pub fn methods() -> &'static [MethodInfo] {
    METHODS
}

/// The names of all methods that say [what a step is made of](super::form), as derivatives of runs need.
pub fn with_form() -> String {
    let has = |info: &MethodInfo| {
        let defaults: Vec<f64> = info.parameters.iter().map(|p| p.default).collect();
        match (info.build)(&defaults, SolverSpec::default()) {
            Scheme::Explicit(scheme) => scheme.form(1.0, true).is_some(),
            Scheme::Implicit(scheme) => scheme.form(1.0, true).is_some(),
            Scheme::Graph(scheme) => scheme.form(1.0, true).is_some(),
        }
    };
    methods().iter().filter(|info| has(info)).map(|info| info.name).collect::<Vec<_>>().join(", ")
}

static METHODS: &[MethodInfo] = &[
    MethodInfo {
        name: "explicit-euler",
        order: 1,
        order_with: None,
        family: Family::Explicit,
        color: 0,
        evaluations: [1, 1],
        parameters: &[],
        stability: "unstable on undamped oscillations for every step; w h < 2 zeta up to damping ratio zeta = 1",
        linear: LinearStep::PLAIN,
        source: "Euler 1768; thesis Eq. 11-12",
        build: |_, _| explicit_euler::TABLEAU.scheme(),
    },
    MethodInfo {
        name: "euler-cromer",
        order: 1,
        order_with: None,
        family: Family::Explicit,
        color: 3,
        evaluations: [1, 1],
        parameters: &[],
        stability: "w h < 2 undamped, 2 (sqrt(1 + zeta^2) - zeta) damped; symplectic",
        linear: LinearStep { pencil: Some(Pencil::EULER_CROMER), ..LinearStep::PARTITIONED },
        source: "Cromer 1981; thesis Eq. 15-16",
        build: |_, _| Scheme::Explicit(Box::new(EULER_CROMER.scheme())),
    },
    MethodInfo {
        name: "euler-richardson",
        order: 2,
        order_with: None,
        family: Family::Explicit,
        color: 12,
        evaluations: [2, 2],
        parameters: &[],
        stability: "undamped oscillations grow by (w h)^4/8 a step",
        linear: LinearStep::PLAIN,
        source: "midpoint rule; thesis Eq. 17-22",
        build: |_, _| euler_richardson::TABLEAU.scheme(),
    },
    MethodInfo {
        name: "improved-euler",
        order: 2,
        order_with: None,
        family: Family::Explicit,
        color: 6,
        evaluations: [2, 2],
        parameters: &[],
        stability: "undamped oscillations grow by (w h)^4/8 a step",
        linear: LinearStep::PLAIN,
        source: "Heun 1900; thesis Eq. 23-24",
        build: |_, _| improved_euler::TABLEAU.scheme(),
    },
    MethodInfo {
        name: "improved-euler-pec",
        order: 2,
        order_with: None,
        family: Family::Explicit,
        color: 9,
        evaluations: [1, 1],
        parameters: &[],
        stability: "undamped oscillations grow slowly, as with Adams-Bashforth 2; w h < 1 at damping ratio 1",
        linear: LinearStep::PLAIN,
        source: "Hanna 1988; thesis section 2.4.4",
        build: |_, _| Scheme::Explicit(Box::new(ImprovedEulerPec::default())),
    },
    MethodInfo {
        name: "velocity-verlet",
        order: 2,
        order_with: None,
        family: Family::Explicit,
        color: 1,
        evaluations: [1, 2],
        parameters: &[],
        stability: "w h < 2 undamped, 1.84 at damping ratio 0.1; symplectic without damping",
        linear: LinearStep { fixed_velocity: Some(2.0), ..LinearStep::PARTITIONED },
        source: "Swope et al. 1982; thesis Eq. 37-40",
        build: |_, _| Scheme::Explicit(Box::new(VELOCITY_VERLET.scheme())),
    },
    MethodInfo {
        name: "beeman",
        order: 3,
        order_with: None,
        family: Family::Explicit,
        color: 5,
        evaluations: [1, 1],
        parameters: &[],
        stability: "w h < 1.73 undamped, 1.27 at damping ratio 0.1, 0.27 at 1",
        linear: LinearStep::PARTITIONED,
        source: "Beeman 1976",
        build: |_, _| Scheme::Explicit(Box::new(Beeman::default())),
    },
    MethodInfo {
        name: "rk4",
        order: 4,
        order_with: None,
        family: Family::Explicit,
        color: 4,
        evaluations: [4, 4],
        parameters: &[],
        stability: "w h < 2.83 undamped",
        linear: LinearStep::DISSIPATIVE,
        source: "Kutta 1901; thesis Eq. 42-51",
        build: |_, _| rk4::TABLEAU.scheme(),
    },
    MethodInfo {
        name: "dormand-prince",
        order: 5,
        order_with: None,
        family: Family::Explicit,
        color: 7,
        evaluations: [6, 6],
        parameters: &[],
        stability: "w h < 0.997 undamped, growing slowly above; 2.68 at damping ratio 0.1",
        linear: LinearStep::PLAIN,
        source: "Dormand & Prince 1980, RK5(4)7M; Hairer, Norsett & Wanner 1993, Table II.5.2",
        build: |_, _| dormand_prince::TABLEAU.scheme(),
    },
    MethodInfo {
        name: "dop853",
        order: 8,
        order_with: None,
        family: Family::Explicit,
        color: 8,
        evaluations: [12, 12],
        parameters: &[],
        stability: "w h < 5.96 undamped",
        linear: LinearStep::DISSIPATIVE,
        source: "Prince & Dormand 1981; Hairer, Norsett & Wanner 1993, section II.10",
        build: |_, _| dop853::TABLEAU.scheme(),
    },
    MethodInfo {
        name: "newmark",
        order: 2,
        order_with: Some(|p| if p[1] == 0.5 { 2 } else { 1 }),
        family: Family::Implicit,
        color: 2,
        evaluations: [0, 0],
        parameters: &[
            ParameterInfo {
                name: "beta",
                default: 0.25,
                min: 0.0,
                min_included: false,
                max: 0.5,
                whole: false,
                doc: "[-] weight of the new acceleration in the displacement",
            },
            ParameterInfo {
                name: "gamma",
                default: 0.5,
                min: 0.5,
                min_included: true,
                max: 1.0,
                whole: false,
                doc: "[-] weight of the new acceleration in the velocity; above 1/2 it damps and is of order 1",
            },
        ],
        stability: "every step on linear scenes if 2 beta >= gamma; else h/T <= 1/(pi sqrt2 sqrt(gamma - 2 beta))",
        linear: LinearStep { partitioned: |p| p[0] != 0.25 || p[1] != 0.5, linear_only: true, ..LinearStep::PLAIN },
        source: "Newmark 1959; thesis Eq. 25-26",
        build: |p, solver| {
            let parameters = NewmarkParameters { beta: p[0], gamma: p[1] };
            Scheme::Implicit(Box::new(Implicit::new(Newmark(parameters), solver)))
        },
    },
    MethodInfo {
        name: "hht",
        order: 2,
        order_with: None,
        family: Family::Implicit,
        color: 5,
        evaluations: [0, 0],
        parameters: &[ParameterInfo {
            name: "alpha",
            default: -0.1,
            min: -1.0 / 3.0,
            min_included: true,
            max: 0.0,
            whole: false,
            doc: "[-] numerical damping of high frequencies; 0 is Newmark 1/4, 1/2",
        }],
        stability: "every step on linear scenes",
        linear: LinearStep { partitioned: |p| p[0] != 0.0, linear_only: true, ..LinearStep::PLAIN },
        source: "Hilber, Hughes & Taylor 1977, Eq. 1-5",
        build: |p, solver| Scheme::Implicit(Box::new(Implicit::new(Hht { alpha: p[0] }, solver))),
    },
    MethodInfo {
        name: "kang",
        order: 1,
        order_with: None,
        family: Family::MatrixFree,
        color: 10,
        evaluations: [1, 1],
        parameters: &[],
        stability: "every step for springs that stay taut; the air and other forces outside the filter are explicit",
        linear: LinearStep::PARTITIONED,
        source: "Kang, Choi, Cho & Park 2000; thesis Eq. 52-57",
        build: |_, _| Scheme::Graph(Box::new(Kang::default())),
    },
    MethodInfo {
        name: "backward-euler",
        order: 1,
        order_with: None,
        family: Family::Implicit,
        color: 11,
        evaluations: [0, 0],
        parameters: &[],
        stability: "every step; damps everything",
        linear: LinearStep::DISSIPATIVE,
        source: "Baraff & Witkin 1998, here with full Newton iterations",
        build: |_, solver| Scheme::Implicit(Box::new(Implicit::new(BackwardEuler, solver))),
    },
    MethodInfo {
        name: "generalized-alpha",
        order: 2,
        order_with: None,
        family: Family::Implicit,
        color: 13,
        evaluations: [0, 0],
        parameters: &[ParameterInfo {
            name: "rho_inf",
            default: 0.8,
            min: 0.0,
            min_included: true,
            max: 1.0,
            whole: false,
            doc: "[-] spectral radius at infinite frequency; 1 damps nothing",
        }],
        stability: "every step on linear scenes",
        linear: LinearStep { partitioned: |p| p[0] != 1.0, linear_only: true, ..LinearStep::PLAIN },
        source: "Chung & Hulbert 1993, Eq. 15-18, 25",
        build: |p, solver| Scheme::Implicit(Box::new(Implicit::new(GeneralizedAlpha { rho_inf: p[0] }, solver))),
    },
    MethodInfo {
        name: "esdirk4",
        order: 4,
        order_with: None,
        family: Family::Implicit,
        color: 14,
        evaluations: [0, 0],
        parameters: &[],
        stability: "every step on linear scenes; L-stable",
        linear: LinearStep { linear_only: true, ..LinearStep::DISSIPATIVE },
        source: "Kennedy & Carpenter 2003, ARK4(3)6L[2]SA",
        build: |_, solver| esdirk4::scheme(solver),
    },
    MethodInfo {
        name: "central-difference",
        order: 1,
        order_with: None,
        family: Family::Explicit,
        color: 10,
        evaluations: [1, 1],
        parameters: &[],
        stability: "w h < 2 undamped, where it is velocity Verlet; 2 (sqrt(1 + zeta^2) - zeta) damped",
        linear: LinearStep { pencil: Some(Pencil::EULER_CROMER), ..LinearStep::PARTITIONED },
        source: "Belytschko, Liu, Moran & Elkhodary 2014, Box 5.1",
        build: |_, _| Scheme::Explicit(Box::new(CENTRAL_DIFFERENCE.scheme())),
    },
    MethodInfo {
        name: "multirate",
        order: 1,
        order_with: None,
        family: Family::Explicit,
        color: 13,
        evaluations: [2, 2],
        parameters: &[ParameterInfo {
            name: "substeps",
            default: 6.0,
            min: 1.0,
            min_included: true,
            max: 32.0,
            whole: true,
            doc: "[-] short steps of stiff springs in one step",
        }],
        stability: "w h < 2 substeps undamped where springs set the limit; as central-difference where other forces do",
        linear: LinearStep { substeps: |p| p[0], pencil: Some(Pencil::EULER_CROMER), ..LinearStep::PARTITIONED },
        source: "Tuckerman, Berne & Martyna 1992, section II; Neal & Belytschko 1989",
        build: |p, _| Scheme::Explicit(Box::new(Multirate::new(p[0] as u32))),
    },
    MethodInfo {
        name: "energy-momentum",
        order: 2,
        order_with: Some(|p| if p[0] == 0.0 { 2 } else { 1 }),
        family: Family::Implicit,
        color: 0,
        evaluations: [0, 0],
        parameters: &[ParameterInfo {
            name: "dissipation",
            default: 0.0,
            min: 0.0,
            min_included: true,
            max: 1.0,
            whole: false,
            doc: "[-] damping inside of elements; 0 keeps the energy, above it the order is 1",
        }],
        stability: "every step, on nonlinear scenes too: elastic energy is kept, or falls with dissipation",
        linear: LinearStep { partitioned: |p| p[0] != 0.0, ..LinearStep::PLAIN },
        source: "Greenspan 1984; Simo & Tarnow 1992; Gonzalez 1996; Armero & Romero 2001",
        build: |p, solver| Scheme::Implicit(Box::new(EnergyMomentum::new(p[0], solver))),
    },
    MethodInfo {
        name: "xpbd",
        order: 1,
        order_with: None,
        family: Family::MatrixFree,
        color: 4,
        evaluations: [1, 1],
        parameters: &[
            ParameterInfo { name: "substeps", default: 10.0, doc: "[-] short steps in one step", ..WHOLE_NUMBER },
            ParameterInfo {
                name: "iterations",
                default: 1.0,
                doc: "[-] sweeps over all springs in each short step",
                ..WHOLE_NUMBER
            },
        ],
        stability: "every step for springs and their dashpots; all other forces are explicit",
        linear: LinearStep {
            sweeps: |p| p[0] * p[1],
            solves_dashpots: true,
            always_dissipates: true,
            ..LinearStep::PARTITIONED
        },
        source: "Macklin, Mueller & Chentanez 2016, Eq. 18 and 26; Macklin et al. 2019",
        build: |p, _| Scheme::Graph(Box::new(Xpbd::new(p[0] as u32, p[1] as u32))),
    },
    MethodInfo {
        name: "vbd",
        order: 1,
        order_with: None,
        family: Family::MatrixFree,
        color: 1,
        evaluations: [1, 1],
        parameters: &[ParameterInfo {
            name: "iterations",
            default: 20.0,
            doc: "[-] sweeps over all nodes",
            ..WHOLE_NUMBER
        }],
        stability: "every step for springs and their dashpots; all other forces are explicit",
        linear: LinearStep {
            sweeps: |p| p[0],
            solves_dashpots: true,
            always_dissipates: true,
            ..LinearStep::PARTITIONED
        },
        source: "Chen, Liu, Yang & Yuksel 2024, Algorithm 1",
        build: |p, _| Scheme::Graph(Box::new(Vbd::new(p[0] as u32))),
    },
];

/// A number of sweeps or of short steps.
const WHOLE_NUMBER: ParameterInfo =
    ParameterInfo { name: "", default: 1.0, min: 1.0, min_included: true, max: 10_000.0, whole: true, doc: "" };
