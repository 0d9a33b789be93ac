//! K and C at a state as one sparse matrix of pairs, by rows: both are needed at once, and a row gathers where a column
//! scatters.

use crate::assembly::Pattern;
use crate::model::state::StateRef;
use crate::model::system::Weights;
use crate::scene::Scene;

/// Entries `[k, c]` of K and C; rows and columns are degrees of freedom, those that are held have none.
pub(super) struct Matrices {
    start: Vec<u32>,
    column: Vec<u32>,
    values: Vec<[f64; 2]>,
}

impl Matrices {
    /// `None` where the matrix cannot be numbered.
    pub fn of(scene: &dyn Scene, at: StateRef<'_>) -> Option<Self> {
        let mut assembler = scene.assembler().ok()?;
        let mut values = |c: f64, k: f64| {
            scene.assemble(at, Weights { m: 0.0, c, k }, &mut assembler);
            assembler.values().to_vec()
        };
        let (c, k) = (values(1.0, 0.0), values(0.0, 1.0));
        Some(by_rows(&assembler.pattern, scene.n_dof(), [&k, &c]))
    }

    /// y = k K x + c C v
    pub fn times(&self, [k, c]: [f64; 2], [x, v]: [&[f64]; 2], y: &mut [f64]) {
        for (y, ends) in y.iter_mut().zip(self.start.windows(2)) {
            let row = ends[0] as usize..ends[1] as usize;
            let (mut of_k, mut of_c) = (0.0, 0.0);
            for (&j, [stiffness, damping]) in self.column[row.clone()].iter().zip(&self.values[row]) {
                of_k += stiffness * x[j as usize];
                of_c += damping * v[j as usize];
            }
            *y = k * of_k + c * of_c;
        }
    }

    /// `[k, c]` of a row and a column.
    pub fn entry(&self, row: u32, column: u32) -> [f64; 2] {
        let ends = |i: usize| self.start.get(i).map_or(0, |&end| end as usize);
        let places = ends(row as usize)..ends(row as usize + 1);
        places.into_iter().find(|&place| self.column[place] == column).map_or([0.0; 2], |place| self.values[place])
    }
}

/// Stored entries go to their row and, of a symmetric matrix below the diagonal, to their column's row too.
fn by_rows(pattern: &Pattern, n: usize, [k, c]: [&[f64]; 2]) -> Matrices {
    let entries = |take: &mut dyn FnMut(u32, u32, usize)| {
        for j in 0..pattern.n() {
            let slots = pattern.col_ptr[j] as usize..;
            for (&i, slot) in pattern.column(j).iter().zip(slots) {
                let (row, column) = (pattern.dof[i as usize], pattern.dof[j]);
                take(row, column, slot);
                if pattern.symmetric && row != column {
                    take(column, row, slot);
                }
            }
        }
    };
    let mut start = vec![0_u32; n + 1];
    entries(&mut |row, _, _| start[row as usize + 1] += 1);
    for i in 0..n {
        start[i + 1] += start[i];
    }
    let total = start[n] as usize;
    let (mut column, mut values) = (vec![0; total], vec![[0.0; 2]; total]);
    let mut next = start.clone();
    entries(&mut |row, at, slot| {
        let place = next[row as usize] as usize;
        (column[place], values[place]) = (at, [k[slot], c[slot]]);
        next[row as usize] += 1;
    });
    Matrices { start, column, values }
}
