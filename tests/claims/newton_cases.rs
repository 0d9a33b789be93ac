//! A sheet for every force term, alone where it is not linear alone, in a state away from all kinks.

use serde_json::{Value, json};

/// A scene, the step that its order is measured in and what ten steps of 10 ms are known to take.
pub struct Trial {
    pub name: &'static str,
    /// [s] so long that three residuals lie between the first guess and rounding
    pub step: f64,
    /// Newton iterations, a digit a step
    pub record: &'static str,
    system: Value,
}

/// Iterations of most sheets.
const TWO_EACH: &str = "2222222222";

impl Trial {
    fn new(name: &'static str, step: f64, system: Value) -> Self {
        Trial { name, step, record: TWO_EACH, system }
    }

    fn recorded(self, record: &'static str) -> Self {
        Trial { record, ..self }
    }

    /// Nine nodes with diagonals, bent out of their plane by up to a fifth of a spring's length.
    pub fn case(&self) -> Value {
        let wave = |i: i32, c: i32| 0.1 * (f64::from(7 * i + 5 * c)).sin();
        let moved: Vec<Value> = (0..9).map(|i| json!([wave(i, 0), wave(i, 1), 2.0 * wave(i, 2)])).collect();
        let velocity: Vec<Value> =
            (0..9).map(|i| json!([5.0 * wave(i, 3), 5.0 * wave(i, 4), 5.0 * wave(i, 5)])).collect();
        let network = json!({
            "mesh": {"rectangle": {"width": 1.0, "height": 1.0, "columns": 2, "rows": 2}},
            "mass": {"nodal": [0.3, 0.35, 0.4, 0.45, 0.5, 0.55, 0.6, 0.65, 0.7]},
            "initial": {"displacement": moved, "velocity": velocity}
        });
        json!({
            "name": "sheet",
            "system": {"network": merged(network, &self.system)},
            "time": {"end": 0.1, "method": "newmark", "step": 0.01}
        })
    }
}

fn merged(mut object: Value, more: &Value) -> Value {
    for (key, value) in more.as_object().into_iter().flatten() {
        object[key] = value.clone();
    }
    object
}

fn springs(rest_scale: f64, more: Value) -> Value {
    json!([merged(json!({"on": "all", "stiffness": 80.0, "rest_scale": rest_scale}), &more)])
}

fn axial() -> Value {
    json!({"axial": {"coefficient": 3.0}})
}

fn relative() -> Value {
    json!({"relative": {"coefficient": 8.0}})
}

fn rayleigh() -> Value {
    json!({"rayleigh": {"mass": 2.0, "stiffness": 0.05}})
}

fn air(law: Value) -> Value {
    json!({"wind": [3.0, -2.0, 25.0], "law": law})
}

fn ergun() -> Value {
    json!({"ergun": {
        "porosity": 0.9, "pore_diameter": 1e-4, "thickness": 1e-4, "air_density": 1.225, "air_viscosity": 1.81e-5
    }})
}

fn follower() -> Value {
    json!([{"on": "all", "pressure": 600.0, "kind": "follower", "table": [[0.0, 1.0], [1.0, 2.0]]}])
}

pub fn trials() -> Vec<Trial> {
    let mut all = of_springs();
    all.extend(of_bars());
    all.extend(of_the_surface());
    all.extend(of_membranes());
    all
}

fn of_springs() -> Vec<Trial> {
    let slack = |rest_scale: f64, slack: Value| json!({"springs": springs(rest_scale, json!({"slack": slack}))});
    let dashpot = |dashpot: Value| json!({"springs": springs(0.5, json!({"dashpot": dashpot}))});
    let clamped = springs(0.3, json!({"dashpot": axial(), "slack": "tension-only"}));
    let taut = springs(0.5, json!({}));
    vec![
        Trial::new("taut springs", 0.05, json!({"springs": taut})).recorded("2222222232"),
        Trial::new("tension-only springs, taut", 0.05, slack(0.5, json!("tension-only"))),
        Trial::new("springs beyond a dead zone", 0.05, slack(0.5, json!({"dead_zone": 0.02}))),
        Trial::new("springs at their compression limit", 0.12, slack(2.0, json!({"compression_limit": 0.1})))
            .recorded("1111111111"),
        Trial::new("springs pushed within their limit", 0.06, slack(1.6, json!({"compression_limit": 2.0})))
            .recorded("2222222332"),
        Trial::new("axial dashpots on springs", 0.05, dashpot(axial())),
        Trial::new("axial dashpots on tension-only springs", 0.05, json!({"springs": clamped})),
        Trial::new("relative dashpots on springs", 0.1, dashpot(relative())).recorded("2222222221"),
        Trial::new("Rayleigh damping on springs", 0.05, json!({"springs": taut, "damping": rayleigh()})),
    ]
}

fn of_bars() -> Vec<Trial> {
    let bars = |law: Value, slack: Value| json!({"springs": [merged(json!({"on": "all", "law": law}), &slack)]});
    let rows = json!([[-0.9, -60.0], [0.0, 0.0], [0.1, 2.0], [2.0, 90.0]]);
    let scaled = |rule: Value, scale: f64| merged(rule, &json!({"rest_scale": scale}));
    let tension = json!({"stiffness": 80.0, "slack": "tension-only", "dashpot": axial()});
    let compression = json!({"stiffness": 80.0, "slack": "compression-only"});
    vec![
        Trial::new("green bars, taut", 0.03, bars(json!("green"), scaled(tension, 0.5))).recorded("3433243222"),
        Trial::new("green bars, pressed", 0.05, bars(json!("green"), scaled(json!({"stiffness": 80.0}), 1.2)))
            .recorded("2222222233"),
        Trial::new("bars by a table", 0.05, bars(json!({"table": rows}), json!({}))).recorded("2222333222"),
        Trial::new("springs that only push", 0.06, bars(json!("linear"), scaled(compression, 1.6)))
            .recorded("2222222333"),
    ]
}

/// States of the sheet as it is moved: taut where it is drawn, else wrinkled and slack beside each other.
fn of_membranes() -> Vec<Trial> {
    let sheet = |more: Value| {
        let rule = merged(json!({"on": "all", "thickness": 1e-3, "modulus": 1e5, "poisson": 0.3}), &more);
        json!({"membranes": [rule]})
    };
    let cloth = json!({"modulus": [1e5, 6e4], "shear": 2e4, "warp": [1, 0.5, 0]});
    let wrinkling = json!({"wrinkling": true});
    let damped = json!({"damping_time": 0.02});
    let bending = json!({"bending": [{"on": "all", "stiffness": 0.5}]});
    vec![
        Trial::new("membrane", 0.05, sheet(json!({}))).recorded("2222333222"),
        Trial::new("orthotropic membrane", 0.05, sheet(cloth.clone())).recorded("2222233322"),
        Trial::new("membrane that wrinkles", 0.05, sheet(wrinkling.clone())).recorded("2222322222"),
        Trial::new("orthotropic membrane that wrinkles", 0.05, sheet(merged(cloth, &wrinkling))).recorded("2221232222"),
        Trial::new("damped membrane", 0.05, sheet(damped.clone())).recorded("2223332222"),
        Trial::new("damped membrane that wrinkles", 0.05, sheet(merged(wrinkling, &damped))).recorded("2223222223"),
        Trial::new("Rayleigh damping on a membrane", 0.05, merged(sheet(json!({})), &json!({"damping": rayleigh()})))
            .recorded("2223322222"),
        Trial::new("membrane with bending", 0.05, merged(sheet(json!({})), &bending)).recorded("2222332222"),
    ]
}

fn of_the_surface() -> Vec<Trial> {
    let dead = json!([
        {"on": "all", "pressure": 60.0, "kind": "dead", "direction": [0, 0.6, 0.8], "table": [[0.0, 1.0], [1.0, 2.0]]},
        {"on": {"ids": [3]}, "force": [5, -4, 3]}
    ]);
    let loaded = json!({"springs": springs(0.5, json!({})), "loads": dead, "gravity": [0, 0, -9.81]});
    let all = json!({
        "springs": [
            {"on": "boundary", "stiffness": 80.0, "rest_scale": 0.3, "dashpot": axial(), "slack": "tension-only"},
            {"on": "all", "stiffness": 60.0, "rest_scale": 0.5, "dashpot": relative()}
        ],
        "aero": air(ergun()), "loads": follower(), "gravity": [0, 0, -9.81], "damping": rayleigh()
    });
    let blown = |law: Value| json!({"springs": [], "aero": air(law)});
    let cp = json!({"pressure_coefficient": {"cp": 1.2, "air_density": 1.225}});
    vec![
        Trial::new("Ergun air", 0.1, blown(ergun())).recorded("2111111111"),
        Trial::new("air by permeability", 0.05, blown(json!({"permeable": {"a": 2e4, "b": 5e2, "thickness": 1e-3}}))),
        Trial::new("air by pressure coefficient", 0.06, blown(cp)),
        Trial::new("follower pressure", 0.05, json!({"springs": [], "loads": follower()})),
        Trial::new("dead pressure, force and gravity on springs", 0.05, loaded).recorded("2222222232"),
        Trial::new("everything at once", 0.05, all),
    ]
}
