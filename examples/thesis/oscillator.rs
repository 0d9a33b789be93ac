//! Appendix A: the oscillator, Figures 26 to 40, beside its closed form.

use super::page::{Caption, Section, curve, exact_curve};
use super::runs::{Failed, Trace, asset, changed, displacement};
use canopy_fem::case::Case;
use canopy_fem::plot::chart::{Axis, Chart, Line};
use std::path::Path;

/// A figure or a pair of figures: displacement, and perhaps phase.
struct Shown {
    figures: &'static [&'static str],
    methods: &'static [&'static str],
    damped: bool,
    step: &'static str,
    notes: &'static [&'static str],
}

const UNDAMPED: [Shown; 5] = [
    Shown {
        figures: &["26", "27"],
        methods: &["explicit-euler"],
        damped: false,
        step: "0.05",
        notes: &[
            "Explicit Euler's amplitude grows by sqrt(1 + (w h)^2) a step, here 0.19 %.",
            "The spiral outwards is its energy.",
        ],
    },
    Shown {
        figures: &["28", "29"],
        methods: &["euler-cromer"],
        damped: false,
        step: "0.05",
        notes: &[
            "No growth: symplectic, not energy-conserving.",
            "An ellipse tilted by w^2 h x v, which is what it keeps.",
        ],
    },
    Shown {
        figures: &["30", "31"],
        methods: &["euler-richardson", "improved-euler", "improved-euler-pec"],
        damped: false,
        step: "0.05",
        notes: &["Growth (w h)^4/8 a step: not to be seen in 20 s.", "Closed to the eye."],
    },
    Shown {
        figures: &["32", "33"],
        methods: &["velocity-verlet", "rk4"],
        damped: false,
        step: "0.05",
        notes: &["Verlet's period is (w h)^2/24 short, RK4's error cannot be seen.", "Closed."],
    },
    Shown {
        figures: &["34", "35"],
        methods: &["newmark", "hht"],
        damped: false,
        step: "0.05",
        notes: &[
            "The periods are (w h)^2/12 long; HHT loses a little amplitude, which is what it is for.",
            "HHT spirals inwards slowly.",
        ],
    },
];

const DAMPED: [Shown; 4] = [
    Shown {
        figures: &["36", "37"],
        methods: &["explicit-euler", "euler-cromer", "velocity-verlet", "rk4", "newmark", "hht"],
        damped: true,
        step: "0.05",
        notes: &[
            "All schemes decay with the closed form; explicit Euler's own growth eats a part of the damping.",
            "Spirals inwards.",
        ],
    },
    Shown {
        figures: &["38"],
        methods: &["explicit-euler", "euler-cromer", "improved-euler", "velocity-verlet", "rk4"],
        damped: true,
        step: "0.2",
        notes: &["At 0.2 s explicit Euler makes more energy than the dashpot takes and grows (limit w h = 2 zeta = \
            0.204, here 0.245)."],
    },
    Shown {
        figures: &["39"],
        methods: &["newmark", "hht", "generalized-alpha", "backward-euler"],
        damped: true,
        step: "0.2",
        notes: &["The implicit schemes at the same step; backward Euler damps on its own account."],
    },
    Shown {
        figures: &["40"],
        methods: &["newmark", "hht", "euler-cromer"],
        damped: true,
        step: "1.0",
        notes: &["At w h = 1.2 all are stable and none is accurate: stability is not accuracy."],
    },
];

pub fn section(out: &Path) -> Result<Section, Failed> {
    let mut s = Section::new("Oscillator");
    s.text(
        "k = 3 N/m, m = 2 kg, x0 = 2 m. Eq. 74, 75 and 80 are misprinted: A = sqrt(x0^2 + (v0/w0)^2), phi = \
            atan2(x0 w0, v0), damped phi = atan2(x0, B). The thesis' captions call all fifteen figures \
            undamped and its text names neither schemes, steps nor c; here Figures 26 to 35 are undamped at \
            0.05 s and 36 to 40 have c = 0.5 N s/m.",
    );
    for shown in UNDAMPED.iter().chain(&DAMPED) {
        figure(out, &mut s, shown)?;
    }
    Ok(s)
}

/// What of a trace is drawn.
type Curve = fn(&Trace) -> Vec<(f64, f64)>;

/// x(t) and v(t) of the closed form, from rest at 2 m; c = 0 or 0.5 N s/m.
fn closed_form(t: f64, c: f64) -> (f64, f64) {
    let (k, m, x0) = (3.0_f64, 2.0, 2.0_f64);
    let w = (4.0 * m * k - c * c).sqrt() / (2.0 * m);
    let b = c * x0 / (2.0 * m * w);
    let (amplitude, phi, decay) = ((x0 * x0 + b * b).sqrt(), x0.atan2(b), c / (2.0 * m));
    let e = amplitude * (-decay * t).exp();
    (e * (w * t + phi).sin(), e * (w * (w * t + phi).cos() - decay * (w * t + phi).sin()))
}

fn figure(out: &Path, s: &mut Section, shown: &Shown) -> Result<(), Failed> {
    let stem = if shown.damped { "oscillator-damped" } else { "oscillator" };
    let base = asset(stem, &[("time.step", shown.step), ("time.end", "20")])?;
    let mut exact = Trace::default();
    for i in 0..=2000 {
        let t = 0.01 * f64::from(i);
        let (x, v) = closed_form(t, if shown.damped { 0.5 } else { 0.0 });
        exact.push(t, x, v);
    }
    let mut traces = Vec::new();
    for method in shown.methods {
        traces.push((*method, traced(&base, method)?));
    }
    let what = if shown.damped { "damped" } else { "undamped" };
    let kinds: [(&str, Axis, Axis, Curve); 2] = [
        ("displacement", Axis::linear("time t [s]"), Axis::linear("displacement x [m]"), Trace::over_time),
        ("phase", Axis::linear("displacement x [m]"), Axis::linear("velocity v [m/s]"), Trace::phase),
    ];
    for ((number, note), (kind, x, y, points)) in shown.figures.iter().zip(shown.notes).zip(kinds) {
        let mut lines: Vec<Line> = traces.iter().map(|(name, trace)| curve(name, *name, points(trace))).collect();
        lines.push(exact_curve("closed form", points(&exact)));
        let (stem, caption) =
            (format!("figure-{number}"), format!("Figure {number}: {kind}, {what}, step {} s", shown.step));
        let chart = Chart { x, y, lines, ..Chart::default() };
        s.figure(out, Caption { stem: &stem, caption: &caption, note }, chart)?;
    }
    Ok(())
}

fn traced(base: &Case, method: &str) -> Result<Trace, Failed> {
    Ok(displacement(&changed(base, &[("time.method", method)])?, 1, 0)?.0)
}
