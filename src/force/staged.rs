//! Strides of Runge-Kutta methods, of a scene that is one tile and has springs and weight alone: its nodes stay in the
//! tile's windows from the first step to the last.

use super::sweep::{Sweep, Terms};
use super::threads::{Resident, SUMS, Threads, Windows};
use super::tile::Tile;
use super::told::{Sums, Told};
use super::window::{RECORD, Records, Window, fill, rows, store_rows};
use crate::model::forces::Tally;
use crate::model::point::Point;
use crate::model::stride::{Kicks, Nodes, Passed, Staged, Stages};
use bytemuck::cast_slice_mut;
use glam::DVec3;

/// Where steps begin, and what they are made of.
#[derive(Clone, Copy)]
pub struct ByStages<'a> {
    /// where the first begins
    pub from: &'a Point,
    /// what each is made of
    pub stages: Stages<'a>,
    /// [kg] one a node
    pub mass: &'a [f64],
    /// [1/kg] by degree of freedom, 0 at fixed ones
    pub inverse_mass: &'a [f64],
}

/// Where a stride ends.
pub struct Ended<'a> {
    /// [m]
    pub x: &'a mut [f64],
    /// [m/s]
    pub v: &'a mut [f64],
    /// [N]
    pub f: &'a mut [DVec3],
}

impl Sweep {
    /// As many steps as there are entries of `passed`, of terms of the first sum alone, where the scene [is one
    /// tile](Sweep::resides). State, forces and what is told of every step have the bits of steps made one by one.
    pub fn stride_by_stages<T: Terms + ?Sized>(
        &self,
        terms: &T,
        ByStages { from, stages, mass, inverse_mass }: ByStages<'_>,
        threads: &Threads,
        to: Ended<'_>,
        passed: &mut [Passed],
    ) {
        let n = mass.len();
        let windows = &mut *threads.windows(0);
        let Windows { x, v, sums, resident: Resident { inverse_mass: m, before, kicked, kept, summed } } = windows;
        let [x, v, m, x_n, v_n, x_s, v_s] = [x, v, m, before, kicked, kept, summed].map(Window::records);
        let sums = sums.each_mut().map(Window::records);
        let started = [(&from.state.x, &mut *x), (&from.state.v, &mut *v), (&from.forces.total, &mut *sums[0])];
        for (from, to) in started {
            fill(from, rows(to, n));
        }
        fill(inverse_mass, rows(m, n));
        let mut net = Net { terms, mass, at: [x, v], from: [x_n, v_n], sum: [x_s, v_s], m, sums };
        for passed in passed {
            passed.tallies.resize(terms.count(), Tally::default());
            net.step(stages, passed);
        }
        let Net { at: [x, v], sums: [f, ..], .. } = net;
        store_rows(rows(x, n), cast_slice_mut(to.x));
        store_rows(rows(v, n), cast_slice_mut(to.v));
        store_rows(rows(f, n), to.f);
    }
}

/// A scene in its windows.
struct Net<'a, T: ?Sized> {
    terms: &'a T,
    /// [kg] one a node
    mass: &'a [f64],
    /// [m] and [m/s] where passes find nodes, where the step began, and where it ends
    at: [&'a mut Records; 2],
    from: [&'a mut Records; 2],
    sum: [&'a mut Records; 2],
    /// [1/kg] by degree of freedom
    m: &'a mut Records,
    /// [N] all forces; the other sums are not there
    sums: [&'a mut Records; SUMS],
}

impl<T: Terms + ?Sized> Net<'_, T> {
    /// A step that ends at `passed.t`, from the forces at its start. Neither springs nor weight depend on time, so that
    /// stages need none of their own.
    fn step(&mut self, stages: Stages<'_>, passed: &mut Passed) {
        stages.begin(&mut self.nodes());
        for stage in 0..stages.others.len() {
            self.find(passed);
            stages.go_on(&mut self.nodes(), stage);
        }
        self.find(passed);
        let n = self.mass.len();
        let flat = |records| rows(records, n).as_flattened_mut();
        let [x, v] = self.at.each_mut().map(|records| flat(records));
        let nodes: Nodes<'_, RECORD> =
            Nodes { mass: self.mass, inverse_mass: flat(self.m), x, v, kicked: &mut [], f: flat(self.sums[0]) };
        // Nothing moves: this is the account alone.
        passed.nodes = Kicks { begin: 0.0, drift: 0.0, end: None, predicts: false }.end(nodes, false);
        let tile = Tile { number: 0, own: 0..n, t: passed.t, x: self.at[0], v: self.at[1] };
        passed.largest_stretch = self.terms.largest_stretch(&tile, passed.stretch_wanted);
    }

    /// The forces where nodes are.
    fn find(&mut self, passed: &mut Passed) {
        let n = self.mass.len();
        let tile = Tile { number: 0, own: 0..n, t: passed.t, x: self.at[0], v: self.at[1] };
        let sums = self.sums.each_mut().map(|sum| &mut **sum);
        let mut sums = Sums { n, sums, present: [true, false, false], kept: &mut [] };
        sums.add(self.terms, Told::All, &tile, &mut passed.tallies);
    }

    fn nodes(&mut self) -> Staged<'_> {
        let Net { mass, at, from, sum, m, sums: [f, ..], .. } = self;
        let n = mass.len();
        let flat = |records| rows(records, n).as_flattened_mut();
        let [at, from, sum] = [at, from, sum].map(|pair| pair.each_mut().map(|records| flat(records)));
        Staged { inverse_mass: flat(m), at, from, sum, f: flat(f) }
    }
}
