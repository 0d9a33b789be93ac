//! M, C and K as MatrixMarket files, so that a user can check them in another program.

use super::{Pattern, TangentSystem};
use crate::model::state::StateRef;
use crate::model::system::Weights;
use sprs::TriMat;
use std::path::{Path, PathBuf};

/// Why matrices cannot be exported.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// The folder or a file cannot be written.
    #[error("{path}: {source}", path = path.display())]
    Write {
        /// the file or folder
        path: PathBuf,
        /// the system's reason
        source: std::io::Error,
    },
    /// No pattern.
    #[error(transparent)]
    Pattern(#[from] super::PatternError),
}

/// Writes `M.mtx`, `C.mtx` and `K.mtx` (both triangles, unknowns only) and `unknowns.csv`
/// (`unknown,node,axis`, nodes as `node_of` names them) for a state into `dir`.
///
/// # Errors
/// When the folder cannot be made or a file not written.
pub fn write_matrix_market(
    system: &dyn TangentSystem,
    at: StateRef<'_>,
    dir: &Path,
    node_of: &dyn Fn(usize) -> (u32, &'static str),
) -> Result<(), ExportError> {
    let failed = |path: &Path| {
        let path = path.to_owned();
        move |source| ExportError::Write { path, source }
    };
    std::fs::create_dir_all(dir).map_err(failed(dir))?;
    let mut assembler = system.assembler()?;
    let weights = [
        ("M", Weights { m: 1.0, c: 0.0, k: 0.0 }),
        ("C", Weights { m: 0.0, c: 1.0, k: 0.0 }),
        ("K", Weights { m: 0.0, c: 0.0, k: 1.0 }),
    ];
    for (name, w) in weights {
        system.assemble(at, w, &mut assembler);
        let path = dir.join(format!("{name}.mtx"));
        sprs::io::write_matrix_market(&path, &to_triplets(&assembler.pattern, assembler.values()))
            .map_err(|e| ExportError::Write { path: path.clone(), source: std::io::Error::other(e.to_string()) })?;
    }
    let mut csv = String::from("unknown,node,axis\n");
    for (unknown, &dof) in assembler.pattern.dof.iter().enumerate() {
        let (node, axis) = node_of(dof as usize);
        csv.push_str(&format!("{unknown},{node},{axis}\n"));
    }
    let path = dir.join("unknowns.csv");
    std::fs::write(&path, csv).map_err(failed(&path))
}

/// Entries that are zero by structure only (an absent C) are left out.
fn to_triplets(pattern: &Pattern, values: &[f64]) -> TriMat<f64> {
    let n = pattern.n();
    let mut triplets = TriMat::new((n, n));
    for j in 0..n {
        let first = pattern.col_ptr[j] as usize;
        for (&i, &value) in pattern.column(j).iter().zip(&values[first..]) {
            if value == 0.0 {
                continue;
            }
            triplets.add_triplet(i as usize, j, value);
            if pattern.symmetric && i as usize != j {
                triplets.add_triplet(j, i as usize, value);
            }
        }
    }
    triplets
}
