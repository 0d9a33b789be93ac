//! Turns accepted steps into frames and rows, and sends them to the writing thread.

use serde::{Deserialize, Serialize};

use super::checkpoint::Checkpoint;
use super::crossings::{CrossingReport, CrossingWatch};
use super::frame::{Fields, Frame};
use super::gauges::{Gauges, GaugesSoFar, MeasuredQuantity, Peak};
use super::hermite::interpolate;
use super::request::{check, files_spec};
use super::rows::HistoryRow;
use super::schedule::CheckpointSchedule;
use super::schedule::{FrameDue, RowSchedule, Schedule, TimeInStep, tolerance};
use super::stages::StageReport;
use super::tables::{Destination, MemoryTables, Tables};
use super::writer::{Message, ResultWriter};
use crate::case::spec::RowEvery;
use crate::drive::event::Fired;
use crate::drive::observer::{
    AcceptedStep, Energies, ObserveError, Observer, Occasion, Point, Resumable, States, UpcomingStep, Wants,
};
use crate::model::forces::Forces;
use crate::model::observables::Observables;
use crate::model::state::{State, StateRef};

pub use super::request::{MOST_FRAMES, RecorderError, RecorderSpec};
pub use super::schedule::CheckpointSpec;

/// State of a recorder; part of a checkpoint.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RecorderState {
    /// number of the next frame time
    next_frame: u64,
    /// [s] time of the newest frame
    shown: Option<f64>,
    /// the newest step, if it is not yet in the history
    waiting: Option<HistoryRow>,
    /// interval of the rows; a run that is extended keeps it
    history_every: RowEvery,
    /// what the gauges have measured so far
    gauges: GaugesSoFar,
    /// crossings of cloth so far, if they are searched for
    pub(super) crossings: Option<CrossingReport>,
}

/// The observer that writes `NAME.pvd`, its frames, `history.csv`, `probes.csv` and `gauges.csv`.
///
/// Frames show t = 0, every multiple of `frames_every`, and the end. A frame within 1e-9 of a step from the end of the
/// step is that end; any other is [interpolated](super::hermite) within its step, with forces, reactions and tensions
/// evaluated there. A state that is not finite is never shown. Where a run fails, frames that are not
/// [credible](AcceptedStep::credible) are removed again, and the last credible state becomes the last frame.
pub struct Recorder<'a> {
    picture: &'a dyn Observables,
    fields: Fields,
    frames_every: Option<f64>,
    history_every: RowEvery,
    rows: RowSchedule,
    gauges: Gauges,
    /// here in memory, and where every step is searched; else the writing thread has it
    crossings: Option<CrossingWatch>,
    /// whether the states that come next are credible
    credible: bool,
    schedule: Schedule,
    /// [s] time of the newest frame
    shown: Option<f64>,
    /// the newest step, if it is not yet in the history
    waiting: Option<HistoryRow>,
    between: State,
    forces: Forces,
    writer: Destination,
    checkpoints: Option<CheckpointSchedule>,
    /// the last credible state, if newer ones are not credible
    last_good: Option<LastGood>,
    failed: bool,
}

/// The last credible state.
struct LastGood {
    point: Point,
    /// [s] time of the newest frame at that state
    shown: Option<f64>,
}

impl<'a> Recorder<'a> {
    /// Checks the request, creates the files and starts the writing thread.
    ///
    /// # Errors
    /// When the request is out of range or a file cannot be created.
    pub fn new(picture: &'a dyn Observables, spec: &RecorderSpec) -> Result<Self, RecorderError> {
        check(spec, picture.reference().len())?;
        let gauges = Gauges::new(picture, &spec.gauges(spec.history_every))?;
        let (here, there) = here_or_there(CrossingWatch::new(picture, spec.crossings));
        let writer = Destination::Files(Box::new(ResultWriter::start(&files_spec(picture, spec, &gauges), there)?));
        let mark = RecorderState { history_every: spec.history_every, ..RecorderState::default() };
        Ok(Self::around(picture, (gauges, here), spec, writer, mark))
    }

    /// The same in memory: no file is created, and frames only give the rows of probes.
    ///
    /// # Errors
    /// When the request is out of range.
    pub fn in_memory(picture: &'a dyn Observables, spec: &RecorderSpec) -> Result<Self, RecorderError> {
        check(spec, picture.reference().len())?;
        let gauges = Gauges::new(picture, &spec.gauges(spec.history_every))?;
        let files = files_spec(picture, spec, &gauges);
        let (size, channels) = (files.frame_size(), files.gauges);
        let writer = Destination::Memory(Box::new(MemoryTables::new(&spec.probes, channels, size)));
        let mark = RecorderState { history_every: spec.history_every, ..RecorderState::default() };
        Ok(Self::around(picture, (gauges, CrossingWatch::new(picture, spec.crossings)), spec, writer, mark))
    }

    /// What a recorder in memory has kept so far, which it then has no more.
    pub fn take_tables(&mut self) -> Tables {
        self.writer.take_tables()
    }

    /// Reopens the files of an earlier run and cuts them off at its checkpoint.
    ///
    /// # Errors
    /// When the request is out of range, or the files have changed or cannot be opened.
    pub fn resume(
        picture: &'a dyn Observables,
        spec: &RecorderSpec,
        checkpoint: &Checkpoint,
    ) -> Result<Self, RecorderError> {
        check(spec, picture.reference().len())?;
        let RecorderState { history_every, gauges: so_far, crossings: kept, .. } = &checkpoint.recorder;
        let mut gauges = Gauges::new(picture, &spec.gauges(*history_every))?;
        gauges.take_up(so_far);
        let mut watch = CrossingWatch::new(picture, spec.crossings);
        if let (Some(watch), Some(kept)) = (&mut watch, kept) {
            watch.take_up(kept);
        }
        let (here, there) = here_or_there(watch);
        let writer = ResultWriter::resume(&files_spec(picture, spec, &gauges), &checkpoint.files, there)?;
        let writer = Destination::Files(Box::new(writer));
        Ok(Self::around(picture, (gauges, here), spec, writer, checkpoint.recorder.clone()))
    }

    fn around(
        picture: &'a dyn Observables,
        (gauges, crossings): (Gauges, Option<CrossingWatch>),
        spec: &RecorderSpec,
        writer: Destination,
        mark: RecorderState,
    ) -> Self {
        let RecorderState { next_frame, shown, waiting, history_every, gauges: _, crossings: _ } = mark;
        Self {
            picture,
            fields: spec.fields.of_scene(picture),
            frames_every: spec.frames_every,
            history_every,
            rows: RowSchedule::of(history_every),
            gauges,
            crossings,
            credible: true,
            schedule: Schedule::at(spec.frames_every, next_frame),
            shown,
            waiting,
            between: picture.initial_state(),
            forces: picture.new_forces(),
            writer,
            checkpoints: None,
            last_good: None,
            failed: false,
        }
    }

    /// [s] time of the newest frame.
    pub fn shown(&self) -> Option<f64> {
        self.shown
    }

    /// The largest values that gauges have measured.
    pub fn peaks(&self) -> Vec<Peak> {
        self.gauges.peaks()
    }

    /// What the gauges reached in each stage of the run.
    pub fn stages(&self) -> Vec<StageReport> {
        self.gauges.stages()
    }

    /// The quantities of the run.
    pub fn quantities(&self) -> Vec<MeasuredQuantity> {
        self.gauges.quantities()
    }

    /// What was found of cloth that passes through cloth, if it was searched for. Of frames in files it is known once
    /// the run has ended.
    pub fn crossings(&self) -> Option<&CrossingReport> {
        self.crossings.as_ref().map(CrossingWatch::report).or_else(|| self.writer.crossings())
    }

    /// Measures gauges at the start, and writes their rows.
    fn measure(&mut self, at: &Point) -> Result<(), ObserveError> {
        let Self { gauges, writer, picture, .. } = self;
        gauges.step(*picture, 0, at, true, |row| writer.send(Message::Gauge(row)))
    }

    /// Makes the recorder also write `checkpoint.bin`.
    #[must_use]
    pub fn with_checkpoints(self, spec: CheckpointSpec) -> Self {
        Self { checkpoints: Some(CheckpointSchedule::new(spec)), ..self }
    }

    fn send_frame(&mut self, at: StateRef<'_>, forces: &Forces) -> Result<(), ObserveError> {
        let mut frame = self.writer.empty_frame()?;
        self.fill(&mut frame, at, forces);
        if !frame.is_finite() {
            self.writer.recycle(frame);
            return Ok(());
        }
        frame.credible = self.credible;
        if let Some(watch) = &mut self.crossings {
            watch.frame(&mut frame);
        }
        self.shown = Some(at.t);
        self.writer.send(Message::Frame(frame))
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
        if self.fields.tension {
            picture.springs().into_iter().for_each(|springs| springs.add_axial_damping(at, &mut frame.tension));
        }
        if self.fields.rest_length {
            match picture.springs() {
                Some(springs) => springs.rest_lengths(at.t, &mut frame.rest_length),
                None => frame.rest_length.fill(f64::NAN),
            }
        }
        if self.fields.pressure {
            picture.air().into_iter().for_each(|air| air.triangle_pressure(at, &mut frame.pressure));
        }
        if self.fields.membrane {
            picture.triangle_membranes(at, &mut frame.membrane);
        }
    }

    fn show_between(&mut self, [start, end]: [&Point; 2], moment: TimeInStep) -> Result<(), ObserveError> {
        // Moved out and back, because `send_frame` needs the rest of `self`.
        let (mut state, mut forces) = (std::mem::take(&mut self.between), std::mem::take(&mut self.forces));
        interpolate(start.state.as_ref(), end.state.as_ref(), moment.fraction, &mut state);
        // k * every itself, without the rounding error of a sum from the start of the step.
        state.t = moment.time;
        if self.fields.force || self.fields.reaction {
            self.picture.evaluate(state.as_ref(), &mut forces);
        }
        let shown = self.send_frame(state.as_ref(), &forces);
        (self.between, self.forces) = (state, forces);
        shown
    }

    fn write_row(&mut self, row: HistoryRow, at: StateRef<'_>) -> Result<(), ObserveError> {
        let (max_speed, max_strain) = (self.picture.max_speed(at), self.picture.max_strain(at));
        self.writer.send(Message::Row(HistoryRow { max_speed, max_strain, ..row }))
    }

    /// Writes the row of a step if it is due, with its largest speed [m/s] and strain [-]; any other is kept.
    fn row(&mut self, row: HistoryRow, largest: impl FnOnce() -> (f64, f64)) -> Result<(), ObserveError> {
        if !self.rows.due(row.step, row.t) {
            self.waiting = Some(row);
            return Ok(());
        }
        self.waiting = None;
        let (max_speed, max_strain) = largest();
        self.writer.send(Message::Row(HistoryRow { max_speed, max_strain, ..row }))
    }

    /// Whether a checkpoint is due at the end of a step, at `t` [s].
    fn keeps_at(&self, t: f64) -> bool {
        self.checkpoints.as_ref().is_some_and(|checkpoints| checkpoints.due(t))
    }
}

/// The watch where it stays with the recorder, which sees every step, and where it goes to the writing thread, which
/// has the frames.
fn here_or_there(watch: Option<CrossingWatch>) -> (Option<CrossingWatch>, Option<CrossingWatch>) {
    match watch.as_ref().is_some_and(CrossingWatch::every_step) {
        true => (watch, None),
        false => (None, watch),
    }
}

impl Observer for Recorder<'_> {
    fn started(&mut self, at: &Point, ledger: Energies) -> Result<(), ObserveError> {
        let state = at.state.as_ref();
        self.schedule = Schedule::new(self.frames_every, state.t);
        self.rows.skip(state.t);
        self.write_row(HistoryRow { t: state.t, ledger, ..HistoryRow::default() }, state)?;
        self.gauges.skip(state.t);
        self.gauges.account(state.t, ledger);
        self.measure(at)?;
        self.send_frame(state, &at.forces)
    }

    /// Wants the end state of a step that ends at a frame or a checkpoint, and both states if a frame lies within it.
    fn wants(&self, step: UpcomingStep) -> Wants {
        let (mut rows, checkpoint) = (self.rows, Wants::end_if(self.keeps_at(step.t)));
        rows.skip(step.from);
        let measured = Wants::end_if(self.gauges.wants(step.step, [step.from, step.t]));
        let crossings = Wants::end_if(self.crossings.as_ref().is_some_and(CrossingWatch::every_step));
        let states = [checkpoint, measured, crossings].map(|wants| wants.states);
        let states = states.into_iter().fold(self.schedule.states(step), States::max);
        Wants { states, strain: rows.due(step.step, step.t) }
    }

    fn accepted(&mut self, step: AcceptedStep<'_>) -> Result<(), ObserveError> {
        if step.credible {
            self.last_good = None;
        } else if let (None, Some(start)) = (&self.last_good, step.start) {
            self.last_good = Some(LastGood { point: start.clone(), shown: self.shown });
        }
        self.credible = step.credible;
        while let Some(due) = self.schedule.next_in(step.from, step.t) {
            match (due, step.start, step.end) {
                (FrameDue::End, _, Some(end)) => self.send_frame(end.state.as_ref(), &end.forces)?,
                (FrameDue::Between(moment), Some(start), Some(end)) => self.show_between([start, end], moment)?,
                // The run gives every state that is wanted.
                _ => {}
            }
        }
        let Self { gauges, writer, picture, .. } = self;
        gauges.accepted(*picture, step, |row| writer.send(Message::Gauge(row)))?;
        if let (Some(watch), Some(end)) = (&mut self.crossings, step.end)
            && watch.every_step()
            && step.credible
        {
            watch.step(self.picture, end.state.as_ref());
        }
        let row = HistoryRow {
            t: step.t,
            step: step.step,
            ledger: step.ledger,
            newton_iterations: step.newton_iterations,
            residual: step.residual,
            ..HistoryRow::default()
        };
        let picture = self.picture;
        self.row(row, || (step.max_speed(picture), step.max_strain(picture)))
    }

    fn event(&mut self, event: &Fired) -> Result<(), ObserveError> {
        self.gauges.event(event);
        Ok(())
    }

    fn resumed(&mut self, at: &Point, _ledger: Energies) -> Result<(), ObserveError> {
        self.rows.skip(at.state.t);
        self.gauges.skip(at.state.t);
        if let Some(checkpoints) = &mut self.checkpoints {
            checkpoints.skip(at.state.t);
        }
        Ok(())
    }

    fn resumable(&mut self, run: &Resumable<'_>) -> Result<(), ObserveError> {
        // A run that is resumed from a state that is not credible would not know the last credible one.
        if self.last_good.is_some() && run.occasion == Occasion::Step {
            return Ok(());
        }
        let Self { shown, waiting, history_every, .. } = *self;
        let (next_frame, gauges, crossings) = (self.schedule.position(), &self.gauges, self.crossings().cloned());
        let mark = || RecorderState { next_frame, shown, waiting, history_every, gauges: gauges.kept(), crossings };
        match self.checkpoints.as_mut().and_then(|checkpoints| checkpoints.checkpoint_if_due(run, mark)) {
            Some(checkpoint) => self.writer.checkpoint(checkpoint),
            None => Ok(()),
        }
    }

    fn failed(&mut self) -> Result<(), ObserveError> {
        self.failed = true;
        Ok(())
    }

    fn finished(&mut self, last: &Point) -> Result<(), ObserveError> {
        let state = last.state.as_ref();
        if let Some(row) = self.waiting.take().filter(|row| row.t == state.t) {
            self.write_row(row, state)?;
        }
        let Self { gauges, writer, picture, failed, .. } = self;
        gauges.last(*picture, last, !*failed, |row| writer.send(Message::Gauge(row)))?;
        let good = self.last_good.take().filter(|_| self.failed);
        if let Some(LastGood { point, shown }) = &good {
            if self.shown != *shown {
                self.writer.send(Message::WithdrawAfter(point.state.t))?;
            }
            self.shown = *shown;
        }
        let last = good.as_ref().map_or(last, |good| &good.point);
        let state = last.state.as_ref();
        let same = |shown: f64| (shown - state.t).abs() <= tolerance(state.t, state.t);
        if !self.shown.is_some_and(same) {
            self.send_frame(state, &last.forces)?;
        }
        self.writer.finish()
    }
}
