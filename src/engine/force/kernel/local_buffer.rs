//! LocalBuffers: the few nodes of a block as records of four numbers, one vector register each.
//!
//! An element's node is known by where its record begins. A local buffer reaches as far as the 16 bits of such a
//! number, so that no access needs a check; memory that no block uses is never touched.

use crate::model::quad::{Pass, Quad, VectorUnit, run};
use nalgebra::Vector3;

/// A vector and a number that means nothing.
pub type PaddedVec3 = [f64; RECORD];

/// Numbers of a record.
pub(in crate::force) const RECORD: usize = 4;

const REACH: usize = u16::MAX as usize + RECORD;

/// A local buffer's records, one after the other.
pub type Records = [f64; REACH];

/// Numbers of a cache line and of a page.
const LINE: usize = 8;
const PAGE: usize = 512;

/// The record that begins at a place.
#[inline(always)]
pub fn record(records: &Records, at: u16) -> PaddedVec3 {
    // `None` cannot be, and is compiled away.
    records[at as usize..].first_chunk().copied().unwrap_or_default()
}

/// Replaces the record that begins at a place.
#[inline(always)]
pub fn set_record(records: &mut Records, at: u16, value: PaddedVec3) {
    if let Some(record) = records[at as usize..].first_chunk_mut() {
        *record = value;
    }
}

/// Workspace for the records of one block after the other.
#[derive(Debug)]
pub(in crate::force) struct LocalBuffer {
    /// more than is used; empty until it is
    room: Vec<f64>,
    /// [cache lines] where in a page the records begin
    shift: usize,
    first: usize,
}

impl LocalBuffer {
    /// LocalBuffers that are used together begin at different lines of a page: where a load and an earlier store are
    /// equally far from the beginning of their pages, a processor lets the load wait as if both were one place.
    pub(crate) fn new(shift: usize) -> Self {
        LocalBuffer { room: Vec::new(), shift, first: 0 }
    }

    /// The records; whatever was there before.
    pub(crate) fn records(&mut self) -> &mut Records {
        if self.room.is_empty() {
            // Zeroed by the operating system, page after page when they are used.
            self.room = vec![0.0; REACH + 2 * PAGE];
            self.first = self.room.as_ptr().align_offset(PAGE * size_of::<f64>()).min(PAGE) + self.shift * LINE;
        }
        &mut self.room[self.first..].as_chunks_mut().0[0]
    }
}

/// The first records.
pub(in crate::force) fn rows(records: &mut Records, n: usize) -> &mut [PaddedVec3] {
    &mut records.as_chunks_mut().0[..n]
}

/// The same, to be read.
pub(in crate::force) fn rows_of(records: &Records, n: usize) -> &[PaddedVec3] {
    &records.as_chunks().0[..n]
}

/// Copies a nodal vector into as many records.
pub(in crate::force) fn copy_rows(from: &[Vector3<f64>], to: &mut [PaddedVec3]) {
    run(CopyRows { from: bytemuck::cast_slice(from), to });
}

/// Copies vectors into as many records, with 0 in their fourth numbers, which a scheme moves as all others.
pub(in crate::force) fn fill(from: &[f64], to: &mut [PaddedVec3]) {
    for (&[x, y, z], to) in from.as_chunks().0.iter().zip(to) {
        *to = [x, y, z, 0.0];
    }
}

struct CopyRows<'a> {
    from: &'a [f64],
    to: &'a mut [PaddedVec3],
}

impl Pass for CopyRows<'_> {
    type Output = ();

    /// Four numbers at once; the last of them belongs to the next node.
    #[inline(always)]
    fn run<U: VectorUnit>(self, _: U) {
        let (whole, last) = self.to.split_at_mut(self.to.len().saturating_sub(1) / 4 * 4);
        let rest = &self.from[3 * whole.len()..];
        for (four, to) in self.from.windows(13).step_by(12).zip(whole.as_chunks_mut::<4>().0) {
            for (node, to) in to.iter_mut().enumerate() {
                *to = four[3 * node..].first_chunk().copied().unwrap_or_default();
            }
        }
        for (from, to) in rest.as_chunks::<3>().0.iter().zip(last) {
            *to = [from[0], from[1], from[2], 0.0];
        }
    }
}

/// Adds records to as many nodes.
pub(in crate::force) fn add_rows(records: &[PaddedVec3], to: &mut [Vector3<f64>]) {
    run(StoreRows::<true> { records, to: bytemuck::cast_slice_mut(to) });
}

/// Overwrites as many nodes with records.
pub(in crate::force) fn store_rows(records: &[PaddedVec3], to: &mut [Vector3<f64>]) {
    run(StoreRows::<false> { records, to: bytemuck::cast_slice_mut(to) });
}

struct StoreRows<'a, const ADD: bool> {
    records: &'a [PaddedVec3],
    to: &'a mut [f64],
}

impl<const ADD: bool> Pass for StoreRows<'_, ADD> {
    type Output = ();

    #[inline(always)]
    fn run<U: VectorUnit>(self, unit: U) {
        let (records, last) = self.records.as_chunks::<4>();
        let (to, last_to) = self.to.as_chunks_mut::<12>();
        for (records, to) in records.iter().zip(to) {
            let [a, b, c, d] = *records;
            let sums = U::Quad::pack([unit.quad(a), unit.quad(b), unit.quad(c), unit.quad(d)]);
            for (to, sum) in to.as_chunks_mut().0.iter_mut().zip(sums) {
                *to = if ADD { (unit.quad(*to) + sum).numbers() } else { sum.numbers() };
            }
        }
        for (&[x, y, z, _], to) in last.iter().zip(last_to.as_chunks_mut::<3>().0) {
            *to = if ADD { [to[0] + x, to[1] + y, to[2] + z] } else { [x, y, z] };
        }
    }
}

/// Overwrites records with the sums of others: `first`, or else what is there, and then those of `others` that are not
/// empty, one after the other.
pub(in crate::force) fn sum_rows(to: &mut [PaddedVec3], first: Option<&[PaddedVec3]>, others: [&[PaddedVec3]; 2]) {
    match (others, first) {
        ([[], []], None) => {}
        ([[], []], Some(first)) => to.copy_from_slice(first),
        ([one, []] | [[], one], None) => run(Sum { to, first: (), others: [one] }),
        ([one, []] | [[], one], Some(first)) => run(Sum { to, first, others: [one] }),
        (others, None) => run(Sum { to, first: (), others }),
        (others, Some(first)) => run(Sum { to, first, others }),
    }
}

struct Sum<'a, F, const N: usize> {
    to: &'a mut [PaddedVec3],
    first: F,
    others: [&'a [PaddedVec3]; N],
}

/// Where a sum begins: with records, or with what is there.
trait SumStart {
    fn record(&self, i: usize, there: PaddedVec3) -> PaddedVec3;
}

impl SumStart for &[PaddedVec3] {
    #[inline(always)]
    fn record(&self, i: usize, _: PaddedVec3) -> PaddedVec3 {
        self[i]
    }
}

impl SumStart for () {
    #[inline(always)]
    fn record(&self, _: usize, there: PaddedVec3) -> PaddedVec3 {
        there
    }
}

impl<F: SumStart, const N: usize> Pass for Sum<'_, F, N> {
    type Output = ();

    #[inline(always)]
    fn run<U: VectorUnit>(self, unit: U) {
        for (i, to) in self.to.iter_mut().enumerate() {
            let mut sum = unit.quad(self.first.record(i, *to));
            for records in self.others {
                sum = sum + unit.quad(records[i]);
            }
            *to = sum.numbers();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_copied_and_added_for_every_length() {
        for n in 0..23 {
            let nodes: Vec<Vector3<f64>> = (0..n).map(|i| Vector3::new(1.0, 10.0, 100.0) * f64::from(i + 1)).collect();
            let mut window = LocalBuffer::new(3);
            let records = rows(window.records(), nodes.len());
            copy_rows(&nodes, records);
            let mut sums = vec![Vector3::repeat(0.5); nodes.len()];
            add_rows(records, &mut sums);
            let mut stored = vec![Vector3::repeat(f64::NAN); nodes.len()];
            store_rows(records, &mut stored);
            assert_eq!(stored, nodes);
            for (i, (sum, node)) in sums.iter().zip(&nodes).enumerate() {
                assert_eq!(*sum, node.add_scalar(0.5));
                let [x, y, z, _] = record(window.records(), (i * RECORD) as u16);
                assert_eq!(Vector3::new(x, y, z), *node);
            }
        }
    }

    /// One after the other, from what is there or from what is given.
    #[test]
    fn records_are_summed_in_their_order() {
        let records =
            |scale: f64| (0..5).map(|i| [1.0, 0.1, 0.3, 1e16].map(|x| scale * x + f64::from(i))).collect::<Vec<_>>();
        let [first, a, b, there] = [0.1, 0.7, -0.7, 0.3].map(records);
        for (first, others) in [None, Some(&first)]
            .into_iter()
            .flat_map(|first| [[&[][..], &[]], [&a, &[]], [&[], &b], [&a, &b]].map(|others| (first, others)))
        {
            let mut found = there.clone();
            sum_rows(&mut found, first.map(Vec::as_slice), others);
            for (i, found) in found.into_iter().enumerate() {
                let mut sum = first.map_or(there[i], |first| first[i]);
                for other in others.into_iter().filter(|other| !other.is_empty()) {
                    sum.iter_mut().zip(other[i]).for_each(|(sum, other)| *sum += other);
                }
                assert_eq!(found, sum);
            }
        }
    }

    #[test]
    fn the_last_place_has_a_whole_record() {
        let mut window = LocalBuffer::new(3);
        set_record(window.records(), u16::MAX, [1.0, 2.0, 3.0, 4.0]);
        assert_eq!(record(window.records(), u16::MAX), [1.0, 2.0, 3.0, 4.0]);
        assert_eq!(record(window.records(), u16::MAX - 4), [0.0; 4]);
        assert_eq!(window.records().as_ptr().align_offset(LINE * size_of::<f64>()), 0);
    }
}
