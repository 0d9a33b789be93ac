//! Schemes that kick, drift and possibly kick again: their updates of nodes between force passes.
//!
//! ```text
//! v += l M^-1 f                       a step ends: kinetic energy and largest speed; where none follows, bounds, and whether all is finite
//! v += k M^-1 f,  x += h v            the next begins
//! ```
//! and for schemes that first evaluate forces at predicted velocities, with the second kick before the step ends,
//! ```text
//! u = v + k M^-1 f,  x += h u,  v += h M^-1 f         a step begins
//! v = u + l M^-1 f                                    with the forces at these
//! ```
//! Nodes are updated four by four: as three quads if their vectors are packed, and as four if they are records (of four
//! numbers, the last of them 0). Operations and their order are those of single steps, and so are the bits.

use super::groups::{Group, begun, columns, filled, groups, groups_mut};
use super::work::{Sums, along};
use super::{NodeSums, Work};
use crate::model::bounds::Bounds;
use crate::model::motion::{BLOCK, MotionSum};
use crate::model::point::Point;
use crate::model::quad::{self, Quad, Real, VectorUnit};
use multiversion::multiversion;
use std::ops::Range;

/// A step v += k M^-1 f, x += h v, then with the new forces v += l M^-1 f.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KickDriftScheme {
    /// [s] k
    pub begin: f64,
    /// [s] h
    pub drift: f64,
    /// [s] l, if there is a second kick
    pub end: Option<f64>,
    /// whether the second kick uses the forces at velocities v + h M^-1 f, before those at the step's end are evaluated
    pub predicts: bool,
}

/// The start of a step: the same degrees of freedom of every vector.
#[derive(Clone, Copy, Debug)]
pub struct StepStart<'a> {
    /// [m]
    pub x: &'a [f64],
    /// [m/s]
    pub v: &'a [f64],
    /// [N]
    pub f: &'a [f64],
    /// [1/kg] 0 at fixed ones
    pub inverse_mass: &'a [f64],
}

impl<'a> StepStart<'a> {
    /// Some degrees of freedom of a point.
    pub fn of(from: &'a Point, inverse_mass: &'a [f64], dofs: Range<usize>) -> Self {
        let Point { state, forces } = from;
        let [x, v, f, inverse_mass] = [&state.x, &state.v, &forces.total, inverse_mass].map(|all| &all[dofs.clone()]);
        StepStart { x, v, f, inverse_mass }
    }
}

/// Some nodes at the end of a step: vectors with `W` numbers per node.
#[derive(Debug)]
pub struct Nodes<'a, const W: usize> {
    /// [kg] `[n_nodes]`
    pub mass: &'a [f64],
    /// [1/kg] by degree of freedom, 0 at fixed ones
    pub inverse_mass: &'a [f64],
    /// [m]
    pub x: &'a mut [f64],
    /// [m/s]
    pub v: &'a mut [f64],
    /// [m/s] u of the next step, if the scheme predicts; else empty
    pub kicked: &'a mut [f64],
    /// [N] forces of a pass at x; need not be 0 at fixed degrees of freedom. If another step follows, those of records
    /// are set to 0, because its pass adds to them
    pub f: &'a mut [f64],
    /// forces whose work is summed, if there are any
    pub works: Option<Working<'a>>,
}

/// Forces whose work is summed, of the same nodes.
#[derive(Debug)]
pub struct Working<'a> {
    /// [N] external and dissipative forces at the step's end; empty if there are none
    pub forces: [&'a [f64]; 2],
    /// [m] positions at the start of the step; afterwards, those at its end
    pub before: &'a mut [f64],
}

impl KickDriftScheme {
    /// Force passes per step.
    pub fn passes(self) -> usize {
        1 + usize::from(self.predicts)
    }

    /// Moves nodes from the start of a step to the state of its first force pass: positions at the step's end,
    /// velocities kicked or predicted.
    pub fn begin(self, start: StepStart<'_>, x: &mut [f64], v: &mut [f64]) {
        begin(self, start, x, v);
    }

    /// The kick after the first force pass, with its forces f [N]: v += l M^-1 f of kicked velocities. Predicted
    /// velocities are first replaced by the kicked ones.
    pub fn kick_again(self, start: StepStart<'_>, v: &mut [f64], f: &[f64]) {
        match self.end {
            Some(l) if self.predicts => kick_twice(self.begin, l, start, v, f),
            Some(l) => kick(l, start.inverse_mass, v, f),
            None if self.predicts => kick_twice(self.begin, 0.0, start, v, f),
            None => {}
        }
    }

    /// v = u + l M^-1 f, for schemes that predict.
    pub fn correct(self, v: &mut [f64], kicked: &[f64], inverse_mass: &[f64], f: &[f64]) {
        correct(v, kicked, self.end.unwrap_or_default(), inverse_mass, f);
    }

    /// Ends a step, and begins the next one if there is one.
    pub fn end<const W: usize>(self, nodes: Nodes<'_, W>, another: bool) -> BoundarySums {
        quad::run(Pass { scheme: self, nodes, another })
    }
}

/// Sums over the nodes at the boundary of two steps.
#[derive(Clone, Copy, Debug)]
pub struct BoundarySums {
    /// their motion, with twice the work of the forces at the step's end over this step
    pub nodes: NodeSums,
    /// [J] twice the work of these forces over the next step
    pub next: Work,
}

struct Pass<'a, const W: usize> {
    scheme: KickDriftScheme,
    nodes: Nodes<'a, W>,
    another: bool,
}

impl<const W: usize> quad::Pass for Pass<'_, W> {
    type Output = BoundarySums;

    #[inline(always)]
    fn run<U: VectorUnit>(self, unit: U) -> BoundarySums {
        if self.nodes.works.is_some() { self.kinds::<U, true>(unit) } else { self.kinds::<U, false>(unit) }
    }
}

#[multiversion(targets("x86_64+avx+avx2"))]
fn begin(scheme: KickDriftScheme, start: StepStart<'_>, x: &mut [f64], v: &mut [f64]) {
    let KickDriftScheme { begin: k, drift: h, predicts, .. } = scheme;
    let of_forces = if predicts { h } else { k };
    let from = start.x.iter().zip(start.v).zip(start.f.iter().zip(start.inverse_mass));
    for ((x, v), ((x_n, v_n), (f, inverse_mass))) in x.iter_mut().zip(v).zip(from) {
        let a = inverse_mass * f;
        *x = x_n + h * (v_n + k * a);
        *v = v_n + of_forces * a;
    }
}

#[multiversion(targets("x86_64+avx+avx2"))]
fn kick(l: f64, inverse_mass: &[f64], v: &mut [f64], f: &[f64]) {
    for ((v, f), inverse_mass) in v.iter_mut().zip(f).zip(inverse_mass) {
        *v += l * (inverse_mass * f);
    }
}

#[multiversion(targets("x86_64+avx+avx2"))]
fn kick_twice(k: f64, l: f64, start: StepStart<'_>, v: &mut [f64], f: &[f64]) {
    let from = start.v.iter().zip(start.f).zip(start.inverse_mass);
    for ((v, f), ((v_n, f_n), inverse_mass)) in v.iter_mut().zip(f).zip(from) {
        *v = (v_n + k * (inverse_mass * f_n)) + l * (inverse_mass * f);
    }
}

#[multiversion(targets("x86_64+avx+avx2"))]
fn correct(v: &mut [f64], kicked: &[f64], l: f64, inverse_mass: &[f64], f: &[f64]) {
    for ((v, kicked), (f, inverse_mass)) in v.iter_mut().zip(kicked).zip(f.iter().zip(inverse_mass)) {
        *v = kicked + l * (inverse_mass * f);
    }
}

impl<const W: usize> Pass<'_, W> {
    #[inline(always)]
    fn kinds<U: VectorUnit, const WORKS: bool>(self, unit: U) -> BoundarySums {
        match (self.scheme.end.is_some() && !self.scheme.predicts, self.another, self.scheme.predicts) {
            (true, true, _) => self.blocks::<U, WORKS, true, true, false>(unit),
            (true, false, _) => self.blocks::<U, WORKS, true, false, false>(unit),
            (false, true, true) => self.blocks::<U, WORKS, false, true, true>(unit),
            (false, true, false) => self.blocks::<U, WORKS, false, true, false>(unit),
            (false, false, _) => self.blocks::<U, WORKS, false, false, false>(unit),
        }
    }

    #[inline(always)]
    fn blocks<U: VectorUnit, const WORKS: bool, const END: bool, const ANOTHER: bool, const PREDICTS: bool>(
        self,
        unit: U,
    ) -> BoundarySums {
        let Nodes { mass, inverse_mass, x, v, kicked, f, works } = self.nodes;
        let (forces, before) = works.map_or(([&[][..]; 2], &mut [][..]), |works| (works.forces, works.before));
        let (kicked, kicked_last) = groups_mut::<W>(kicked);
        let (before, before_last) = groups_mut::<W>(before);
        let (forces, forces_last) = (forces.map(|f| groups::<W>(f).0), forces.map(|f| groups::<W>(f).1));
        let mut totals = Totals::<U, W, END, ANOTHER, PREDICTS>::new(unit, self.scheme);
        let (n, mut number) = (W * BLOCK, 0);
        let rest = inverse_mass.chunks(n).zip(mass.chunks(BLOCK)).zip(f.chunks_mut(n));
        for ((x, v), ((inverse_mass, mass), f)) in x.chunks_mut(n).zip(v.chunks_mut(n)).zip(rest) {
            let (x, x_last) = groups_mut::<W>(x);
            let (v, v_last) = groups_mut::<W>(v);
            let (m, m_last) = groups::<W>(inverse_mass);
            let (f, f_last) = groups_mut::<W>(f);
            let (mass, mass_last) = mass.as_chunks::<4>();
            for ((x, v), ((m, mass), f)) in x.iter_mut().zip(v).zip(m.iter().zip(mass).zip(f)) {
                let kicked = if PREDICTS { kicked.get_mut(number) } else { None };
                let works = if WORKS {
                    ([forces[0].get(number), forces[1].get(number)], before.get_mut(number))
                } else {
                    ([None; 2], None)
                };
                totals.four(unit, (*mass, m), ([x, v, f], kicked), works);
                number += 1;
            }
            if !mass_last.is_empty() {
                // Missing nodes are replaced by the first one, with zero mass and without forces whose work is summed.
                let mut mass = [0.0; 4];
                mass[..mass_last.len()].copy_from_slice(mass_last);
                let [mut x, mut v, mut f] = [&*x_last, v_last, f_last].map(filled);
                let mut u = v;
                let mut from = if before_last.is_empty() { x } else { filled(before_last) };
                let last = forces_last.map(|f| (!f.is_empty()).then(|| begun::<W>(f)));
                let works = ([last[0].as_ref(), last[1].as_ref()], WORKS.then_some(&mut from));
                totals.four(unit, (mass, &filled(m_last)), ([&mut x, &mut v, &mut f], Some(&mut u)), works);
                for (last, new) in [(x_last, x), (v_last, v), (f_last, f)] {
                    last.copy_from_slice(&new.as_flattened()[..last.len()]);
                }
                if PREDICTS {
                    kicked_last.copy_from_slice(&u.as_flattened()[..kicked_last.len()]);
                }
                before_last.copy_from_slice(&from.as_flattened()[..before_last.len()]);
            }
            totals.motion.end_block(unit);
            totals.work.end_block(unit);
        }
        totals.sums()
    }
}

/// The update between two steps, with the sums over the nodes so far.
struct Totals<U: VectorUnit, const W: usize, const END: bool, const ANOTHER: bool, const PREDICTS: bool> {
    /// k, h and l
    sizes: [U::Quad; 3],
    motion: MotionSum<U::Quad>,
    low: [U::Quad; W],
    high: [U::Quad; W],
    /// 0 if all values are finite
    nothing: U::Quad,
    /// [J] work of external and of dissipative forces: over this step, then over the next
    work: Sums<U::Quad, 4>,
}

impl<U: VectorUnit, const W: usize, const END: bool, const ANOTHER: bool, const PREDICTS: bool>
    Totals<U, W, END, ANOTHER, PREDICTS>
{
    #[inline(always)]
    fn new(unit: U, KickDriftScheme { begin, drift, end, .. }: KickDriftScheme) -> Self {
        Totals {
            sizes: [unit.splat(begin), unit.splat(drift), unit.splat(end.unwrap_or_default())],
            motion: MotionSum::new(unit),
            low: [unit.splat(f64::INFINITY); W],
            high: [unit.splat(f64::NEG_INFINITY); W],
            nothing: unit.splat(0.0),
            work: Sums::new(unit),
        }
    }

    #[inline(always)]
    fn four(
        &mut self,
        unit: U,
        (mass, inverse_mass): ([f64; 4], &Group<W>),
        ([x, v, f], mut kicked): ([&mut Group<W>; 3], Option<&mut Group<W>>),
        (forces, mut before): ([Option<&Group<W>>; 2], Option<&mut Group<W>>),
    ) {
        let [k, h, l] = self.sizes;
        let mut between = [unit.splat(0.0); W];
        let mut ways = [between; 2];
        for i in 0..W {
            if let Some(before) = &mut before {
                ways[0][i] = unit.quad(x[i]) - unit.quad(before[i]);
                before[i] = x[i];
            }
            let (x_i, mut v_i, f_i) = (unit.quad(x[i]), unit.quad(v[i]), unit.quad(f[i]));
            let a = unit.quad(inverse_mass[i]) * f_i;
            if END {
                v_i = v_i + l * a;
            }
            between[i] = v_i;
            // All quads of records have the same coordinates in the same places.
            let place = if W == 4 { 0 } else { i };
            if ANOTHER {
                let u = v_i + k * a;
                let next = x_i + h * u;
                x[i] = next.numbers();
                ways[1][i] = next - x_i;
                if PREDICTS && let Some(kicked) = &mut kicked {
                    kicked[i] = u.numbers();
                    v_i = v_i + h * a;
                } else {
                    v_i = u;
                }
                if W == 4 {
                    f[i] = [0.0; 4];
                }
            } else {
                self.low[place] = x_i.smaller(self.low[place]);
                self.high[place] = x_i.larger(self.high[place]);
                self.nothing = self.nothing + unit.splat(0.0) * f_i;
            }
            if END || ANOTHER {
                v[i] = v_i.numbers();
            }
        }
        self.motion.add(unit.quad(mass), columns::<U::Quad, W>(between));
        if before.is_some() {
            for (place, force) in forces.into_iter().enumerate() {
                let Some(force) = force else { continue };
                self.work.add(place, along::<U, W>(unit, force, &ways[0]));
                if ANOTHER {
                    self.work.add(2 + place, along::<U, W>(unit, force, &ways[1]));
                }
            }
        }
    }

    fn sums(self) -> BoundarySums {
        let mut bounds = Bounds::default();
        let places = if W == 4 { 1 } else { W };
        let numbers = |quads: [U::Quad; W]| quads.into_iter().take(places).flat_map(Quad::numbers);
        for (i, (low, high)) in numbers(self.low).zip(numbers(self.high)).enumerate().filter(|(i, _)| i % W < 3) {
            let mut of_axis = Bounds::default();
            (of_axis.low[i % W], of_axis.high[i % W]) = (low, high);
            bounds = bounds.and(of_axis);
        }
        let motion = self.motion.motion();
        let finite = self.nothing.numbers().into_iter().all(|zero| zero == 0.0);
        let [external, dissipative, next_external, next_dissipative] = self.work.sums();
        let (kinetic, largest_square) = (motion.kinetic, motion.largest_square);
        let nodes = NodeSums { kinetic, largest_square, bounds, finite, work: Work { external, dissipative } };
        BoundarySums { nodes, next: Work { external: next_external, dissipative: next_dissipative } }
    }
}

#[cfg(test)]
mod tests;
