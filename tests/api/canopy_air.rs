//! What the air may do to a canopy as a whole: it takes energy from every canopy that moves through it without
//! deforming, whatever its shape, attitude and motion; and the force across the axis at an angle of attack.

use crate::common::Random;
use crate::common::parachute::Parachute;
use crate::common::run::case_of;
use canopy_fem::case::spec::SystemSpec;
use canopy_fem::force::schedule::threads::Threads;
use canopy_fem::model::state::StateRef;
use canopy_fem::model::system::System;
use canopy_fem::scene::{Network, Scene, build_network};
use nalgebra::{Rotation3, Vector3};
use serde_json::{Value, json};

const SMALL: Parachute = Parachute { gores: 8, rings: 4, line_segments: 2, nominal_diameter: 2.0, line_length: 2.0 };
/// [m/s]
const WIND: [f64; 3] = [3.0, -2.0, 1.0];
/// [m^2] of the schedules
const DRAG_AREA: f64 = 2.4;

/// The canopy in a wind, with its air.
fn scene(air: &str) -> Network {
    let mut case = SMALL.case(1.7, 4.0, 6.0);
    let aero = &mut case["system"]["network"]["aero"];
    aero["wind"] = json!(WIND);
    match air {
        "schedule" => {
            aero["canopy"]["schedule"] = json!({"drag_area": DRAG_AREA, "filling_time": 1e-3, "start": -1.0});
        }
        "cavity" => {
            aero["canopy"]["cavity"] = json!({"inflow": 0.4, "outer_pressure_coefficient": -0.6,
                "law": {"permeable": {"a": 1.6e6, "b": 4.8e5, "thickness": 1e-4}}});
        }
        _ => {}
    }
    if air != "table" {
        aero["canopy"]["table"] = Value::Null;
    }
    match &case_of(&case, &[]).problem().system {
        SystemSpec::Network(spec) => build_network((**spec).clone(), Threads::one()).expect("it builds"),
        SystemSpec::Pendulum(_) => panic!("a network"),
    }
}

/// The force of the air [N] on all nodes at one velocity [m/s].
fn force(scene: &Network, x: &[f64], velocity: Vector3<f64>) -> Vector3<f64> {
    let v: Vec<f64> = (0..x.len()).map(|dof| velocity[dof % 3]).collect();
    let mut forces = scene.new_forces();
    scene.evaluate(StateRef { t: 1.0, x, v: &v }, &mut forces);
    forces.external.chunks(3).map(|f| Vector3::new(f[0], f[1], f[2])).sum()
}

/// Positions moved node by node, by the user's number of each.
fn moved(scene: &Network, x: &[f64], to: impl FnMut((usize, Vector3<f64>)) -> Vector3<f64>) -> Vec<f64> {
    let node = |i: usize| (scene.name_of(3 * i).0 as usize, Vector3::new(x[3 * i], x[3 * i + 1], x[3 * i + 2]));
    (0..x.len() / 3).map(node).map(to).flat_map(<[f64; 3]>::from).collect()
}

/// A shape of the canopy: squeezed, pulled long, crumpled, turned inside out against its lines, and leaning.
fn shape(scene: &Network, random: &mut Random) -> Vec<f64> {
    let scale = Vector3::new(1.0 + 0.99 * random.next(), 1.0 + 0.99 * random.next(), 1.5 * random.next());
    let crumpled = if random.next() > 0.0 { 0.0 } else { 0.4 };
    let lean = Rotation3::from_scaled_axis(1.5 * Vector3::from(random.vector()));
    moved(scene, &scene.initial_state().x, |(node, at)| {
        let noise = crumpled * Vector3::from(random.vector());
        if node == SMALL.payload() { at } else { lean * at.component_mul(&scale) + noise }
    })
}

/// F . u <= 0 with the velocity u against the undisturbed wind: no state gives a canopy more energy than the stream has
/// lost to it.
#[test]
fn the_air_takes_energy_in_every_shape_and_attitude() {
    for air in ["table", "schedule", "cavity"] {
        let scene = scene(air);
        let mut random = Random(17);
        let (mut taken, mut most) = (0, 0.0_f64);
        for number in 0..4000 {
            let x = shape(&scene, &mut random);
            let size = 10.0_f64.powf(2.0 * random.next());
            let u = size * Vector3::from(random.vector());
            let force = force(&scene, &x, u + Vector3::from(WIND));
            let (power, scale) = (force.dot(&u), force.norm() * u.norm());
            assert!(power <= 1e-9 * scale, "{air}, state {number}: {power} W of {scale} at {u:?}");
            taken += u32::from(power < -0.1 * scale);
            most = most.max(force.norm() / (0.6125 * u.norm_squared()));
        }
        assert!(taken > 2000, "{air}: {taken} states with a force against the motion");
        // Whatever the shape, the force stays near that of the drag area that is given.
        assert!(air != "schedule" || most < 3.5 * DRAG_AREA, "{air}: {most} m^2");
    }
}

/// While the drag area A is given, a canopy that moves at the angle alpha to its axis meets rho/2 A V^2 along it and
/// rho/2 A |u| |u_n| across: no lift at small angles, whatever the shape. A reefed canopy had a slope of 30 there.
#[test]
fn the_side_force_follows_the_drag_area() {
    let scene = scene("schedule");
    for squeeze in [1.0, 0.6] {
        // Deep like a tube: much of the cloth faces sideways.
        let start = moved(&scene, &scene.initial_state().x, |(node, at)| match node == SMALL.payload() {
            true => at,
            false => Vector3::new(squeeze * at.x, squeeze * at.y, at.z - 0.5 * at.xy().norm()),
        });
        for angle in [0.0_f64, 0.1, 0.3, 1.0] {
            let speed = 12.0;
            let u = speed * Vector3::new(angle.sin(), 0.0, -angle.cos());
            let found = force(&scene, &start, u + Vector3::from(WIND));
            let q = 0.5 * 1.225 * DRAG_AREA * speed * speed;
            let expected = q * Vector3::new(-angle.sin(), 0.0, angle.cos().powi(2));
            assert!((found - expected).norm() < 1e-9 * q, "{squeeze}, {angle}: {found:?} {expected:?}");
        }
    }
}

/// An opening that is too small for its drag area has the drag of at most six times q.
#[test]
fn an_opening_has_no_more_drag_than_air_can_give() {
    let scene = scene("schedule");
    let start = scene.initial_state();
    let opening = 8.0 * 0.5 * SMALL.radius().powi(2) * (std::f64::consts::PI / 4.0).sin();
    for squeeze in [1.0_f64, 0.8, 0.4, 0.1, 0.01] {
        let x = moved(&scene, &start.x, |(node, at)| match node <= 8 * 4 {
            true => Vector3::new(squeeze * at.x, squeeze * at.y, at.z),
            false => at,
        });
        let found = force(&scene, &x, Vector3::new(0.0, 0.0, -10.0) + Vector3::from(WIND)).z / (0.6125 * 100.0);
        let mouth = opening * squeeze * squeeze;
        let expected = if DRAG_AREA <= 3.0 * mouth { DRAG_AREA } else { 3.0 * mouth * (2.0 - 3.0 * mouth / DRAG_AREA) };
        assert!((found / expected - 1.0).abs() < 1e-9, "{squeeze}: {found} {expected}");
    }
}
