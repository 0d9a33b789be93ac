//! The numbers of a symmetric matrix by the 3x3 blocks of its nodes, in double precision.

use super::block_rows::row_sections;
use crate::assembly::Pattern;
use crate::mesh::adjacency::Adjacency;
use nalgebra::Matrix3;
use std::cmp::Ordering;

/// Columns in a section of a coarse matrix.
pub(super) const COLUMNS: usize = 2_048;

/// A symmetric matrix, by columns of its lower triangle.
pub(super) trait Numbers {
    /// Calls `found(row, block)` for every block of a column: the one on the diagonal, then those below it, ascending.
    /// Rows of fixed components are 0.
    fn column(&self, g: u32, found: impl FnMut(u32, &Matrix3<f64>));
}

/// The nodes that every node is coupled to, itself and those behind it.
pub(super) fn lower_blocks(pattern: &Pattern, node: &[u32]) -> Adjacency {
    let (mut start, mut items) = (vec![0], Vec::new());
    for unknowns in pattern.node_start.windows(2) {
        // All unknowns of a node have the same neighbours.
        let rows = pattern.column(unknowns[0] as usize);
        let leads = |r: &&u32| **r == unknowns[0] || pattern.node_start[node[**r as usize] as usize] == **r;
        items.extend(rows.iter().filter(leads).map(|&r| node[r as usize]));
        start.push(items.len() as u32);
    }
    Adjacency { start, items }
}

/// W times a scale.
pub(super) struct FineNumbers<'a> {
    pub pattern: &'a Pattern,
    /// node of every unknown `[n]`
    pub node: &'a [u32],
    /// `[nonzeros]`
    pub values: &'a [f64],
    pub scale: f64,
}

impl Numbers for FineNumbers<'_> {
    fn column(&self, g: u32, mut found: impl FnMut(u32, &Matrix3<f64>)) {
        let Pattern { col_ptr, row_idx, dof, node_start, .. } = self.pattern;
        let unknowns = node_start[g as usize] as usize..node_start[g as usize + 1] as usize;
        let direction = |u: usize| (dof[u] % 3) as usize;
        let mut diagonal = Matrix3::zeros();
        for u in unknowns.clone() {
            for (r, value) in (u..unknowns.end).zip(&self.values[col_ptr[u] as usize..]) {
                diagonal[(direction(r), direction(u))] = value * self.scale;
                diagonal[(direction(u), direction(r))] = value * self.scale;
            }
        }
        found(g, &diagonal);
        let rows = &row_idx[col_ptr[unknowns.start] as usize..col_ptr[unknowns.start + 1] as usize];
        let mut place = unknowns.len();
        while let Some(&r) = rows.get(place) {
            let h = self.node[r as usize];
            let others = r as usize..node_start[h as usize + 1] as usize;
            let mut block = Matrix3::zeros();
            for (above, u) in unknowns.clone().enumerate() {
                // A column has no entries above the diagonal.
                let first = col_ptr[u] as usize + place - above;
                for (r, value) in others.clone().zip(&self.values[first..]) {
                    block[(direction(r), direction(u))] = value * self.scale;
                }
            }
            found(h, &block);
            place += others.len();
        }
    }
}

/// The matrix of a coarse level.
#[derive(Debug)]
pub(super) struct CoarseNumbers {
    /// rows of every column, ascending, the diagonal first
    pub(super) rows: Adjacency,
    pub(super) blocks: Vec<Matrix3<f64>>,
}

impl CoarseNumbers {
    pub(super) fn new(rows: Adjacency) -> Self {
        CoarseNumbers { blocks: vec![Matrix3::zeros(); rows.items.len()], rows }
    }

    /// The columns of every section, to write.
    pub(super) fn sections_mut(&mut self) -> impl ExactSizeIterator<Item = ColumnsMut<'_>> + Send {
        let CoarseNumbers { rows, blocks } = self;
        row_sections(&rows.start, COLUMNS, blocks).map(|(first, blocks)| ColumnsMut { rows, first, blocks })
    }

    /// The blocks of a column.
    pub(super) fn blocks_of(&self, column: usize) -> &[Matrix3<f64>] {
        &self.blocks[self.rows.start[column] as usize..self.rows.start[column + 1] as usize]
    }
}

impl Numbers for CoarseNumbers {
    fn column(&self, g: u32, mut found: impl FnMut(u32, &Matrix3<f64>)) {
        self.rows.row(g).iter().zip(self.blocks_of(g as usize)).for_each(|(row, block)| found(*row, block));
    }
}

/// The columns of a section, to write.
pub(super) struct ColumnsMut<'a> {
    rows: &'a Adjacency,
    /// the first of them
    first: usize,
    blocks: &'a mut [Matrix3<f64>],
}

impl ColumnsMut<'_> {
    pub(super) fn clear(&mut self) {
        self.blocks.fill(Matrix3::zeros());
    }

    /// Adds a block and its transpose, of which the matrix stores what is not above its diagonal, if it is here.
    pub(super) fn add_both(&mut self, row: u32, column: u32, block: impl FnOnce() -> Matrix3<f64>) {
        let (low, high) = (row.min(column), row.max(column));
        if !(self.first..self.first + COLUMNS).contains(&(low as usize)) {
            return;
        }
        let start = (self.rows.start[low as usize] - self.rows.start[self.first]) as usize;
        let place = self.rows.row(low).iter().position(|other| *other == high);
        if let Some(sum) = place.and_then(|place| self.blocks.get_mut(start + place)) {
            let block = block();
            *sum += match row.cmp(&column) {
                Ordering::Greater => block,
                Ordering::Less => block.transpose(),
                Ordering::Equal => block + block.transpose(),
            };
        }
    }
}
