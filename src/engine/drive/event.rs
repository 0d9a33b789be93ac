//! Events of a run: those that are told, and those that wait for a state of the scene or for another event.

use crate::model::abilities::Events;
use crate::model::spec::{EventSpec, Trigger};
use crate::model::state::StateRef;
use crate::scene::Scene;
use serde::{Deserialize, Serialize};

/// An event that has happened.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Fired {
    /// its number in the [events of the scene](Events::named)
    pub event: usize,
    /// [s] when
    pub t: f64,
    /// its name
    pub name: String,
    /// what happened, in words
    pub what: String,
    /// [m] where the payload, or what the event looks at, was then
    pub place: [f64; 3],
    /// [m/s] its velocity then
    pub velocity: [f64; 3],
    /// [m/s] its speed against the air then
    pub air_speed: f64,
    /// whether a time was given for it, so that it is only told
    pub told: bool,
    /// the [stage](EventSpec::stage) of the run that begins there
    pub stage: Option<String>,
    /// the landing, if it is one
    pub landing: Option<Landing>,
}

/// The end of a flight.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Landing {
    /// [m/s] speed at touchdown
    pub speed: f64,
    /// [m/s] downward part of it
    pub descent: f64,
    /// [m] horizontal distance from where it was at the start
    pub drift: f64,
    /// [deg] direction of the drift, from the y axis (north) to the x axis (east); null without a drift
    pub heading: Option<f64>,
}

fn length([x, y, z]: [f64; 3]) -> f64 {
    x.hypot(y).hypot(z)
}

impl Landing {
    /// That of a body from its place at the start [m], with a velocity [m/s].
    fn new(start: [f64; 3], place: [f64; 3], velocity: [f64; 3]) -> Self {
        let [x, y] = [0, 1].map(|axis| place[axis] - start[axis]);
        let (speed, drift) = (length(velocity), x.hypot(y));
        let heading = (drift > 0.0).then(|| x.atan2(y).to_degrees().rem_euclid(360.0));
        Landing { speed, descent: -velocity[2], drift, heading }
    }
}

/// Where a run stands in the events of its scene.
#[derive(Clone, Debug, Default)]
pub(super) struct EventWatch {
    /// numbers of those whose conditions are not met yet, but for springs that break
    waiting: Vec<usize>,
    /// numbers of those of springs that can still break
    waiting_breaks: Vec<usize>,
    /// [s] times that are known, at which steps end, with the number of the event
    armed: Vec<(f64, usize)>,
    /// the same of those that are only told
    told: Vec<(f64, usize)>,
    /// those that have happened
    fired: Vec<Fired>,
    /// numbers and names of those that have not happened, springs that break and those that are told left out
    unmet: Vec<(usize, String)>,
    /// whether the present step was made to end at one of those that wait
    found: bool,
    /// whether it was seen that none of them is due at its end
    none_due: bool,
    /// whether the run ends at events that say so
    ends_runs: bool,
    /// whether one of these has happened
    ended: bool,
}

impl EventWatch {
    /// Of a run in which these events have happened. The scene is then in that state.
    pub(super) fn open(scene: &dyn Scene, fired: Vec<Fired>, ends_runs: bool) -> Self {
        let Some(events) = scene.events().filter(|events| !events.named().is_empty()) else {
            return EventWatch::default();
        };
        let watch = EventWatch::of(events, fired, ends_runs);
        watch.tell_scene(events);
        watch
    }

    fn of(events: &dyn Events, mut fired: Vec<Fired>, ends_runs: bool) -> Self {
        let named = events.named();
        fired.retain(|one| one.event < named.len());
        let mut watch = EventWatch { fired, ends_runs, ..EventWatch::default() };
        watch.ended = ends_runs && watch.fired.iter().any(|one| named.get(one.event).is_some_and(|of| of.ends_run));
        let (mut left, breaks) = (vec![true; named.len()], events.breaks());
        watch.fired.iter().for_each(|one| left[one.event] = false);
        for event in (0..named.len()).filter(|event| left[*event]) {
            if named[event].acts() && !breaks.contains(&event) {
                watch.unmet.push((event, named[event].name.clone()));
            }
            match &named[event].trigger {
                Trigger::When(_) if breaks.contains(&event) => watch.waiting_breaks.push(event),
                Trigger::When(_) => watch.waiting.push(event),
                Trigger::At(t) => watch.armed.push((*t, event)),
                Trigger::Told(t) => watch.told.push((*t, event)),
                Trigger::After { event: other, delay } => {
                    watch.armed.extend(watch.happened(*other).map(|t| (t + delay, event)));
                }
            }
        }
        watch.sort();
        watch
    }

    /// [s] The times at which steps of a run end in which these have happened; the scene stays as it is.
    pub(super) fn known(scene: &dyn Scene, fired: &[Fired]) -> Vec<f64> {
        let watch = scene.events().map(|events| EventWatch::of(events, fired.to_vec(), false));
        watch.map_or_else(Vec::new, |watch| watch.times(scene).collect())
    }

    /// [s] When an event has happened.
    fn happened(&self, event: usize) -> Option<f64> {
        self.fired.iter().find(|one| one.event == event).map(|one| one.t)
    }

    fn sort(&mut self) {
        let by_time = |a: &(f64, usize), b: &(f64, usize)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
        self.armed.sort_by(by_time);
        self.told.sort_by(by_time);
    }

    /// Returns whether the scene is another one now.
    fn tell_scene(&self, events: &dyn Events) -> bool {
        let mut happened = vec![[f64::INFINITY, 0.0]; events.named().len()];
        self.fired.iter().for_each(|one| happened[one.event] = [one.t, one.air_speed]);
        events.set_happened(&happened)
    }

    /// Whether events can happen at a state that is not known before: such a run makes its steps one by one.
    pub(super) fn waits(&self) -> bool {
        !self.waiting.is_empty() || !self.waiting_breaks.is_empty()
    }

    /// Says whether the step that was attempted was made to end at an event that waits.
    pub(super) fn ends_step(&mut self, found: bool) {
        (self.found, self.none_due) = (found, false);
    }

    /// Says that no event that waits is due at the end of the step that was attempted.
    pub(super) fn none_is_due(&mut self) {
        self.none_due = true;
    }

    /// Whether nothing is left that steps must end at.
    pub(super) fn is_idle(&self) -> bool {
        !self.waits() && self.armed.is_empty()
    }

    /// Whether the run is at its end.
    pub(super) fn ended(&self) -> bool {
        self.ended
    }

    /// What has happened so far.
    pub(super) fn fired(&self) -> &[Fired] {
        &self.fired
    }

    /// [s] The times at which steps end: of events that have happened, of the corners of winds that have begun with
    /// them, and of those whose time is known.
    pub(super) fn times<'a>(&'a self, scene: &'a dyn Scene) -> impl Iterator<Item = f64> + 'a {
        let happened = scene.events().into_iter().flat_map(|events| {
            let acts = |one: &&Fired| events.named().get(one.event).is_some_and(EventSpec::acts);
            self.fired.iter().filter(acts).flat_map(|one| {
                let corners = events.corners_after(one.event).into_iter().filter(|since| *since > 0.0);
                std::iter::once(one.t).chain(corners.map(|since| one.t + since))
            })
        });
        happened.chain(self.armed.iter().map(|(t, _)| *t))
    }

    /// Whether an event lies in a step between two times [s] that is only told.
    pub(super) fn tells(&self, [from, to]: [f64; 2]) -> bool {
        self.told.first().is_some_and(|(t, _)| *t > from && *t <= to)
    }

    /// Names of the events that have not happened.
    pub(super) fn unmet(&self) -> Vec<String> {
        self.unmet.iter().map(|(_, name)| name.clone()).collect()
    }

    /// How far the next of the events that wait is from happening; infinite without any.
    pub(super) fn margin(&self, scene: &dyn Scene, at: StateRef<'_>) -> f64 {
        let Some(events) = scene.events() else { return f64::INFINITY };
        let of_others = self.waiting.iter().map(|event| events.margin(*event, at)).fold(f64::INFINITY, f64::min);
        of_others.min(self.break_margin(events, at))
    }

    /// [N] How far the next spring is from breaking; infinite where none can.
    fn break_margin(&self, events: &dyn Events, at: StateRef<'_>) -> f64 {
        if self.waiting_breaks.is_empty() { f64::INFINITY } else { events.break_margin(at) }
    }

    /// Lets all happen that is due at an accepted state, one after the other, as one may follow another at once. Times
    /// count as reached that are at most `slack` [s] later. Returns whether the scene is another one now.
    pub(super) fn happen(&mut self, scene: &dyn Scene, at: StateRef<'_>, slack: f64) -> bool {
        if self.is_idle() && self.told.is_empty() {
            return false;
        }
        let Some(events) = scene.events() else { return false };
        let due = |(t, _): &(f64, usize)| *t - at.t <= slack;
        let told = self.told.partition_point(due);
        for (t, event) in self.told.drain(..told).collect::<Vec<_>>() {
            self.note(scene, events, event, StateRef { t, ..at });
        }
        let mut acted = false;
        loop {
            let by_time = self.armed.partition_point(due);
            let mut happening: Vec<usize> = self.armed.drain(..by_time).map(|(_, event)| event).collect();
            let margin = |event: usize| events.margin(event, at);
            if !std::mem::take(&mut self.none_due) {
                happening.extend(self.waiting.extract_if(.., |event| margin(*event) <= 0.0));
                if self.break_margin(events, at) <= 0.0 {
                    happening.extend(self.waiting_breaks.extract_if(.., |event| margin(*event) <= 0.0));
                }
            }
            if std::mem::take(&mut self.found) && happening.is_empty() {
                // An iteration that was made again, to the same place, may end a rounding error before the event.
                let all = self.waiting.iter().chain(&self.waiting_breaks).copied();
                let next = all.min_by(|a, b| margin(*a).total_cmp(&margin(*b)));
                for list in [&mut self.waiting, &mut self.waiting_breaks] {
                    list.retain(|event| Some(*event) != next);
                }
                happening.extend(next);
            }
            if happening.is_empty() {
                return acted;
            }
            acted = true;
            happening.iter().for_each(|event| self.note(scene, events, *event, at));
            self.tell_scene(events);
        }
    }

    /// Notes an event at a state, and when those happen that follow it.
    fn note(&mut self, scene: &dyn Scene, events: &dyn Events, event: usize, at: StateRef<'_>) {
        let named = events.named();
        let Some(of @ EventSpec { name, what, ends_run, .. }) = named.get(event) else { return };
        let [place, velocity] = events.place_of(event, at);
        let wind = events.wind_at(at.t, place[2]);
        let air_speed = length(std::array::from_fn(|axis| velocity[axis] - wind[axis]));
        let landing = ends_run.then(|| {
            let [start, _] = events.place_of(event, scene.initial_state().as_ref());
            Landing::new(start, place, velocity)
        });
        log::info!("t = {:.6e} s: {name}: {what}", at.t);
        self.ended |= *ends_run && self.ends_runs;
        self.unmet.retain(|(of, _)| *of != event);
        let (name, what, told, stage) = (name.clone(), what.clone(), !of.acts(), of.stage.clone());
        self.fired.push(Fired { event, t: at.t, name, what, place, velocity, air_speed, told, stage, landing });
        // Nothing follows a break.
        let followers = if events.breaks().contains(&event) { 0 } else { named.len() };
        for (number, of) in named[..followers].iter().enumerate() {
            if let Trigger::After { event: other, delay } = of.trigger
                && other == event
            {
                self.armed.push((at.t + delay, number));
            }
        }
        self.sort();
    }
}
