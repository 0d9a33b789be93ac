//! Several runs of one scene at the same time: each has the bits of the same run of a scene of its own.

use crate::common::run::asset;
use canopy_fem::case::spec::SystemSpec;
use canopy_fem::mesh::source::MeshSource;
use canopy_fem::model::spec::{
    AtmosphereSpec, DashpotKind, DashpotSpec, GustSpec, LineDragSpec, MotionSpec, NetworkSpec, NodeDragSpec,
    PressureKind, PressureLoad, RayleighSpec, ReleaseSpec, Series, Slack, SpringGroup, SpringValues, StreamSpec,
};
use canopy_fem::scene::Scene;
use canopy_fem::simulation::{Load, NetworkBuilder, RunSpec, Simulation, SpringLaw, build_scene};

/// Times and values of one number, or of several.
fn series<T>(rows: Vec<(f64, T)>) -> Series<T> {
    let (t, value) = rows.into_iter().unzip();
    Series { t, value }
}

/// Every third spring of a group, or the others.
fn some(group: &SpringGroup, thirds: bool) -> SpringGroup {
    let keep: Vec<usize> = (0..group.edges.len()).filter(|i| (i % 3 == 0) == thirds).collect();
    let pick = |values: &[f64]| keep.iter().map(|&i| values[i]).collect::<Vec<f64>>();
    let of_some = |values: &SpringValues| keep.iter().filter_map(|&i| values.get(i)).collect::<SpringValues>();
    let dashpot = group.dashpot.as_ref().map(|d| DashpotSpec { coefficient: of_some(&d.coefficient), ..d.clone() });
    SpringGroup {
        edges: keep.iter().map(|&i| group.edges[i]).collect(),
        stiffness: of_some(&group.stiffness),
        rest_length: pick(&group.rest_length),
        dashpot,
        ..group.clone()
    }
}

/// A cloth with all that changes in a run: springs that are cut and reeled, supports that let go and move, tables of
/// loads, base and wind with corners within steps, and a gust of less than a step.
fn eventful() -> NetworkSpec {
    let rectangle = r#"{"rectangle": {"width": 1, "height": 1, "columns": 5, "rows": 5, "pattern": "crossed"}}"#;
    let mesh = serde_json::from_str::<MeshSource>(rectangle).expect("a mesh").build(std::path::Path::new("."));
    let dashpot = Some((DashpotKind::Axial, 0.02));
    let mut spec = NetworkBuilder::from_mesh(mesh.expect("a mesh"))
        .springs_on_edges(SpringLaw { stiffness: 300.0, slack: Slack::TensionOnly, dashpot, ..SpringLaw::default() })
        .total_mass(0.2)
        .hold(|_, x| x[0] == 0.0)
        .gravity([0.0, 0.0, -9.81])
        .force(&[8, 9], [0.01, 0.0, 0.02])
        .build()
        .expect("a mesh");
    let all = spec.springs[0].clone();
    spec.springs = vec![some(&all, true), some(&all, false)];
    spec.springs[0].cut = Some(0.0312);
    spec.springs[1].rest_scale = Some(series(vec![(0.0101, 1.0), (0.0307, 0.97)]));
    spec.rayleigh = Some(RayleighSpec { mass: 0.1, stiffness: 1e-4 });
    let held: Vec<u32> = (0..).zip(&spec.fixed).filter(|(_, fixed)| fixed[0]).map(|(node, _)| node).collect();
    spec.releases = vec![ReleaseSpec { t: 0.0213, nodes: vec![(held[0], [true; 3])], ..ReleaseSpec::default() }];
    let rise = series(vec![(0.0, [0.0; 3]), (0.0153, [0.0, 0.0, 0.01]), (0.04, [0.0; 3])]);
    let nodes = vec![(held[1], [false, false, true])];
    spec.motions = vec![MotionSpec { nodes, displacement: rise, settlement: [0.0; 3] }];
    spec.forces[0].factor = Some(series(vec![(0.0, 0.0), (0.0104, 3.0), (0.0109, 1.0)]));
    let factor = Some(series(vec![(0.0051, 0.0), (0.0053, 1.0), (0.0057, 0.2)]));
    let triangles: Vec<u32> = (0..spec.mesh.triangles.len() as u32).collect();
    let dead = PressureKind::Dead(Some([0.0, 0.0, 1.0]));
    for kind in [PressureKind::Follower, dead] {
        spec.pressures.push(PressureLoad { triangles: triangles.clone(), pressure: 2.0, factor: factor.clone(), kind });
    }
    spec.base_acceleration = Some(series(vec![(0.0, [0.0; 3]), (0.0117, [3.0, 0.0, 1.0]), (0.0123, [0.0; 3])]));
    spec.stream = Some(StreamSpec {
        wind: series(vec![(0.0, [1.0, 0.0, 0.0]), (0.0221, [1.0, 0.0, 0.0]), (0.0224, [0.0, 2.0, 1.0])]),
        gusts: vec![GustSpec { start: 0.0071, duration: 3e-4, velocity: [0.0, 0.0, 20.0] }],
        profile: None,
        by_event: Vec::new(),
        atmosphere: AtmosphereSpec::Constant { density: 1.2 },
        altitude: 0.0,
    });
    spec.node_drag = vec![NodeDragSpec { nodes: vec![7, 8], drag_area: 0.01, glide: None }];
    spec.line_drag = vec![LineDragSpec { edges: vec![3, 4, 5], diameter: 0.01, coefficient: 1.0 }];
    spec
}

/// What one of the runs does on its way.
type Change = fn(&mut Simulation);

/// Runs of different methods and steps. The first changes loads, wind, rest lengths and forces, the others do not.
const RUNS: [(&str, f64, Change); 4] = [
    ("velocity-verlet", 2e-4, |sim| {
        sim.set_load_factor(Load::Gravity, 0.5).expect("a load");
        sim.set_load_factor(Load::Forces(0), -1.0).expect("a load");
        sim.set_wind(Some([0.0, 0.0, 3.0])).expect("air");
        sim.set_rest_scale(&[5, 6], 0.98).expect("springs");
        sim.set_force("mine", &vec![[0.0, 0.001, 0.0]; sim.node_count()]).expect("a force");
    }),
    ("newmark", 1e-3, |_| {}),
    ("multirate", 5e-4, |_| {}),
    ("rk4", 3e-4, |_| {}),
];

fn begun(scene: &dyn Scene, (method, step, _): (&str, f64, Change)) -> Simulation {
    Simulation::from_scene(scene, RunSpec::fixed(method, step, 0.05).expect("registered")).expect("it starts")
}

/// A part of a run, of eight.
fn go(sim: &mut Simulation, part: u32, change: Change) {
    if part == 3 {
        change(sim);
    }
    sim.run_until(0.006 * f64::from(part)).expect("it goes on");
}

/// All that a run shows at its end.
fn end(mut sim: Simulation) -> (Vec<u8>, Vec<u64>) {
    let shown = sim.tensions().into_iter().chain(sim.reactions().into_iter().flatten());
    let shown = shown.map(f64::to_bits).collect();
    (sim.snapshot().expect("idle"), shown)
}

fn whole(scene: &dyn Scene, run: (&str, f64, Change)) -> (Vec<u8>, Vec<u64>) {
    let mut sim = begun(scene, run);
    (1..=8).for_each(|part| go(&mut sim, part, run.2));
    end(sim)
}

#[test]
fn runs_of_one_scene_do_not_see_each_other() {
    let built = || build_scene(SystemSpec::Network(Box::new(eventful())), 1).expect("a scene");
    let alone = RUNS.map(|run| whole(&*built(), run));
    assert!(alone[1..].iter().all(|other| other.1 != alone[0].1), "the runs differ");
    let scene = built();
    // In turns.
    let mut sims = RUNS.map(|run| begun(&*scene, run));
    for part in 1..=8 {
        sims.iter_mut().zip(RUNS).for_each(|(sim, run)| go(sim, part, run.2));
    }
    assert!(sims.map(end) == alone, "in turns");
    // On threads of their own, each twice.
    let scene = &*scene;
    let at_once = std::thread::scope(|scope| {
        let threads = [RUNS, RUNS].as_flattened().iter().map(|&run| scope.spawn(move || whole(scene, run)));
        let threads: Vec<_> = threads.collect();
        threads.into_iter().map(|thread| thread.join().expect("no panic")).collect::<Vec<_>>()
    });
    assert!(at_once == [alone.clone(), alone].as_flattened(), "at once");
}

/// A parachute's canopy holds the air around it in several places.
#[test]
fn drops_of_one_parachute_do_not_see_each_other() {
    let case = asset("parachute/c9-drop", &[("time.end", "0.5")]);
    let built = || build_scene(case.problem().system.clone(), 1).expect("a scene");
    let spec = || case.problem().run_spec();
    let run = |scene: &dyn Scene, wind: Option<[f64; 3]>| {
        let mut sim = Simulation::from_scene(scene, spec()).expect("it starts");
        sim.set_wind(wind).expect("air");
        sim.steps(20).expect("it goes on");
        end(sim)
    };
    let winds = [None, Some([5.0, 0.0, 0.0])];
    let alone = winds.map(|wind| run(&*built(), wind));
    assert!(alone[0] != alone[1], "the wind acts");
    let (scene, run) = (&*built(), &run);
    let at_once = std::thread::scope(|scope| {
        let threads = winds.map(|wind| scope.spawn(move || run(scene, wind)));
        threads.map(|thread| thread.join().expect("no panic"))
    });
    assert!(at_once == alone);
}
