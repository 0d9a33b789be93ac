//! The equations do not know where the origin is, how axes are turned, what units are used, how nodes are numbered, or
//! how many threads compute: neither may the results.

use super::nets::{Net, net};
use canopy_fem::case::Case;
use canopy_fem::drive::Status;
use canopy_fem::integrate::registry::{MethodInfo, methods};
use canopy_fem::simulation::{FollowSpec, follow};
use proptest::prelude::*;
use proptest::test_runner::TestCaseError;
use std::path::PathBuf;

/// The end of a run.
struct End {
    status: Status,
    steps: u64,
    positions: Vec<[f64; 3]>,
    velocities: Vec<[f64; 3]>,
}

fn run(net: &Net, method: &str, threads: usize) -> Result<End, TestCaseError> {
    let fail = |error: &dyn std::fmt::Display| TestCaseError::fail(format!("{method}: {error}"));
    let sets = [("time.method".to_owned(), method.to_owned())];
    let case = Case::from_text(net.case().to_string(), "net.json", PathBuf::new(), &sets);
    let case = case.map_err(|error| fail(&error))?;
    let (mut positions, mut velocities) = (Vec::new(), Vec::new());
    let outcome = follow(case.problem(), FollowSpec { threads, keep_going: false }, |seen| {
        positions = seen.positions.to_vec();
        velocities = seen.velocities.to_vec();
    });
    let outcome = outcome.map_err(|error| fail(&error))?;
    Ok(End { status: outcome.status, steps: outcome.steps, positions, velocities })
}

/// Runs two nets with every method and compares positions by `place` and velocities by `turn` of the first with those
/// of the second, whose node `number(i)` is the first's node i.
struct Comparison<'a> {
    nets: [&'a Net; 2],
    place: &'a dyn Fn([f64; 3]) -> [f64; 3],
    turn: &'a dyn Fn([f64; 3]) -> [f64; 3],
    number: &'a dyn Fn(usize) -> usize,
    /// [-] of the scene's size and of the largest speed; 0 asks for the same bits
    allowed: f64,
}

impl Comparison<'_> {
    fn hold(&self) -> Result<(), TestCaseError> {
        self.hold_but_for(&[])
    }

    /// The same without some methods.
    fn hold_but_for(&self, left_out: &[&str]) -> Result<(), TestCaseError> {
        let mut held = methods().iter().filter(|method| !left_out.contains(&method.name));
        held.try_for_each(|method| self.hold_for(method))
    }

    fn hold_for(&self, method: &MethodInfo) -> Result<(), TestCaseError> {
        let [first, second] = self.nets.map(|net| run(net, method.name, 1));
        let (first, second) = (first?, second?);
        prop_assert_eq!((first.status, first.steps), (second.status, second.steps), "{}", method.name);
        let largest = |list: &[[f64; 3]]| list.iter().flatten().fold(0.0_f64, |m, x| m.max(x.abs()));
        let places: Vec<[f64; 3]> = first.positions.iter().map(|p| (self.place)(*p)).collect();
        let speeds: Vec<[f64; 3]> = first.velocities.iter().map(|v| (self.turn)(*v)).collect();
        let compared = [("positions", places, &second.positions), ("velocities", speeds, &second.velocities)];
        for (what, expected, found) in compared {
            let allowed = self.allowed * largest(&expected).max(1e-3 * largest(found));
            for (i, expected) in expected.iter().enumerate() {
                let found = found[(self.number)(i)];
                let off = (0..3).map(|c| (found[c] - expected[c]).abs()).fold(0.0, f64::max);
                prop_assert!(off <= allowed, "{} of node {i} with {}: {found:?}, not {expected:?}", what, method.name);
            }
        }
        Ok(())
    }
}

fn same(v: [f64; 3]) -> [f64; 3] {
    v
}

/// Another unit of length, mass and time is a power of two in every number: not a bit of what is computed may change,
/// or some constant with a unit hides in the code. Powers of four, since Cholesky takes roots.
fn in_units(net: &Net, [length, mass, time]: [f64; 3]) -> Net {
    let mut other = net.clone();
    let scale = |vectors: &mut Vec<[f64; 3]>, by: f64| vectors.iter_mut().flatten().for_each(|x| *x *= by);
    scale(&mut other.nodes, length);
    scale(&mut other.velocity, length / time);
    other.masses.iter_mut().for_each(|m| *m *= mass);
    other.stiffness *= mass / time / time;
    other.dashpot *= mass / time;
    other.gravity.iter_mut().for_each(|g| *g *= length / time / time);
    other.wind.iter_mut().for_each(|v| *v *= length / time);
    other.air_density *= mass / length / length / length;
    other.pressure *= mass / length / time / time;
    other.rayleigh = [net.rayleigh[0] / time, net.rayleigh[1] * time];
    other.step *= time;
    other
}

/// A power of `base`.
fn power(base: f64) -> impl Strategy<Value = f64> {
    (-10_i32..=10).prop_map(move |e| base.powi(e))
}

/// Rotation about a unit axis (Rodrigues' formula).
fn rotate(v: [f64; 3], axis: [f64; 3], angle: f64) -> [f64; 3] {
    let size = axis.iter().map(|a| a * a).sum::<f64>().sqrt();
    let [x, y, z] = axis.map(|a| a / size);
    let (s, c) = angle.sin_cos();
    let along = (1.0 - c) * (x * v[0] + y * v[1] + z * v[2]);
    let across = [y * v[2] - z * v[1], z * v[0] - x * v[2], x * v[1] - y * v[0]];
    [c * v[0] + s * across[0] + along * x, c * v[1] + s * across[1] + along * y, c * v[2] + s * across[2] + along * z]
}

proptest! {
    #![proptest_config(super::config(24))]

    #[test]
    fn units_do_not_matter_to_the_bit(net in net(), length in power(4.0), mass in power(4.0), time in power(4.0)) {
        let other = in_units(&net, [length, mass, time]);
        let scaled = |by: f64| move |v: [f64; 3]| v.map(|x| x * by);
        let (place, turn) = (scaled(length), scaled(length / time));
        Comparison { nets: [&net, &other], place: &place, turn: &turn, number: &|i| i, allowed: 0.0 }.hold()?;
    }

    #[test]
    fn the_origin_does_not_matter(net in net(), offset in prop::array::uniform3(-1e3..1e3_f64)) {
        let mut other = net.clone();
        let place = |p: [f64; 3]| std::array::from_fn(|c| p[c] + offset[c]);
        other.nodes.iter_mut().for_each(|p| *p = place(*p));
        // 1e3 m are rounded to 1e-13 m, which a few steps carry on.
        Comparison { nets: [&net, &other], place: &place, turn: &same, number: &|i| i, allowed: 1e-10 }.hold()?;
    }

    #[test]
    fn axes_do_not_matter(net in net(), axis in prop::array::uniform3(0.1..1.0_f64), angle in 0.0..6.3_f64) {
        let mut other = net.clone();
        let turn = |v: [f64; 3]| rotate(v, axis, angle);
        for vectors in [&mut other.nodes, &mut other.velocity] {
            vectors.iter_mut().for_each(|v| *v = turn(*v));
        }
        (other.gravity, other.wind) = (turn(net.gravity), turn(net.wind));
        Comparison { nets: [&net, &other], place: &turn, turn: &turn, number: &|i| i, allowed: 1e-9 }.hold()?;
    }

    #[test]
    fn numbering_does_not_matter(net in net(), seed in any::<u64>()) {
        let n = net.nodes.len();
        // Fisher and Yates with a linear congruence.
        let (mut number, mut state) = ((0..n).collect::<Vec<_>>(), seed);
        for i in (1..n).rev() {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            number.swap(i, (state >> 33) as usize % (i + 1));
        }
        let mut other = net.clone();
        for (i, &to) in number.iter().enumerate() {
            (other.nodes[to], other.masses[to], other.velocity[to]) = (net.nodes[i], net.masses[i], net.velocity[i]);
        }
        other.springs = net.springs.iter().rev().map(|s| s.map(|i| number[i])).collect();
        other.triangles = net.triangles.iter().rev().map(|t| t.map(|i| number[i])).collect();
        other.held = net.held.iter().map(|&i| number[i]).collect();
        let number = |i: usize| number[i];
        let compared = Comparison { nets: [&net, &other], place: &same, turn: &same, number: &number, allowed: 1e-9 };
        // Sweeps that have not converged depend on the order of springs or nodes.
        compared.hold_but_for(&["xpbd", "vbd"])?;
    }

    #[test]
    fn threads_do_not_matter_to_the_bit(net in net()) {
        for method in methods() {
            let (one, two) = (run(&net, method.name, 1)?, run(&net, method.name, 2)?);
            prop_assert_eq!((one.status, one.steps), (two.status, two.steps));
            prop_assert_eq!((one.positions, one.velocities), (two.positions, two.velocities), "{}", method.name);
        }
    }
}
