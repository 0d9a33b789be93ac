//! From a plain specification to force terms in internal numbering.

use super::Load;
use super::acting::{Acting, Added, Break, SpringBatch};
use super::air_pressure::{AirLaw, AirPressure};
use super::apparent::{ApparentMass, Volume};
use super::build_bending::AtRest;
use super::build_rings::{Shapes, rings};
use super::build_surface::MembraneBatch;
use super::canopy_shape::{CanopyLaw, CanopyShape};
use super::check::{check, check_bars};
use super::check_values::BuildError;
use super::events::Phases;
use super::network::{Built, Network};
use super::numbering::Numbering;
use super::point_canopy::ShownCanopy;
use super::reach::reach;
use super::triggers::{self, Triggers};
use crate::force::kernel::element_block::NodeVectors;
use crate::force::law::air::{Air, AirData};
use crate::force::law::axial_flow::CanopyAxis;
use crate::force::law::bar_law::{BarData, Bars, LawBars};
use crate::force::law::base_acceleration::BaseAcceleration;
use crate::force::law::canopy::{AirModel, Canopy, CanopyData};
use crate::force::law::cavity::Cavity;
use crate::force::law::damped_springs::{DampedSprings, Dashpots};
use crate::force::law::enclosure::Enclosure;
use crate::force::law::follower_pressure::{FollowerData, FollowerPressure};
use crate::force::law::gravity::Gravity;
use crate::force::law::inflow::InflowLoss;
use crate::force::law::nodal::{DeadPressure, FORCES, NodalForces, PlanLoad};
use crate::force::law::rayleigh::{RayleighData, RayleighMass, RayleighStiffness};
use crate::force::law::rings::RingedCanopy;
use crate::force::law::series::{LoadFactor, Table, scalar};
use crate::force::law::spring::{Coefficient, Cut, SpringData};
use crate::force::law::stages::Stages;
use crate::force::law::stream::Stream;
use crate::force::law::surface_pressure::{SurfacePressure, SurfacePressureData};
use crate::force::law::triangle::AreaVector;
use crate::force::schedule::threads::Threads;
use crate::mesh::tuples::in_order;
use crate::mesh::unit_vector::unit_vector;
use crate::model::spec::{
    CanopyAir, DashpotKind, FillingSpec, NetworkSpec, PressureKind, Series, SpringGroup, StreamSpec, ascending,
    support_velocity,
};
use crate::startup::{Phase, timed};
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Builds a network; the mesh is kept for pictures.
///
/// # Errors
/// A specification that contradicts itself.
pub fn build_network(spec: NetworkSpec, threads: Threads) -> Result<Network, BuildError> {
    build_network_with(spec, &[], threads)
}

/// The same with bars of a program's own laws. Kang's filter and tensions by edge know only the springs.
///
/// # Errors
/// As [`build_network`], and bars of nodes that do not exist or of rest lengths that are not finite.
pub fn build_network_with(spec: NetworkSpec, bars: &[Bars], threads: Threads) -> Result<Network, BuildError> {
    check(&spec)?;
    bars.iter().try_for_each(|bars| check_bars(bars, spec.mesh.nodes.len()))?;
    let triangle_edges = |t: &[u32; 3]| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
    let links = spec.mesh.edges.iter().chain(bars.iter().flat_map(|bars| &bars.pairs)).copied();
    let links = links.chain(spec.mesh.triangles.iter().flat_map(triangle_edges));
    let number = || Numbering::reverse_cuthill_mckee(spec.mesh.nodes.len(), links.clone());
    let (numbering, reach) = timed(Phase::Numbering, || threads.workers().join(number, || reach(&spec)));
    let at = |i: usize| numbering.user[i] as usize;
    let n = spec.mesh.nodes.len();
    let reference: Vec<Vector3<f64>> = (0..n).map(|i| Vector3::from(spec.mesh.nodes[at(i)])).collect();
    let displaced = |i: usize| spec.displacement.get(at(i)).map_or(Vector3::zeros(), |&u| Vector3::from(u));
    let start: Arc<[Vector3<f64>]> = (0..n).map(|i| reference[i] + displaced(i)).collect();
    let always = spec.always_fixed();
    let fixed: Vec<[bool; 3]> = (0..n).map(|i| always[at(i)]).collect();
    let mass: Arc<[f64]> = (0..n).map(|i| spec.mass[at(i)]).collect();
    let of_wind = || Some(StreamSpec::of_wind(spec.air.as_ref()?.wind.clone()));
    let stream = spec.stream.clone().or_else(of_wind).map(|stream| Arc::new(Stream::new(stream)));
    let acting = Acting::around(stream, triggers::count(&spec));
    let mut builder = Builder { spec: &spec, numbering: &numbering, acting, membranes: Vec::new() };
    builder.springs_and_dashpots();
    bars.iter().for_each(|bars| builder.bars(bars));
    builder.membranes()?;
    builder.bending(AtRest { x: &reference, fixed: &fixed })?;
    builder.gravity(&mass, &start);
    builder.base(&fixed, &mass);
    builder.air();
    builder.surface_pressures();
    builder.canopies(&start, &reference)?;
    builder.drag();
    builder.loads(&start);
    builder.gases(&start)?;
    builder.rayleigh(&mass, &reference);
    let velocity = initial_velocity(&spec);
    let velocity = if velocity.is_empty() { Vec::new() } else { (0..n).map(|i| velocity[at(i)]).collect() };
    let may_touch = builder.contacts(super::build_contact::Nodes {
        reference: &reference,
        start: &start,
        mass: &mass,
        fixed: &fixed,
        velocity: &velocity,
    });
    let scaled = builder.scale_masses([&reference, &start], &velocity, &fixed, &mass)?;
    let added_mass = scaled.as_ref().map(|scaled| scaled.added);
    let inertia = scaled.map_or_else(|| mass.clone(), |scaled| scaled.inertia.into());
    let Builder { acting, membranes, .. } = builder;
    let phases = Phases::new(&spec, &inertia, &numbering, &acting.springs);
    let triggers = Triggers::new(&spec, &numbering, &acting.springs);
    let built = Built {
        triggers,
        corners: ascending(acting.corners().chain(phases.times().iter().copied()).collect()),
        changing: acting.changing().chain(phases.changing(&spec.motions)).collect(),
        phases,
        numbering,
        weighed: mass,
        mass: inertia,
        added_mass,
        start,
        velocity,
        gravity: spec.gravity.map_or(Vector3::zeros(), Vector3::from),
        membranes,
        reach,
        ..Built::default()
    };
    Ok(Network::new(built, acting, may_touch, spec.mesh, threads))
}

/// Which rim of a canopy is its mouth, which must be open at the start.
fn mouth(enclosure: &Enclosure, skirt: &[u32], x: NodeVectors<'_>) -> Result<usize, BuildError> {
    let of_skirt = |rim: &usize| enclosure.rims()[*rim].iter().any(|node| skirt.contains(node));
    let rims: Vec<usize> = (0..enclosure.rims().len()).filter(of_skirt).collect();
    let [mouth] = rims[..] else { return Err(BuildError::Mouth { loops: rims.len() }) };
    if enclosure.opening(mouth, x) == Vector3::zeros() {
        return Err(BuildError::ClosedMouth);
    }
    Ok(mouth)
}

/// [m/s] Velocity of every node at t = 0, `[n_nodes][3]`; empty if all stand still.
fn initial_velocity(spec: &NetworkSpec) -> Vec<[f64; 3]> {
    let mut velocity = spec.velocity.clone();
    if !spec.motions.is_empty() {
        velocity.resize(spec.mesh.nodes.len(), [0.0; 3]);
    }
    // What is held stands still: its velocity is 0, and here it loses a sign that steps of different kinds would treat
    // differently.
    for (velocity, fixed) in velocity.iter_mut().zip(&spec.fixed) {
        velocity.iter_mut().zip(fixed).filter(|(_, held)| **held).for_each(|(v, _)| *v = 0.0);
    }
    let of_supports = support_velocity(&spec.motions, velocity.len());
    for (v, of_support) in velocity.as_flattened_mut().iter_mut().zip(of_supports.as_flattened()) {
        *v += of_support;
    }
    velocity
}

/// [s] Beginnings and ends of stages whose start is known.
pub(super) fn filling_times(stages: &[FillingSpec]) -> Vec<[f64; 2]> {
    let known = stages.iter().filter(|stage| stage.event.is_none());
    known.map(|stage| [stage.start, stage.start + stage.duration]).collect()
}

pub(super) struct Builder<'a> {
    pub(super) spec: &'a NetworkSpec,
    pub(super) numbering: &'a Numbering,
    pub(super) acting: Acting,
    pub(super) membranes: Vec<MembraneBatch>,
}

impl Builder<'_> {
    pub(super) fn node(&self, user: u32) -> u32 {
        self.numbering.internal[user as usize]
    }

    pub(super) fn triangles(&self, ids: impl Iterator<Item = u32>) -> Arc<[[u32; 3]]> {
        let mut list: Vec<[u32; 3]> = ids.map(|t| self.spec.mesh.triangles[t as usize].map(|i| self.node(i))).collect();
        list.sort_unstable_by_key(|t| (t[0].min(t[1]).min(t[2]), *t));
        list.into()
    }

    fn springs_and_dashpots(&mut self) {
        let groups = self.spec.springs.iter().filter(|group| !group.edges.is_empty());
        // Events of springs that break follow those of the specification.
        let mut next_event = self.spec.events.len();
        for (group, number) in groups.zip(0_u32..) {
            let mut batch = self.spring_batch(group, number, next_event);
            next_event += group.breaks.len();
            batch.data.rest_scale = group.rest_scale.as_ref().map(scalar);
            self.springs_of(group, batch);
        }
    }

    /// Adds springs of a group as a term.
    fn springs_of(&mut self, group: &SpringGroup, batch: SpringBatch) {
        let coefficient = batch.dashpot.clone();
        let dashpots = group.dashpot.as_ref().map(|dashpot| Dashpots { kind: dashpot.kind, coefficient });
        let springs = DampedSprings::new(batch.data.clone(), dashpots).cut_with(batch.cut.clone());
        self.acting.add(Added::term(springs).by(batch.data.rest_scale.clone()));
        self.acting.springs.push(batch);
    }

    fn bars(&mut self, bars: &Bars) {
        let ends = |pair: &[u32; 2]| pair.map(|node| self.node(node));
        let mut order: Vec<([u32; 2], f64)> =
            bars.pairs.iter().map(ends).zip(bars.rest_length.iter().copied()).collect();
        order.sort_by_key(|([a, b], _)| (*a.min(b), *a.max(b)));
        let (nodes, rest_length) = order.into_iter().unzip();
        self.acting.add(Added::term(LawBars::new(BarData { nodes, rest_length, law: bars.law.clone() })));
    }

    /// Springs of the group with this number; where they break, the events of their breaks follow each other from
    /// `first_event` on.
    fn spring_batch(&self, group: &SpringGroup, number: u32, first_event: usize) -> SpringBatch {
        let nodes = |i: usize| self.spec.mesh.edges[group.edges[i] as usize].map(|n| self.node(n));
        let ends: Vec<[u32; 2]> = (0..group.edges.len()).map(nodes).map(|[a, b]| [a.min(b), a.max(b)]).collect();
        let mut order = Vec::with_capacity(ends.len());
        in_order(ends.iter().copied(), |_, place| order.push(place as usize));
        let data = SpringData {
            nodes: order.iter().map(|&i| nodes(i)).collect(),
            rest_length: order.iter().map(|&i| group.rest_length[i]).collect(),
            stiffness: Coefficient::of_springs(&group.stiffness, &order),
            curve: (&group.law).into(),
            slack: group.slack,
            rest_scale: None,
        };
        let (dashpot, in_filter) = match &group.dashpot {
            None => (Coefficient::Uniform(0.0), false),
            Some(d) => {
                let in_filter = d.from_step && d.kind == DashpotKind::Relative;
                (Coefficient::of_springs(&d.coefficient, &order), in_filter)
            }
        };
        let axial = group.dashpot.as_ref().is_some_and(|d| d.kind == DashpotKind::Axial);
        let given = data.rest_length.clone();
        let edges = order.iter().map(|&i| group.edges[i]).collect();
        let limit = |&i: &usize| Some(Break { event: first_event + i, tension: *group.breaks.get(i)? });
        let breaks: Arc<[Break]> = order.iter().filter_map(limit).collect();
        let cut = Cut::of_breaking(breaks.len());
        let (group, cut_at, cut_by) = (number, group.cut, group.cut_by);
        SpringBatch { group, cut_at, cut_by, breaks, data, given, edges, dashpot, axial, in_filter, cut }
    }

    fn gravity(&mut self, mass: &[f64], start: &Arc<[Vector3<f64>]>) {
        let Some(g) = self.spec.gravity else { return };
        let factor = LoadFactor::default();
        let gravity = Gravity::new(Vector3::from(g), factor.scale.clone(), mass.iter().copied(), start.clone());
        self.acting.add(Added::load(gravity, Load::Gravity, factor));
    }

    pub(super) fn base(&mut self, fixed: &[[bool; 3]], mass: &[f64]) {
        let Some(table) = &self.spec.base_acceleration else { return };
        let mass = mass.iter().zip(fixed).map(|(&m, f)| if *f == [true; 3] { 0.0 } else { m });
        let acceleration = Arc::new(Table::new(table.clone()));
        self.acting.add(Added::term(BaseAcceleration::new(acceleration.clone(), mass)).by([acceleration]));
    }

    fn air(&mut self) {
        let Some(air) = &self.spec.air else { return };
        let triangles = self.triangles(0..self.spec.mesh.triangles.len() as u32);
        let Some(stream) = self.acting.stream.clone() else { return };
        let data = AirData { triangles, linear: air.linear, quadratic: air.quadratic, stream };
        self.show_pressure(AirLaw::Cloth(data.clone()));
        self.acting.add(Added::term(Air::new(data)));
    }

    fn surface_pressures(&mut self) {
        let Some(stream) = self.acting.stream.clone() else { return };
        for zone in &self.spec.surface_pressures {
            let triangles = self.triangles(zone.triangles.iter().copied());
            let coefficient = Arc::new(zone.coefficient.rows());
            let data = SurfacePressureData { triangles, coefficient, stream: stream.clone() };
            self.show_pressure(AirLaw::Surface(data.clone()));
            self.acting.add(Added::term(SurfacePressure::new(data)));
        }
    }

    pub(super) fn show_pressure(&mut self, law: AirLaw) {
        self.acting.pressures.push(AirPressure::new(law, &self.spec.mesh, &self.numbering.internal));
    }

    fn canopies(&mut self, start: &[Vector3<f64>], reference: &[Vector3<f64>]) -> Result<(), BuildError> {
        let Some(stream) = self.acting.stream.clone() else { return Ok(()) };
        for canopy in &self.spec.canopies {
            if let CanopyAir::Point(stages) = &canopy.air {
                self.point_canopy(canopy, stages, &stream);
                continue;
            }
            let numbering = self.numbering;
            let nodes = |list: &[u32]| list.iter().map(|&i| numbering.internal[i as usize]).collect::<Vec<u32>>();
            let (skirt, apex, confluence) = (nodes(&canopy.skirt), nodes(&canopy.apex), nodes(&canopy.confluence));
            let corners = |t: u32| self.spec.mesh.triangles[t as usize].map(|i| self.node(i));
            let mut list: Vec<([u32; 3], f64)> =
                canopy.triangles.iter().map(|&t| corners(t)).zip(canopy.pressure_coefficient.iter().copied()).collect();
            let x = NodeVectors::Nodes(start);
            let axis = x.mean(&confluence) - x.mean(&apex);
            let inwards: f64 = list.iter().map(|(nodes, _)| AreaVector::new(start, *nodes).s.dot(&axis)).sum();
            if inwards > 0.0 {
                list.iter_mut().for_each(|([_, b, c], _)| std::mem::swap(b, c));
            }
            list.sort_unstable_by_key(|(t, _)| (t[0].min(t[1]).min(t[2]), *t));
            let (triangles, pressure_coefficient): (Vec<_>, Vec<_>) = list.into_iter().unzip();
            let triangles: Arc<[[u32; 3]]> = triangles.into();
            let pressure_coefficient = pressure_coefficient.into();
            let enclosure = Arc::new(Enclosure::new(triangles.clone()));
            if let Some(factor) = canopy.apparent_mass {
                let mut nodes = BTreeMap::new();
                for corners in triangles.iter() {
                    let area = AreaVector::new(reference, *corners).s.norm() / 3.0;
                    corners.iter().for_each(|&node| *nodes.entry(node).or_insert(0.0) += area);
                }
                let area: f64 = nodes.values().sum();
                let nodes = nodes.into_iter().map(|(node, share)| (node, share / area)).collect();
                let (volume, stream, term) =
                    (Volume::Cloth(enclosure.clone()), stream.clone(), self.acting.terms.len());
                self.acting.apparent.push(ApparentMass { nodes, volume, factor, stream, term });
            }
            // The skirt's own speed swings while a canopy fills by a balance of its air. With `table` and `schedule`
            // lines may be slack, as in a cluster that is released, and confluence and canopy go their own ways.
            let fills = matches!(canopy.air, CanopyAir::Cavity(_) | CanopyAir::Rings(_));
            let carrier = if fills { confluence.clone() } else { skirt.clone() };
            let axis = CanopyAxis { carrier, skirt, apex, confluence, stream: stream.clone() };
            let air = match &canopy.air {
                CanopyAir::Coefficient => AirModel::Coefficient,
                CanopyAir::Filling(stages) | CanopyAir::Point(stages) => AirModel::Filling(self.stages(stages)),
                CanopyAir::Cavity(spec) => {
                    let mouth = mouth(&enclosure, &axis.skirt, x)?;
                    AirModel::Cavity(Cavity { enclosure: enclosure.clone(), mouth, spec: *spec })
                }
                CanopyAir::Rings(spec) => {
                    let rows: Vec<Vec<u32>> = spec.rows.iter().map(|row| nodes(row)).collect();
                    let data =
                        rings(spec, &rows, triangles, axis, Shapes { start, cut: reference }, canopy.nominal_area)?;
                    self.show_pressure(AirLaw::Rings(data.clone()));
                    let law = CanopyLaw::Rings(data.clone());
                    self.show_canopy(CanopyShape::new(law, enclosure, canopy.nominal_area));
                    self.acting.add(Added::term(RingedCanopy::new(data)));
                    continue;
                }
            };
            let loss = |coefficient| -> Result<_, BuildError> {
                Ok(InflowLoss { enclosure: enclosure.clone(), mouth: mouth(&enclosure, &axis.skirt, x)?, coefficient })
            };
            let inflow = canopy.inflow_loss.map(loss).transpose()?;
            let data = CanopyData { triangles, pressure_coefficient, axis, air, inflow };
            let law = CanopyLaw::Canopy(data.clone());
            self.show_canopy(CanopyShape::new(law, enclosure, canopy.nominal_area));
            self.show_pressure(AirLaw::Canopy(data.clone()));
            let changes = filling_times(canopy.air.stages());
            self.acting.add(Added { changes, ..Added::term(Canopy::new(data)) });
        }
        Ok(())
    }

    /// Stages of a canopy, with the events at which some start.
    pub(super) fn stages(&mut self, given: &[FillingSpec]) -> Stages {
        let stages = Stages::new(given, self.acting.event_times.clone());
        if given.iter().any(|stage| stage.event.is_some()) {
            self.acting.stages.push(stages.clone());
        }
        stages
    }

    fn show_canopy(&mut self, shape: CanopyShape) {
        self.acting.canopies.push(ShownCanopy::Cloth(Box::new(shape)));
    }

    fn loads(&mut self, start: &[Vector3<f64>]) {
        let factor_of =
            |series: &Option<Series<f64>>| LoadFactor { table: series.as_ref().map(scalar), ..LoadFactor::default() };
        for (number, load) in self.spec.pressures.iter().enumerate() {
            let triangles = self.triangles(load.triangles.iter().copied());
            let (number, pressure, own) = (Load::Pressure(number), load.pressure, factor_of(&load.factor));
            let factor = own.clone();
            self.acting.add(match load.kind {
                PressureKind::Follower => {
                    Added::load(FollowerPressure::new(FollowerData { triangles, pressure, factor }), number, own)
                }
                PressureKind::Plan(direction) => {
                    let direction = Vector3::from(direction);
                    let plan = PlanLoad { triangles: &triangles, load: pressure, direction, factor };
                    Added::load(plan.lump(start), number, own)
                }
                PressureKind::Dead(direction) => {
                    let direction = direction.map(Vector3::from);
                    let dead = DeadPressure { triangles: &triangles, pressure, direction, factor };
                    Added::load(dead.lump(start), number, own)
                }
            });
        }
        for (number, load) in self.spec.forces.iter().enumerate() {
            let mut nodes: Vec<u32> = load.nodes.iter().map(|&i| self.node(i)).collect();
            nodes.sort_unstable();
            let force = nodes.iter().map(|_| Vector3::from(load.force)).collect();
            let factor = factor_of(&load.factor);
            let forces = NodalForces { info: FORCES, nodes: nodes.into(), force, factor: factor.clone() };
            self.acting.add(Added::load(forces, Load::Forces(number), factor));
        }
    }

    fn rayleigh(&mut self, mass: &Arc<[f64]>, reference: &[Vector3<f64>]) {
        let Some(rayleigh) = self.spec.rayleigh else { return };
        if rayleigh.mass != 0.0 {
            self.acting.add(Added::term(RayleighMass { factor: rayleigh.mass, mass: mass.clone() }));
        }
        if rayleigh.stiffness == 0.0 {
            return;
        }
        self.rayleigh_membranes(rayleigh.stiffness, reference);
        for batch in self.acting.springs.clone() {
            let data = &batch.data;
            let coefficient: Vec<f64> =
                (0..data.nodes.len()).map(|i| rayleigh.stiffness * data.stiffness.at(i)).collect();
            let direction = data
                .nodes
                .iter()
                .map(|&[a, b]| unit_vector(reference[b as usize] - reference[a as usize]).unwrap_or_default());
            self.acting.add(Added::term(RayleighStiffness::new(RayleighData {
                nodes: data.nodes.clone(),
                coefficient: Coefficient::from_values(&coefficient),
                direction: direction.collect(),
                cut: batch.cut.clone(),
            })));
        }
    }
}
