//! The states at the frame times of a run: kept, or compared with those of a reference.
//!
//! Frames are what `solve` would write: the state at every multiple of the interval and at the end, a frame between two
//! steps being their cubic Hermite interpolation.

use crate::drive::observer::{AcceptedStep, ObserveError, Observer, Point, UpcomingStep, Wants};
use crate::model::state::State;
use crate::output::hermite::interpolate;
use crate::output::schedule::{FrameDue, Schedule, tolerance};
use crate::scene::Scene;
use serde::{Deserialize, Serialize};

/// Frames and what the scene did in them, in the user's numbering.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Frames {
    /// nodes a frame
    pub nodes: usize,
    /// [m] positions, frame by frame
    pub positions: Vec<[f64; 3]>,
    /// size of the motion
    pub motion: Motion,
}

/// How far a scene moved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Motion {
    /// [m^2] sum of squares of the distances from the start, over all frames and nodes
    pub squares: f64,
    /// [m] the largest distance from the start
    pub largest: f64,
    /// [m^2/s^2] sum of squares of the velocities
    pub velocity_squares: f64,
    /// number of frames after the start
    pub frames: u64,
}

impl Motion {
    /// [s] About the period of what moves most: 2 pi over the quotient of the root mean squares of velocity and motion.
    pub fn period(&self) -> f64 {
        std::f64::consts::TAU * (self.squares / self.velocity_squares).sqrt()
    }
}

/// How far a run is from the reference; part of what is kept of an unfinished run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Distance {
    /// [m^2] sum of squares, over all frames and nodes
    pub squares: f64,
    /// [m] the largest
    pub largest: f64,
    /// frames that were compared
    pub frames: u64,
}

impl Distance {
    /// Between two sequences of frames.
    pub fn between(a: &Frames, b: &Frames) -> Self {
        let mut distance = Distance { frames: a.motion.frames, ..Distance::default() };
        distance.add(&a.positions, &b.positions);
        distance
    }

    fn add(&mut self, a: &[[f64; 3]], b: &[[f64; 3]]) {
        for (a, b) in a.iter().zip(b) {
            let square = distance_squared(a, b);
            self.squares += square;
            self.largest = larger(self.largest, square.sqrt());
        }
    }

    /// [-] Root mean square over that of the motion, and the largest over the largest; nothing if frames are missing or
    /// not numbers.
    pub fn over(&self, motion: Motion) -> Option<[f64; 2]> {
        let relative = [(self.squares / motion.squares).sqrt(), self.largest / motion.largest];
        (self.frames == motion.frames && relative.iter().all(|e| e.is_finite())).then_some(relative)
    }
}

/// The larger of two numbers, NaN if one of them is; `f64::max` would drop it and hide the error.
fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) }
}

fn distance_squared(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

/// What is done with frames.
enum Purpose<'a> {
    Keep(Frames),
    Compare(&'a Frames, Distance),
}

/// An observer that visits the frames of a run.
pub struct Sampler<'a> {
    scene: &'a dyn Scene,
    schedule: Schedule,
    /// [s] last frame that was visited
    last: f64,
    between: State,
    start: Vec<[f64; 3]>,
    positions: Vec<[f64; 3]>,
    velocities: Vec<[f64; 3]>,
    purpose: Purpose<'a>,
}

impl<'a> Sampler<'a> {
    /// Keeps the frames of a run at every multiple of `every` [s].
    pub fn keeping(scene: &'a dyn Scene, every: f64) -> Self {
        let nodes = scene.reference().len();
        Self::of(scene, Schedule::new(Some(every), 0.0), Purpose::Keep(Frames { nodes, ..Frames::default() }))
    }

    /// Compares the frames of a run with those of the reference, which are `every` [s] apart. A run that is taken up at
    /// `from` [s] brings the distance it had come to.
    pub fn comparing(scene: &'a dyn Scene, every: f64, reference: &'a Frames, from: f64, so_far: Distance) -> Self {
        let mut sampler = Self::of(scene, Schedule::new(Some(every), from), Purpose::Compare(reference, so_far));
        sampler.last = from;
        sampler
    }

    fn of(scene: &'a dyn Scene, schedule: Schedule, purpose: Purpose<'a>) -> Self {
        let between = scene.initial_state();
        let nodes = scene.reference().len();
        let (mut start, mut velocities) = (vec![[0.0; 3]; nodes], vec![[0.0; 3]; nodes]);
        scene.trace(between.as_ref(), &mut start, &mut velocities);
        Sampler { scene, schedule, last: 0.0, between, positions: start.clone(), start, velocities, purpose }
    }

    /// The frames that were kept.
    pub fn into_frames(self) -> Frames {
        match self.purpose {
            Purpose::Keep(frames) => frames,
            Purpose::Compare(..) => Frames::default(),
        }
    }

    /// The distance that was found.
    pub fn distance(&self) -> Distance {
        match &self.purpose {
            Purpose::Compare(_, distance) => *distance,
            Purpose::Keep(_) => Distance::default(),
        }
    }

    fn visit(&mut self, state: &State) {
        self.last = state.t;
        self.scene.trace(state.as_ref(), &mut self.positions, &mut self.velocities);
        match &mut self.purpose {
            Purpose::Keep(frames) => {
                frames.positions.extend_from_slice(&self.positions);
                let motion = &mut frames.motion;
                motion.frames += 1;
                for ((x, v), x0) in self.positions.iter().zip(&self.velocities).zip(&self.start) {
                    let square = distance_squared(x, x0);
                    motion.squares += square;
                    motion.largest = larger(motion.largest, square.sqrt());
                    motion.velocity_squares += v.iter().map(|v| v * v).sum::<f64>();
                }
            }
            Purpose::Compare(reference, distance) => {
                let begin = distance.frames as usize * reference.nodes;
                if let Some(frame) = reference.positions.get(begin..begin + reference.nodes) {
                    distance.add(&self.positions, frame);
                }
                distance.frames += 1;
            }
        }
    }
}

impl Observer for Sampler<'_> {
    fn wants(&self, step: UpcomingStep) -> Wants {
        Wants { states: self.schedule.states(step), strain: false }
    }

    fn accepted(&mut self, step: AcceptedStep<'_>) -> Result<(), ObserveError> {
        while let Some(due) = self.schedule.next_in(step.from, step.t) {
            match (due, step.start, step.end) {
                (FrameDue::End, _, Some(end)) => self.visit(&end.state),
                (FrameDue::Between(at), Some(start), Some(end)) => {
                    let mut between = std::mem::take(&mut self.between);
                    interpolate(start.state.as_ref(), end.state.as_ref(), at.fraction, &mut between);
                    self.visit(&between);
                    self.between = between;
                }
                // Not without a state that was asked for.
                _ => {}
            }
        }
        Ok(())
    }

    fn finished(&mut self, last: &Point) -> Result<(), ObserveError> {
        if last.state.t - self.last > tolerance(self.last, last.state.t) {
            self.visit(&last.state);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A node that is nowhere stays in the largest distance, whatever follows it.
    #[test]
    fn a_distance_keeps_what_is_no_number() {
        let at = |x: [f64; 3]| Frames { nodes: 1, positions: x.map(|x| [x, 0.0, 0.0]).to_vec(), ..Frames::default() };
        assert_eq!(Distance::between(&at([0.0, 3.0, 1.0]), &at([0.0; 3])).largest, 3.0);
        let lost = Distance::between(&at([0.0, f64::NAN, 1.0]), &at([0.0; 3]));
        assert!(lost.largest.is_nan() && lost.squares.is_nan(), "{lost:?}");
    }
}
