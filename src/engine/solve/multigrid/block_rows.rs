//! 3x3 blocks by rows in single precision, and the sections of rows that threads share.

use super::super::bsr::{columns, times};
use crate::mesh::adjacency::Adjacency;
use nalgebra::Matrix3;
use std::ops::Range;
use wide::f32x4;

/// Rows of a section.
pub(super) const SECTION: usize = 16_384;

/// The sections of a vector.
pub(super) fn sections<T>(v: &[T]) -> std::slice::Chunks<'_, T> {
    v.chunks(SECTION)
}

/// The same to write.
pub(super) fn sections_mut<T>(v: &mut [T]) -> std::slice::ChunksMut<'_, T> {
    v.chunks_mut(SECTION)
}

/// What `size` rows at a time have of `items`: the first row, and those from `start[row]` on.
pub(super) fn row_sections<'a, T>(
    start: &'a [u32],
    size: usize,
    mut items: &'a mut [T],
) -> impl ExactSizeIterator<Item = (usize, &'a mut [T])> {
    let n = start.len() - 1;
    (0..n.div_ceil(size)).map(move |section| {
        let rows = section * size..n.min((section + 1) * size);
        let count = (start[rows.end] - start[rows.start]) as usize;
        let (own, others) = std::mem::take(&mut items).split_at_mut(count);
        items = others;
        (rows.start, own)
    })
}

/// 3x3 blocks by rows.
#[derive(Clone, Debug)]
pub(super) struct BlockRows {
    /// columns of the blocks
    columns: Adjacency,
    /// every block by columns, and one number behind the last, as [`columns`] reads it
    numbers: Vec<f32>,
}

impl BlockRows {
    /// Zeros at pairs (row, column); a row keeps the order of its columns.
    pub(super) fn new(columns: Adjacency) -> Self {
        BlockRows { numbers: vec![0.0; 9 * columns.items.len() + 1], columns }
    }

    pub(super) fn rows(&self) -> usize {
        self.columns.rows()
    }

    pub(super) fn is_empty(&self) -> bool {
        self.columns.items.is_empty()
    }

    /// The columns of a row.
    pub(super) fn columns(&self, row: usize) -> &[u32] {
        self.columns.row(row as u32)
    }

    /// The places of the blocks of a row.
    pub(super) fn places(&self, row: usize) -> Range<usize> {
        self.columns.start[row] as usize..self.columns.start[row + 1] as usize
    }

    pub(super) fn block(&self, place: usize) -> Matrix3<f32> {
        Matrix3::from_column_slice(&self.numbers[9 * place..9 * place + 9])
    }

    /// The columns and the blocks of a row.
    pub(super) fn blocks(&self, row: usize) -> impl Iterator<Item = (u32, Matrix3<f32>)> {
        self.columns(row).iter().copied().zip(self.places(row).map(|place| self.block(place)))
    }

    /// The rows of every section, to write.
    pub(super) fn sections_mut(&mut self) -> impl ExactSizeIterator<Item = RowsMut<'_>> + Send {
        let BlockRows { columns, numbers } = self;
        let (numbers, _) = numbers.as_chunks_mut();
        row_sections(&columns.start, SECTION, numbers).map(|(row, numbers)| RowsMut {
            columns,
            first: columns.start[row] as usize,
            numbers,
        })
    }

    /// The blocks of a row, for [`columns`], and their columns.
    #[inline(always)]
    pub(super) fn row(&self, i: usize) -> impl Iterator<Item = (&[f32], usize)> {
        let row = self.places(i);
        let numbers = &self.numbers[9 * row.start..=9 * row.end];
        numbers.windows(10).step_by(9).zip(self.columns.items[row].iter().map(|&j| j as usize))
    }

    /// Sum of the blocks of a row times v.
    #[inline(always)]
    pub(super) fn sum(&self, i: usize, v: &[f32x4]) -> f32x4 {
        self.row(i).fold(f32x4::ZERO, |sum, (block, j)| sum + times(columns(block), v[j]))
    }

    /// The same of the transposed blocks.
    #[inline(always)]
    pub(super) fn transposed_sum(&self, i: usize, v: &[f32x4]) -> f32x4 {
        let row = self.places(i);
        self.transposed(row.clone().zip(self.columns.items[row].iter().map(|&j| v[j as usize])))
    }

    /// Sum of transposed blocks, by their places, times vectors.
    #[inline(always)]
    fn transposed(&self, of: impl Iterator<Item = (usize, f32x4)>) -> f32x4 {
        let [mut x, mut y, mut z] = [f32x4::ZERO; 3];
        for (place, v) in of {
            let [a, b, c] = columns(&self.numbers[9 * place..=9 * place + 9]);
            x += a * v;
            y += b * v;
            z += c * v;
        }
        let [x, y, z, _] = f32x4::transpose([x, y, z, z]);
        x + y + z
    }
}

/// Where the blocks of every column of [`BlockRows`] are.
#[derive(Debug)]
pub(super) struct Columns {
    /// rows of every column, ascending
    rows: Adjacency,
    /// the places of their blocks
    places: Vec<u32>,
}

impl Columns {
    /// Of `count` columns of blocks by `rows`.
    pub(super) fn new(rows: &Adjacency, count: usize) -> Self {
        let places = (0..).zip(&rows.items).map(|(place, &column)| (column, place));
        let of_places = (0..rows.rows() as u32).flat_map(|i| rows.row(i).iter().map(move |_| i));
        Columns {
            rows: Adjacency::new(count, rows.items.iter().copied().zip(of_places)),
            places: Adjacency::new(count, places).items,
        }
    }

    /// Number of columns.
    pub(super) fn count(&self) -> usize {
        self.rows.rows()
    }

    /// The rows of a column.
    pub(super) fn rows(&self, column: usize) -> &[u32] {
        self.rows.row(column as u32)
    }

    /// The rows of a column and the places of their blocks.
    #[inline(always)]
    pub(super) fn places(&self, column: usize) -> impl Iterator<Item = (usize, usize)> {
        let own = self.rows.start[column] as usize..self.rows.start[column + 1] as usize;
        let places = self.places[own.clone()].iter().map(|&place| place as usize);
        self.rows.items[own].iter().map(|&row| row as usize).zip(places)
    }

    /// Sum of the transposed blocks of a column, which are in `blocks`, times v.
    #[inline(always)]
    pub(super) fn transposed_sum(&self, blocks: &BlockRows, column: usize, v: &[f32x4]) -> f32x4 {
        blocks.transposed(self.places(column).map(|(row, place)| (place, v[row])))
    }
}

/// The rows of a section, to write.
pub(super) struct RowsMut<'a> {
    columns: &'a Adjacency,
    /// place of the first block
    first: usize,
    numbers: &'a mut [[f32; 9]],
}

impl RowsMut<'_> {
    pub(super) fn clear(&mut self) {
        self.numbers.fill([0.0; 9]);
    }

    /// The block of a row and a column.
    fn block(&mut self, row: usize, column: u32) -> Option<&mut [f32; 9]> {
        let place = self.columns.row(row as u32).iter().position(|&other| other == column)?;
        self.numbers.get_mut(self.columns.start[row] as usize + place - self.first)
    }

    pub(super) fn set(&mut self, row: usize, column: u32, block: &Matrix3<f32>) {
        if let Some(numbers) = self.block(row, column) {
            numbers.copy_from_slice(block.as_slice());
        }
    }

    pub(super) fn add(&mut self, row: usize, column: u32, block: &Matrix3<f32>) {
        let numbers = self.block(row, column).into_iter().flatten();
        numbers.zip(block.as_slice()).for_each(|(sum, entry)| *sum += entry);
    }

    /// Replaces every block of a row by what `by` makes of its column and itself.
    pub(super) fn replace(&mut self, row: usize, by: impl Fn(u32, Matrix3<f32>) -> Matrix3<f32>) {
        let columns = self.columns.row(row as u32);
        let numbers = &mut self.numbers[self.columns.start[row] as usize - self.first..][..columns.len()];
        for (&column, numbers) in columns.iter().zip(numbers) {
            let block = by(column, Matrix3::from_column_slice(numbers));
            numbers.copy_from_slice(block.as_slice());
        }
    }
}
