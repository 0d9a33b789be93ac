//! The rows of `history.csv` and `probes.csv`.

use std::io::{self, Write};

use super::csv::CsvFile;
use super::frame::Frame;
use crate::case::spec::ProbeSpec;
use crate::drive::observer::{Energies, ObserveError};

/// The header line of `history.csv`; other programs rely on it.
pub const HISTORY_HEADER: &str =
    "t,step,kinetic,elastic,gravity,external_work,dissipated,numerical,newton_iterations,residual,max_speed,max_strain";
/// The header line of `probes.csv`; other programs rely on it.
pub const PROBES_HEADER: &str = "t,name,node,x,y,z,vx,vy,vz";

/// The header line of `gauges.csv`; other programs rely on it.
pub const GAUGES_HEADER: &str = "t,name,quantity,value";

/// One row of `history.csv`: a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct HistoryRow {
    /// [s] time
    pub t: f64,
    /// number of the step, 0 for the start
    pub step: u64,
    /// [J] the energy account
    pub ledger: Energies,
    /// Newton iterations of the step, 0 for explicit schemes
    pub newton_iterations: u32,
    /// [-] final residual over its scale, 0 for explicit schemes
    pub residual: f64,
    /// [m/s] largest node speed
    pub max_speed: f64,
    /// [-] largest strain over all springs
    pub max_strain: f64,
}

impl HistoryRow {
    /// The row as text, every number in the shortest form that reads back to the same bits.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write(&self, out: &mut impl Write) -> io::Result<()> {
        let Self { t, step, ledger, newton_iterations, residual, max_speed, max_strain } = self;
        let Energies { kinetic, elastic, gravity, external_work, dissipated, numerical } = ledger;
        write!(
            out,
            "{t:?},{step},{kinetic:?},{elastic:?},{gravity:?},{external_work:?},{dissipated:?},{numerical:?},"
        )?;
        write!(out, "{newton_iterations},{residual:?},{max_speed:?},{max_strain:?}")
    }
}

/// Appends the positions and velocities of probed nodes at one frame time: probes in the order of the case, nodes in
/// the order of the probe. Names are already quoted; nodes outside the frame were refused before the run.
pub(super) fn write_probes(file: &mut CsvFile, probes: &[ProbeSpec], frame: &Frame) -> Result<(), ObserveError> {
    let t = frame.time;
    for ProbeSpec { name, nodes } in probes {
        for &node in nodes {
            let at = node as usize;
            let (Some([x, y, z]), Some([vx, vy, vz])) = (frame.positions.get(at), frame.velocities.get(at)) else {
                continue;
            };
            file.line(|out| write!(out, "{t:?},{name},{node},{x:?},{y:?},{z:?},{vx:?},{vy:?},{vz:?}"))?;
        }
    }
    Ok(())
}
