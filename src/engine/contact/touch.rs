//! Energy, force and tangent of a pair that is closer than its gap.
//!
//! ```text
//! phi = m V(g),   g = d - thickness;   m: what smooths parallel edges (`parallel`), else 1
//! dphi/dx_j = m V' w_j n + V dm/dx_j
//! K = m V'' (w n)(w n)^T + m V' d2d/dx2 + V' (dd dm^T + dm dd^T) + V d2m/dx2;      convex: the first part alone
//! ```
//! w_j are the shares of the nodes in the closest points, those of the second element negative, and n the unit vector
//! from the second to the first (`distance`). So forces of a pair add up to 0, and so do their moments.

use super::barrier::{Barrier, Push};
use super::bodies::Contacts;
use super::distance::{Nearest, PairKind, nearest};
use super::friction::{CREEP, Friction};
use super::near::{Candidate, Form, NO_NODE, Places, points};
use super::parallel::Mollifier;
use crate::force::outer;
use nalgebra::{Matrix3, Vector3};

/// One value for every pair of nodes of a pair.
pub type Blocks = [[Matrix3<f64>; 4]; 4];

/// A pair that is closer than its gap.
#[derive(Clone, Debug)]
pub struct Touch {
    /// [-] w
    pub weights: [f64; 4],
    /// n
    pub normal: Vector3<f64>,
    /// [m] g
    pub gap: f64,
    /// V, -V' and V''
    push: Push,
    /// the closest points; `None` at a plane
    nearest: Option<Nearest>,
    /// m, where it is not 1
    parallel: Option<Mollifier>,
}

impl Touch {
    /// A candidate at these places; `None` if it is not closer than its gap. `limited` is how explicit steps have it.
    pub fn of(candidate: &Candidate, places: Places<'_>, limited: bool) -> Option<Self> {
        let contact = &places.contacts.list[usize::from(candidate.contact)];
        let barrier = Barrier { stiffness: candidate.stiffness, gap: contact.gap, limited };
        let kind = match candidate.form {
            Form::Plane => {
                let plane = places.plane(candidate.contact)?;
                let gap = plane.normal.dot(&(places.at(candidate.nodes[0]) - plane.point));
                let push = barrier.at(gap)?;
                let weights = [1.0, 0.0, 0.0, 0.0];
                return Some(Touch { weights, normal: plane.normal, gap, push, nearest: None, parallel: None });
            }
            Form::Pair(kind) => kind,
        };
        let x = points(candidate.nodes, |node| places.at(node));
        let found = nearest(kind, &x);
        let gap = found.distance - contact.thickness;
        let push = barrier.at(gap)?;
        let parallel = (kind == PairKind::EdgeEdge).then(|| Mollifier::new(&x, candidate.lengths));
        let parallel = parallel.filter(Mollifier::is_below_1);
        Some(Touch { weights: found.weights, normal: found.normal(), gap, push, nearest: Some(found), parallel })
    }

    /// m
    fn share(&self) -> f64 {
        self.parallel.as_ref().map_or(1.0, Mollifier::value)
    }

    /// [J] phi
    pub fn energy(&self) -> f64 {
        self.share() * self.push.energy
    }

    /// [N] -m V', by which the sides press on each other.
    pub fn pressure(&self) -> f64 {
        self.share() * self.push.force
    }

    /// [N/m] m V''
    pub fn slope(&self) -> f64 {
        self.share() * self.push.slope
    }

    /// [N] dphi/dx_j: minus the forces on the nodes.
    pub fn gradient(&self) -> [Vector3<f64>; 4] {
        let along = self.normal * -self.pressure();
        let mut gradient = self.weights.map(|w| along * w);
        if let Some(parallel) = &self.parallel {
            let of_share = parallel.gradient().into_iter().map(|slope| slope * self.push.energy);
            gradient.iter_mut().zip(of_share).for_each(|(sum, added)| *sum += added);
        }
        gradient
    }

    /// [N/m] K, or its convex part, which has no negative eigenvalue.
    pub fn tangent(&self, convex: bool) -> Blocks {
        let along = outer(self.normal, self.normal) * self.slope();
        let mut k: Blocks = self.weights.map(|a| self.weights.map(|b| along * (a * b)));
        if convex {
            return k;
        }
        let Some(nearest) = &self.nearest else { return k };
        let [share, slope] = [self.share(), -self.push.force];
        add(&mut k, &nearest.hessian(), share * slope);
        if let Some(parallel) = &self.parallel {
            let (of_gap, of_share) = (self.weights.map(|w| self.normal * w), parallel.gradient());
            for (i, row) in k.iter_mut().enumerate() {
                for (j, block) in row.iter_mut().enumerate() {
                    *block += (outer(of_gap[i], of_share[j]) + outer(of_share[i], of_gap[j])) * slope;
                }
            }
            add(&mut k, &parallel.hessian(), self.push.energy);
        }
        k
    }

    /// Where and how strongly the sides press on each other.
    pub fn pressed(&self, candidate: &Candidate) -> Pressed {
        Pressed { candidate: *candidate, weights: self.weights, normal: self.normal, pressure: self.pressure() }
    }
}

fn add(sum: &mut Blocks, added: &Blocks, times: f64) {
    for (sum, added) in sum.iter_mut().flatten().zip(added.iter().flatten()) {
        *sum += added * times;
    }
}

/// Where and how strongly the sides of a pair press on each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pressed {
    /// the pair
    pub candidate: Candidate,
    /// [-] w
    pub weights: [f64; 4],
    /// n
    pub normal: Vector3<f64>,
    /// [N] lambda
    pub pressure: f64,
}

impl Pressed {
    /// By which they are in order.
    pub fn key(&self) -> (u16, Form, [u32; 4]) {
        self.candidate.key()
    }

    /// [m/s] Velocity of the first closest point against the second, for nodes with velocities `v` [m/s].
    pub fn velocity(&self, places: Places<'_>, v: &[Vector3<f64>]) -> Vector3<f64> {
        let nodes = self.candidate.nodes.iter().zip(self.weights).filter(|(node, _)| **node != NO_NODE);
        let own: Vector3<f64> = nodes.map(|(node, w)| places.velocity(v, *node) * w).sum();
        match self.candidate.form {
            Form::Plane => own - places.shifts[usize::from(self.candidate.contact)][1],
            Form::Pair(_) => own,
        }
    }

    /// Its friction; `None` without. `held` is what an explicit step can follow.
    pub fn friction(&self, places: Places<'_>, held: Option<Held<'_>>) -> Option<Friction> {
        let contacts = places.contacts;
        let limit = self.limit(contacts);
        let creep = held.map_or(CREEP, |Held { h, limits }| {
            let nodes = || self.candidate.nodes.iter().zip(self.weights);
            let inverse = |node: &u32| contacts.inverse_mass.get(*node as usize).copied().unwrap_or(0.0);
            let mobility: f64 = nodes().map(|(node, w)| w * w * inverse(node)).sum();
            let of_node = |(node, w): (&u32, f64)| limits.get(*node as usize).filter(|_| w != 0.0).copied();
            let all = nodes().filter_map(of_node).fold(limit, f64::max);
            f64::max(CREEP, 2.0 * all * h * mobility)
        });
        (limit > 0.0).then_some(Friction { limit, creep, normal: self.normal })
    }

    /// [N] mu lambda
    fn limit(&self, contacts: &Contacts) -> f64 {
        contacts.list[usize::from(self.candidate.contact)].friction * self.pressure
    }
}

/// What friction an explicit step can follow: less than what would stop the sides within two steps.
#[derive(Clone, Copy, Debug)]
pub struct Held<'a> {
    /// [s] the step
    pub h: f64,
    /// [N] mu lambda of all pairs at every node
    pub limits: &'a [f64],
}

/// Overwrites `limits` [N] with the sum of mu lambda at every node of the scene, each by its share in the pair.
pub fn add_up(pressed: &[Pressed], contacts: &Contacts, limits: &mut Vec<f64>) {
    limits.clear();
    limits.resize(contacts.rest.len(), 0.0);
    for place in pressed {
        let limit = place.limit(contacts);
        for (node, w) in place.candidate.nodes.iter().zip(place.weights) {
            limits.get_mut(*node as usize).into_iter().for_each(|sum| *sum += w.abs() * limit);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::bodies::{Body, Contact, Contacts, Other};
    use super::*;
    use crate::mesh::random::SplitMix64;

    const GAP: f64 = 0.6;

    fn contacts() -> Contacts {
        let (body, motion) = (Body::default(), None);
        let contact = Contact { body, other: Other::Itself, thickness: 0.1, gap: GAP, friction: 0.3, motion };
        Contacts {
            list: vec![contact],
            rest: vec![Vector3::zeros(); 4],
            inverse_mass: vec![1.0; 4],
            ..Contacts::default()
        }
    }

    /// Of all kinds, parallel edges among them: the gradient is the slope of the energy, the tangent that of the
    /// gradient, where the closest features stay, and forces and moments add up to 0.
    #[test]
    fn gradients_and_tangents_belong_to_energies() {
        let (contacts, shifts, mut random) = (contacts(), [[Vector3::zeros(); 2]], SplitMix64::new(3, 0));
        let (mut compared, mut parallel) = (0, 0);
        for round in 0..4000 {
            let kind = [PairKind::NodeNode, PairKind::NodeEdge, PairKind::NodeTriangle, PairKind::EdgeEdge][round % 4];
            let mut unit = || 2.0 * random.uniform() - 1.0;
            let mut point = || Vector3::new(unit(), unit(), unit());
            let (mut x, way) = ([0; 4].map(|_| point()), [0; 4].map(|_| point()));
            if round % 8 == 3 {
                x[3] = x[2] + (x[1] - x[0]) + point() * 0.02;
            }
            let nodes = std::array::from_fn(|j| if j < kind.nodes() { j as u32 } else { NO_NODE });
            let lengths = [(x[1] - x[0]).norm(), (x[3] - x[2]).norm()];
            let candidate =
                Candidate { contact: 0, form: Form::Pair(kind), nodes, stiffness: 50.0, lengths, beyond: 0.0 };
            let at = |s: f64| {
                let x: [Vector3<f64>; 4] = std::array::from_fn(|j| x[j] + way[j] * s);
                let places = Places { contacts: &contacts, t: 0.0, x: &x, shifts: &shifts };
                Touch::of(&candidate, places, false)
            };
            let Some(touch) = at(0.0).filter(|touch| touch.gap > 0.05) else { continue };
            let d = if round % 8 == 3 { 1e-7 } else { 1e-5 };
            let (Some(below), Some(above)) = (at(-d), at(d)) else { continue };
            let slope = (above.energy() - below.energy()) / (2.0 * d);
            let gradient = touch.gradient();
            let along: f64 = (0..kind.nodes()).map(|j| gradient[j].dot(&way[j])).sum();
            let size = gradient.iter().map(Vector3::norm).sum::<f64>();
            assert!((slope - along).abs() < 1e-6 * (size + 1.0), "{kind:?} {round}: {slope} and not {along}");
            let force: Vector3<f64> = gradient.iter().sum();
            let moment: Vector3<f64> = gradient.iter().zip(&x).map(|(g, x)| x.cross(g)).sum();
            assert!(force.norm() + moment.norm() < 1e-12 * (size + 1.0), "{kind:?} {round}: {force} {moment}");
            let feature = |touch: &Touch| touch.nearest.as_ref().map(|nearest| nearest.feature);
            let smooth = feature(&below) == feature(&above) && below.parallel.is_some() == above.parallel.is_some();
            parallel += usize::from(touch.parallel.is_some());
            let k = touch.tangent(false);
            for (j, row) in k.iter().enumerate().take(kind.nodes()).filter(|_| smooth) {
                let slope = (above.gradient()[j] - below.gradient()[j]) / (2.0 * d);
                let along: Vector3<f64> = (0..kind.nodes()).map(|i| row[i] * way[i]).sum();
                let stiff: f64 = row.iter().map(|block| block.norm()).sum();
                assert!((slope - along).norm() < 1e-5 * (stiff + 10.0), "{kind:?} {round}: {slope} and not {along}");
                compared += 1;
            }
        }
        assert!(compared > 2000 && parallel > 30, "{compared} compared, {parallel} parallel");
    }
}
