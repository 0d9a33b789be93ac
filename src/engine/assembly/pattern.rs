//! The compressed-column pattern of W over the unknowns.

/// Why a pattern cannot be built.
#[derive(Clone, Debug, thiserror::Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum PatternError {
    /// More nonzeros than 32-bit slots can number.
    #[error(
        "the matrix would hold {nonzeros} entries, more than 32 bits can number; use an explicit method or a coarser mesh"
    )]
    TooLarge {
        /// entries counted
        nonzeros: usize,
    },
}

/// Compressed columns with ascending rows; the lower triangle only where `symmetric`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pattern {
    /// start of every column in `row_idx`, and the number of entries at the end
    pub col_ptr: Vec<u32>,
    /// rows
    pub row_idx: Vec<u32>,
    /// whether W is symmetric, and only its lower triangle stored
    pub symmetric: bool,
    /// degree of freedom of every unknown, ascending
    pub dof: Vec<u32>,
    /// first unknown of every node that has any, and the number of unknowns at the end; what an ordering permutes
    pub node_start: Vec<u32>,
    /// [m] position of these nodes on the mesh as given; a geometric ordering cuts along it
    pub position: Vec<[f64; 3]>,
}

impl Pattern {
    /// Number of unknowns.
    pub fn n(&self) -> usize {
        self.dof.len()
    }

    /// Number of stored entries.
    pub fn nonzeros(&self) -> usize {
        self.row_idx.len()
    }

    /// Rows of column `j`.
    pub fn column(&self, j: usize) -> &[u32] {
        &self.row_idx[self.col_ptr[j] as usize..self.col_ptr[j + 1] as usize]
    }

    /// Node of every unknown `[n]`, as numbered in `node_start`.
    pub fn node_of_unknown(&self) -> Vec<u32> {
        let mut node = vec![0; self.n()];
        for (g, unknowns) in (0..).zip(self.node_start.windows(2)) {
            node[unknowns[0] as usize..unknowns[1] as usize].fill(g);
        }
        node
    }

    /// Every pair of coupled nodes of a symmetric pattern, the lower first. `node` is [`Pattern::node_of_unknown`].
    pub(crate) fn coupled_nodes<'a>(&'a self, node: &'a [u32]) -> impl Iterator<Item = (u32, u32)> + 'a {
        (0..).zip(self.node_start.windows(2)).filter(|(_, unknowns)| unknowns[0] < unknowns[1]).flat_map(
            move |(g, unknowns)| {
                // All unknowns of a node have the same neighbours.
                let others = self.column(unknowns[0] as usize).iter().map(|&row| (row, node[row as usize]));
                let first = move |(row, other)| other != g && row == self.node_start[other as usize];
                others.filter(move |&pair| first(pair)).map(move |(_, other)| (g, other))
            },
        )
    }

    /// Slot of entry (i, j), if it is stored.
    pub fn slot(&self, i: u32, j: u32) -> Option<u32> {
        let first = *self.col_ptr.get(j as usize)?;
        self.column(j as usize).binary_search(&i).ok().map(|p| first + p as u32)
    }

    /// y = W p for `values` [nonzeros] on this pattern, both triangles of a symmetric W; `p` and `y` `[n]`.
    pub fn multiply(&self, values: &[f64], p: &[f64], y: &mut [f64]) {
        self.product::<false>(values, p, y);
    }

    /// The sums of the rows of W `[n]` for `values` [nonzeros].
    pub fn row_sums(&self, values: &[f64], sums: &mut [f64]) {
        sums.fill(0.0);
        self.each_entry(values, |row, _, value| sums[row] += value);
    }

    /// y = W^T p.
    pub fn multiply_transposed(&self, values: &[f64], p: &[f64], y: &mut [f64]) {
        self.product::<true>(values, p, y);
    }

    fn product<const TRANSPOSED: bool>(&self, values: &[f64], p: &[f64], y: &mut [f64]) {
        y.fill(0.0);
        self.each_entry(values, |i, j, value| {
            let [row, column] = if TRANSPOSED { [j, i] } else { [i, j] };
            y[row] += value * p[column];
        });
    }

    /// Calls `each` with row, column and value of every entry, of both triangles of a symmetric W.
    fn each_entry(&self, values: &[f64], mut each: impl FnMut(usize, usize, f64)) {
        for j in 0..self.n() {
            let first = self.col_ptr[j] as usize;
            for (&i, &value) in self.column(j).iter().zip(&values[first..]) {
                each(i as usize, j, value);
                if self.symmetric && i as usize != j {
                    each(j, i as usize, value);
                }
            }
        }
    }
}
