//! Random networks. Each has a seed, and is the same on every machine.

use crate::row::{End, Row, row};
use canopy_fem::mesh::random::SplitMix64;
use serde_json::{Value, json};

const METHODS: [&str; 6] = ["newmark", "hht", "generalized-alpha", "backward-euler", "energy-momentum", "esdirk4"];
const MAKES_NONE: [&str; 2] = ["backward-euler", "energy-momentum"];
/// [-] energy made over all energy, and error of an equation over the largest force, that need words
const SILENT: f64 = 0.1;
const UNBALANCED: f64 = 1e-3;

/// parts of messages, and how they are counted
const NEWTON: [(&str, &str); 4] = [
    ("is stuck", ": no smaller residual"),
    ("did not converge", ": most iterations"),
    ("rounding", ": rounding"),
    ("iteration", ": matrix"),
];

struct Dice(SplitMix64);

impl Dice {
    /// in [low, high)
    fn real(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.0.draw() >> 11) as f64 / (1_u64 << 53) as f64
    }
    /// the same, its logarithm evenly spread, to three digits
    fn log(&mut self, low: f64, high: f64) -> f64 {
        let value = self.real(low.ln(), high.ln()).exp();
        format!("{value:.2e}").parse().expect("a number")
    }
    /// below `n`
    fn below(&mut self, n: u64) -> u64 {
        self.0.draw() % n
    }
    fn point(&mut self, size: f64) -> [f64; 3] {
        [(); 3].map(|()| (1e4 * self.real(-size, size)).round() / 1e4)
    }
}

/// The case of a seed: a tree of springs with some more between its nodes, in up to three groups of their own laws,
/// held here and there, which swings for five steps.
pub fn network(seed: u64) -> Value {
    let mut dice = Dice(SplitMix64::of_seed(seed));
    let n = 5 + dice.below(56);
    let nodes: Vec<[f64; 3]> = (0..n).map(|_| dice.point(0.5)).collect();
    let mut springs: Vec<[u64; 2]> = (1..n).map(|i| [dice.below(i), i]).collect();
    for _ in 0..dice.below(2 * n) {
        let (a, b) = (dice.below(n), dice.below(n));
        let pair = [a.min(b), a.max(b)];
        if a != b && !springs.contains(&pair) {
            springs.push(pair);
        }
    }
    let groups = 1 + dice.below(3) as usize;
    let mut members: Vec<Vec<usize>> = vec![Vec::new(); groups];
    (0..springs.len())
        .for_each(|edge| members[if edge < groups { edge } else { dice.below(groups as u64) as usize }].push(edge));
    let dashpots = dice.below(2) == 0;
    let rules: Vec<Value> = (0..groups).map(|group| rule(&mut dice, group, dashpots)).collect();
    let named = members.iter().enumerate().map(|(group, edges)| (format!("g{group}"), json!({"edges": edges})));
    let named: serde_json::Map<String, Value> = named.collect();
    let supports: Vec<Value> = (0..1 + dice.below(3))
        .map(|_| {
            let fix = ["xyz", "xyz", "xz", "z"][dice.below(4) as usize];
            json!({"on": {"ids": [dice.below(n)]}, "fix": fix})
        })
        .collect();
    let step = dice.log(1e-4, 0.1);
    json!({
        "name": format!("random-{seed}"),
        "system": {"network": {
            "mesh": {"explicit": {"nodes": nodes, "springs": springs, "groups": named}},
            "mass": {"nodal": dice.log(1e-3, 1.0)}, "springs": rules, "supports": supports,
            "initial": {"velocity": dice.point(2.0)}, "gravity": [0, 0, -9.81]}},
        "time": {"end": 5.0 * step, "step": step, "method": METHODS[(seed % 6) as usize]}})
}

fn rule(dice: &mut Dice, group: usize, dashpots: bool) -> Value {
    let mut rule = json!({"on": {"group": format!("g{group}")}, "stiffness": dice.log(1.0, 1e8)});
    match dice.below(5) {
        0 => {}
        1 => rule["slack"] = json!("tension-only"),
        2 => rule["slack"] = json!("compression-only"),
        3 => rule["slack"] = json!({"dead_zone": dice.log(1e-4, 1e-2)}),
        _ => rule["slack"] = json!({"compression_limit": dice.log(1e-4, 1e-2)}),
    }
    if dashpots {
        let kind = ["axial", "relative"][dice.below(2) as usize];
        rule["dashpot"] = json!({kind: {"time": dice.log(1e-4, 1e-2)}});
    }
    rule
}

/// How a network has ended, for the counts.
fn kind(seed: u64, row: &Row) -> String {
    let method = METHODS[(seed % 6) as usize];
    match row.end {
        End::Completed if row.made.is_nan() || row.error.is_nan() => "SILENT: no number".to_owned(),
        End::Completed if row.made > SILENT && row.words.is_empty() => "SILENT: energy made".to_owned(),
        End::Completed if row.made > SILENT && MAKES_NONE.contains(&method) => {
            "energy made by a method that makes none, with a warning".to_owned()
        }
        End::Completed if row.unbalanced > UNBALANCED => "SILENT: equation not met".to_owned(),
        End::Completed if row.made > SILENT => "completed, warns of energy made".to_owned(),
        End::Completed => "completed".to_owned(),
        End::EnergyMade | End::Diverged if MAKES_NONE.contains(&method) => {
            "energy made by a method that makes none".to_owned()
        }
        End::NotSolved if row.made > SILENT => "not solved, after energy made".to_owned(),
        End::NotSolved => {
            let cause = NEWTON.iter().find(|(part, _)| row.words.contains(part));
            format!("not solved{}", cause.map_or("", |(_, name)| name))
        }
        end => end.words().to_owned(),
    }
}

pub fn table(count: u64) {
    let mut ended: Vec<(String, u64, Row)> = Vec::new();
    for seed in 0..count {
        let row = row(&network(seed), seed % 6 == 3);
        ended.push((kind(seed, &row), seed, row));
    }
    let mut kinds: Vec<&str> = ended.iter().map(|(kind, ..)| &**kind).collect();
    kinds.sort_unstable();
    kinds.dedup();
    println!(
        "| how it ends | networks | {} | seeds |\n|---|---|{}---|",
        METHODS.join(" | "),
        "---|".repeat(METHODS.len())
    );
    for kind in kinds {
        let seeds: Vec<u64> = ended.iter().filter(|(of, ..)| of == kind).map(|(_, seed, _)| *seed).collect();
        let by_method = (0..6).map(|method| seeds.iter().filter(|seed| **seed % 6 == method).count().to_string());
        let by_method = by_method.collect::<Vec<_>>().join(" | ");
        let shown: Vec<String> = seeds.iter().take(12).map(u64::to_string).collect();
        println!("| {kind} | {} | {by_method} | {} |", seeds.len(), shown.join(" "));
    }
    let iterations: f64 = ended.iter().map(|(_, _, row)| row.mean * row.steps as f64).sum();
    let steps: u64 = ended.iter().map(|(_, _, row)| row.steps).sum();
    ended.sort_by_key(|(_, _, row)| std::cmp::Reverse(row.most));
    let worst: Vec<String> =
        ended.iter().take(10).map(|(_, seed, row)| format!("{} (seed {seed})", row.most)).collect();
    println!("\n{:.2} iterations a step; most: {}", iterations / steps as f64, worst.join(", "));
    let seconds = ended.iter().map(|(_, _, row)| row.seconds).sum::<f64>();
    println!("LU in {} of {count}; {seconds:.1} s in all", ended.iter().filter(|(_, _, row)| row.lu > 0).count());
    ended.sort_by(|a, b| (&a.0, a.1).cmp(&(&b.0, b.1)));
    for (kind, seed, row) in ended.iter().filter(|(kind, ..)| !kind.starts_with("completed")) {
        println!(
            "* {seed} {kind}: step {}, most {}, made {:.2e}, unbalanced {:.1e}: {}",
            row.steps, row.most, row.made, row.unbalanced, row.words
        );
    }
}

pub fn one(seed: u64) {
    let case = network(seed);
    println!("{case:#}");
    let row = row(&case, seed % 6 == 3);
    println!("{}\n{row:#?}", kind(seed, &row));
}
