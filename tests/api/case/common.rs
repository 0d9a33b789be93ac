//! A small case that every test changes a little.

use std::path::{Path, PathBuf};

use canopy_fem::case::{Case, CaseError, Fault};

/// Two triangles and a line: nodes 0 1 2 3 make a unit square, node 4 hangs from node 2 on edge 5.
pub const BASE: &str = r#"{
  "name": "base",
  "system": {"network": {
    "mesh": {"explicit": {
      "nodes": [[0,0,0],[1,0,0],[1,1,0],[0,1,0],[2,1,0]],
      "springs": [[0,1],[1,2],[2,0],[2,3],[3,0],[2,4]],
      "triangles": [[0,1,2],[0,2,3]]
    }},
    "mass": {"areal_density": 3.0, "nodal": 0.5},
    "springs": [{"on": "all", "stiffness": 100.0}],
    "supports": [{"on": {"ids": [0]}, "fix": "xyz"}]
  }},
  "time": {"end": 1.0, "method": "rk4", "step": 0.01}
}"#;

/// [`BASE`] with `--set` values.
pub fn base_with(sets: &[(&str, &str)]) -> Result<Case, CaseError> {
    text_with(BASE, sets)
}

/// A text with `--set` values.
pub fn text_with(text: &str, sets: &[(&str, &str)]) -> Result<Case, CaseError> {
    let sets: Vec<(String, String)> = sets.iter().map(|(k, v)| ((*k).to_owned(), (*v).to_owned())).collect();
    Case::from_text(text.to_owned(), "base.json", PathBuf::new(), &sets)
}

/// The faults of a case that must have some.
pub fn faults(result: Result<Case, CaseError>) -> Vec<Fault> {
    match result {
        Ok(_) => panic!("the case was accepted"),
        Err(error) => {
            assert!(!error.faults().is_empty(), "no faults but: {error}");
            error.faults().to_vec()
        }
    }
}

/// All case files that come with the program.
pub fn assets() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/cases");
    let mut list: Vec<PathBuf> = std::fs::read_dir(folder)
        .expect("assets/cases")
        .map(|entry| entry.expect("entry").path())
        .filter(|path| path.extension().is_some_and(|e| e == "json"))
        .collect();
    list.sort_by_key(|path| path.file_stem().map(ToOwned::to_owned));
    list
}
