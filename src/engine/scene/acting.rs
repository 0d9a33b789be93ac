//! What acts on the nodes of a network: forces, with what they share with the scene, and springs with their way back to
//! the user's edges.

use super::air_pressure::AirPressure;
use super::apparent::ApparentMass;
use super::network::{by_node, node_state};
use super::point_canopy::ShownCanopy;
use super::{Load, ScaledLoad};
use crate::force::law::damped_springs::axial_force;
use crate::force::law::gas::GasData;
use crate::force::law::series::{LoadFactor, SampledTable};
use crate::force::law::spring::{Coefficient, Cut, SpringData, SpringsAt};
use crate::force::law::stages::{EventTimes, Stages};
use crate::force::law::stream::Stream;
use crate::force::{Copies, ForceTerm};
use crate::model::state::StateRef;
use std::borrow::Cow;
use std::sync::Arc;

/// What acts on the nodes, with values that change in a run.
#[derive(Default)]
pub(super) struct Acting {
    pub terms: Vec<Box<dyn ForceTerm>>,
    /// what a program can scale
    pub loads: Vec<ScaledLoad>,
    /// load and wind tables, shared with the terms
    pub tables: Vec<Arc<dyn SampledTable>>,
    /// [s] beginnings and ends of changes of forces that are in no table
    pub changes: Vec<[f64; 2]>,
    pub springs: Vec<SpringBatch>,
    /// when events have happened, shared with the stages
    pub event_times: Arc<EventTimes>,
    /// stages of which some start with an event, shared with the terms
    pub stages: Vec<Stages>,
    /// the air around it, shared with the terms
    pub stream: Option<Arc<Stream>>,
    pub canopies: Vec<ShownCanopy>,
    /// pressures of the air, for pictures
    pub pressures: Vec<AirPressure>,
    /// air that canopies take along
    pub apparent: Vec<ApparentMass>,
    /// gases, by the place of their terms
    pub gases: Vec<(usize, GasData)>,
}

/// What a force brings to a scene.
pub(super) struct Added {
    pub term: Box<dyn ForceTerm>,
    /// what it depends on over time
    pub tables: Vec<Arc<dyn SampledTable>>,
    /// what a program can scale of it
    pub load: Option<ScaledLoad>,
    /// [s] beginnings and ends of its changes that are in no table
    pub changes: Vec<[f64; 2]>,
}

impl Added {
    /// A force that depends on nothing over time.
    pub(super) fn term(term: impl ForceTerm + 'static) -> Self {
        Added { term: Box::new(term), tables: Vec::new(), load: None, changes: Vec::new() }
    }

    /// A load that depends on time by a factor, which a program can scale.
    pub(super) fn load(term: impl ForceTerm + 'static, load: Load, LoadFactor { table, scale }: LoadFactor) -> Self {
        Added { load: Some(ScaledLoad { load, scale }), ..Added::term(term).by(table) }
    }

    /// The same force, which depends on tables.
    pub(super) fn by<T: SampledTable + 'static>(mut self, tables: impl IntoIterator<Item = Arc<T>>) -> Self {
        self.tables.extend(tables.into_iter().map(|table| table as Arc<dyn SampledTable>));
        self
    }
}

impl Acting {
    /// What acts by the air around the nodes, before there is a force.
    pub(super) fn around(stream: Option<Arc<Stream>>, events: usize) -> Self {
        let tables = stream.iter().map(|stream| stream.clone() as Arc<dyn SampledTable>).collect();
        Acting { stream, tables, event_times: Arc::new(EventTimes::new(events)), ..Acting::default() }
    }

    pub(super) fn add(&mut self, Added { term, tables, load, changes }: Added) {
        self.terms.push(term);
        self.tables.extend(tables);
        self.loads.extend(load);
        self.changes.extend(changes);
    }

    /// [s] Times at which a force has a corner or a jump.
    pub(super) fn corners(&self) -> impl Iterator<Item = f64> {
        self.tables.iter().flat_map(|table| table.corners()).chain(self.changes.iter().flatten().copied())
    }

    /// [s] Beginnings and ends of all changes of forces.
    pub(super) fn changing(&self) -> impl Iterator<Item = [f64; 2]> {
        self.tables.iter().flat_map(|table| table.changing()).chain(self.changes.iter().copied())
    }

    /// The same for another run.
    pub(super) fn for_run(&self, copies: &mut Copies) -> Self {
        Acting {
            terms: self.terms.iter().map(|term| term.for_run(copies)).collect(),
            loads: self.loads.iter().map(|found| ScaledLoad { scale: copies.of(&found.scale), ..*found }).collect(),
            tables: self.tables.iter().map(|table| table.clone().for_run(copies)).collect(),
            changes: self.changes.clone(),
            springs: self.springs.iter().map(|batch| batch.for_run(copies)).collect(),
            event_times: copies.of(&self.event_times),
            stages: self.stages.iter().map(|stages| stages.for_run(copies)).collect(),
            stream: self.stream.as_ref().map(|stream| copies.of(stream)),
            canopies: self.canopies.iter().map(|canopy| canopy.for_run(copies)).collect(),
            pressures: self.pressures.iter().map(|pressure| pressure.for_run(copies)).collect(),
            apparent: self.apparent.iter().map(|canopy| canopy.for_run(copies)).collect(),
            gases: self.gases.iter().map(|(term, gas)| (*term, gas.copy(copies))).collect(),
        }
    }
}

/// When a spring breaks.
#[derive(Clone, Copy, Debug)]
pub(super) struct Break {
    /// the number of its event
    pub event: usize,
    /// [N] its strength
    pub tension: f64,
}

/// Springs of one rule, as the terms hold them, with their way back to the user's edges.
#[derive(Clone, Debug)]
pub(super) struct SpringBatch {
    /// place of their group in the specification, groups without edges left out
    pub group: u32,
    /// [s] when they are cut, if that is known from the start
    pub cut_at: Option<f64>,
    /// the event at which they are cut, if there is one
    pub cut_by: Option<usize>,
    /// when each of them breaks; empty where none can
    pub breaks: Arc<[Break]>,
    /// arrays shared with the terms
    pub data: SpringData,
    /// [m] rest lengths as given; those in `data` are a program's factors times these
    pub given: Arc<[f64]>,
    /// user's edge of every spring
    pub edges: Arc<[u32]>,
    /// [N s/m] dashpot coefficients, 0 without
    pub dashpot: Coefficient,
    /// whether the dashpots act along the springs
    pub axial: bool,
    /// whether the dashpots are relative with c = k h, which Kang's filter contains
    pub in_filter: bool,
    /// which of them carry nothing, shared with the terms
    pub cut: Cut,
}

impl SpringBatch {
    /// The same springs in another run.
    fn for_run(&self, copies: &mut Copies) -> Self {
        SpringBatch { data: self.data.for_run(copies), cut: self.cut.for_run(copies), ..self.clone() }
    }

    /// [N] Tension of a spring with its dashpot; 0 where it is cut or has broken.
    pub(super) fn tension(&self, at: StateRef<'_>, i: usize) -> f64 {
        if self.cut.is_cut(i) { 0.0 } else { self.tension_of_whole(self.data.at(at.t, by_node(at.x)), at, i) }
    }

    /// [N] How far the next of its springs is from breaking; infinite where none can.
    pub(super) fn break_margin(&self, at: StateRef<'_>) -> f64 {
        let springs = self.data.at(at.t, by_node(at.x));
        let whole = self.breaks.iter().enumerate().filter(|(i, _)| !self.cut.is_cut(*i));
        let margins = whole.map(|(i, limit)| limit.tension - self.tension_of_whole(springs, at, i));
        margins.fold(f64::INFINITY, f64::min)
    }

    fn tension_of_whole(&self, springs: SpringsAt<'_>, at: StateRef<'_>, i: usize) -> f64 {
        let elastic = self.data.tension(springs, i);
        if self.axial { elastic + axial_force(&self.data, node_state(at), i, self.dashpot.at(i)) } else { elastic }
    }

    /// What is left of it where some have broken.
    pub(super) fn left(&self) -> Cow<'_, SpringBatch> {
        if !self.cut.some_broken() {
            return Cow::Borrowed(self);
        }
        let whole: Vec<usize> = (0..self.edges.len()).filter(|&i| !self.cut.is_cut(i)).collect();
        Cow::Owned(self.part(&whole, |node| node))
    }

    /// Some of its springs, which break no more, between nodes with other numbers.
    pub(super) fn part(&self, kept: &[usize], place: impl Fn(u32) -> u32) -> SpringBatch {
        let pick = |values: &Coefficient| -> Coefficient {
            Coefficient::from_values(&kept.iter().map(|&i| values.at(i)).collect::<Vec<_>>())
        };
        let lengths = |values: &[f64]| kept.iter().map(|&i| values[i]).collect();
        SpringBatch {
            data: SpringData {
                nodes: kept.iter().map(|&i| self.data.nodes[i].map(&place)).collect(),
                rest_length: lengths(&self.data.rest_length),
                stiffness: pick(&self.data.stiffness),
                ..self.data.clone()
            },
            given: lengths(&self.given),
            edges: kept.iter().map(|&i| self.edges[i]).collect(),
            dashpot: pick(&self.dashpot),
            breaks: Arc::default(),
            cut: self.cut.of_all(),
            ..self.clone()
        }
    }
}
