//! The forces of an energy-momentum step, of every term at random states: their work, and their tangents.

use super::scenes::{scenes, uneven_scenes};
use super::{Sample, build, columns};
use canopy_fem::assembly::{MeanSystem, TangentSystem};
use canopy_fem::model::forces::Forces;
use canopy_fem::model::state::StateRef;
use canopy_fem::model::system::{StepMean, System, Weights};
use canopy_fem::scene::{Network, Scene};

/// [s] Half of a step in which bars turn and stretch by a fifth.
const HALF: f64 = 0.05;
/// [-] Difference that no rounding makes.
const KINK: f64 = 1e-3;
/// [-] Off by so much of the largest entry of its column. In wrinkles the tangent leaves out how the cuts of the way
/// move, which matters as much as the sum at five points is off the integral.
const TOLERANCE: f64 = 1e-7;
const IN_WRINKLES: f64 = 1e-5;

fn at(sample: &Sample, by: f64) -> (Vec<f64>, &[f64]) {
    (sample.x.iter().zip(&sample.v).map(|(x, v)| x + by * v).collect(), &sample.v)
}

/// A sample whose held nodes do not move.
fn sample_of(scene: &Network, seed: u64) -> Sample {
    let mut sample = Sample::new(scene, seed);
    sample.v.iter_mut().zip(scene.inverse_mass()).filter(|(_, m)| **m == 0.0).for_each(|(v, _)| *v = 0.0);
    sample
}

fn mean(scene: &Network, dissipation: f64) -> MeanSystem<'_> {
    MeanSystem { system: scene, mean: StepMean { half: HALF, dissipation } }
}

/// [J] Energy that is stored more at the end than at the start, and its sum at both.
fn gain(scene: &Network, sample: &Sample) -> [f64; 2] {
    let energy = |by: f64| {
        let ((x, v), mut forces) = (at(sample, by), scene.new_forces());
        scene.evaluate(StateRef { t: sample.t, x: &x, v }, &mut forces);
        forces.tallies.iter().map(|tally| tally.energy).sum::<f64>()
    };
    let [start, end] = [-HALF, HALF].map(energy);
    [end - start, end.abs() + start.abs()]
}

/// [J] Work of elastic forces and weight over a step, and the sum of its parts without their signs.
fn work(sample: &Sample, forces: &Forces) -> [f64; 2] {
    let other = |of: &[f64], i: usize| of.get(i).copied().unwrap_or(0.0);
    let works = (0..sample.x.len()).map(|i| {
        let stored = forces.total[i] - other(&forces.external, i) - other(&forces.dissipative, i);
        stored * 2.0 * HALF * sample.v[i]
    });
    works.fold([0.0; 2], |[sum, size], work| [sum + work, size + work.abs()])
}

/// What a step takes from the energies is the work of their forces; with dissipation it gives back less, and somewhere
/// much less.
#[test]
fn elastic_forces_do_the_work_that_their_energies_lose() {
    let mut lost = 0.0_f64;
    for (name, spec) in scenes() {
        let scene = build(spec);
        for seed in 0..super::STATES {
            let (sample, mut forces) = (sample_of(&scene, seed), scene.new_forces());
            let [gained, stored] = gain(&scene, &sample);
            for dissipation in [0.0, 0.3, 1.0] {
                mean(&scene, dissipation).evaluate(sample.at(), &mut forces);
                let [work, size] = work(&sample, &forces);
                let missing = -work - gained;
                let rounding = 1e-13 * (stored + size);
                assert!(missing >= -rounding, "{name}, state {seed}, chi {dissipation}: {missing} J were made");
                assert!(dissipation > 0.0 || missing <= rounding, "{name}, state {seed}: {missing} J are missing");
                lost = lost.max(missing / (stored + size).max(1.0));
            }
        }
    }
    assert!(lost > 0.05, "dissipation took {lost} of the energy at most");
}

/// As a step becomes short, its mean forces become those at a state, with the square of the step.
#[test]
fn mean_forces_of_short_steps_are_forces() {
    for (name, spec) in scenes().into_iter().chain(uneven_scenes()) {
        let scene = build(spec);
        for seed in 0..super::STATES {
            let (sample, mut forces, mut expected) = (sample_of(&scene, seed), scene.new_forces(), scene.new_forces());
            scene.evaluate(sample.at(), &mut expected);
            let short = StepMean { half: 1e-7, dissipation: 0.0 };
            MeanSystem { system: &scene, mean: short }.evaluate(sample.at(), &mut forces);
            for (i, (found, expected)) in forces.total.iter().zip(&expected.total).enumerate() {
                let off = (found - expected).abs() / (1.0 + expected.abs());
                assert!(off < 1e-6, "{name}, state {seed}: {found} and not {expected} at {:?}", scene.name_of(i));
            }
        }
    }
}

/// W of mean forces, with what couples the whole scene, unknown by unknown.
fn matrix(scene: &Network, sample: &Sample, dissipation: f64) -> Vec<Vec<f64>> {
    let (mean, w) = (mean(scene, dissipation), Weights { m: 0.0, c: 1.0 / HALF, k: 1.0 });
    let mut assembler = mean.assembler().expect("small");
    mean.assemble(sample.at(), w, &mut assembler);
    let mut w_of = columns(&assembler);
    let dof = &assembler.pattern.dof;
    for which in 0..mean.rank_ones() {
        let (mut u, mut g) = (vec![0.0; scene.n_dof()], vec![0.0; scene.n_dof()]);
        mean.rank_one(which, sample.at(), w, &mut u, &mut g);
        for (column, &j) in w_of.iter_mut().zip(dof.iter()) {
            column.iter_mut().zip(dof.iter()).for_each(|(w, &i)| *w += u[i as usize] * g[j as usize]);
        }
    }
    w_of
}

/// The middle moves by d and so the end by 2 d, while the start stays: v grows by d/(h/2).
fn moved(sample: &Sample, dof: usize, d: f64) -> Sample {
    let mut moved = Sample { t: sample.t, x: sample.x.clone(), v: sample.v.clone() };
    moved.x[dof] += d;
    moved.v[dof] += d / HALF;
    moved
}

#[test]
fn tangents_of_mean_forces_equal_their_differences() {
    let (mut compared, mut at_kinks) = (0, 0);
    for (name, spec) in scenes().into_iter().chain(uneven_scenes()) {
        let scene = build(spec);
        let tolerance =
            if name.contains("wrinkling") || name.contains("of a membrane") { IN_WRINKLES } else { TOLERANCE };
        let free: Vec<usize> = (0..scene.n_dof()).filter(|&i| scene.inverse_mass()[i] > 0.0).collect();
        for (seed, dissipation) in [(0, 0.0), (1, 0.4), (2, 0.0), (3, 1.0)] {
            let sample = sample_of(&scene, seed);
            let exact = matrix(&scene, &sample, dissipation);
            for (j, &dof) in free.iter().enumerate() {
                let d = 1e-4;
                let force = |by: f64| {
                    let mut forces = scene.new_forces();
                    mean(&scene, dissipation).evaluate(moved(&sample, dof, by * d).at(), &mut forces);
                    forces.total
                };
                let [p1, m1, p2, m2] = [1.0, -1.0, 2.0, -2.0].map(force);
                for (i, &row) in free.iter().enumerate() {
                    let expected = -(8.0 * (p1[row] - m1[row]) - (p2[row] - m2[row])) / (12.0 * d);
                    let size = 1.0 + exact[j].iter().fold(0.0, |most: f64, w| most.max(w.abs()));
                    if (exact[j][i] - expected).abs() <= tolerance * size {
                        compared += 1;
                        continue;
                    }
                    // Only a kink of the force inside the stencil may spoil the difference: the slope jumps there.
                    let [before, after] =
                        [-2.0, 2.0].map(|by| matrix(&scene, &moved(&sample, dof, by * d), dissipation));
                    assert!(
                        (before[j][i] - after[j][i]).abs() > KINK * size,
                        "{name}, state {seed}: W[{i}, {j}] is {} by its formula and {expected} by differences",
                        exact[j][i]
                    );
                    at_kinks += 1;
                }
            }
        }
    }
    assert!(compared > 30_000 && at_kinks < compared / 100, "{compared} entries compared, {at_kinks} at kinks");
}
