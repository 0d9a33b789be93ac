//! Strides of a scene that is one tile: its nodes stay in the tile's windows from the first step to the last, and nothing is copied between.

use super::NodeState;
use super::around::Moving;
use super::stride::Between;
use super::sweep::{Sweep, Terms};
use super::threads::{SUMS, Threads, Windows};
use super::tile::Tile;
use super::window::{Padded, Window, rows, store_rows};
use crate::model::stride::{Nodes, Passed};
use bytemuck::cast_slice_mut;
use glam::DVec3;

impl Sweep {
    /// Whether all nodes and elements are in one tile, and all terms in one sum.
    pub fn resides<T: Terms + ?Sized>(&self, terms: &T) -> bool {
        self.tiling.tiles().len() == 1 && (0..terms.count()).all(|i| terms.term(i).1 == 0)
    }

    /// [`Sweep::stride`] of such a scene.
    pub(super) fn stride_in_windows<T: Terms + ?Sized>(
        &self,
        (terms, mut moving): (&T, Moving<'_>),
        Between { kicks, mass, inverse_mass }: Between<'_>,
        threads: &Threads,
        [total, others @ ..]: [&mut [DVec3]; SUMS],
        passed: &mut [Passed],
    ) {
        let n = mass.len();
        moving.before(0..n, threads.workers());
        let windows = &mut *threads.windows(0);
        let Windows { x, v, sums: [f, m, _] } = windows;
        let [x, v, f, m] = [x, v, f, m].map(Window::records);
        for (from, to) in [(&*moving.x, &mut *x), (&*moving.v, &mut *v), (inverse_mass, &mut *m)] {
            fill(from, rows(to, n));
        }
        rows(f, n).fill(Padded::default());
        let steps = passed.len();
        for (step, passed) in passed.iter_mut().enumerate() {
            let at = NodeState { t: moving.t, x: &[], v: &[] };
            let tile = Tile { number: 0, own: 0..n, at, x, v };
            passed.tallies.clear();
            passed.tallies.extend((0..terms.count()).map(|i| terms.term(i).0.add(&tile, f)));
            let stretches = (0..terms.count()).map(|i| terms.term(i).0.largest_stretch(&tile));
            passed.largest_stretch =
                if passed.stretch_wanted { stretches.fold(f64::NEG_INFINITY, f64::max) } else { f64::NEG_INFINITY };
            let nodes: Nodes<'_, 4> = Nodes {
                mass,
                inverse_mass: rows(m, n).as_flattened(),
                x: rows(x, n).as_flattened_mut(),
                v: rows(v, n).as_flattened_mut(),
                f: rows(f, n).as_flattened_mut(),
            };
            passed.nodes = kicks.end(nodes, step + 1 < steps);
        }
        for (from, to) in [(x, cast_slice_mut(moving.x)), (v, cast_slice_mut(moving.v)), (f, total)] {
            store_rows(rows(from, n), to);
        }
        others.into_iter().for_each(|other| other.fill(DVec3::ZERO));
    }
}

/// Copies vectors into as many records, with 0 in their fourth numbers, which kicks move as all others.
fn fill(from: &[f64], to: &mut [Padded]) {
    for (&[x, y, z], to) in from.as_chunks().0.iter().zip(to) {
        *to = [x, y, z, 0.0];
    }
}
