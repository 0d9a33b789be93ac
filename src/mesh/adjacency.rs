//! Lists of numbers, one for every row, in two arrays (compressed sparse rows).

/// Row i holds `items[start[i]..start[i + 1]]`.
#[derive(Clone, Debug)]
pub struct Adjacency {
    /// start of every row, and the number of items at the end `[n + 1]`
    pub start: Vec<u32>,
    /// items of all rows
    pub items: Vec<u32>,
}

impl Adjacency {
    /// Sorts pairs (row, item) by their rows, below `n`; a row keeps the order of its items.
    pub fn new(n: usize, pairs: impl Iterator<Item = (u32, u32)> + Clone) -> Self {
        let start = row_starts(n, pairs.clone().map(|(row, _)| row));
        let (mut next, mut items) = (start.clone(), vec![0; start[n] as usize]);
        for (row, item) in pairs {
            let next = &mut next[row as usize];
            items[*next as usize] = item;
            *next += 1;
        }
        Adjacency { start, items }
    }

    /// The neighbours of `n` nodes; an edge that is listed twice counts twice.
    pub fn of_edges(n: usize, edges: impl Iterator<Item = [u32; 2]> + Clone) -> Self {
        Self::new(n, edges.flat_map(|[a, b]| [(a, b), (b, a)]))
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.start.len() - 1
    }

    /// Items of a row.
    pub fn row(&self, i: u32) -> &[u32] {
        &self.items[self.start[i as usize] as usize..self.start[i as usize + 1] as usize]
    }
}

/// Where `n` rows start when items are sorted by their rows, and the number of items at the end `[n + 1]`.
pub fn row_starts(n: usize, rows: impl Iterator<Item = u32>) -> Vec<u32> {
    let mut start = vec![0; n + 1];
    rows.for_each(|row| start[row as usize + 1] += 1);
    for i in 0..n {
        start[i + 1] += start[i];
    }
    start
}
