//! The derivatives of what a gauge measures, with respect to the state and to what acts there.

use super::places::Places;
use crate::model::abilities::SpringPlace;
use crate::model::gauge::{NodeColumns, NodeGauge, NodeQuantity, SpringGauge};
use crate::model::point::Point;
use crate::model::quantity::OfScene;
use crate::model::state::{State, StateRef};
use crate::scene::{Adjoint, Scene};
use crate::sensitivity::Seed;
use crate::sensitivity::difference::{PLACES, derivative};

/// [-] Share of the scene's size, and of its speeds, by which differences move a state.
const SHARE: f64 = 1e-4;

impl Places {
    /// The derivatives of one of the columns at a state.
    ///
    /// # Errors
    /// Why they are not known.
    pub(super) fn seed(
        &mut self,
        (scene, adjoint): (&dyn Scene, &dyn Adjoint),
        (column, columns): (usize, usize),
        at: &Point,
    ) -> Result<Seed, &'static str> {
        match self {
            Places::Nodes(of, nodes) => nodal((scene, adjoint), (*of, nodes), column, at),
            Places::Probe(nodes) => {
                let of = if column < 3 { NodeGauge::POSITION } else { NodeGauge::VELOCITY };
                nodal((scene, adjoint), (of, nodes), column % 3, at)
            }
            Places::Springs(SpringGauge::Tension, springs) => Ok(tension((scene, adjoint), springs, column, at)),
            Places::Pull(_) => Err("the pull of a canopy that is a point has no adjoint; name keys of the case"),
            Places::Cloth(_) => Err("it is a count"),
            Places::Contact(_) => Err("derivatives do not know contact"),
            Places::Scene(OfScene::Strain) => Err("the largest strain has no adjoint; name a gauge of tensions"),
            Places::Canopy(_) | Places::Gas(_) | Places::Membranes(_) | Places::Scene(_) => {
                Ok(self.by_differences(scene, (column, columns), at))
            }
        }
    }

    /// Those of a gauge that depends on positions and velocities only, by each of them.
    fn by_differences(&mut self, scene: &dyn Scene, (column, columns): (usize, usize), at: &Point) -> Seed {
        let n = scene.n_dof();
        let mut seed = Seed::zero(n);
        let [of_x, of_v] = steps(scene, at.state.as_ref());
        let mut values = vec![0.0; columns];
        let mut moved = at.clone();
        let mut slope = |moved: &mut Point, part: fn(&mut State) -> &mut Vec<f64>, (dof, h): (usize, f64)| {
            let middle = part(&mut moved.state)[dof];
            let found = PLACES.map(|place| {
                part(&mut moved.state)[dof] = middle + place * h;
                self.measure(scene, moved, &mut values);
                values[column]
            });
            part(&mut moved.state)[dof] = middle;
            derivative(found, h)
        };
        for dof in 0..n {
            seed.x[dof] = slope(&mut moved, |state| &mut state.x, (dof, of_x));
            seed.v[dof] = slope(&mut moved, |state| &mut state.v, (dof, of_v));
        }
        seed
    }
}

/// [m] and [m/s] Steps of differences.
fn steps(scene: &dyn Scene, at: StateRef<'_>) -> [f64; 2] {
    let speed = at.v.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
    [SHARE * scene.size().max(1e-3), SHARE * (1.0 + speed)]
}

/// Those of a column of a gauge on nodes.
fn nodal(
    (scene, adjoint): (&dyn Scene, &dyn Adjoint),
    (of, nodes): (NodeGauge, &[u32]),
    column: usize,
    at: &Point,
) -> Result<Seed, &'static str> {
    let values: Vec<[f64; 3]> = nodes.iter().map(|&node| scene.node_value(of.vector, at, node)).collect();
    let mut seed = Seed::zero(scene.n_dof());
    for (&node, slope) in nodes.iter().zip(column_slopes(of.columns, &values, column)) {
        let first = adjoint.first_dof(node);
        for (dof, slope) in (first..).zip(slope) {
            let inverse = scene.inverse_mass()[dof];
            let held = inverse == 0.0;
            match of.vector {
                NodeQuantity::Position | NodeQuantity::Displacement => seed.x[dof] += slope,
                NodeQuantity::Velocity => seed.v[dof] += slope,
                NodeQuantity::Acceleration => seed.force[dof] += slope * inverse,
                NodeQuantity::Force => seed.force[dof] += if held { 0.0 } else { slope },
                NodeQuantity::Reaction => seed.force[dof] -= if held { slope } else { 0.0 },
            }
        }
    }
    seed.inertia = of.vector == NodeQuantity::Acceleration;
    let (mut u, mut g) = (vec![0.0; scene.n_dof()], vec![0.0; scene.n_dof()]);
    for part in 0..scene.mass_parts() {
        scene.rank_one(
            part,
            at.state.as_ref(),
            crate::model::system::Weights { m: 1.0, c: 0.0, k: 0.0 },
            &mut u,
            &mut g,
        );
        if g.iter().zip(&seed.force).any(|(g, force)| *g != 0.0 && *force != 0.0) {
            return Err("forces on the cloth of a canopy with the air that it takes along have no adjoint");
        }
    }
    Ok(seed)
}

/// The derivatives of a column with respect to the vectors of its nodes.
fn column_slopes(columns: NodeColumns, values: &[[f64; 3]], column: usize) -> Vec<[f64; 3]> {
    let size = |value: &[f64; 3]| value.iter().map(|x| x * x).sum::<f64>().sqrt();
    let direction = |value: [f64; 3]| {
        let size = size(&value);
        value.map(|x| if size > 0.0 { x / size } else { 0.0 })
    };
    let axis = |share: f64| vec![std::array::from_fn(|i| if i == column { share } else { 0.0 }); values.len()];
    let mean = 1.0 / values.len() as f64;
    let largest = || {
        let most = values.iter().enumerate().max_by(|a, b| size(a.1).total_cmp(&size(b.1))).map(|(place, _)| place);
        let slope = |(place, value): (usize, &[f64; 3])| if Some(place) == most { direction(*value) } else { [0.0; 3] };
        values.iter().enumerate().map(slope).collect()
    };
    match (columns, column) {
        (NodeColumns::Sum(_), 0..3) => axis(1.0),
        (NodeColumns::Sum(_), 3) => {
            let sum = values.iter().fold([0.0; 3], |sum: [f64; 3], v| std::array::from_fn(|i| sum[i] + v[i]));
            vec![direction(sum); values.len()]
        }
        (NodeColumns::Mean(_), _) | (NodeColumns::MeanAndLargest(_), 0..3) => axis(mean),
        (NodeColumns::Sizes(_), 0) => values.iter().map(|value| direction(*value).map(|d| mean * d)).collect(),
        (NodeColumns::Sum(_) | NodeColumns::MeanAndLargest(_) | NodeColumns::Sizes(_), _) => largest(),
    }
}

/// Those of the sum of tensions, or of the largest one.
fn tension((scene, adjoint): (&dyn Scene, &dyn Adjoint), springs: &[SpringPlace], column: usize, at: &Point) -> Seed {
    let mut seed = Seed::zero(scene.n_dof());
    let (Some(all), places, ends) = (scene.springs(), adjoint.springs(), adjoint.spring_ends()) else { return seed };
    let value = |spring: SpringPlace| all.spring_tension(at.state.as_ref(), spring);
    let largest = || springs.iter().copied().max_by(|a, b| value(*a).total_cmp(&value(*b)));
    let chosen: Vec<SpringPlace> = if column == 0 { springs.to_vec() } else { largest().into_iter().collect() };
    let [of_x, of_v] = steps(scene, at.state.as_ref());
    let mut moved = at.state.clone();
    for spring in chosen {
        let Ok(number) = places.binary_search_by_key(&(spring.batch, spring.number), |of| (of.batch, of.number)) else {
            continue;
        };
        seed.tensions.push((number, 1.0));
        for dof in ends[number].into_iter().flat_map(|first| first as usize..first as usize + 3) {
            let (x, v) = (moved.x[dof], moved.v[dof]);
            let by_x = PLACES.map(|place| {
                moved.x[dof] = x + place * of_x;
                all.spring_tension(moved.as_ref(), spring)
            });
            moved.x[dof] = x;
            let by_v = PLACES.map(|place| {
                moved.v[dof] = v + place * of_v;
                all.spring_tension(moved.as_ref(), spring)
            });
            moved.v[dof] = v;
            seed.x[dof] += derivative(by_x, of_x);
            seed.v[dof] += derivative(by_v, of_v);
        }
    }
    seed
}
