//! `probes.csv`: positions and velocities of chosen nodes at each frame time.

use std::io::Write;
use std::path::Path;

use super::csv::CsvFile;
use super::file_prefix::FilePrefix;
use super::frame::Frame;
use super::resume::ResumeError;
use super::sanitize::csv_field;
use crate::drive::observer::ObserveError;

/// The header line; other programs rely on it.
pub const HEADER: &str = "t,name,node,x,y,z,vx,vy,vz";

/// Nodes to follow under one name.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Probe {
    /// name in the file
    pub name: String,
    /// nodes in the user's numbering
    pub nodes: Vec<u32>,
}

/// The growing file.
#[derive(Debug)]
pub struct Probes {
    file: CsvFile,
    /// names quoted as csv wants them
    probes: Vec<Probe>,
}

impl Probes {
    /// Creates the file with its header.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn create(path: &Path, probes: &[Probe]) -> Result<Self, ObserveError> {
        Ok(Self { file: CsvFile::create(path, HEADER)?, probes: quoted(probes) })
    }

    /// Goes on with a file after its mark.
    ///
    /// # Errors
    /// When another run holds it or it cannot be opened.
    pub fn reopen(path: &Path, probes: &[Probe], mark: FilePrefix) -> Result<Self, ResumeError> {
        Ok(Self { file: CsvFile::reopen(path, mark)?, probes: quoted(probes) })
    }

    /// Appends the rows of one frame time: probes in the order of the case, nodes in the order of the probe.
    /// Nodes outside the frame have been refused before the run.
    ///
    /// # Errors
    /// When they cannot be written.
    pub fn push(&mut self, frame: &Frame) -> Result<(), ObserveError> {
        let t = frame.time;
        for Probe { name, nodes } in &self.probes {
            for &node in nodes {
                let at = node as usize;
                let (Some([x, y, z]), Some([vx, vy, vz])) = (frame.positions.get(at), frame.velocities.get(at)) else {
                    continue;
                };
                self.file.line(|out| write!(out, "{t:?},{name},{node},{x:?},{y:?},{z:?},{vx:?},{vy:?},{vz:?}"))?;
            }
        }
        Ok(())
    }

    /// The file under it, to flush.
    pub fn file(&mut self) -> &mut CsvFile {
        &mut self.file
    }
}

fn quoted(probes: &[Probe]) -> Vec<Probe> {
    probes.iter().map(|p| Probe { name: csv_field(&p.name), nodes: p.nodes.clone() }).collect()
}
