//! Values fitted to curves: closed forms of linear least squares, values that the data do not determine, and intervals
//! that hold the truth as often as they say.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use canopy_fem::mesh::random::SplitMix64;
use canopy_fem::output::gauge_rows::{ColumnName, GaugeRows};
use canopy_fem::simulation::{bind, build_scene};
use canopy_fem::study::StudyError;
use canopy_fem::study::fit::{DataSource, Fit, FitSpec, Fitted, Parameter, Range};
use serde_json::{Value, json};

use crate::common::run::case_of;

/// [s] between points of the data
const EVERY: f64 = 0.02;

/// Noise with the distribution of Gauss (Box & Muller 1958), the same for each seed.
struct Noise(SplitMix64);

impl Noise {
    fn of(seed: u64) -> Self {
        Noise(SplitMix64::of_seed(seed))
    }

    fn draw(&mut self) -> f64 {
        let mut uniform = || ((self.0.draw() >> 11) as f64 + 0.5) / (1_u64 << 53) as f64;
        let (radius, angle) = ((-2.0 * uniform().ln()).sqrt(), std::f64::consts::TAU * uniform());
        radius * angle.cos()
    }
}

/// A column of a gauge in the run of a case, at times [s] that are ends of steps.
fn curve(case: &Value, of: &str) -> Vec<(f64, f64)> {
    let mut problem = case_of(case, &[]).into_problem();
    let scene = build_scene(problem.take_system(), 1).expect("the case is good");
    let (gauge, column) = of.rsplit_once('.').expect("GAUGE.COLUMN");
    let columns = [ColumnName { gauge: gauge.to_owned(), column: column.to_owned() }];
    let mut rows = GaugeRows::new(&*scene, &problem.output, problem.time.end, &columns).expect("the gauge is there");
    let mut stepper = bind(&problem, &*scene).expect("the method fits the scene");
    let stop = AtomicBool::new(false);
    canopy_fem::drive::run(&*scene, &mut stepper, &problem.run_spec(), &mut [&mut rows], &stop).expect("it starts");
    let step = (EVERY / problem.time.step.fixed().expect("fixed steps")).round() as usize;
    rows.t.iter().copied().zip(rows.values[0].iter().copied()).step_by(step).skip(1).collect()
}

/// Writes data with noise of a standard deviation; it is in the file too if `given`.
fn write(path: &Path, points: &[(f64, f64)], sigma: f64, given: bool, noise: &mut Noise) -> Vec<f64> {
    let mut text = "t,value\n# measured\n".to_owned();
    let mut values = Vec::new();
    for (t, value) in points {
        values.push(value + sigma * noise.draw());
        text += &format!("{t:?},{:?}", values[values.len() - 1]);
        text += &if given { format!(",{sigma:?}\n") } else { "\n".to_owned() };
    }
    std::fs::write(path, text).expect("data are written");
    values
}

struct Asked<'a> {
    case: &'a Value,
    data: Vec<String>,
    vary: &'a [&'a str],
    offset: Option<&'a str>,
    starts: u32,
    threads: usize,
}

fn fit(asked: &Asked<'_>) -> Result<Fit, StudyError> {
    let vary: Vec<String> = asked.vary.iter().map(|text| (*text).to_owned()).collect();
    FitSpec {
        case: &case_of(asked.case, &[]),
        data: asked.data.iter().map(|text| DataSource::parse(text)).collect::<Result<_, _>>()?,
        vary: Parameter::parse_all(&vary)?,
        offset: asked.offset.map(|text| Range::parse(text).expect("a range")),
        starts: asked.starts,
        seed: 1,
        threads: asked.threads,
        interrupt: &AtomicBool::new(false),
        on_run: &|_| (),
    }
    .run()
}

fn values(fit: &Fit) -> Vec<f64> {
    fit.estimate.values.iter().map(|value| value.value).collect()
}

/// A mass that falls with a constant load: velocity Verlet is exact, x = a t^2/2 with a = F/m.
fn falling(load: f64) -> Value {
    json!({
        "name": "falling",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": [[0, 0, 0]], "springs": []}},
            "mass": {"nodal": 2.0},
            "loads": [{"on": "all", "force": [load, 0, 0]}]
        }},
        "time": {"end": 2.0, "method": "velocity-verlet", "step": 0.02},
        "output": {"gauges": [{"name": "mass", "on": "all", "of": "position"}]}
    })
}

/// Three masses that hang on springs and swing.
fn chain() -> Value {
    json!({
        "name": "chain",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": [[0, 0, 0], [0.3, 0, -1], [0.3, 0, -2], [0, 0, -3]],
                                  "springs": [[0, 1], [1, 2], [2, 3]]}},
            "mass": {"nodal": 0.5},
            "springs": [
                {"on": {"ids": [0]}, "stiffness": 300.0, "rest_length": 0.9, "dashpot": {"axial": {"coefficient": 0.8}}},
                {"on": {"ids": [1]}, "stiffness": 200.0, "rest_length": 0.95},
                {"on": {"ids": [2]}, "stiffness": 150.0}
            ],
            "supports": [{"on": {"ids": [0]}, "fix": "xyz"}],
            "gravity": [0, 0, -9.81]
        }},
        "acknowledge": ["initial-strain"],
        "time": {"end": 1.2, "method": "velocity-verlet", "step": 0.005},
        "output": {"gauges": [
            {"name": "upper", "on": {"ids": [1]}, "of": "position"},
            {"name": "lower", "on": {"ids": [3]}, "of": "position"},
            {"name": "line", "on": {"ids": [0]}, "of": "tension"}
        ]}
    })
}

/// Seven keys of the chain, with their values in it.
const SEVEN: [(&str, f64); 7] = [
    ("system.network.springs.0.stiffness=100..900", 300.0),
    ("system.network.springs.1.stiffness=log:50..800", 200.0),
    ("system.network.springs.2.stiffness=50..500", 150.0),
    ("system.network.springs.0.rest_length=0.7..1.1", 0.9),
    ("system.network.springs.1.rest_length=0.7..1.1", 0.95),
    ("system.network.springs.0.dashpot.axial.coefficient=0..5", 0.8),
    ("system.network.mass.nodal=0.2..1.5", 0.5),
];

/// Where the model is linear in the value, the fit is the closed form of weighted least squares, with its error.
#[test]
fn a_linear_fit_is_the_closed_form() {
    let (folder, sigma, m) = (tempfile::tempdir().expect("a folder"), 0.05, 2.0);
    let file = folder.path().join("x.csv");
    let points = curve(&falling(3.0), "mass.position_x");
    assert_eq!(points.len(), 100);
    for given in [true, false] {
        let data = write(&file, &points, sigma, given, &mut Noise::of(7));
        let fit = fit(&Asked {
            case: &falling(1.0),
            data: vec![format!("{}:mass.position_x", file.display())],
            vary: &["system.network.loads.0.force.0=0..10"],
            offset: None,
            starts: 1,
            threads: 1,
        })
        .expect("it fits");
        let basis: Vec<f64> = points.iter().map(|(t, _)| t * t / (2.0 * m)).collect();
        let square: f64 = basis.iter().map(|b| b * b).sum();
        let best: f64 = basis.iter().zip(&data).map(|(b, x)| b * x).sum::<f64>() / square;
        let rest: f64 = basis.iter().zip(&data).map(|(b, x)| (x - best * b).powi(2)).sum();
        let noise = if given { sigma } else { (rest / 99.0).sqrt() };
        let value = &fit.estimate.values[0];
        assert!((value.value / best - 1.0).abs() < 1e-9, "{} for {best}", value.value);
        let error = value.standard_error.expect("it is determined");
        assert!((error / (noise / square.sqrt()) - 1.0).abs() < 1e-6, "{error} for {}", noise / square.sqrt());
        let chi = fit.estimate.reduced_chi_square.map(|chi| chi / (rest / sigma.powi(2) / 99.0));
        assert_eq!(chi.is_some(), given);
        assert!(chi.is_none_or(|ratio| (ratio - 1.0).abs() < 1e-9));
    }
}

/// Data without noise give the values back, also those of a file in other units and with another zero of time.
#[test]
fn exact_data_give_the_values_back() {
    let folder = tempfile::tempdir().expect("a folder");
    let (x, line) = (folder.path().join("x.csv"), folder.path().join("line.csv"));
    let shifted = |points: Vec<(f64, f64)>, factor: f64| -> Vec<(f64, f64)> {
        points.into_iter().filter(|(t, _)| *t < 1.0).map(|(t, value)| (t - 0.06, value / factor)).collect()
    };
    write(&x, &shifted(curve(&chain(), "lower.position_z"), 1.0), 0.0, false, &mut Noise::of(1));
    write(&line, &shifted(curve(&chain(), "line.tension"), 1000.0), 0.0, false, &mut Noise::of(1));
    let mut start = chain();
    start["system"]["network"]["springs"][0]["stiffness"] = json!(450.0);
    start["system"]["network"]["mass"]["nodal"] = json!(0.8);
    let fit = fit(&Asked {
        case: &start,
        data: vec![format!("{}:lower.position_z", x.display()), format!("{}:line.tension*1000", line.display())],
        vary: &["system.network.springs.0.stiffness=100..900", "system.network.mass.nodal=log:0.2..1.5"],
        offset: Some("0.04..0.2"),
        starts: 1,
        threads: 2,
    })
    .expect("it fits");
    for (value, exact) in values(&fit).iter().zip([300.0, 0.5, 0.06]) {
        assert!((value / exact - 1.0).abs() < 1e-5, "{value} for {exact}");
    }
}

/// Only the ratio of stiffness and mass acts on a motion that begins with a velocity, so the data determine neither; a
/// key without any effect is told too.
#[test]
fn values_that_the_data_do_not_determine_are_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("x.csv");
    let case = json!({
        "name": "oscillator",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": [[0, 0, 0], [10, 0, 0]], "springs": [[0, 1]]}},
            "mass": {"nodal": 2.0},
            "springs": [{"on": "all", "stiffness": 3.0}],
            "supports": [{"on": {"ids": [0]}, "fix": "xyz"}, {"on": {"ids": [1]}, "fix": "yz"}],
            "gravity": [0, 0, -9.81],
            "initial": {"velocity": [1, 0, 0]}
        }},
        "time": {"end": 4.0, "method": "velocity-verlet", "step": 0.02},
        "output": {"gauges": [{"name": "mass", "on": {"ids": [1]}, "of": "position"}]}
    });
    write(&file, &curve(&case, "mass.position_x"), 0.01, false, &mut Noise::of(3));
    let asked = |vary| {
        let data = vec![format!("{}:mass.position_x", file.display())];
        fit(&Asked { case: &case, data, vary, offset: None, starts: 1, threads: 1 }).expect("it fits")
    };
    let determined =
        |fit: &Fit| fit.estimate.values.iter().map(|v| (v.determined, v.standard_error.is_some())).collect();
    let both = asked(&["system.network.springs.0.stiffness=1..9", "system.network.mass.nodal=1..9"]);
    let told: Vec<(bool, bool)> = determined(&both);
    assert_eq!(told, [(false, false); 2]);
    let ratio = values(&both)[0] / values(&both)[1];
    assert!((ratio / 1.5 - 1.0).abs() < 0.01, "k/m is known: {ratio}");
    let without_effect = asked(&["system.network.springs.0.stiffness=1..9", "system.network.gravity.2=-20..0"]);
    let told: Vec<(bool, bool)> = determined(&without_effect);
    assert_eq!(told, [(true, true), (false, false)]);
}

/// Each of seven values is in its own interval of 95 % in so many of 40 fits to other noise, as chance allows: of 280
/// intervals 266 in the mean with a standard deviation of 3.6, and of the 40 of one value 38 with 1.4.
#[test]
fn intervals_hold_the_truth_as_often_as_they_say() {
    let folder = tempfile::tempdir().expect("a folder");
    let gauges = [("upper.position_x", 0.004), ("lower.position_z", 0.01), ("line.tension", 0.3)];
    let curves = gauges.map(|(of, _)| curve(&chain(), of));
    let vary = SEVEN.map(|(vary, _)| vary);
    let mut inside = [0; SEVEN.len()];
    for seed in 0..40 {
        let mut noise = Noise::of(1000 + seed);
        let mut data = Vec::new();
        for ((of, sigma), points) in gauges.iter().zip(&curves) {
            let file = folder.path().join(format!("{of}.csv"));
            // The noise of one of them is given, that of the others is to be found.
            write(&file, points, *sigma, *of == "line.tension", &mut noise);
            data.push(format!("{}:{of}", file.display()));
        }
        let fit =
            fit(&Asked { case: &chain(), data, vary: &vary, offset: None, starts: 1, threads: 2 }).expect("it fits");
        for ((count, value), (_, exact)) in inside.iter_mut().zip(&fit.estimate.values).zip(SEVEN) {
            let holds = |Fitted { interval, .. }: &Fitted| interval.is_some_and(|[a, b]| a <= exact && exact <= b);
            *count += usize::from(holds(value));
        }
    }
    let all: usize = inside.iter().sum();
    assert!((255..=277).contains(&all), "{all} of 280: {inside:?}");
    assert!(inside.iter().all(|count| *count >= 34), "{inside:?}");
}

/// Starts that are spread over the ranges find the deepest of several minima; threads do not change a bit.
#[test]
fn several_starts_find_the_best_minimum_on_any_threads() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("z.csv");
    let mut case = chain();
    case["time"]["end"] = json!(3.0);
    write(&file, &curve(&case, "lower.position_z"), 0.002, false, &mut Noise::of(5));
    // Far too soft: the curves are out of step by whole periods.
    case["system"]["network"]["springs"][2]["stiffness"] = json!(12.0);
    let asked = |starts, threads| {
        let data = vec![format!("{}:lower.position_z", file.display())];
        let vary = &["system.network.springs.2.stiffness=log:10..1000"];
        fit(&Asked { case: &case, data, vary, offset: None, starts, threads }).expect("it fits")
    };
    let [one, two] = [asked(6, 1), asked(6, 2)];
    assert!((values(&one)[0] / 150.0 - 1.0).abs() < 0.01, "{:?}", one.starts);
    let text = |fit: &Fit| serde_json::to_string(fit).expect("json");
    assert_eq!(text(&one), text(&two));
}

/// What cannot be fitted says why.
#[test]
fn faults_of_a_fit_are_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("x.csv");
    let case = falling(1.0);
    let key = "system.network.loads.0.force.0=0..10";
    let fault = |content: &str, of: &str, vary: &[&str], offset| {
        std::fs::write(&file, content).expect("data are written");
        let data = vec![format!("{}:{of}", file.display())];
        match fit(&Asked { case: &case, data, vary, offset, starts: 1, threads: 1 }) {
            Ok(_) => panic!("{content} {of} {vary:?} fits"),
            Err(why) => why.to_string(),
        }
    };
    let good = "0.1,1\n0.2,2\n";
    for (content, of, vary, offset, words) in [
        ("0.1\n", "mass.position_x", key, None, "expected 2 or 3 numbers"),
        ("0.1,1\n0.1,2\n", "mass.position_x", key, None, "times must ascend"),
        ("t,x\na,b\n", "mass.position_x", key, None, "line 2: a field is no number"),
        ("t,x\n", "mass.position_x", key, None, "no points"),
        ("0.1,1,0\n", "mass.position_x", key, None, "must be above 0"),
        ("0.1,1,1\n0.2,1\n", "mass.position_x", key, None, "some lines have a standard deviation"),
        ("0.1,1\n3,2\n", "mass.position_x", key, None, "the run goes from 0 to 2 s"),
        (good, "mass.position_x", key, Some("-1..1"), "the run goes from 0 to 2 s"),
        (good, "riser.tension", key, None, "there is no gauge of this name here; there are mass"),
        (good, "mass.tension", key, None, "there is no column of this name here; there are position_x"),
        (good, "mass", key, None, "expected FILE:GAUGE.COLUMN"),
        (good, "mass.position_x*0", key, None, "is no factor"),
        (good, "mass.position_x", "a.b=3..1", None, "must be below the second"),
        (good, "mass.position_x", "a.b=log:0..1", None, "needs a range above 0"),
        (good, "mass.position_x", "system.network.springs.0.stiffness=1..2", None, "springs"),
    ] {
        let told = fault(content, of, &[vary], offset);
        assert!(told.contains(words), "{told}");
    }
    let three = ["system.network.mass.nodal=1..3", key, "system.network.loads.0.force.1=0..1"];
    assert!(fault(good, "mass.position_x", &three, None).contains("2 points of data cannot determine 3 values"));
}
