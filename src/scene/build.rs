//! From a plain specification to force terms in internal numbering.

use super::Load;
use super::check::{BuildError, check, check_bars};
use super::network::{Network, SpringBatch};
use super::numbering::Numbering;
use crate::force::ForceTerm;
use crate::force::law::air::{Air, AirData};
use crate::force::law::bar_law::{BarData, Bars, LawBars};
use crate::force::law::damped_springs::{DampedSprings, Dashpots};
use crate::force::law::follower_pressure::{FollowerData, FollowerPressure};
use crate::force::law::gravity::Gravity;
use crate::force::law::nodal::{DeadPressure, FORCES, NodalForces};
use crate::force::law::rayleigh::{RayleighData, RayleighMass, RayleighStiffness};
use crate::force::law::series::{LoadFactor, SampledTable, Scale, Table, scalar};
use crate::force::law::spring::{Coefficient, SpringData};
use crate::force::schedule::threads::Threads;
use crate::model::spec::{DashpotKind, NetworkSpec, PressureKind, Series, SpringGroup};
use crate::model::unit_vector::unit_vector;
use crate::startup::{Phase, timed};
use nalgebra::Vector3;
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
    let numbering = timed(Phase::Numbering, || Numbering::reverse_cuthill_mckee(spec.mesh.nodes.len(), links));
    let at = |i: usize| numbering.user[i] as usize;
    let n = spec.mesh.nodes.len();
    let reference: Vec<Vector3<f64>> = (0..n).map(|i| Vector3::from(spec.mesh.nodes[at(i)])).collect();
    let displaced = |i: usize| spec.displacement.get(at(i)).map_or(Vector3::zeros(), |&u| Vector3::from(u));
    let start: Arc<[Vector3<f64>]> = (0..n).map(|i| reference[i] + displaced(i)).collect();
    let fixed: Vec<[bool; 3]> = (0..n).map(|i| spec.fixed[at(i)]).collect();
    let mass: Arc<[f64]> = (0..n).map(|i| spec.mass[at(i)]).collect();
    let mut builder = Builder {
        spec: &spec,
        numbering: &numbering,
        terms: Vec::new(),
        springs: Vec::new(),
        loads: Vec::new(),
        tables: Vec::new(),
        wind: None,
    };
    builder.springs_and_dashpots();
    bars.iter().for_each(|bars| builder.bars(bars));
    builder.gravity(&fixed, &mass, &start);
    builder.air();
    builder.loads(&start);
    builder.rayleigh(&mass, &reference);
    let Builder { terms, springs, loads, tables, wind: wind_table, .. } = builder;
    // What is held stands still: its velocity is 0, and here it loses a sign that steps of different kinds would treat
    // differently.
    let velocity_of = |node: usize| -> [f64; 3] {
        std::array::from_fn(|i| if spec.fixed[node][i] { 0.0 } else { spec.velocity[node][i] })
    };
    let velocity = if spec.velocity.is_empty() { Vec::new() } else { (0..n).map(|i| velocity_of(at(i))).collect() };
    let gravity = spec.gravity.map_or(Vector3::zeros(), Vector3::from);
    let wind = spec.air.iter().flat_map(|air| &air.wind.t);
    let factors = spec.pressures.iter().map(|p| &p.factor).chain(spec.forces.iter().map(|f| &f.factor));
    let mut corners: Vec<f64> = wind.chain(factors.flatten().flat_map(|s| &s.t)).copied().collect();
    corners.sort_by(f64::total_cmp);
    corners.dedup();
    Ok(Network::assemble_parts(super::network::Parts {
        numbering,
        fixed,
        mass,
        start,
        velocity,
        gravity,
        loads,
        corners,
        tables,
        wind: wind_table,
        terms,
        springs,
        threads,
        mesh: spec.mesh,
    }))
}

struct Builder<'a> {
    spec: &'a NetworkSpec,
    numbering: &'a Numbering,
    terms: Vec<Box<dyn ForceTerm>>,
    springs: Vec<SpringBatch>,
    loads: Vec<(Load, Arc<Scale>)>,
    tables: Vec<Arc<dyn SampledTable>>,
    wind: Option<Arc<Table<3>>>,
}

impl Builder<'_> {
    fn node(&self, user: u32) -> u32 {
        self.numbering.internal[user as usize]
    }

    fn triangles(&self, ids: impl Iterator<Item = u32>) -> Arc<[[u32; 3]]> {
        let mut list: Vec<[u32; 3]> = ids.map(|t| self.spec.mesh.triangles[t as usize].map(|i| self.node(i))).collect();
        list.sort_unstable_by_key(|t| (t[0].min(t[1]).min(t[2]), *t));
        list.into()
    }

    fn springs_and_dashpots(&mut self) {
        for group in self.spec.springs.iter().filter(|g| !g.edges.is_empty()) {
            let batch = self.spring_batch(group);
            let coefficient = batch.dashpot.clone();
            let dashpots = group.dashpot.as_ref().map(|dashpot| Dashpots { kind: dashpot.kind, coefficient });
            self.terms.push(Box::new(DampedSprings::new(batch.data.clone(), dashpots)));
            self.springs.push(batch);
        }
    }

    fn bars(&mut self, bars: &Bars) {
        let ends = |pair: &[u32; 2]| pair.map(|node| self.node(node));
        let mut order: Vec<([u32; 2], f64)> =
            bars.pairs.iter().map(ends).zip(bars.rest_length.iter().copied()).collect();
        order.sort_by_key(|([a, b], _)| (*a.min(b), *a.max(b)));
        let (nodes, rest_length) = order.into_iter().unzip();
        self.terms.push(Box::new(LawBars::new(BarData { nodes, rest_length, law: bars.law.clone() })));
    }

    fn spring_batch(&self, group: &SpringGroup) -> SpringBatch {
        let nodes = |i: usize| self.spec.mesh.edges[group.edges[i] as usize].map(|n| self.node(n));
        let mut order: Vec<usize> = (0..group.edges.len()).collect();
        order.sort_unstable_by_key(|&i| {
            let [a, b] = nodes(i);
            (a.min(b), a.max(b), i)
        });
        let pick = |values: &[f64]| -> Vec<f64> { order.iter().map(|&i| values[i]).collect() };
        let data = SpringData {
            nodes: order.iter().map(|&i| nodes(i)).collect(),
            rest_length: pick(&group.rest_length).into(),
            stiffness: Coefficient::from_values(&pick(&group.stiffness)),
            slack: group.slack,
        };
        let (dashpot, in_filter) = match &group.dashpot {
            None => (Coefficient::Uniform(0.0), false),
            Some(d) => {
                let in_filter = d.from_step && d.kind == DashpotKind::Relative;
                (Coefficient::from_values(&pick(&d.coefficient)), in_filter)
            }
        };
        let axial = group.dashpot.as_ref().is_some_and(|d| d.kind == DashpotKind::Axial);
        let given = data.rest_length.clone();
        SpringBatch { data, given, edges: order.iter().map(|&i| group.edges[i]).collect(), dashpot, axial, in_filter }
    }

    fn gravity(&mut self, fixed: &[[bool; 3]], mass: &[f64], start: &Arc<[Vector3<f64>]>) {
        let Some(g) = self.spec.gravity else { return };
        let mass = mass.iter().zip(fixed).map(|(&m, f)| if *f == [true; 3] { 0.0 } else { m });
        let scale = self.scale(Load::Gravity);
        self.terms.push(Box::new(Gravity::new((Vector3::from(g), scale), mass, start.clone())));
    }

    fn air(&mut self) {
        let Some(air) = &self.spec.air else { return };
        let triangles = self.triangles(0..self.spec.mesh.triangles.len() as u32);
        let wind = Table::new(air.wind.clone());
        self.tables.push(wind.clone());
        self.wind = Some(wind.clone());
        let data = AirData { triangles, linear: air.linear, quadratic: air.quadratic, wind };
        self.terms.push(Box::new(Air::new(data)));
    }

    fn scale(&mut self, load: Load) -> Arc<Scale> {
        let scale = Arc::new(Scale::default());
        self.loads.push((load, scale.clone()));
        scale
    }

    fn factor(&mut self, load: Load, series: Option<&Series<f64>>) -> LoadFactor {
        let table = series.map(scalar);
        self.tables.extend(table.iter().map(|table| table.clone() as Arc<dyn SampledTable>));
        LoadFactor { table, scale: self.scale(load) }
    }

    fn loads(&mut self, start: &[Vector3<f64>]) {
        for (number, load) in self.spec.pressures.iter().enumerate() {
            let triangles = self.triangles(load.triangles.iter().copied());
            let (pressure, factor) = (load.pressure, self.factor(Load::Pressure(number), load.factor.as_ref()));
            self.terms.push(match load.kind {
                PressureKind::Follower => Box::new(FollowerPressure::new(FollowerData { triangles, pressure, factor })),
                PressureKind::Dead(direction) => {
                    let direction = direction.map(Vector3::from);
                    Box::new(DeadPressure { triangles: &triangles, pressure, direction, factor }.lump(start))
                }
            });
        }
        for (number, load) in self.spec.forces.iter().enumerate() {
            let mut nodes: Vec<u32> = load.nodes.iter().map(|&i| self.node(i)).collect();
            nodes.sort_unstable();
            let force = vec![Vector3::from(load.force); nodes.len()];
            let factor = self.factor(Load::Forces(number), load.factor.as_ref());
            self.terms.push(Box::new(NodalForces { info: FORCES, nodes, force, factor }));
        }
    }

    fn rayleigh(&mut self, mass: &Arc<[f64]>, reference: &[Vector3<f64>]) {
        let Some(rayleigh) = self.spec.rayleigh else { return };
        if rayleigh.mass != 0.0 {
            self.terms.push(Box::new(RayleighMass { factor: rayleigh.mass, mass: mass.clone() }));
        }
        if rayleigh.stiffness == 0.0 {
            return;
        }
        for batch in &self.springs {
            let data = &batch.data;
            let coefficient: Vec<f64> =
                (0..data.nodes.len()).map(|i| rayleigh.stiffness * data.stiffness.at(i)).collect();
            let direction = data
                .nodes
                .iter()
                .map(|&[a, b]| unit_vector(reference[b as usize] - reference[a as usize]).unwrap_or_default());
            self.terms.push(Box::new(RayleighStiffness::new(RayleighData {
                nodes: data.nodes.clone(),
                coefficient: Coefficient::from_values(&coefficient),
                direction: direction.collect(),
            })));
        }
    }
}
