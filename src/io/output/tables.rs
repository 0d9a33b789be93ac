//! The tables of a run in memory, instead of its files.

use super::checkpoint::Checkpoint;
use super::crossings::CrossingReport;
use super::frame::{Frame, FrameSize};
use super::gauges::GaugeRow;
use super::rows::HistoryRow;
use super::writer::{Message, ResultWriter};
use crate::case::spec::ProbeSpec;
use crate::drive::observer::ObserveError;

/// A row of `probes.csv`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbeRow {
    /// [s] time
    pub t: f64,
    /// number of the probe in the case
    pub probe: usize,
    /// number of the node
    pub node: u32,
    /// [m] its position
    pub position: [f64; 3],
    /// [m/s] its velocity
    pub velocity: [f64; 3],
}

/// What `history.csv`, `probes.csv` and `gauges.csv` of a run hold.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tables {
    /// rows of the history
    pub history: Vec<HistoryRow>,
    /// names of the probes
    pub followed: Vec<String>,
    /// rows of the probes
    pub probes: Vec<ProbeRow>,
    /// values of the gauges
    pub gauges: Vec<GaugeRow>,
    /// name and quantity of each channel of the gauges
    pub channels: Vec<[String; 2]>,
}

/// Where a recorder puts what it shows.
#[derive(Debug)]
pub(super) enum Destination {
    /// into files, which another thread writes
    Files(Box<ResultWriter>),
    /// into memory
    Memory(Box<MemoryTables>),
}

/// Tables that grow, and the frame that probes are read from.
#[derive(Debug)]
pub(super) struct MemoryTables {
    tables: Tables,
    probes: Vec<ProbeSpec>,
    size: FrameSize,
    frame: Option<Frame>,
    /// whether the run has failed: no more rows of probes then
    withdrawn: bool,
}

impl MemoryTables {
    pub(super) fn new(probes: &[ProbeSpec], channels: Vec<[String; 2]>, size: FrameSize) -> Self {
        let followed = probes.iter().map(|probe| probe.name.clone()).collect();
        let tables = Tables { channels, followed, ..Tables::default() };
        MemoryTables { tables, probes: probes.to_vec(), size, frame: None, withdrawn: false }
    }

    fn keep(&mut self, message: Message) {
        match message {
            Message::Frame(frame) => {
                if !self.withdrawn {
                    self.follow(&frame);
                }
                self.frame = Some(frame);
            }
            Message::Row(row) => self.tables.history.push(row),
            Message::Gauge(row) => self.tables.gauges.push(row),
            Message::WithdrawAfter(_) => self.withdrawn = true,
            Message::Checkpoint(_) => {}
        }
    }

    /// Adds the rows of the probes: probes in the order of the case, nodes in the order of the probe.
    fn follow(&mut self, frame: &Frame) {
        for (probe, ProbeSpec { nodes, .. }) in self.probes.iter().enumerate() {
            for &node in nodes {
                let at = node as usize;
                if let (Some(&position), Some(&velocity)) = (frame.positions.get(at), frame.velocities.get(at)) {
                    self.tables.probes.push(ProbeRow { t: frame.time, probe, node, position, velocity });
                }
            }
        }
    }
}

impl Destination {
    /// A frame to fill, which still has its old content.
    ///
    /// # Errors
    /// As [`ResultWriter::empty_frame`].
    pub(super) fn empty_frame(&mut self) -> Result<Frame, ObserveError> {
        match self {
            Destination::Files(writer) => writer.empty_frame(),
            Destination::Memory(memory) => Ok(memory.frame.take().unwrap_or_else(|| Frame::new(memory.size))),
        }
    }

    /// Takes back a frame that is not shown.
    pub(super) fn recycle(&mut self, frame: Frame) {
        match self {
            Destination::Files(writer) => writer.recycle(frame),
            Destination::Memory(memory) => memory.frame = Some(frame),
        }
    }

    /// Sends a checkpoint, as [`ResultWriter::checkpoint`]; a run in memory is never gone on with.
    ///
    /// # Errors
    /// As there.
    pub(super) fn checkpoint(&mut self, checkpoint: Box<Checkpoint>) -> Result<(), ObserveError> {
        match self {
            Destination::Files(writer) => writer.checkpoint(checkpoint),
            Destination::Memory(_) => Ok(()),
        }
    }

    /// Shows something.
    ///
    /// # Errors
    /// As [`ResultWriter::send`].
    pub(super) fn send(&mut self, message: Message) -> Result<(), ObserveError> {
        match self {
            Destination::Files(writer) => writer.send(message),
            Destination::Memory(memory) => {
                memory.keep(message);
                Ok(())
            }
        }
    }

    /// Ends it.
    ///
    /// # Errors
    /// As [`ResultWriter::finish`].
    pub(super) fn finish(&mut self) -> Result<(), ObserveError> {
        match self {
            Destination::Files(writer) => writer.finish(),
            Destination::Memory(_) => Ok(()),
        }
    }

    /// What the writing thread has found of crossings, once it has ended.
    pub(super) fn crossings(&self) -> Option<&CrossingReport> {
        match self {
            Destination::Files(writer) => writer.crossings(),
            Destination::Memory(_) => None,
        }
    }

    /// What was kept in memory so far; nothing of what went into files.
    pub(super) fn take_tables(&mut self) -> Tables {
        match self {
            Destination::Files(_) => Tables::default(),
            Destination::Memory(memory) => std::mem::take(&mut memory.tables),
        }
    }
}
