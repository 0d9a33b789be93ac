//! Equilibria: sheets that hang, and ropes.

use crate::row::{by_lu, case_of, with_slack, within};
use canopy_fem::model::stop::Stop;
use canopy_fem::simulation::build_scene;
use canopy_fem::solve::LinearChoice;
use canopy_fem::statics::{self, StaticSpec};
use serde_json::{Value, json};

const LAWS: [&str; 2] = ["both ways", "tension-only"];

/// What a search has found.
struct Found {
    iterations: u64,
    /// factorisations by LU, for a table
    lu: String,
    /// [m] lowest height
    lowest: f64,
    failure: Option<String>,
}

/// Searches as `canopy-fem static` does. Returns a table's cell, and the lowest height [m] if there is an equilibrium.
fn search(json: &Value) -> (String, Option<f64>) {
    let case = case_of(json);
    let found = within(move |stop| {
        let scene = build_scene(case.problem().system.clone(), 1).unwrap_or_else(|fault| panic!("{fault}"));
        let linear = LinearChoice::Auto;
        let spec = StaticSpec { at: 0.0, relative: 1e-8, max_iterations: 10_000, load_steps: 1, linear };
        let found = statics::find(&*scene, spec, Stop::on(stop));
        let lowest = found.point.state.x.iter().skip(2).step_by(3).fold(f64::INFINITY, |least, z| least.min(*z));
        let failure = found.failure.map(|failure| failure.to_string());
        let lu = by_lu(found.counters.lu_factorizations);
        Found { iterations: found.counters.newton_iterations, lu, lowest, failure }
    });
    match found {
        None => ("**stuck**".to_owned(), None),
        Some((Found { iterations, lu, lowest, failure: None }, s)) => {
            (format!("{iterations}{lu}, {s:.2} s"), Some(lowest))
        }
        Some((Found { iterations, lu, failure: Some(words), .. }, s)) => {
            (format!("**{words}** ({iterations}{lu}, {s:.1} s)"), None)
        }
    }
}

/// A flat sheet of 1 m by 1 m and 0.2 kg/m2.
fn sheet(cells: u32, stiffness: f64, law: &str, held: &str) -> Value {
    let corner = |x: f64, y: f64| json!({"box": [[x - 1e-9, y - 1e-9, -1], [x + 1e-9, y + 1e-9, 1]]});
    let on = match held {
        "one side" => vec![json!({"box": [[-1e-9, -1e-9, -1], [1e-9, 1.000001, 1]]})],
        "two corners" => vec![corner(0.0, 0.0), corner(0.0, 1.0)],
        "four corners" => [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0)].map(|(x, y)| corner(x, y)).to_vec(),
        _ => vec![json!("boundary")],
    };
    let supports: Vec<Value> = on.into_iter().map(|on| json!({"on": on, "fix": "xyz"})).collect();
    json!({
        "name": "hanging-sheet", "acknowledge": ["areal-density"],
        "system": {"network": {
            "mesh": {"rectangle": {"width": 1.0, "height": 1.0, "columns": cells, "rows": cells}},
            "mass": {"areal_density": 0.2},
            "springs": [with_slack(json!({"on": "all", "stiffness": stiffness}), law)],
            "supports": supports, "gravity": [0, 0, -9.81]}},
        "time": {"end": 1.0, "step": 0.01, "method": "newmark"}})
}

/// A rope of 1 m between supports that are `1 - slack` apart, straight at the start.
fn rope(links: u32, axial_rigidity: f64, slack: f64, law: &str) -> Value {
    let nodes: Vec<[f64; 3]> =
        (0..=links).map(|i| [(1.0 - slack) * f64::from(i) / f64::from(links), 0.0, 0.0]).collect();
    let springs: Vec<[u32; 2]> = (0..links).map(|i| [i, i + 1]).collect();
    let rule = json!({"on": "all", "axial_rigidity": axial_rigidity, "rest_length": 1.0 / f64::from(links),
        "linear_density": DENSITY});
    json!({
        "name": "rope",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": nodes, "springs": springs}}, "springs": [with_slack(rule, law)],
            "supports": [{"on": {"ids": [0, links]}, "fix": "xyz"}], "gravity": [0, 0, -9.81]}},
        "time": {"end": 1.0, "step": 0.01, "method": "newmark"}})
}

/// [kg/m] of the span
const DENSITY: f64 = 0.1;

/// [m] Sag of an elastic catenary of unstretched length 1 m (Irvine 1981): span = H/EA + 2 H/w asinh(w/2H), which grows
/// with H, and sag = w/8EA + H/w (sqrt(1 + (w/2H)^2) - 1).
fn catenary_sag(span: f64, axial_rigidity: f64) -> f64 {
    let weight = 9.81 * DENSITY * span;
    let (mut low, mut high) = (1e-9_f64, 1e9_f64);
    for _ in 0..200 {
        let h = (low * high).sqrt();
        if h / axial_rigidity + 2.0 * h / weight * (0.5 * weight / h).asinh() < span {
            low = h;
        } else {
            high = h;
        }
    }
    let u = 0.5 * weight / low;
    // sqrt(1 + u^2) - 1 without the digits that cancel
    weight / (8.0 * axial_rigidity) + low / weight * u * u / (1.0 + (1.0 + u * u).sqrt())
}

pub fn table() {
    println!(
        "Sheets: iterations and processor time.\n\n| cells, slack, held | 1e1 N/m | 1e3 | 1e5 | 1e7 |\n|---|---|---|---|---|"
    );
    for cells in [20, 40, 100] {
        for law in LAWS {
            for held in ["one side", "two corners", "four corners", "all round"] {
                print!("| {cells} {law}, {held} |");
                for stiffness in [1e1, 1e3, 1e5, 1e7] {
                    print!(" {} |", search(&sheet(cells, stiffness, law, held)).0);
                    _ = std::io::Write::flush(&mut std::io::stdout());
                }
                println!();
            }
        }
    }
    println!("\nRopes: iterations, processor time, and the error of the sag against the elastic catenary.\n");
    println!("| links, slack law | EA [N] | no slack | 5 % | 50 % |\n|---|---|---|---|---|");
    for links in [10, 100, 1_000, 10_000] {
        for law in LAWS {
            for axial_rigidity in [1e2, 1e5, 1e8] {
                print!("| {links} {law} | {axial_rigidity:.0e} |");
                for slack in [0.0, 0.05, 0.5] {
                    let (cell, lowest) = search(&rope(links, axial_rigidity, slack, law));
                    let error =
                        |z: f64| format!(", {:.1e}", (-z / catenary_sag(1.0 - slack, axial_rigidity) - 1.0).abs());
                    print!(" {cell}{} |", lowest.map(error).unwrap_or_default());
                }
                println!();
            }
        }
    }
    println!("\n100,489 nodes held at four corners, 1e5 N/m:\n");
    for law in LAWS {
        println!("* {law}: {}", search(&sheet(316, 1e5, law, "four corners")).0);
    }
}
