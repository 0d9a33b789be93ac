//! The lift of a body that glides: its drag, turned by a right angle in the vertical plane of its heading, times its
//! glide ratio.
//!
//! ```text
//! e = (sin psi, cos psi, 0),   n = e_z x e,   u = wind - v
//! f_lift = (L/D) n x f_drag,   f = M f_drag,   M = I + (L/D) [n]x
//! ```
//! The lift is normal to u, so it does no work on the air that goes with the wind, and normal to n, so it lies in the
//! plane of e and the vertical. In a vertical fall it points along e, and it is up and forward in a glide. The part of
//! u across the plane is a sideslip: there is no lift by it. M does not depend on the state, so that all tangents of
//! the drag are multiplied by it.

use crate::force::Copies;
use crate::force::law::series::{Table, scalar};
use crate::model::spec::GlideSpec;
use nalgebra::{Matrix3, Vector3};
use std::sync::Arc;

/// A glide in a run.
#[derive(Clone, Debug)]
pub struct Glide {
    /// [-] lift over drag
    ratio: f64,
    /// [deg] heading over time
    heading: Arc<Table<1>>,
}

impl Glide {
    /// That of a specification whose heading has at least one row.
    pub fn new(spec: &GlideSpec) -> Self {
        Glide { ratio: spec.ratio, heading: scalar(&spec.heading) }
    }

    /// Its heading over time.
    pub fn heading(&self) -> &Arc<Table<1>> {
        &self.heading
    }

    /// The same in another run.
    #[must_use]
    pub(crate) fn for_run(&self, copies: &mut Copies) -> Self {
        Glide { heading: copies.of(&self.heading), ..*self }
    }

    /// [-] M at time `t` [s]: what the drag is multiplied by.
    pub fn matrix(&self, t: f64) -> Matrix3<f64> {
        let [heading] = self.heading.at(t);
        let (sine, cosine) = heading.to_radians().sin_cos();
        Matrix3::identity() + (self.ratio * Vector3::new(-cosine, sine, 0.0)).cross_matrix()
    }
}
