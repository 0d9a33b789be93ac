//! Two-node elements that pull along a difference: springs along `xb - xa`, dashpots along `vb - va`.
//!
//! ```text
//! d = ub - ua      force on a = s d, on b = -s d
//! ```
//! To add such a force, write a [`PullLaw`]: s and the energy or power from d, as equations on four numbers at once.

use super::batch::LANES;
use super::coefficient::Place;
use super::phases::{Phases, add};
use super::window::{Padded, Records, record, set_record};
use crate::model::quad::{Quad, VectorUnit};

/// How elements pull.
pub(super) trait PullLaw {
    /// Four elements with the components of their differences; `#[inline(always)]`.
    fn pull<U: VectorUnit>(&self, unit: U, place: Place, d: [U::Quad; 3]) -> Pull<U::Quad>;
}

/// What four elements do.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pull<Q> {
    /// force on node a by difference
    pub scale: Q,
    /// [J] or [W] energy or power
    pub amount: Q,
}

/// Adds the forces [N] of elements to a window; `u` is the nodal vector of the differences.
pub(super) fn pull<L: PullLaw>(law: L, nodes: &[[u16; 2]], u: &Records, f: &mut Records) -> f64 {
    add(Pulling { law, u: u }, nodes, f)
}

struct Pulling<'a, L> {
    law: L,
    u: &'a Records,
}

#[derive(Clone, Copy, Default)]
#[repr(align(32))]
struct Kept {
    d: [Padded; LANES],
    scale: [Padded; 2],
}

impl<L: PullLaw> Phases<2> for Pulling<'_, L> {
    type Kept = Kept;

    #[inline(always)]
    fn measure<U: VectorUnit>(&self, unit: U, at: Place, nodes: &[[u16; 2]; LANES], kept: &mut Kept) -> U::Quad {
        let mut d = [unit.splat(0.0); 4];
        for j in 0..4 {
            let [a, b] = nodes[4 * at.half + j];
            d[j] = unit.quad(record(self.u, b)) - unit.quad(record(self.u, a));
            kept.d[4 * at.half + j] = d[j].numbers();
        }
        let Pull { scale, amount } = self.law.pull(unit, at, U::Quad::columns(d));
        kept.scale[at.half] = scale.numbers();
        amount
    }

    #[inline(always)]
    fn scatter<U: VectorUnit>(&self, unit: U, nodes: &[[u16; 2]], kept: &Kept, f: &mut Records) {
        for (j, &[a, b]) in nodes.iter().enumerate().take(LANES) {
            let force = unit.splat(kept.scale[j / 4][j % 4]) * unit.quad(kept.d[j]);
            set_record(f, a, (unit.quad(record(f, a)) + force).numbers());
            set_record(f, b, (unit.quad(record(f, b)) - force).numbers());
        }
    }
}
