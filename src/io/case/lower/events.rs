//! Events: what supports, springs, stages and the end of a run wait for. What is told of a time is an event too, which
//! others can follow.

use super::geometry::Geometry;
use super::select;
use super::stages::after_cut;
use super::wind;
use crate::case::diagnostics::{Faults, did_you_mean, one_of};
use crate::case::pointer::Pointer;
use crate::case::schema::{CutRule, Network, NodeOrEdgeSelection, OneOrSeveral, Until, When, Wind};
use crate::model::spec::{CanopyAir, CanopySpec, Condition, EventSpec, Trigger, Watched};

/// The group of the payload, which events look at if they do not say what, and whose height reports tell.
pub(super) const PAYLOAD: &str = "payload";

/// What waits for an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Waits {
    /// a support, by its place
    Support(usize),
    /// a rule of springs, by its place
    Springs(usize),
    /// a stage of a canopy, by the places of both
    Stage(usize, usize),
    /// a part of the wind, by its place
    Wind(usize),
    /// the end of the run
    End,
}

/// When it happens, as the case says it.
#[derive(Clone, Copy, Debug)]
enum Moment<'a> {
    Time(f64),
    When(&'a When),
    Ground(&'a Until),
}

/// An event of the case.
#[derive(Debug)]
struct Planned<'a> {
    waits: Waits,
    moment: Moment<'a>,
    /// where it says so
    at: Pointer,
    name: String,
    what: String,
    /// name of the stage of the run that begins there
    stage: Option<String>,
}

/// The events of a case, by their places in the specification.
#[derive(Debug, Default)]
pub(super) struct Plan<'a>(Vec<Planned<'a>>);

impl<'a> Plan<'a> {
    /// Those of a network, and of what ends the run.
    pub(super) fn of(at: &Pointer, network: &'a Network, until: Option<&'a Until>) -> Self {
        let mut plan = Plan(Vec::new());
        for (i, support) in network.supports.iter().enumerate() {
            let own = format!("supports[{i}]");
            let at = at.key("supports").index(i);
            plan.add(
                Waits::Support(i),
                &at,
                (support.until, support.when.as_ref()),
                [own, "release".to_owned(), "release".to_owned()],
            );
        }
        for (i, rule) in network.springs.iter().enumerate() {
            let own = format!("springs[{i}]");
            let at = at.key("springs").index(i);
            let words = [own, "cut".to_owned(), after_cut(&rule.on)];
            plan.add(Waits::Springs(i), &at, (rule.cut.as_ref().and_then(CutRule::last), rule.when.as_ref()), words);
        }
        let at = at.key("aero");
        let wind = network.aero.as_ref().and_then(|aero| aero.wind.as_ref());
        for (i, (at, part)) in wind.map_or_else(Vec::new, |wind| wind::parts(&at.key("wind"), wind)).iter().enumerate()
        {
            let own = if let Some(Wind::Sum(_)) = wind { format!("wind.sum[{i}]") } else { "wind".to_owned() };
            plan.add(Waits::Wind(i), at, (None, part.when()), [own, "wind".to_owned(), "wind".to_owned()]);
        }
        let canopies = network.aero.as_ref().and_then(|aero| aero.canopy.as_ref());
        let at = at.key("canopy");
        for (i, canopy) in canopies.map_or(&[][..], OneOrSeveral::all).iter().enumerate() {
            let Some(stages) = &canopy.schedule else { continue };
            let (at, own) = match canopies {
                Some(OneOrSeveral::Several(_)) => (at.index(i), format!("canopy[{i}].schedule")),
                _ => (at.clone(), "canopy.schedule".to_owned()),
            };
            let at = at.key("schedule");
            for (j, stage) in stages.all().iter().enumerate() {
                let (at, own) = match stages {
                    OneOrSeveral::Several(_) => (at.index(j), format!("{own}[{j}]")),
                    OneOrSeveral::One(_) => (at.clone(), own.clone()),
                };
                let told = Some(stage.start).filter(|start| *start >= 0.0 && stage.when.is_none());
                let begins = if j == 0 { "opening".to_owned() } else { format!("disreef {j}") };
                let words = [own, format!("stage {}", j + 1), begins];
                plan.add(Waits::Stage(i, j), &at, (told, stage.when.as_ref()), words);
            }
        }
        if let Some(until) = until {
            let (moment, at) = (Moment::Ground(until), Pointer::root().key("time").key("until"));
            let [name, what] = ["ground", "landing"].map(str::to_owned);
            plan.0.push(Planned { waits: Waits::End, moment, at, name, what, stage: None });
        }
        plan
    }

    fn add(&mut self, waits: Waits, at: &Pointer, given: (Option<f64>, Option<&'a When>), words: [String; 3]) {
        let [own, what, begins] = words;
        let moment = match given {
            (_, Some(when)) => Moment::When(when),
            (Some(t), None) => Moment::Time(t),
            (None, None) => return,
        };
        let (at, name, stage) = match moment {
            Moment::When(When { name, .. }) => {
                (at.key("when"), name.clone().unwrap_or(own), Some(name.clone().unwrap_or(begins)))
            }
            Moment::Time(_) | Moment::Ground(_) => (at.clone(), own, None),
        };
        self.0.push(Planned { waits, moment, at, name, what, stage });
    }

    /// The event by a state, or after another one, that something waits for.
    pub(super) fn event(&self, waits: Waits) -> Option<usize> {
        self.0.iter().position(|one| one.waits == waits && !matches!(one.moment, Moment::Time(_)))
    }

    /// [s] Times of events that have a name or follow one whose time is known, and where they are in the case.
    pub(super) fn times(&self) -> impl Iterator<Item = (Pointer, Option<f64>)> {
        let time = |name: &str| {
            let other = self.0.iter().find(|one| one.name == name)?;
            match other.moment {
                Moment::Time(t) => Some(t),
                Moment::When(when) => when.time,
                Moment::Ground(_) => None,
            }
        };
        let of = |one: &Planned<'_>| match one.moment {
            Moment::When(when @ When { after: Some(other), .. }) => Some(time(other)? + when.delay.unwrap_or(0.0)),
            Moment::When(when) => when.time,
            Moment::Time(_) | Moment::Ground(_) => None,
        };
        self.0.iter().map(|one| (one.at.clone(), of(one))).collect::<Vec<_>>().into_iter()
    }

    /// Whether something waits for more than a time that is known, the end of the run left out.
    pub(super) fn waits(&self) -> bool {
        self.0.iter().any(|one| matches!(one.moment, Moment::When(_)))
    }

    /// Makes stages wait for their events.
    pub(super) fn put_into(&self, canopies: &mut [CanopySpec]) {
        for (i, canopy) in canopies.iter_mut().enumerate() {
            let CanopyAir::Filling(stages) = &mut canopy.air else { continue };
            for (j, stage) in stages.iter_mut().enumerate() {
                stage.event = self.event(Waits::Stage(i, j));
                stage.start = if stage.event.is_some() { f64::INFINITY } else { stage.start };
            }
        }
    }
}

/// What conditions look at.
#[derive(Clone, Copy)]
pub(super) struct Sights<'a> {
    pub geometry: &'a Geometry,
    /// [kg]
    pub mass: &'a [f64],
    /// whether each edge has a spring
    pub has_spring: &'a dyn Fn(u32) -> bool,
    /// whether there is air around the nodes
    pub air: bool,
}

/// Checks the events and resolves what they look at.
pub(super) fn events(plan: &Plan<'_>, sights: Sights<'_>, faults: &mut Faults<'_>) -> Vec<EventSpec> {
    let named = &plan.0;
    for (i, one) in named.iter().enumerate() {
        if named[..i].iter().any(|earlier| earlier.name == one.name) {
            let hint = "\"after\" must know which of them is meant".to_owned();
            let value = format!("a second event \"{}\"", one.name);
            faults.add_value(&one.at.key("name"), value, "another name for each event", Some(hint));
        }
    }
    let event = |one: &Planned<'_>| {
        let (trigger, of) = match one.moment {
            Moment::Time(t) => (Trigger::Told(t), None),
            Moment::Ground(Until { ground, of }) => (Trigger::When(Condition::HeightBelow(*ground)), of.as_ref()),
            Moment::When(when) => (trigger(one, when, plan, sights, faults)?, when.of.as_ref()),
        };
        let tension = matches!(trigger, Trigger::When(Condition::TensionAbove(_)));
        let of = if tension { springs(one, of, sights, faults)? } else { nodes(one, of, sights, faults)? };
        let (name, what, stage) = (one.name.clone(), one.what.clone(), one.stage.clone());
        Some(EventSpec { name, what, stage, trigger, of, ends_run: one.waits == Waits::End })
    };
    named.iter().filter_map(event).collect()
}

/// The keys of which one is given, with what it means.
fn conditions(when: &When) -> Vec<(&'static str, Option<Condition>)> {
    let When {
        name: _,
        of: _,
        time,
        height_below,
        height_above,
        speed_below,
        speed_above,
        dynamic_pressure_below,
        dynamic_pressure_above,
        tension_above,
        descending,
        after,
        delay: _,
    } = when;
    let of =
        |key, limit: &Option<f64>, condition: fn(f64) -> Condition| limit.map(|limit| (key, Some(condition(limit))));
    let given = [
        of("height_below", height_below, Condition::HeightBelow),
        of("height_above", height_above, Condition::HeightAbove),
        of("speed_below", speed_below, Condition::SpeedBelow),
        of("speed_above", speed_above, Condition::SpeedAbove),
        of("dynamic_pressure_below", dynamic_pressure_below, Condition::PressureBelow),
        of("dynamic_pressure_above", dynamic_pressure_above, Condition::PressureAbove),
        of("tension_above", tension_above, Condition::TensionAbove),
        descending.filter(|yes| *yes).map(|_| ("descending", Some(Condition::Descending))),
        time.map(|_| ("time", None)),
        after.as_ref().map(|_| ("after", None)),
    ];
    given.into_iter().flatten().collect()
}

fn trigger(
    one: &Planned<'_>,
    when: &When,
    plan: &Plan<'_>,
    sights: Sights<'_>,
    faults: &mut Faults<'_>,
) -> Option<Trigger> {
    let given = conditions(when);
    let [(_, condition)] = given[..] else {
        let keys: Vec<&str> = given.iter().map(|(key, _)| *key).collect();
        let value = match keys.as_slice() {
            [] => "an event without a condition".to_owned(),
            several => format!("an event with {}", several.join(" and ")),
        };
        let hint = "one event may follow another: \"after\"; for two conditions, the second thing waits for the first \
                    event"
            .to_owned();
        faults.add_value(
            &one.at,
            value,
            "exactly one of time, height_below, height_above, speed_below, speed_above, dynamic_pressure_below, \
             dynamic_pressure_above, tension_above, descending and after",
            Some(hint),
        );
        return None;
    };
    if when.delay.is_some() && when.after.is_none() {
        let hint = "give the event a name, and a second event \"after\" it".to_owned();
        faults.add_value(&one.at.key("delay"), "a delay without \"after\"", "only beside after", Some(hint));
        return None;
    }
    if matches!(condition, Some(Condition::PressureBelow(_) | Condition::PressureAbove(_))) && !sights.air {
        let hint = "without air around bodies and canopies there is no dynamic pressure; take a speed".to_owned();
        faults.add_value(&one.at, "a dynamic pressure without air", "aero with a canopy or drag", Some(hint));
        return None;
    }
    match (condition, when.time, &when.after) {
        (Some(condition), ..) => Some(Trigger::When(condition)),
        (None, Some(t), _) => Some(Trigger::At(t)),
        (None, None, Some(other)) => after(one, other, when.delay.unwrap_or(0.0), plan, faults),
        (None, None, None) => None,
    }
}

/// The trigger of an event that follows another one.
fn after(one: &Planned<'_>, other: &str, delay: f64, plan: &Plan<'_>, faults: &mut Faults<'_>) -> Option<Trigger> {
    let place = |name: &str| plan.0.iter().position(|of| of.name == name);
    let at = one.at.key("after");
    let Some(event) = place(other) else {
        let names: Vec<&str> = plan.0.iter().map(|of| of.name.as_str()).filter(|name| *name != one.name).collect();
        let hint = did_you_mean(other, names.iter().copied());
        faults.add_value(&at, format!("no event \"{other}\""), one_of("events here", &names), hint);
        return None;
    };
    // Whom it follows, up to one that follows none.
    let mut before = event;
    for _ in 0..plan.0.len() {
        let Moment::When(When { after: Some(name), .. }) = plan.0[before].moment else {
            return Some(match plan.0[event].moment {
                Moment::Time(t) => Trigger::At(t + delay),
                Moment::When(_) | Moment::Ground(_) => Trigger::After { event, delay },
            });
        };
        before = place(name)?;
    }
    faults.add_value(&at, format!("\"{other}\", which follows this one"), "an event that happens by itself", None);
    None
}

/// Nodes that an event looks at, with the share of each in the mass of all.
fn nodes(
    one: &Planned<'_>,
    of: Option<&NodeOrEdgeSelection>,
    Sights { geometry, mass, .. }: Sights<'_>,
    faults: &mut Faults<'_>,
) -> Option<Watched> {
    let at = one.at.key("of");
    let chosen = match of {
        Some(selection) => match selection.nodes() {
            Some(selection) => select::nodes(&at, &selection, geometry, faults)?,
            None => {
                faults.add(&at, "a selection of nodes");
                return None;
            }
        },
        None => match geometry.mesh.groups.get(PAYLOAD) {
            Some(group) => group.select_nodes(&geometry.mesh),
            None => (0..geometry.nodes() as u32).collect(),
        },
    };
    let of = |node: u32| mass.get(node as usize).copied().unwrap_or(0.0);
    let total: f64 = chosen.iter().map(|&node| of(node)).sum();
    let count = chosen.len() as f64;
    let share = |node: u32| if total > 0.0 { of(node) / total } else { 1.0 / count };
    Some(Watched::Nodes(chosen.iter().map(|&node| (node, share(node))).filter(|(_, share)| *share > 0.0).collect()))
}

/// Springs that an event looks at.
fn springs(
    one: &Planned<'_>,
    of: Option<&NodeOrEdgeSelection>,
    Sights { geometry, has_spring, .. }: Sights<'_>,
    faults: &mut Faults<'_>,
) -> Option<Watched> {
    let at = one.at.key("of");
    let Some(selection) = of.and_then(NodeOrEdgeSelection::edges) else {
        let hint = "name the group of the lines, e.g. \"of\": {\"group\": \"lines\"}";
        faults.add_hint(&at, "a selection of edges with springs", hint);
        return None;
    };
    let flags = select::edges(&at, &selection, geometry, faults)?;
    let chosen = (0_u32..).zip(flags).filter(|(edge, selected)| *selected && has_spring(*edge));
    let edges: Vec<u32> = chosen.map(|(edge, _)| edge).collect();
    if edges.is_empty() {
        faults.add_value(&at, "edges without springs", "edges with springs", None);
        return None;
    }
    Some(Watched::Springs { edges, group: None })
}
