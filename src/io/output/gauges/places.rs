//! Where gauges measure, and the values that they find there.

use crate::case::spec::{GaugeOf, ProbeSpec};
use crate::drive::max_displacement::Displacement;
use crate::mesh::CrossingFinder;
use crate::model::abilities::{ContactLoad, SpringPlace};
use crate::model::gauge::{
    CONTACT_QUANTITIES, CROSSINGS, GAS_QUANTITIES, MembraneGauge, NodeColumns, NodeGauge, Quantity, SpringColumns,
    SpringGauge,
};
use crate::model::observables::{MembranePicture, Observables};
use crate::model::point::Point;
use crate::model::quantity::OfScene;

/// Where a gauge measures, as the scene knows it.
#[derive(Debug)]
pub(super) enum Places {
    Nodes(NodeGauge, Vec<u32>),
    Springs(SpringGauge, Vec<SpringPlace>),
    Cloth(Box<Cloth>),
    Membranes(Box<Membranes>),
    /// edges that carry all canopies of a point, by the masses above them \[kg\]
    Pull(Vec<f64>),
    Canopy(usize),
    Gas(usize),
    Contact(usize),
    /// a largest value over the whole scene
    Scene(OfScene),
    /// mean positions and velocities of the nodes of a probe
    Probe(Vec<u32>),
}

/// Cloth whose crossings are counted.
#[derive(Debug)]
pub(super) struct Cloth {
    /// `None` where cloth cannot cross
    finder: Option<CrossingFinder>,
    /// of every node, whether it is selected
    selected: Vec<bool>,
    /// \[m\] and \[m/s\] of every node
    trace: [Vec<[f64; 3]>; 2],
}

/// Membrane triangles.
#[derive(Debug)]
pub(super) struct Membranes {
    of: MembraneGauge,
    triangles: Vec<u32>,
    /// of every triangle of the scene
    shown: Vec<MembranePicture>,
}

/// The columns of a probe, as in `probes.csv`.
pub(super) const PROBE: [Quantity; 6] = [
    Quantity::signed("x", "m"),
    Quantity::signed("y", "m"),
    Quantity::signed("z", "m"),
    Quantity::signed("vx", "m/s"),
    Quantity::signed("vy", "m/s"),
    Quantity::signed("vz", "m/s"),
];

impl Places {
    /// The columns of a gauge of the case, where it measures, and the strength of its springs [N] or membranes [Pa].
    pub(super) fn of(picture: &dyn Observables, of: &GaugeOf) -> (&'static [Quantity], Self, Option<f64>) {
        match of {
            GaugeOf::Nodes { of, nodes } => (of.columns.all(), Places::Nodes(*of, nodes.clone()), None),
            GaugeOf::Pull { masses } => (SpringGauge::Tension.columns().all(), Places::Pull(masses.clone()), None),
            GaugeOf::Cloth { nodes } => (&[CROSSINGS], Places::Cloth(Box::new(Cloth::new(picture, nodes))), None),
            GaugeOf::Membranes { of, triangles, strength } => {
                let shown = vec![MembranePicture::default(); picture.triangles().len()];
                let places = Membranes { of: *of, triangles: triangles.clone(), shown };
                (of.columns(), Places::Membranes(Box::new(places)), *strength)
            }
            GaugeOf::Gas { gas } => (&GAS_QUANTITIES, Places::Gas(*gas), None),
            GaugeOf::Contact { contact } => (&CONTACT_QUANTITIES, Places::Contact(*contact), None),
            GaugeOf::Springs { of, edges, rule, strength } => {
                let springs = picture.springs().map_or_else(Vec::new, |springs| springs.springs_on(edges, *rule));
                (of.columns().all(), Places::Springs(*of, springs), *strength)
            }
        }
    }

    /// A probe.
    pub(super) fn of_probe(probe: &ProbeSpec) -> Self {
        Places::Probe(probe.nodes.clone())
    }

    /// Measures a state.
    pub(super) fn measure(&mut self, picture: &dyn Observables, at: &Point, to: &mut [f64]) {
        match self {
            Places::Canopy(canopy) => {
                let air = picture.air().into_iter();
                air.for_each(|air| to.copy_from_slice(&air.canopy_values(*canopy, at.state.as_ref())));
            }
            Places::Gas(gas) => {
                let air = picture.air().into_iter();
                air.for_each(|air| to.copy_from_slice(&air.gas_values(*gas, at.state.as_ref())));
            }
            Places::Contact(contact) => {
                let load = picture.touches().map(|touches| touches.load_of(*contact, at.state.as_ref()));
                let ContactLoad { force: [x, y, z], pressure } = load.unwrap_or(ContactLoad::NONE);
                to.copy_from_slice(&[x, y, z, (x * x + y * y + z * z).sqrt(), pressure]);
            }
            Places::Springs(of, springs) => {
                let all = picture.springs();
                let value = |&spring: &SpringPlace| match of {
                    SpringGauge::Tension => all.map_or(f64::NAN, |all| all.spring_tension(at.state.as_ref(), spring)),
                };
                match of.columns() {
                    SpringColumns::SumAndLargest(_) => to.copy_from_slice(&sum_and_largest(springs.iter().map(value))),
                }
            }
            Places::Pull(masses) => {
                let pull = |mass: &f64| picture.air().map_or(f64::NAN, |air| air.pull_of_points(*mass, at));
                to.copy_from_slice(&sum_and_largest(masses.iter().map(pull)));
            }
            Places::Membranes(membranes) => membranes.measure(picture, at, to),
            Places::Cloth(cloth) => to[0] = cloth.crossings(picture, at),
            Places::Nodes(of, nodes) => nodal(picture, *of, nodes, at, to),
            Places::Scene(of) => to[0] = largest(picture, *of, at),
            Places::Probe(nodes) => {
                let (x, v) = to.split_at_mut(3);
                nodal(picture, NodeGauge::POSITION, nodes, at, x);
                nodal(picture, NodeGauge::VELOCITY, nodes, at, v);
            }
        }
    }
}

impl Cloth {
    fn new(picture: &dyn Observables, nodes: &[u32]) -> Self {
        let count = picture.reference().len();
        let mut selected = vec![false; count];
        nodes.iter().for_each(|node| selected[*node as usize] = true);
        let finder = CrossingFinder::new(picture.triangles()).map(|finder| finder.with_start(picture.reference()));
        Cloth { finder, selected, trace: [(); 2].map(|()| vec![[0.0; 3]; count]) }
    }

    /// Number of crossings with the selected nodes; NaN for positions that are not finite.
    fn crossings(&mut self, picture: &dyn Observables, at: &Point) -> f64 {
        let Some(finder) = &mut self.finder else { return 0.0 };
        let [positions, velocities] = &mut self.trace;
        picture.trace(at.state.as_ref(), positions, velocities);
        if !positions.as_flattened().iter().all(|x| x.is_finite()) {
            return f64::NAN;
        }
        let all = |nodes: &[u32]| nodes.iter().all(|node| self.selected[*node as usize]);
        let triangle = |number: u32| all(&picture.triangles()[number as usize]);
        finder.find(positions).iter().filter(|one| all(&one.edge) || triangle(one.triangle)).count() as f64
    }
}

impl Membranes {
    /// The largest value and the mean over the area at rest, or the shares of that area; NaN where no selected triangle
    /// has a membrane.
    fn measure(&mut self, picture: &dyn Observables, at: &Point, to: &mut [f64]) {
        picture.triangle_membranes(at.state.as_ref(), &mut self.shown);
        let selected = self.triangles.iter().filter_map(|&triangle| self.shown.get(triangle as usize));
        let membranes: Vec<&MembranePicture> = selected.filter(|of| of.wrinkling >= 0.0).collect();
        let area: f64 = membranes.iter().map(|of| of.area).sum();
        let mean = |value: &dyn Fn(&MembranePicture) -> f64| {
            membranes.iter().map(|of| of.area * value(of)).sum::<f64>() / area
        };
        let largest_and_mean = |value: &dyn Fn(&MembranePicture) -> f64| {
            [membranes.iter().map(|of| value(of)).fold(f64::NAN, f64::max), mean(value)]
        };
        match self.of {
            MembraneGauge::Stress => to.copy_from_slice(&largest_and_mean(&|of| of.stress[0])),
            MembraneGauge::Strain => to.copy_from_slice(&largest_and_mean(&MembranePicture::elongation)),
            MembraneGauge::Wrinkling => {
                let share = |state: f64| mean(&|of| f64::from(u8::from(of.wrinkling == state)));
                to.copy_from_slice(&[0.0, 1.0, 2.0].map(share));
            }
        }
    }
}

fn sum_and_largest(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([0.0, f64::NEG_INFINITY], |[sum, most], value| [sum + value, value.max(most)])
}

/// The values of a gauge on nodes.
fn nodal(picture: &dyn Observables, of: NodeGauge, nodes: &[u32], at: &Point, to: &mut [f64]) {
    let (mut sum, mut norms, mut most) = ([0.0; 3], 0.0, 0.0_f64);
    for &node in nodes {
        let value = picture.node_value(of.vector, at, node);
        let [x, y, z] = value;
        let norm = (x * x + y * y + z * z).sqrt();
        sum.iter_mut().zip(value).for_each(|(sum, value)| *sum += value);
        (norms, most) = (norms + norm, most.max(norm));
    }
    let share = 1.0 / nodes.len() as f64;
    let [x, y, z] = sum;
    match of.columns {
        NodeColumns::Sum(_) => to.copy_from_slice(&[x, y, z, (x * x + y * y + z * z).sqrt(), most]),
        NodeColumns::Mean(_) => to.copy_from_slice(&[share * x, share * y, share * z]),
        NodeColumns::MeanAndLargest(_) => to.copy_from_slice(&[share * x, share * y, share * z, most]),
        NodeColumns::Sizes(_) => to.copy_from_slice(&[share * norms, most]),
    }
}

/// The largest value over a scene.
fn largest(picture: &dyn Observables, of: OfScene, at: &Point) -> f64 {
    let state = at.state.as_ref();
    match of {
        OfScene::Speed => picture.max_speed(state),
        OfScene::Strain => picture.max_strain(state),
        OfScene::Displacement => Displacement::of(picture, state).distance,
        OfScene::Stress => {
            let mut shown = vec![MembranePicture::default(); picture.triangles().len()];
            picture.triangle_membranes(state, &mut shown);
            shown.iter().filter(|of| of.wrinkling >= 0.0).map(|of| of.stress[0]).fold(f64::NAN, f64::max)
        }
    }
}
