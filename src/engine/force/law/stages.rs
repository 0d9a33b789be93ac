//! Stages of a drag area, of which some start with an event of the run.

use crate::force::Copies;
use crate::model::spec::FillingSpec;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// When each event of a scene has happened in a run [s], infinite until then, and the speed against the air [m/s] of
/// what it looks at. The scene shares them with its forces.
#[derive(Debug, Default)]
pub struct EventTimes(Vec<[AtomicU64; 2]>);

impl Clone for EventTimes {
    /// Others of the same values.
    fn clone(&self) -> Self {
        let copy = |number: &AtomicU64| AtomicU64::new(number.load(Ordering::Relaxed));
        EventTimes(self.0.iter().map(|[t, speed]| [copy(t), copy(speed)]).collect())
    }
}

impl EventTimes {
    /// Of so many events, none of which has happened.
    pub fn new(count: usize) -> Self {
        let times = EventTimes((0..count).map(|_| Default::default()).collect());
        (0..count).for_each(|event| times.set(event, [f64::INFINITY, 0.0]));
        times
    }

    /// [s, m/s] When an event has happened, and how fast.
    pub fn of(&self, event: usize) -> [f64; 2] {
        let read = |number: &AtomicU64| f64::from_bits(number.load(Ordering::Relaxed));
        self.0.get(event).map_or([f64::INFINITY, 0.0], |numbers| numbers.each_ref().map(read))
    }

    /// Says when an event has happened [s], and how fast [m/s].
    pub fn set(&self, event: usize, values: [f64; 2]) {
        let places = self.0.get(event).into_iter().flatten();
        places.zip(values).for_each(|(place, value)| place.store(value.to_bits(), Ordering::Relaxed));
    }

    /// Number of events.
    pub fn count(&self) -> usize {
        self.0.len()
    }
}

/// The stages of a canopy, in a run.
#[derive(Clone, Debug)]
pub struct Stages {
    given: Arc<[FillingSpec]>,
    times: Arc<EventTimes>,
    /// whether one of them starts with an event
    by_events: bool,
}

impl Stages {
    /// Stages as given, with the events of their scene.
    pub fn new(given: &[FillingSpec], times: Arc<EventTimes>) -> Self {
        let by_events = given.iter().any(|stage| stage.event.is_some());
        Stages { given: given.into(), times, by_events }
    }

    /// No stages.
    pub fn none() -> Self {
        Stages::new(&[], Arc::default())
    }

    /// The same stages in another run.
    #[must_use]
    pub(crate) fn for_run(&self, copies: &mut Copies) -> Self {
        Stages { times: copies.of(&self.times), ..self.clone() }
    }

    /// Calls `f` with the stages as far as it is known when they start; that is infinite for the others.
    fn known<T>(&self, f: impl FnOnce(&[FillingSpec]) -> T) -> T {
        if !self.by_events {
            return f(&self.given);
        }
        let known = |stage: &FillingSpec| {
            let Some(event) = stage.event else { return *stage };
            let [start, speed] = self.times.of(event);
            let duration = if stage.by_speed && start.is_finite() { stage.duration / speed } else { stage.duration };
            FillingSpec { start, duration, ..*stage }
        };
        f(&self.given.iter().map(known).collect::<Vec<_>>())
    }

    /// [m^2] The drag area at time `t` [s].
    pub fn area_at(&self, t: f64) -> f64 {
        self.known(|stages| FillingSpec::area_at(stages, t))
    }

    /// [m^2/s] The rate of change of the drag area at time `t` [s].
    pub fn growth_at(&self, t: f64) -> f64 {
        self.known(|stages| FillingSpec::growth_at(stages, t))
    }

    /// Whether the canopy has at least half of the drag area of the stage at time `t` [s].
    pub fn half_filled(&self, t: f64) -> bool {
        self.known(|stages| FillingSpec::half_filled(stages, t))
    }

    /// [m^2] The drag area at the end of the last stage.
    pub fn full_area(&self) -> Option<f64> {
        self.given.last().map(|stage| stage.drag_area)
    }

    /// [s] Beginnings and ends of those stages that have started with an event.
    pub fn changes(&self) -> Vec<[f64; 2]> {
        let started = |stages: &[FillingSpec]| {
            let begun = stages.iter().filter(|stage| stage.event.is_some() && stage.start.is_finite());
            begun.map(|stage| [stage.start, stage.start + stage.duration]).collect()
        };
        if self.by_events { self.known(started) } else { Vec::new() }
    }
}
