//! Cloth that passes through cloth in the states of a run: what is counted, and what is said of it.

use serde::{Deserialize, Serialize};

use super::frame::Frame;
use crate::case::spec::CrossingSearch;
use crate::format_number::{counted, figures};
use crate::mesh::{Crossing, CrossingFinder};
use crate::model::observables::Observables;
use crate::model::state::StateRef;
use crate::warning::{Warning, WarningCode};

/// An edge of cloth that passes through a triangle of cloth at some time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TimedCrossing {
    /// [s] time
    pub t: f64,
    /// nodes of the edge, the smaller one first
    pub edge: [u32; 2],
    /// the triangle
    pub triangle: u32,
    /// [m] how far edge or triangle would have to move to part
    pub depth: f64,
}

impl TimedCrossing {
    fn new(t: f64, Crossing { edge, triangle, depth }: Crossing) -> Self {
        TimedCrossing { t, edge, triangle, depth }
    }
}

/// Crossings of cloth with cloth over a run, in `summary.json`: all numbers are of edges that pass through triangles.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CrossingReport {
    /// states that were searched
    pub searched: CrossingSearch,
    /// number of these states
    pub states: u64,
    /// number of states with crossings
    pub with_crossings: u64,
    /// largest number of crossings in a state
    pub largest: u64,
    /// [s] the first time with so many; null without crossings
    pub largest_time: Option<f64>,
    /// the deepest crossing of the first state that has any; null without crossings
    pub first: Option<TimedCrossing>,
    /// the deepest of all; null without crossings
    pub deepest: Option<TimedCrossing>,
    /// whether all were found; cloth that is crumpled beyond all measure has more than are looked for
    pub complete: bool,
}

impl CrossingReport {
    /// A warning if there are crossings.
    pub fn warning(&self) -> Option<Warning> {
        let (first, deepest) = (self.first?, self.deepest?);
        let states = match (self.searched, self.states) {
            (_, 1) => "state".to_owned(),
            (CrossingSearch::Steps, n) => format!("states of {n}, the start and every step"),
            (_, n) => format!("frames of {n}"),
        };
        let place = |one: TimedCrossing| {
            format!("the edge of nodes {} and {} through triangle {}", one.edge[0], one.edge[1], one.triangle)
        };
        let largest = counted(self.largest, "crossing", "crossings");
        let text = format!(
            "cloth passes through cloth in {} {states}, first at t = {} s ({}, {} m deep); at most {}{largest} at \
             once, at t = {} s, and up to {} m deep, at t = {} s ({}): keep sheets apart by \
             system.network.contact, or do not trust this run from there on",
            self.with_crossings,
            figures(first.t, 6),
            place(first),
            figures(first.depth, 2),
            if self.complete { "" } else { "more than " },
            figures(self.largest_time?, 6),
            figures(deepest.depth, 2),
            figures(deepest.t, 6),
            place(deepest),
        );
        Some(Warning::new(WarningCode::ClothCrossing, text))
    }
}

/// Searches the states of a run for crossings of cloth with cloth.
#[derive(Debug)]
pub(super) struct CrossingWatch {
    finder: CrossingFinder,
    report: CrossingReport,
    /// [s] time of the state that was searched last
    at: f64,
    /// \[m\] and \[m/s\] of every node at the end of a step
    trace: [Vec<[f64; 3]>; 2],
}

impl CrossingWatch {
    /// Of a scene; `None` where cloth cannot meet cloth or none is searched for.
    pub(super) fn new(picture: &dyn Observables, searched: CrossingSearch) -> Option<Self> {
        let finder = (searched != CrossingSearch::None).then(|| CrossingFinder::new(picture.triangles()))??;
        let finder = finder.with_start(picture.reference());
        let report = CrossingReport { searched, complete: true, ..CrossingReport::default() };
        let nodes = if searched == CrossingSearch::Steps { picture.reference().len() } else { 0 };
        let trace = [(); 2].map(|()| vec![[0.0; 3]; nodes]);
        Some(CrossingWatch { finder, report, at: f64::NAN, trace })
    }

    /// What was found so far; part of a checkpoint.
    pub(super) fn report(&self) -> &CrossingReport {
        &self.report
    }

    /// Takes up what a checkpoint kept.
    pub(super) fn take_up(&mut self, kept: &CrossingReport) {
        self.report = kept.clone();
    }

    pub(super) fn every_step(&self) -> bool {
        self.report.searched == CrossingSearch::Steps
    }

    /// Searches a frame, counts it if frames are counted and it is credible, and writes 1 for its triangles that pass
    /// through others, 0 for all others.
    pub(super) fn frame(&mut self, frame: &mut Frame) {
        self.finder.find(&frame.positions);
        self.at = frame.time;
        // Of the steps, the start is a frame as well.
        if frame.credible && (!self.every_step() || self.report.states == 0) {
            self.count();
        }
        self.finder.mark(&mut frame.crossing);
    }

    /// Searches and counts a credible state at the end of a step.
    pub(super) fn step(&mut self, picture: &dyn Observables, state: StateRef<'_>) {
        // A frame at the end of the step has been searched already.
        if self.at != state.t {
            let [positions, velocities] = &mut self.trace;
            picture.trace(state, positions, velocities);
            if !positions.as_flattened().iter().all(|x| x.is_finite()) {
                return;
            }
            self.finder.find(positions);
            self.at = state.t;
        }
        self.count();
    }

    fn count(&mut self) {
        let (t, found, report) = (self.at, self.finder.found(), &mut self.report);
        report.states += 1;
        report.complete &= self.finder.is_complete();
        let deeper = |deepest: Crossing, one: Crossing| if one.depth > deepest.depth { one } else { deepest };
        let Some(deepest) = found.iter().copied().reduce(deeper).map(|one| TimedCrossing::new(t, one)) else { return };
        report.with_crossings += 1;
        report.first.get_or_insert(deepest);
        if report.deepest.is_none_or(|so_far| deepest.depth > so_far.depth) {
            report.deepest = Some(deepest);
        }
        if found.len() as u64 > report.largest {
            (report.largest, report.largest_time) = (found.len() as u64, Some(t));
        }
    }
}
