//! Flat sheets that swing down, and flags in a wind: stiff, slack, in short and long steps.

use crate::row::{End, Row, row, with_slack};
use serde_json::{Value, json};

fn methods() -> [(&'static str, Value); 5] {
    [
        ("newmark", json!("newmark")),
        ("hht -0.1", json!({"hht": {"alpha": -0.1}})),
        ("gen.-alpha 0.8", json!({"generalized-alpha": {"rho_inf": 0.8}})),
        ("backward-euler", json!("backward-euler")),
        ("energy-momentum", json!("energy-momentum")),
    ]
}

/// A scene, stiff and slack as a row wants it.
#[derive(Clone, Copy)]
struct Cloth {
    /// [N/m]
    stiffness: f64,
    law: &'static str,
    /// [s] retardation time of axial dashpots, 0 for none
    dashpot: f64,
    /// [s]
    step: f64,
}

impl Cloth {
    fn rule(&self) -> Value {
        let mut rule = json!({"on": "all", "stiffness": self.stiffness});
        if self.dashpot > 0.0 {
            rule["dashpot"] = json!({"axial": {"time": self.dashpot}});
        }
        with_slack(rule, self.law)
    }

    /// 1 m by 1 m of 0.2 kg/m2, held along one side.
    fn sheet(&self, method: &Value) -> Value {
        json!({
            "name": "sheet", "acknowledge": ["areal-density"],
            "system": {"network": {
                "mesh": {"rectangle": {"width": 1.0, "height": 1.0, "columns": 20, "rows": 20}},
                "mass": {"areal_density": 0.2}, "springs": [self.rule()],
                "supports": [{"on": {"box": [[-1e-9, -1e-9, -1], [1e-9, 1.000001, 1]]}, "fix": "xyz"}],
                "gravity": [0, 0, -9.81]}},
            "time": {"end": 1.0, "step": self.step, "method": method}})
    }

    /// 1.5 m by 1 m in a wind of 12 m/s, held along its hoist.
    fn flag(&self, method: &Value) -> Value {
        json!({
            "name": "flag-in-wind", "acknowledge": ["areal-density"],
            "system": {"network": {
                "mesh": {"rectangle": {"width": 1.5, "height": 1.0, "columns": 21, "rows": 14}},
                "mass": {"areal_density": 0.2}, "springs": [self.rule()],
                "supports": [{"on": {"box": [[-1e-9, -1, -1], [1e-9, 2, 1]]}, "fix": "xyz"}],
                "gravity": [0, -9.81, 0],
                "aero": {"wind": [12.0, 0, 1.0],
                    "law": {"pressure_coefficient": {"cp": 1.2, "air_density": 1.225}}}}},
            "time": {"end": 1.0, "step": self.step, "method": method}})
    }
}

/// Runs all rows by all methods: one table, and the words of those that have failed.
fn table(rows: &[Cloth], scene: impl Fn(&Cloth, &Value) -> Value) {
    let names = methods().map(|(name, _)| name);
    println!("Iterations a step (mean, most); factorisations (those of them by LU); processor time.\n");
    println!("| K [N/m], slack, dashpot | step [s] | {} |\n|---|---|{}", names.join(" | "), "---|".repeat(names.len()));
    let mut ended: Vec<(String, Row)> = Vec::new();
    for cloth in rows {
        let Cloth { stiffness, law, dashpot, step } = cloth;
        let dashpot = if *dashpot > 0.0 { format!("{dashpot} s") } else { "none".to_owned() };
        print!("| {stiffness:.0e} {law}, {dashpot} | {step} |");
        for (name, method) in methods() {
            let row = row(&scene(cloth, &method), false);
            print!(" {} |", row.cell());
            _ = std::io::Write::flush(&mut std::io::stdout());
            ended.push((format!("{stiffness:.0e} {law}, {dashpot}, {step} s, {name}"), row));
        }
        println!();
    }
    let words = |(label, row): &(String, Row)| println!("* {label}: {}, {}", row.end.words(), row.words);
    println!("\nFailures and warnings:\n");
    ended.iter().filter(|(_, row)| row.end != End::Completed || !row.words.is_empty()).for_each(words);
    let completed: Vec<&Row> = ended.iter().map(|(_, row)| row).filter(|row| row.end == End::Completed).collect();
    println!(
        "\n{} of {} completed; largest mean {:.1}, most {} iterations; LU in {}; {:.1} s in all",
        completed.len(),
        ended.len(),
        completed.iter().map(|row| row.mean).fold(0.0, f64::max),
        completed.iter().map(|row| row.most).max().unwrap_or(0),
        ended.iter().filter(|(_, row)| row.lu > 0).count(),
        ended.iter().map(|(_, row)| row.seconds).sum::<f64>(),
    );
}

pub fn sheets() {
    let both = "both ways";
    let only = "tension-only";
    let undamped =
        [(1e2, both, &[0.01, 0.1][..]), (1e4, both, ALL), (1e4, only, ALL), (1e6, both, ALL), (1e6, only, ALL)];
    let damped = [(1e4, both, &[0.001, 0.01][..]), (1e4, only, ALL), (1e6, both, ALL)];
    const ALL: &[f64] = &[0.001, 0.01, 0.1];
    let rows = |dashpot: f64, of: &[(f64, &'static str, &[f64])]| -> Vec<Cloth> {
        let steps = |&(stiffness, law, steps): &(f64, &'static str, &[f64])| {
            steps.iter().map(|&step| Cloth { stiffness, law, dashpot, step }).collect::<Vec<_>>()
        };
        of.iter().flat_map(steps).collect()
    };
    table(&[rows(0.0, &undamped), rows(1e-3, &damped)].concat(), Cloth::sheet);
}

pub fn flags() {
    let mut rows = Vec::new();
    for stiffness in [1e3, 1e5] {
        for law in ["both ways", "tension-only"] {
            for step in [0.001, 0.01] {
                rows.extend([0.0, 1e-3].map(|dashpot| Cloth { stiffness, law, dashpot, step }));
            }
        }
    }
    table(&rows, Cloth::flag);
}
