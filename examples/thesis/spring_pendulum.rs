//! Section 2.5.2: the spring pendulum, Figures 8 to 13 and Table 2.

use super::page::{Caption, Section, curve};
use super::runs::{COST_HEADS, Failed, Trace, asset, changed, cost_rows, displacement};
use canopy_fem::case::Case;
use canopy_fem::drive::Status;
use canopy_fem::plot::chart::{Axis, Chart, Line, Stroke};
use std::path::Path;

/// Methods of Table 2 with the thesis' seconds.
const TABLE_2: [(&str, &str, f64); 9] = [
    ("Explicit Euler", "explicit-euler", 0.0298),
    ("Newmark", "newmark", 0.7421),
    ("Velocity Verlet", "velocity-verlet", 0.0481),
    ("Euler Richardson", "euler-richardson", 0.0471),
    ("Euler Cromer", "euler-cromer", 0.0296),
    ("4th Runge-Kutta", "rk4", 0.1144),
    ("HHT", "hht", 0.7243),
    ("Improved Explicit Euler", "improved-euler-pec", 0.0286),
    ("the same with two passes (Heun)", "improved-euler", f64::NAN),
];

/// What the thesis leaves open.
fn base() -> Result<Case, Failed> {
    asset(
        "spring-pendulum",
        &[
            ("system.network.springs.0.stiffness", "1000"),
            ("system.network.initial.displacement", "[0.1, 0.05, 0]"),
            ("time.end", "2"),
        ],
    )
}

pub fn section(out: &Path) -> Result<Section, Failed> {
    let mut s = Section::new("Spring pendulum");
    s.text(
        "One mass between two springs, Eq. 63-64 (the last term of Eq. 62 has the wrong sign). The thesis \
            gives no values; with M = 1 kg, a = 1 m, l = 0.5 m and K = 1000 N/m both of its observations hold: \
            at 1e-4 s explicit Euler spirals outwards, at 0.1 s only the implicit schemes stay.",
    );
    let base = base()?;
    pair(
        out,
        &mut s,
        &base,
        &Pair {
            stems: ["figure-08", "figure-09"],
            captions: ["Figure 8: displacement x at a step of 1e-4 s", "Figure 9: phase diagram of the same runs"],
            notes: [
                "As in the thesis only explicit Euler leaves the others: its amplitude grows by sqrt(1 + (w h)^2) a \
            step, whatever the step.",
                "Explicit Euler spirals outwards; the closed curves are not ellipses to the last digit, because two \
            frequencies mix in x at this amplitude.",
            ],
            methods: &["explicit-euler", "euler-cromer", "euler-richardson", "improved-euler", "rk4"],
            step: "1e-4",
        },
    )?;
    pair(
        out,
        &mut s,
        &base,
        &Pair {
            stems: ["figure-10", "figure-11"],
            captions: [
                "Figure 10: displacement x at a step of 1e-4 s, the other schemes",
                "Figure 11: phase diagram of the same runs",
            ],
            notes: [
                "The coherent solution of the text: all three lie on each other.",
                "Closed curves, as the text says.",
            ],
            methods: &["velocity-verlet", "newmark", "hht"],
            step: "1e-4",
        },
    )?;
    pair(
        out,
        &mut s,
        &base,
        &Pair {
            stems: ["figure-12", "figure-13"],
            captions: ["Figure 12: displacement x at a step of 0.1 s", "Figure 13: phase diagram of the same runs"],
            notes: [
                "Stable, as in the thesis, but no solution any more: at w h = 3 to 4.5 a step is half a period or \
            more, so the period shown is the scheme's own (table below).",
                "A phase diagram cannot show that the period is wrong; the table does.",
            ],
            methods: &["newmark", "hht"],
            step: "0.1",
        },
    )?;
    coarse(&mut s, &base)?;
    table_2(&mut s, &base)?;
    Ok(s)
}

struct Pair {
    stems: [&'static str; 2],
    captions: [&'static str; 2],
    notes: [&'static str; 2],
    methods: &'static [&'static str],
    step: &'static str,
}

fn traced(base: &Case, method: &str, step: &str) -> Result<(Trace, Status), Failed> {
    let case = changed(base, &[("time.method", method), ("time.step", step)])?;
    let (trace, outcome) = displacement(&case, 0, 0)?;
    Ok((trace, outcome.status))
}

fn pair(out: &Path, s: &mut Section, base: &Case, p: &Pair) -> Result<(), Failed> {
    let (mut over_time, mut phase) = (Vec::new(), Vec::new());
    for method in p.methods {
        let (trace, _) = traced(base, method, p.step)?;
        over_time.push(curve(method, *method, trace.over_time()));
        phase.push(Line { stroke: Stroke::Thin, ..curve(method, *method, trace.phase()) });
    }
    let charts = [
        Chart {
            x: Axis::linear("time t [s]"),
            y: Axis::linear("displacement x [m]"),
            lines: over_time,
            ..Chart::default()
        },
        Chart {
            x: Axis::linear("displacement x [m]"),
            y: Axis::linear("velocity [m/s]"),
            lines: phase,
            ..Chart::default()
        },
    ];
    for (i, chart) in charts.into_iter().enumerate() {
        s.figure(out, Caption { stem: p.stems[i], caption: p.captions[i], note: p.notes[i] }, chart)?;
    }
    Ok(())
}

/// Every scheme at 0.1 s: which stay, and at which period.
fn coarse(s: &mut Section, base: &Case) -> Result<(), Failed> {
    let small = changed(base, &[("system.network.initial.displacement", "[0.001, 0, 0]"), ("time.end", "20")])?;
    let exact = std::f64::consts::TAU / (2.0 * 1000.0 * 0.5_f64).sqrt();
    let mut rows = vec![vec!["exact".to_owned(), "-".to_owned(), format!("{exact:.4}")]];
    let (mut split, mut newmark) = (true, f64::NAN);
    for (name, method, _) in TABLE_2 {
        let (trace, status) = traced(&small, method, "0.1")?;
        let stays = status == Status::Completed && trace.largest() < 0.01;
        split &= stays == matches!(method, "newmark" | "hht");
        if method == "newmark" {
            newmark = period(&trace).unwrap_or(f64::NAN);
        }
        let period = if stays { period(&trace).map_or("-".to_owned(), |t| format!("{t:.4}")) } else { "-".to_owned() };
        rows.push(vec![name.to_owned(), if stays { "stays" } else { "diverges" }.to_owned(), period]);
    }
    let (w, h) = (std::f64::consts::TAU / exact, 0.1_f64);
    let theory = std::f64::consts::PI * h / (0.5 * w * h).atan();
    let note = [
        s.claim(
            split,
            "As in the thesis every explicit scheme diverges at 0.1 s and Newmark and HHT do not; what they \
                give then is bounded, and its period is that of the step as much as of the springs:",
        ),
        s.claim(
            (newmark / theory - 1.0).abs() < 0.01,
            format!(
                "Newmark's is pi h/atan(w h/2) = {theory:.4} s for the exact {exact:.4} s, and tends to two steps as \
                springs stiffen."
            ),
        ),
    ]
    .join(" ");
    let heads = ["scheme", "at a step of 0.1 s", "period of small swings across [s]"];
    s.table("A step 1000 times larger (text on Figure 13)", &heads, rows, note);
    Ok(())
}

/// [s] Mean time between upward crossings of zero.
fn period(trace: &Trace) -> Option<f64> {
    let mut crossings = Vec::new();
    for i in 1..trace.values.len() {
        let (a, b) = (trace.values[i - 1], trace.values[i]);
        if a < 0.0 && b >= 0.0 {
            crossings.push(trace.times[i - 1] + (trace.times[i] - trace.times[i - 1]) * a / (a - b));
        }
    }
    let (first, last) = (crossings.first()?, crossings.last()?);
    (crossings.len() > 2).then(|| (last - first) / (crossings.len() - 1) as f64)
}

fn table_2(s: &mut Section, base: &Case) -> Result<(), Failed> {
    let rows = cost_rows(&TABLE_2, &changed(base, &[("time.step", "1e-4")])?)?;
    s.table(
        "Table 2: mean of 10 runs, step 1e-4 s, 2 s",
        &COST_HEADS,
        rows,
        "Improved Euler is as cheap as explicit Euler in the thesis' Table 2 and twice as dear in its Table \
            1: two different schemes under one name. Here it took one force pass a step: the reading \"never \
            corrected\" of its text (predict, evaluate, correct, and keep the derivative of the predicted \
            state), on linear problems Adams-Bashforth 2; there it took two, Heun. Our seconds of the one-pass \
            scheme hold a second pass, at the corrected state, for the energy account. Velocity Verlet needs \
            one pass without damping; the thesis' took 1.6.",
    );
    Ok(())
}
