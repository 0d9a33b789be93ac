//! Strip-out: a pack whose bag lets go of bights and folds by a table of cuts.

use super::*;
use crate::common::run::{case_of, network};

/// [N] axial rigidity of what ties the pack to its bag
const TIE: f64 = 200.0;
/// [s] The last release.
const RELEASED: f64 = 0.24;

/// A small canopy of six gores, packed; its payload leaves at 8 m/s, nothing else acts. The rings of bights, skirt and
/// folds are let go one after another.
fn stripped() -> Value {
    let damped = |rigidity: f64, density: Value| {
        let mut rule = json!({
            "axial_rigidity": rigidity, "slack": "tension-only", "dashpot": {"axial": {"time": 0.001}}
        });
        if !density.is_null() {
            rule["linear_density"] = density;
        }
        rule
    };
    let on = |group: &str, mut rule: Value| {
        rule["on"] = json!({"group": group});
        rule
    };
    let line = || damped(2000.0, json!(0.003));
    let mut stows = on("stows", damped(TIE, Value::Null));
    stows["cut"] = json!({"table": [[0.0, 0.0], [RELEASED, 1.0]], "together": 6});
    let cloth = json!({
        "on": {"group": "cloth"}, "membrane": {"modulus": 1e8, "thickness": 1e-4}, "slack": "tension-only",
        "dashpot": {"axial": {"time": 0.001}}
    });
    let springs = [cloth, on("radials", line()), on("lines", line()), on("riser", line())];
    let ties = [on("bridle", damped(TIE, Value::Null)), stows];
    // Four rows of six nodes, the confluence, two nodes in each line, the payload and the bag.
    let mut velocity = vec![[0.0; 3]; 39];
    velocity[37] = [0.0, 0.0, -8.0];
    json!({
        "name": "strip-out",
        "system": {"network": {
            "mesh": {"parachute": {
                "type": "flat-circular", "nominal_diameter": 1.5, "vent_diameter": 0.15, "vent_lines": false,
                "gores": 6, "radial_segments": 3, "lines": {"length": 1.2, "segments": 3}, "riser": {"length": 0.1},
                "start": {"packed": {"length": 0.15, "radius": 0.05, "bag": true}}
            }},
            "mass": {"areal_density": 0.05, "points": [
                {"on": {"group": "payload"}, "mass": 10.0}, {"on": {"group": "bag"}, "mass": 5.0}
            ]},
            "springs": springs.into_iter().chain(ties).collect::<Vec<_>>(),
            "initial": {"velocity": velocity}
        }},
        "time": {"end": 0.4, "method": "newmark", "step": 0.0005}
    })
}

/// Lines strip out before the canopy: each ring of line pieces is taut for the first time after the one below it, and
/// all are before the cloth at the vent is. Nothing leaves the bag before its release, momentum is kept, and the
/// energy account closes.
#[test]
fn lines_strip_out_before_the_canopy() {
    let case = case_of(&stripped(), &[]);
    let spec = network(&case);
    let mesh = &spec.mesh;
    let mut simulation = Simulation::from_case(case.problem(), 1).expect("a scene");
    let rest: Vec<f64> = {
        let at = simulation.positions();
        let place = |node: u32| Vector::from(at[node as usize]);
        mesh.edges.iter().map(|&[a, b]| (place(a) - place(b)).norm()).collect()
    };
    let momentum = |simulation: &Simulation| -> Vector {
        simulation.velocities().iter().zip(&spec.mass).map(|(v, m)| Vector::from(*v) * *m).sum()
    };
    let (at_start, before) = (momentum(&simulation), simulation.energies().kinetic);
    let stows = &group(mesh, "stows").edges;
    let mut first_taut = vec![f64::INFINITY; mesh.edges.len()];
    let mut last_taut = vec![0.0; mesh.edges.len()];
    let (mut farthest, mut pull) = (0.0_f64, 0.0_f64);
    while simulation.time() < 0.4 - 1e-9 {
        simulation.step().expect("it goes on");
        let (t, tensions, at) = (simulation.time(), simulation.tensions(), simulation.positions());
        for (edge, _) in tensions.iter().enumerate().filter(|(_, tension)| **tension > 0.0) {
            first_taut[edge] = first_taut[edge].min(t);
            last_taut[edge] = t;
        }
        for (i, &edge) in stows.iter().enumerate() {
            // The table is a straight line: a ring i of five goes at (i + 1)/5 of its time.
            let release = RELEASED * (i / 6 + 1) as f64 / 5.0;
            let [bag, node] = mesh.edges[edge as usize].map(|node| Vector::from(at[node as usize]));
            if t <= release - 1e-9 {
                let stretch = (bag - node).norm() / rest[edge as usize] - 1.0;
                farthest = farthest.max(stretch);
                pull = pull.max(tensions[edge as usize]);
            } else if t > release + 1e-9 {
                let tension = tensions[edge as usize];
                assert!(tension.is_nan() || tension <= 0.0, "stow {i} pulls at {t} s, after {release} s");
            }
        }
        let lost = (momentum(&simulation) - at_start).norm();
        assert!(lost < 1e-6, "{lost} N s of {at_start:?} are lost at {t} s");
    }
    assert!(pull > 10.0, "the stows held nothing: {pull} N");
    assert!(farthest < 1.2 * pull / TIE, "a row left the bag by {farthest} of its stow, whose pull was {pull} N");
    let energies = simulation.energies();
    let left = energies.kinetic + energies.elastic + energies.dissipated + energies.numerical;
    assert!((left - before).abs() < 1e-6 * before, "{left} J of {before} J");
    assert!(energies.numerical.abs() < 0.02 * before, "{energies:?}");

    // Line pieces by their distance from the confluence: each line lists them from the skirt.
    let lines = &group(mesh, "lines").edges;
    assert_eq!(lines.len(), 18);
    let of_ring = |from_confluence: usize| lines.iter().skip(2 - from_confluence).step_by(3).map(|&edge| edge as usize);
    let begins = |edges: &mut dyn Iterator<Item = usize>| {
        edges.map(|edge| first_taut[edge]).fold([f64::INFINITY, 0.0_f64], |[a, b], t| [a.min(t), b.max(t)])
    };
    let rings: Vec<[f64; 2]> = (0..3).map(|ring| begins(&mut of_ring(ring))).collect();
    let vent: Vec<usize> = group(mesh, "radials").edges.iter().take(6).map(|&edge| edge as usize).collect();
    assert!(vent.iter().all(|&edge| mesh.edges[edge].iter().any(|node| *node < 6)), "radials begin at the vent");
    let canopy = begins(&mut vent.into_iter());
    assert!(rings.windows(2).all(|pair| pair[0][1] < pair[1][0]), "{rings:?}");
    assert!(rings[2][1] < canopy[0], "lines {rings:?}, canopy {canopy:?}");
    let straight = lines.iter().all(|&edge| last_taut[edge as usize] > RELEASED);
    assert!(straight, "some line was never straight after the last release");
}

/// A bag without a mass is a fault that says so.
#[test]
fn a_bag_needs_a_mass() {
    let mut case = stripped();
    case["system"]["network"]["mass"]["points"].as_array_mut().expect("a list").pop();
    let text = match Case::from_text(case.to_string(), "test.json", PathBuf::new(), &[]) {
        Ok(_) => String::new(),
        Err(error) => error.to_string(),
    };
    assert!(text.contains("/system/network/mass") && text.contains("the bag of a pack"), "{text}");
}
