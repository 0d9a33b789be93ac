//! Improved Euler in the readings its text allows, written out by hand on the program's own forces.

use super::runs::Failed;
use canopy_fem::case::Case;
use canopy_fem::model::forces::Forces;
use canopy_fem::model::state::State;
use canopy_fem::scene::Scene;
use canopy_fem::simulation::build_scene;

/// What "Improved Euler" may mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reading {
    /// Eq. 23-24: both derivatives, two passes
    Heun,
    /// the text: the derivative of the predicted state is kept for the next step, one pass
    NeverCorrected,
    /// section 3.1: every scheme "took the internal and the external forces", made once a step
    FrozenForces,
    /// frozen forces, and the corrector averages them with none
    HalfForce,
}

impl Reading {
    pub const ALL: [Reading; 4] = [Reading::Heun, Reading::NeverCorrected, Reading::FrozenForces, Reading::HalfForce];

    pub fn name(self) -> &'static str {
        match self {
            Reading::Heun => "Eq. 23-24 (Heun), two force passes",
            Reading::NeverCorrected => "\"never corrected\", one pass",
            Reading::FrozenForces => "forces made once and handed to the scheme",
            Reading::HalfForce => "forces handed over, second derivative left at zero",
        }
    }
}

/// [s] First time a state is not finite or has left 1e4 times the scene's size; nothing within 1.5e-10 s.
pub fn blow_up(case: &Case, reading: Reading, h: f64) -> Result<Option<f64>, Failed> {
    let scene = build_scene(case.problem().system.clone(), 1)?;
    let mut walk = Walk::start(&*scene);
    let steps = (case.problem().time.end / h).round() as u64;
    for k in 1..=steps {
        walk.step(reading, h);
        let extent = scene.extent(walk.now.as_ref());
        if extent.is_nan() || extent > 1e4 * scene.size() {
            return Ok(Some(k as f64 * h));
        }
    }
    Ok(None)
}

struct Walk<'a> {
    scene: &'a dyn Scene,
    now: State,
    predicted: State,
    forces: Forces,
    /// derivative of (x, v) that the next step starts with
    slope: Slope,
}

#[derive(Clone, Default)]
struct Slope {
    v: Vec<f64>,
    a: Vec<f64>,
}

impl<'a> Walk<'a> {
    fn start(scene: &'a dyn Scene) -> Self {
        let now = scene.initial_state();
        let mut walk = Walk { scene, predicted: now.clone(), now, forces: scene.new_forces(), slope: Slope::default() };
        walk.slope = walk.derivative(&walk.now.clone());
        walk
    }

    fn derivative(&mut self, at: &State) -> Slope {
        self.scene.evaluate(at.as_ref(), &mut self.forces);
        let a = self.forces.total.iter().zip(self.scene.inverse_mass()).map(|(f, w)| f * w).collect();
        let held = |(v, w): (&f64, &f64)| if *w > 0.0 { *v } else { 0.0 };
        Slope { v: at.v.iter().zip(self.scene.inverse_mass()).map(held).collect(), a }
    }

    fn step(&mut self, reading: Reading, h: f64) {
        let first = match reading {
            Reading::NeverCorrected => self.slope.clone(),
            _ => self.derivative(&self.now.clone()),
        };
        self.predicted.t = self.now.t + h;
        for i in 0..self.now.x.len() {
            self.predicted.x[i] = self.now.x[i] + h * first.v[i];
            self.predicted.v[i] = self.now.v[i] + h * first.a[i];
        }
        let second = match reading {
            Reading::Heun | Reading::NeverCorrected => self.derivative(&self.predicted.clone()),
            Reading::FrozenForces => Slope { v: self.predicted.v.clone(), a: first.a.clone() },
            Reading::HalfForce => Slope { v: self.predicted.v.clone(), a: vec![0.0; first.a.len()] },
        };
        self.now.t += h;
        for i in 0..self.now.x.len() {
            self.now.x[i] += 0.5 * h * (first.v[i] + second.v[i]);
            self.now.v[i] += 0.5 * h * (first.a[i] + second.a[i]);
        }
        self.slope = second;
    }
}
