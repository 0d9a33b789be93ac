//! Turns accepted steps into frames and rows, and hands them to the writing thread.

use std::path::PathBuf;

use super::encode::VtuFormat;
use super::files::FilesSpec;
use super::frame::{Fields, Frame};
use super::hermite::interpolate;
use super::history::HistoryRow;
use super::names::file_stem;
use super::probes::Probe;
use super::schedule::{Due, Moment, Schedule, tolerance};
use super::writer::ResultWriter;
use crate::drive::observer::{LedgerRow, ObserveError, Observer, Point, StepView};
use crate::model::forces::Forces;
use crate::model::picture::Picture;
use crate::model::state::{State, StateRef};

/// Frames a run may be asked for; their numbers have six digits.
pub const MOST_FRAMES: f64 = 1e6;

/// What to record.
#[derive(Clone, Debug, Default)]
pub struct RecorderSpec {
    /// name of the case; files are named after its [`file_stem`]
    pub name: String,
    /// folder of the results; see [`super::folder::ResultFolder::prepare`]
    pub out_dir: PathBuf,
    /// [s] between frames, > 0; without it only the first and the last state are shown
    pub frames_every: Option<f64>,
    /// [s] when the run is to end; bounds the number of frames
    pub end: f64,
    /// fields beside displacement and velocity
    pub fields: Fields,
    /// nodes to follow at each frame time
    pub probes: Vec<Probe>,
    /// steps a history row, >= 1; see [`default_history_every`]
    pub history_every: u64,
    /// spelling of the frames' arrays
    pub format: VtuFormat,
}

/// Why a run cannot be recorded as asked.
#[derive(Debug, thiserror::Error)]
pub enum RecorderError {
    /// The interval is no interval.
    #[error(
        "output.frames.every = {every} s must be finite and above 0; leave `frames` out to get the first and last state only"
    )]
    BadInterval {
        /// [s] what was asked for
        every: f64,
    },
    /// More frames than can be numbered.
    #[error(
        "frames every {every} s until {end} s are more than {MOST_FRAMES:e}; take output.frames.every >= {least:e} s"
    )]
    TooManyFrames {
        /// [s] what was asked for
        every: f64,
        /// [s] end of the run
        end: f64,
        /// [s] the smallest interval that is accepted
        least: f64,
    },
    /// No row can be written every 0 steps.
    #[error("output.history.every = 0 must be at least 1 step a row")]
    BadHistory,
    /// A probe follows a node that is not there.
    #[error("probe \"{name}\" follows node {node}, but there are {nodes} nodes, counted from 0")]
    ProbeOutOfRange {
        /// the probe
        name: String,
        /// the node
        node: u32,
        /// number of nodes
        nodes: usize,
    },
    /// The files cannot be created.
    #[error(transparent)]
    Files(#[from] ObserveError),
}

/// Steps a row such that a run of `total_steps` gets at most 10,000 rows beside its first and last.
pub fn default_history_every(total_steps: u64) -> u64 {
    total_steps.div_ceil(10_000).max(1)
}

/// The observer that writes `NAME.pvd`, its frames, `history.csv` and `probes.csv`.
///
/// Frames show t = 0, every multiple of `frames_every`, and the end. One that lies within 1e-9 of a step from the
/// step's end is that end; any other is [interpolated](super::hermite) within its step, with forces, reactions and
/// tensions evaluated there. A state that is not finite is never shown.
pub struct Recorder<'a> {
    picture: &'a dyn Picture,
    fields: Fields,
    frames_every: Option<f64>,
    history_every: u64,
    schedule: Schedule,
    /// [s] time of the newest frame
    shown: Option<f64>,
    /// the newest step, if the history does not show it yet
    waiting: Option<HistoryRow>,
    between: State,
    forces: Forces,
    writer: ResultWriter,
}

impl<'a> Recorder<'a> {
    /// Checks what is asked for, creates the files and starts the writing thread.
    ///
    /// # Errors
    /// When the request is out of range or a file cannot be created.
    pub fn new(picture: &'a dyn Picture, spec: &RecorderSpec) -> Result<Self, RecorderError> {
        check(spec, picture.reference().len())?;
        let writer = ResultWriter::start(&FilesSpec {
            folder: spec.out_dir.clone(),
            stem: file_stem(&spec.name),
            reference: picture.reference(),
            triangles: picture.triangles(),
            edges: picture.edges(),
            fields: spec.fields,
            probes: &spec.probes,
            format: spec.format,
        })?;
        Ok(Self {
            picture,
            fields: spec.fields,
            frames_every: spec.frames_every,
            history_every: spec.history_every,
            schedule: Schedule::new(spec.frames_every, 0.0),
            shown: None,
            waiting: None,
            between: picture.initial_state(),
            forces: picture.new_forces(),
            writer,
        })
    }

    fn show(&mut self, at: StateRef<'_>, forces: &Forces) -> Result<(), ObserveError> {
        let mut frame = self.writer.empty_frame()?;
        self.fill(&mut frame, at, forces);
        if !frame.is_finite() {
            self.writer.forget(frame);
            return Ok(());
        }
        self.shown = Some(at.t);
        self.writer.frame(frame)
    }

    fn fill(&self, frame: &mut Frame, at: StateRef<'_>, forces: &Forces) {
        let picture = self.picture;
        frame.time = at.t;
        picture.trace(at, &mut frame.positions, &mut frame.velocities);
        if self.fields.force {
            picture.node_forces(at, forces, &mut frame.force);
        }
        if self.fields.reaction {
            picture.node_reactions(forces, &mut frame.reaction);
        }
        if self.fields.tension || self.fields.strain {
            picture.edge_tension(at, &mut frame.tension, &mut frame.strain);
        }
    }

    fn show_between(&mut self, step: &StepView<'_>, moment: Moment) -> Result<(), ObserveError> {
        // Taken out and put back, because `show` needs the rest of `self`.
        let (mut state, mut forces) = (std::mem::take(&mut self.between), std::mem::take(&mut self.forces));
        interpolate(step.from.state.as_ref(), step.to.state.as_ref(), moment.fraction, &mut state);
        // k * every itself, without the rounding of getting there from the step's start.
        state.t = moment.time;
        if self.fields.force || self.fields.reaction {
            self.picture.evaluate(state.as_ref(), &mut forces);
        }
        let shown = self.show(state.as_ref(), &forces);
        (self.between, self.forces) = (state, forces);
        shown
    }

    fn write_row(&mut self, row: HistoryRow, at: StateRef<'_>) -> Result<(), ObserveError> {
        let (max_speed, max_strain) = (self.picture.max_speed(at), self.picture.max_strain(at));
        self.writer.row(HistoryRow { max_speed, max_strain, ..row })
    }
}

impl Observer for Recorder<'_> {
    fn started(&mut self, at: &Point, ledger: LedgerRow) -> Result<(), ObserveError> {
        let state = at.state.as_ref();
        self.schedule = Schedule::new(self.frames_every, state.t);
        self.write_row(HistoryRow { t: state.t, ledger, ..HistoryRow::default() }, state)?;
        self.show(state, &at.forces)
    }

    fn accepted(&mut self, step: StepView<'_>) -> Result<(), ObserveError> {
        let (from, to) = (step.from.state.t, step.to.state.as_ref());
        while let Some(due) = self.schedule.next_in(from, to.t) {
            match due {
                Due::End => self.show(to, &step.to.forces)?,
                Due::Between(moment) => self.show_between(&step, moment)?,
            }
        }
        let row = HistoryRow {
            t: to.t,
            step: step.step,
            ledger: step.ledger,
            newton_iterations: step.newton_iterations,
            residual: step.residual,
            ..HistoryRow::default()
        };
        if step.step.is_multiple_of(self.history_every) {
            self.waiting = None;
            self.write_row(row, to)
        } else {
            self.waiting = Some(row);
            Ok(())
        }
    }

    fn finished(&mut self, last: &Point) -> Result<(), ObserveError> {
        let state = last.state.as_ref();
        if let Some(row) = self.waiting.take().filter(|row| row.t == state.t) {
            self.write_row(row, state)?;
        }
        let same = |shown: f64| (shown - state.t).abs() <= tolerance(state.t, state.t);
        if !self.shown.is_some_and(same) {
            self.show(state, &last.forces)?;
        }
        self.writer.finish()
    }
}

fn check(spec: &RecorderSpec, nodes: usize) -> Result<(), RecorderError> {
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
    if spec.history_every == 0 {
        return Err(RecorderError::BadHistory);
    }
    for probe in &spec.probes {
        if let Some(&node) = probe.nodes.iter().find(|&&node| node as usize >= nodes) {
            return Err(RecorderError::ProbeOutOfRange { name: probe.name.clone(), node, nodes });
        }
    }
    Ok(())
}
