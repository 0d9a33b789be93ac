//! A folder with a case in it, the program run there, and readers of what it leaves.

use std::path::{Path, PathBuf};

use assert_cmd::Command;
use serde_json::Value;
use tempfile::TempDir;

use crate::common::read_vtu::{Vtu, attribute, parse};

/// A sail of four triangles, held on one side, with every kind of term and every kind of output.
pub const SAIL: &str = r#"{
  "name": "sail",
  "system": {"network": {
    "mesh": {"explicit": {
      "nodes": [[0,0,0],[1,0,0],[2,0,0],[0,1,0],[1,1,0],[2,1,0]],
      "springs": [[0,1],[1,2],[3,4],[4,5],[0,3],[1,4],[2,5],[0,4],[1,5]],
      "triangles": [[0,1,4],[0,4,3],[1,2,5],[1,5,4]]
    }},
    "mass": {"nodal": [0.5,0.4,0.6,0.5,0.7,0.45]},
    "springs": [{"on": "all", "stiffness": 50.0, "rest_scale": 0.9, "dashpot": {"axial": {"coefficient": 0.2}}}],
    "supports": [{"on": {"ids": [0, 3]}, "fix": "xyz"}],
    "gravity": [0, 0, -9.81],
    "aero": {"wind": {"table": [[0, 0, 0, 8], [0.5, 1, 0, 10]]},
             "law": {"permeable": {"a": 400.0, "b": 100.0, "thickness": 1e-3}}},
    "loads": [{"on": "all", "pressure": 0.5, "kind": "follower"}],
    "damping": {"rayleigh": {"mass": 0.1, "stiffness": 0.001}}
  }},
  "time": {"end": 1.0, "method": "velocity-verlet", "step": 0.01},
  "output": {"frames": {"every": 0.1}, "fields": ["velocity", "force", "reaction", "tension", "strain"],
             "probes": [{"name": "tip", "on": {"ids": [5, 2]}}], "history": {"every": 1}}
}"#;

/// A folder that goes away with the test.
pub struct Bench(TempDir);

/// How a run of the program ended.
pub struct Ended {
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

impl Bench {
    /// A folder with `sail.json` in it.
    pub fn new() -> Self {
        let bench = Bench(TempDir::new().expect("a folder"));
        std::fs::write(bench.path("sail.json"), SAIL).expect("a case");
        bench
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// The program in this folder, not yet started.
    pub fn program(&self) -> std::process::Command {
        let mut command = std::process::Command::new(assert_cmd::cargo::cargo_bin!("canopy-fem"));
        command.current_dir(self.0.path());
        command
    }

    pub fn run(&self, arguments: &[&str]) -> Ended {
        let output = Command::from_std(self.program()).args(arguments).output().expect("the program starts");
        let text = |bytes| String::from_utf8(bytes).expect("the program writes UTF-8");
        Ended { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
    }

    /// Solves the sail into `out`, with more arguments.
    pub fn solve(&self, arguments: &[&str]) -> Ended {
        self.run(&[&["solve", "sail.json", "--out", "out"], arguments].concat())
    }

    pub fn results(&self) -> Results {
        Results(self.path("out"))
    }
}

/// A folder of results.
pub struct Results(pub PathBuf);

impl Results {
    pub fn text(&self, name: &str) -> String {
        let path = self.0.join(name);
        std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
    }

    pub fn summary(&self) -> Value {
        serde_json::from_str(&self.text("summary.json")).expect("JSON")
    }

    /// The rows of a csv file by the names of its header; a cell that is no number is NaN.
    pub fn table(&self, name: &str) -> Table {
        let text = self.text(name);
        let mut lines = text.lines().map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
        let header = lines.next().expect("a header");
        Table { header, rows: lines.collect() }
    }

    /// Time and file of every frame, as the .pvd tells them.
    pub fn frames(&self) -> Vec<(f64, Vtu)> {
        let frame = |line: &str| {
            let time = attribute(line, "timestep").expect("a time").parse().expect("a number");
            let file = self.0.join(attribute(line, "file").expect("a file"));
            (time, parse(&std::fs::read(file).expect("the frame is there")))
        };
        self.text("sail.pvd").lines().filter(|line| line.starts_with("<DataSet")).map(frame).collect()
    }
}

/// A csv file.
pub struct Table {
    pub header: Vec<String>,
    pub rows: Vec<Vec<String>>,
}

impl Table {
    pub fn column(&self, name: &str) -> Vec<f64> {
        let at = self.header.iter().position(|h| h == name).unwrap_or_else(|| panic!("no column {name}"));
        self.rows.iter().map(|row| row[at].parse().unwrap_or(f64::NAN)).collect()
    }
}

/// All files below a folder with their bytes, by path.
pub fn contents(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            files.extend(contents(&path));
        } else {
            let bytes = std::fs::read(&path).expect("a file");
            files.push((path, bytes));
        }
    }
    files.sort();
    files
}
