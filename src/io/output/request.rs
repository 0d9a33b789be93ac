//! The request of what to record in a run, and its check.

use std::path::{Path, PathBuf};

use super::files::FilesSpec;
use super::frame::Fields;
use super::gauges::{Gauges, GaugesSpec};
use super::quantity::UnknownQuantity;
use super::resume::ResumeError;
use super::sanitize::file_stem;
use crate::case::spec::{CrossingSearch, GaugeOf, GaugeSpec, ProbeSpec, Problem, RowEvery, StagesSpec};
use crate::drive::observer::ObserveError;
use crate::model::observables::Observables;
use crate::model::quantity::QuantityName;
use crate::vtk::VtuFormat;

/// Largest number of frames of a run; their numbers have six digits.
pub const MOST_FRAMES: f64 = 1e6;

/// What to record.
#[derive(Clone, Debug, Default)]
pub struct RecorderSpec {
    /// name of the case; files are named after its `file_stem`
    pub name: String,
    /// folder of the results; see [`super::folder::ResultFolder::prepare`]
    pub out_dir: PathBuf,
    /// [s] between frames, > 0; without it only the first and the last state are shown
    pub frames_every: Option<f64>,
    /// [s] when the run is to end; bounds the number of frames
    pub end: f64,
    /// fields beside displacement and velocity
    pub fields: Fields,
    /// whether edges that are sides of triangles are drawn
    pub edges: bool,
    /// where cloth is searched for triangles that pass through others; frames show it only with [`Fields::crossing`]
    pub crossings: CrossingSearch,
    /// nodes to follow at each frame time
    pub probes: Vec<ProbeSpec>,
    /// what to measure at every step
    pub gauges: Vec<GaugeSpec>,
    /// quantities that are asked for; empty: those of the report
    pub quantities: Vec<QuantityName>,
    /// the stages of the run
    pub stages: StagesSpec,
    /// interval of the history rows
    pub history_every: RowEvery,
    /// encoding of the frames' arrays
    pub format: VtuFormat,
}

impl RecorderSpec {
    /// What is measured, with the rows of canopies `history` apart.
    pub(super) fn gauges(&self, history: RowEvery) -> GaugesSpec<'_> {
        let RecorderSpec { gauges, probes, quantities, stages, end, .. } = self;
        GaugesSpec { gauges, probes, quantities, stages, history, end: *end }
    }

    /// The request of a case, for a folder.
    pub fn of(problem: &Problem, out_dir: &Path) -> Self {
        let output = &problem.output;
        RecorderSpec {
            name: problem.name.clone(),
            out_dir: out_dir.to_owned(),
            frames_every: output.frames_every,
            end: problem.time.end,
            fields: output.into(),
            edges: output.edges,
            crossings: output.crossings,
            probes: output.probes.clone(),
            gauges: output.gauges.clone(),
            quantities: output.quantities.clone(),
            stages: output.stages.clone(),
            history_every: output.history_every,
            format: output.format,
        }
    }
}

/// Why a run cannot be recorded as requested.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecorderError {
    /// The interval is not finite and above 0.
    #[error(
        "output.frames.every = {every} s must be finite and above 0; leave `frames` out to get the first and last state only"
    )]
    BadInterval {
        /// [s] the interval given
        every: f64,
    },
    /// More frames than can be numbered.
    #[error(
        "frames every {every} s until {end} s are more than {MOST_FRAMES:e}; take output.frames.every >= {least:e} s"
    )]
    TooManyFrames {
        /// [s] the interval given
        every: f64,
        /// [s] end of the run
        end: f64,
        /// [s] the smallest interval that is accepted
        least: f64,
    },
    /// No row can be written every 0 steps or every 0 s.
    #[error("output.history.every must be at least 1 step a row")]
    BadHistory,
    /// A probe follows a node that does not exist.
    #[error("probe \"{name}\" follows node {node}, but there are {nodes} nodes, counted from 0")]
    ProbeOutOfRange {
        /// the probe
        name: String,
        /// the node
        node: u32,
        /// number of nodes
        nodes: usize,
    },
    /// A gauge measures nothing, or where there is nothing.
    #[error("gauge \"{name}\" needs {needed}")]
    BadGauge {
        /// the gauge
        name: String,
        /// what is needed
        needed: String,
    },
    /// A quantity is asked for that is not there.
    #[error(transparent)]
    Quantity(#[from] UnknownQuantity),
    /// The files cannot be created.
    #[error(transparent)]
    Files(#[from] ObserveError),
    /// The files of an earlier run cannot be continued.
    #[error(transparent)]
    Resume(#[from] ResumeError),
}

/// The data of a request for the writing thread.
pub(super) fn files_spec<'a>(picture: &'a dyn Observables, spec: &'a RecorderSpec, gauges: &Gauges) -> FilesSpec<'a> {
    let channels = gauges.channels().iter();
    FilesSpec {
        folder: spec.out_dir.clone(),
        stem: file_stem(&spec.name),
        reference: picture.reference(),
        triangles: picture.triangles(),
        edges: picture.edges(),
        groups: picture.groups(),
        fields: spec.fields.of_scene(picture),
        draw_sides: spec.edges,
        probes: &spec.probes,
        gauges: channels.map(|channel| [channel.name.clone(), channel.quantity.name.to_owned()]).collect(),
        format: spec.format,
    }
}

/// Checks whether a run can be recorded as requested.
pub(super) fn check(spec: &RecorderSpec, nodes: usize) -> Result<(), RecorderError> {
    if let Some(every) = spec.frames_every {
        if !(every.is_finite() && every > 0.0) {
            return Err(RecorderError::BadInterval { every });
        }
        let end = spec.end;
        let few = end / every <= MOST_FRAMES;
        if !few {
            return Err(RecorderError::TooManyFrames { every, end, least: end / MOST_FRAMES });
        }
    }
    let rows = match spec.history_every {
        RowEvery::Steps(steps) => steps > 0,
        RowEvery::Time(every) => every.is_finite() && every > 0.0,
    };
    if !rows {
        return Err(RecorderError::BadHistory);
    }
    for probe in &spec.probes {
        if let Some(&node) = probe.nodes.iter().find(|&&node| node as usize >= nodes) {
            return Err(RecorderError::ProbeOutOfRange { name: probe.name.clone(), node, nodes });
        }
    }
    for GaugeSpec { name, of, every } in &spec.gauges {
        let bad = |needed: &str| Err(RecorderError::BadGauge { name: name.clone(), needed: needed.to_owned() });
        match of {
            GaugeOf::Nodes { nodes: list, .. } | GaugeOf::Cloth { nodes: list } => {
                if list.is_empty() {
                    return bad("at least one node");
                }
                if list.iter().any(|&node| node as usize >= nodes) {
                    return bad(&format!("nodes below {nodes}"));
                }
            }
            GaugeOf::Springs { .. }
            | GaugeOf::Pull { .. }
            | GaugeOf::Membranes { .. }
            | GaugeOf::Gas { .. }
            | GaugeOf::Contact { .. } => {}
        }
        if *every == 0 {
            return bad("at least 1 step a row");
        }
    }
    Ok(())
}
