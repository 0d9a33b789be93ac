//! Section 3.2: the cloth, Figures 16 to 24, and why every scheme "worked" on it.

use super::page::{Caption, Section, cell};
use super::runs::{Failed, Trace, asset, changed, run, run_to_the_end};
use super::wire::wireframe;
use canopy_fem::analysis::limit::critical_step;
use canopy_fem::analysis::spectrum::Spectrum;
use canopy_fem::case::Case;
use canopy_fem::drive::Status;
use canopy_fem::plot::chart::{Axis, Chart, Line, Stroke};
use canopy_fem::simulation::build_scene;
use rayon::prelude::*;
use std::path::Path;

/// Stiffness [N/m], asset, the thesis' step [s] and its figures.
const CLOTHS: [(f64, &str, f64, [&str; 2]); 4] = [
    (1e2, "cloth-k100", 2e-3, ["17", "18"]),
    (1e3, "cloth-k1000", 5e-4, ["19", "20"]),
    (1e4, "cloth-k10000", 2e-4, ["21", "22"]),
    (1e5, "cloth-k100000", 5e-5, ["23", "24"]),
];

/// As many nodes as the thesis shows (54), spread over the free ones of our mesh, which follow its 126 boundary nodes.
fn shown_nodes() -> Vec<usize> {
    (0..54).map(|i| 126 + i * 577 / 54).collect()
}

const SCHEMES: [&str; 10] = [
    "explicit-euler",
    "euler-cromer",
    "euler-richardson",
    "improved-euler",
    "improved-euler-pec",
    "velocity-verlet",
    "rk4",
    "newmark",
    "hht",
    "kang",
];

/// Step [s] of Newmark and HHT unless the whole is asked for.
const COARSE: &str = "1e-2";

pub fn section(out: &Path, full: bool) -> Result<Section, Failed> {
    let mut s = Section::new("Cloth");
    s.text(
        "703 nodes in a wind of 50 m/s with gravity, uniform stiffness, dashpots of Eq. 68. The mass is not \
            in the thesis: 2 kg/m^2, with which every scheme holds at its four steps. The thesis shows its \
            nodes 650 to 703, wherever its mesh put them; here 54 nodes are spread over the canopy.",
    );
    figures(out, &mut s)?;
    all_schemes(&mut s, full)?;
    why(&mut s)?;
    one_dimension(&mut s)?;
    steps(&mut s)?;
    Ok(s)
}

fn figures(out: &Path, s: &mut Section) -> Result<(), Failed> {
    let nodes = shown_nodes();
    for (k, stem, h, numbers) in CLOTHS {
        let case = asset(stem, &[])?;
        let mut traces = vec![Trace::default(); nodes.len()];
        let mut last = Vec::new();
        run(&case, |seen| {
            for (trace, n) in traces.iter_mut().zip(nodes.iter().copied()) {
                trace.push(seen.t, seen.positions[n][2] - seen.reference[n][2], seen.velocities[n][2]);
            }
            last.clear();
            last.extend_from_slice(seen.positions);
        })?;
        if k == 1e2 {
            let edges = build_scene(case.problem().system.clone(), 1)?.edges().to_vec();
            let caption = Caption {
                stem: "figure-16",
                caption: "Figure 16: the cloth near its equilibrium, K = 100 N/m, velocity Verlet, t = 2 s",
                note: "A billowed annulus, the inner edge highest.",
            };
            s.figure(out, caption, wireframe(&last, &edges))?;
        }
        let bundle = |points: fn(&Trace) -> Vec<(f64, f64)>| {
            traces
                .iter()
                .map(|t| Line { stroke: Stroke::Thin, color: Some(0), points: points(t), ..Line::default() })
                .collect::<Vec<_>>()
        };
        let charts = [
            (
                Axis::linear("time t [s]"),
                Axis::linear("displacement z [m]"),
                bundle(Trace::over_time),
                "displacement z of 54 nodes",
                "Damped oscillation into a new equilibrium, higher and slower the softer the cloth, as the text \
            says; it gives no numbers.",
            ),
            (
                Axis::linear("displacement z [m]"),
                Axis::linear("velocity [m/s]"),
                bundle(Trace::phase),
                "phase diagram of the same nodes",
                "Converging spirals, as the text says, and as it says by the dashpots of Eq. 68: without them the \
            canopy still swings at 2 s (table below).",
            ),
        ];
        for (number, (x, y, lines, what, note)) in numbers.into_iter().zip(charts) {
            let (stem, caption) =
                (format!("figure-{number}"), format!("Figure {number}: {what}, K = {k:e} N/m, step {h:e} s"));
            let chart = Chart { x, y, lines, ..Chart::default() };
            s.figure(out, Caption { stem: &stem, caption: &caption, note }, chart)?;
        }
    }
    Ok(())
}

/// The inner edge's mean height [m] at the end, and between which bounds it moved in the last half second.
struct Height {
    last: f64,
    low: f64,
    high: f64,
}

/// `Err`: the time [s] that a run reached which did not get to its end.
fn height(case: &Case) -> Result<Result<Height, f64>, Failed> {
    let inner = case.problem().output.probes[0].nodes.clone();
    let late = case.problem().time.end - 0.5;
    let mut seen_so_far = Height { last: 0.0, low: f64::INFINITY, high: f64::NEG_INFINITY };
    let outcome = run(case, |seen| {
        let z = inner.iter().map(|&n| seen.positions[n as usize][2]).sum::<f64>() / inner.len() as f64;
        seen_so_far.last = z;
        if seen.t >= late {
            (seen_so_far.low, seen_so_far.high) = (seen_so_far.low.min(z), seen_so_far.high.max(z));
        }
    })?;
    Ok(if outcome.status == Status::Completed { Ok(seen_so_far) } else { Err(outcome.t_end) })
}

fn last(height: &Result<Height, f64>) -> String {
    height.as_ref().map_or_else(|t| format!("ends at {t:.2e} s"), |h| format!("{:.4}", h.last))
}

fn swing(height: &Result<Height, f64>) -> String {
    height.as_ref().map_or_else(|t| format!("diverges at {t:.2e} s"), |h| format!("{:.3} .. {:.3}", h.low, h.high))
}

fn all_schemes(s: &mut Section, full: bool) -> Result<(), Failed> {
    let jobs: Vec<(&str, &str)> = SCHEMES.iter().flat_map(|m| CLOTHS.iter().map(move |c| (*m, c.1))).collect();
    let heights: Vec<Result<Result<Height, f64>, Failed>> = jobs
        .par_iter()
        .with_max_len(1)
        .map(|(method, stem)| {
            let implicit = matches!(*method, "newmark" | "hht");
            let mut sets = vec![("time.method", *method)];
            if implicit && !full {
                sets.push(("time.step", COARSE));
            }
            height(&asset(stem, &sets)?)
        })
        .collect();
    let heights = heights.into_iter().collect::<Result<Vec<_>, Failed>>()?;
    let mut rows = Vec::new();
    for (method, heights) in SCHEMES.into_iter().zip(heights.chunks(CLOTHS.len())) {
        let note = if matches!(method, "newmark" | "hht") && !full { " (step 1e-2 s)" } else { "" };
        let mut row = vec![format!("{method}{note}")];
        row.extend(heights.iter().map(last));
        rows.push(row);
    }
    let note = of_heights(s, &heights, full);
    let heads = ["scheme", "K 100, h 2e-3", "K 1e3, h 5e-4", "K 1e4, h 2e-4", "K 1e5, h 5e-5"];
    s.table("Height of the inner edge after 2 s [m]: \"all of the tested schemes worked\"", &heads, rows, note);
    Ok(())
}

/// What the heights show.
fn of_heights(s: &mut Section, heights: &[Result<Height, f64>], full: bool) -> String {
    // [m] how far a scheme is from RK4 on a cloth
    let off = |method: &str, cloth: usize| -> f64 {
        let at = |name: &str| {
            let i = SCHEMES.iter().position(|m| *m == name).and_then(|i| heights.get(i * CLOTHS.len() + cloth));
            i.and_then(|height| height.as_ref().ok()).map_or(f64::NAN, |height| height.last)
        };
        (at(method) - at("rk4")).abs()
    };
    let first = ["explicit-euler", "euler-cromer"].map(|m| off(m, 0));
    let second = ["euler-richardson", "improved-euler", "velocity-verlet"].map(|m| off(m, 0));
    let (least, most) = (first.into_iter().fold(f64::INFINITY, f64::min), second.into_iter().fold(0.0, f64::max));
    let kang = (0..CLOTHS.len()).map(|cloth| off("kang", cloth)).fold(0.0, f64::max);
    let mut sentences = vec![
        s.claim(heights.iter().all(Result::is_ok), "True here too, and the heights show what \"worked\" hides:"),
        s.claim(
            least > 3.0 * most,
            format!(
                "where the cloth still moves (K = 100) the first-order schemes are {} m or more from RK4, those of order \
                 two at most {} m,",
                cell(least),
                cell(most)
            ),
        ),
        s.claim(
            kang > 1e-3,
            format!("and Kang's scheme keeps an error of its own, up to {} m.", cell(kang)),
        ),
    ];
    if !full {
        let longest = COARSE.parse::<f64>().unwrap_or(f64::NAN) / CLOTHS[3].2;
        sentences.push(format!("Newmark and HHT run at {COARSE} s, up to {longest:.0} times the thesis' step."));
    }
    sentences.join(" ")
}

/// Explicit Euler with the dashpot of Eq. 68 and without.
fn why(s: &mut Section) -> Result<(), Failed> {
    let jobs: Vec<(&str, &str)> = ["explicit-euler", "euler-cromer", "velocity-verlet"]
        .into_iter()
        .flat_map(|m| CLOTHS.iter().map(move |c| (m, c.1)))
        .collect();
    let cells: Vec<Result<[Result<Height, f64>; 2], Failed>> = jobs
        .par_iter()
        .with_max_len(1)
        .map(|(method, stem)| {
            let with = asset(stem, &[("time.method", method)])?;
            let without = changed(&with, &[("system.network.springs.0.dashpot", "null")])?;
            Ok([height(&with)?, height(&without)?])
        })
        .collect();
    let (mut rows, mut diverge, mut stay, mut calmer) = (Vec::new(), true, true, true);
    for ((method, stem), cell) in jobs.iter().zip(cells) {
        let [with, without] = cell?;
        rows.push(vec![format!("{method}, {stem}"), swing(&with), swing(&without)]);
        let range = |height: &Result<Height, f64>| height.as_ref().map_or(f64::NAN, |h| h.high - h.low);
        if *method == "explicit-euler" {
            diverge &= with.is_ok() && without.is_err();
        } else {
            stay &= with.is_ok() && without.is_ok();
            calmer &= range(&with) < 0.5 * range(&without);
        }
    }
    let note = [
        s.claim(
            diverge,
            "Eq. 68's dashpot with c = k dt is not a material: it is the term that makes explicit Euler's step \
                semi-implicit, and without it explicit Euler diverges.",
        ),
        s.claim(
            stay && calmer,
            "It is also what brings the canopy to rest: without it Euler-Cromer and Verlet stay stable and swing on, \
                at least twice as far; the air alone does not settle the net in 2 s.",
        ),
    ]
    .join(" ");
    let heads = ["scheme and cloth", "with the dashpot c = k dt", "without it"];
    s.table("Why every scheme worked: the inner edge's height [m] in the last half second", &heads, rows, note);
    Ok(())
}

/// In one dimension explicit Euler with c = k dt has exactly Euler-Cromer's characteristic polynomial.
fn one_dimension(s: &mut Section) -> Result<(), Failed> {
    let (mut rows, mut worst) = (Vec::new(), 0.0_f64);
    for wh in [0.1, 0.5, 0.9, 1.9] {
        let h = wh / 1.5_f64.sqrt();
        let (step, end) = (format!("{h:e}"), format!("{:e}", 3.0 * h));
        let sets = [("time.step", step.as_str()), ("time.end", &end), ("output.frames.every", &end)];
        let mut row = vec![wh.to_string()];
        for (method, dashpot) in
            [("explicit-euler", r#"{"relative": "step"}"#), ("euler-cromer", "null"), ("explicit-euler", "null")]
        {
            let case = changed(
                &asset("oscillator", &sets)?,
                &[("time.method", method), ("system.network.springs.0.dashpot", dashpot)],
            )?;
            let [trace, determinant] = roots(&case)?;
            let plain = method == "explicit-euler" && dashpot == "null";
            let expected = if plain { [2.0, 1.0 + wh * wh] } else { [2.0 - wh * wh, 1.0] };
            worst = worst.max((trace - expected[0]).abs()).max((determinant - expected[1]).abs());
            row.push(format!("{trace:.4}, {determinant:.4}"));
        }
        rows.push(row);
    }
    let note = s.claim(
        worst < 1e-6,
        "Both have the characteristic polynomial z^2 - (2 - (w h)^2) z + 1, so in one dimension explicit \
            Euler with Eq. 68 is Euler-Cromer in other coordinates: stable to w h = 2, no damping at all. \
            Plain explicit Euler has determinant 1 + (w h)^2.",
    );
    let heads = ["w h", "explicit Euler, c = k h", "Euler-Cromer, no dashpot", "explicit Euler, no dashpot"];
    s.table("Trace and determinant of one step on the oscillator, from three states of each run", &heads, rows, note);
    Ok(())
}

/// A linear step keeps x2 = T x1 - D x0: trace and determinant from four displacements, also where the energy grows.
fn roots(case: &Case) -> Result<[f64; 2], Failed> {
    let mut x = Vec::new();
    run_to_the_end(case, |seen| x.push(seen.positions[1][0] - seen.reference[1][0]))?;
    let [x0, x1, x2, x3] = x[..].try_into().map_err(|_| format!("{} states in place of four", x.len()))?;
    let determinant = (x2 * x2 - x1 * x3) / (x1 * x1 - x0 * x2);
    Ok([(x2 + determinant * x0) / x1, determinant])
}

/// Eq. 72 beside the limit of the net.
fn steps(s: &mut Section) -> Result<(), Failed> {
    let (mut rows, mut ratios) = (Vec::new(), Vec::new());
    for (k, stem, h, _) in CLOTHS {
        let case = asset(stem, &[])?;
        let scene = build_scene(case.problem().system.clone(), 1)?;
        let fastest = Spectrum::of(&*scene, scene.initial_state().as_ref()).rates();
        let limit = critical_step(&case.problem().method, fastest);
        let lightest = scene.inverse_mass().iter().fold(0.0_f64, |m, w| m.max(*w));
        let rule = std::f64::consts::PI / (k * lightest).sqrt();
        ratios.push(rule / limit);
        rows.push(vec![format!("{k:e}"), format!("{h:e}"), cell(rule), cell(limit), format!("{:.1}", rule / limit)]);
    }
    let (least, most) =
        (ratios.iter().copied().fold(f64::INFINITY, f64::min), ratios.iter().copied().fold(0.0, f64::max));
    let note = s.claim(
        least > 1.5 && most < 10.0,
        format!(
            "Six springs meet at a node, so the fastest oscillation of the net is faster than Eq. 72's single \
                spring: on a regular triangular net without dashpots the limit is 0.816 sqrt(m/k), 3.8 times smaller. \
                Of the thesis' \"approximately 10 times smaller\" than its rule that explains {least:.1} to {most:.1}; the \
                rest is margin."
        ),
    );
    let heads = ["K [N/m]", "thesis' step [s]", "Eq. 72 [s]", "limit of velocity Verlet [s]", "Eq. 72 / limit"];
    s.table("Eq. 72, dt = pi sqrt(m/k)", &heads, rows, note);
    Ok(())
}
