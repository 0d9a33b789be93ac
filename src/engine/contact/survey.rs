//! What a contact is made of, and how stiff one of its pairs can be along its normal in an explicit step.
//!
//! ```text
//! V'' <= b''(0.4) kappa,   kappa = min(kappa_e, kappa_f)          of the elements e and f of a pair
//! K = V'' (w n)(w n)^T,    sum of w_j^2 = at most 1 on each side
//! largest eigenvalue of M^-1 K  <=  V'' (mu_e + mu_f)  <=  b''(0.4) (kappa_e mu_e + kappa_f mu_f)
//! ```
//! with the mean kappa and the largest inverse mass mu of the nodes of an element. Where n pairs share a node, the
//! largest eigenvalue of all of them together is at most n times as large: sums over pairs lie below sums over nodes.
//!
//! It is an estimate of the whole stiffness: what smooths nearly parallel edges ([`super::parallel`]) and the rotation
//! of the normal are not in it, and edges that are nearly parallel can be many times stiffer.

use super::barrier::MOST_SLOPE;
use super::bodies::{Body, Contacts, Other};
use super::near::{Candidate, NO_NODE};

impl Contacts {
    /// [1/s^2] The estimate above for one pair of a contact.
    pub fn most_rate(&self, contact: usize) -> f64 {
        let Some(found) = self.list.get(contact) else { return 0.0 };
        let [first, second] = match &found.other {
            Other::Plane(_) => [self.rate_of(contact, found.body.nodes.iter().map(std::slice::from_ref)), 0.0],
            Other::Body(other) => [self.rate_of_side(contact, &found.body), self.rate_of_side(contact, other)],
            Other::Itself => [self.rate_of_side(contact, &found.body); 2],
        };
        MOST_SLOPE * (first + second)
    }

    fn rate_of_side(&self, contact: usize, body: &Body) -> f64 {
        let nodes = body.nodes.iter().map(std::slice::from_ref);
        let edges = body.edges.iter().map(|edge| &edge[..]);
        self.rate_of(contact, nodes.chain(edges).chain(body.triangles.iter().map(|triangle| &triangle[..])))
    }

    /// [1/s^2] The largest kappa_e mu_e.
    fn rate_of<'a>(&self, contact: usize, elements: impl Iterator<Item = &'a [u32]>) -> f64 {
        let inverse = |node: &u32| self.inverse_mass.get(*node as usize).copied().unwrap_or(0.0);
        let rate = |element: &[u32]| {
            let mu = element.iter().map(inverse).fold(0.0, f64::max);
            self.stiffness_of(contact, [element, &[]]) * mu
        };
        elements.map(rate).fold(0.0, f64::max)
    }

    /// Nodes, edges and triangles of both sides; zeros of a plane, and of a contact with itself.
    pub fn elements(&self, contact: usize) -> [[usize; 3]; 2] {
        let count = |body: &Body| [body.nodes.len(), body.edges.len(), body.triangles.len()];
        let found = &self.list[contact];
        [count(&found.body), found.other.body().map_or([0; 3], count)]
    }

    /// The largest number of these pairs that share a node of the scene.
    pub fn most_at_a_node<'a>(&self, pairs: impl Iterator<Item = &'a Candidate>) -> usize {
        let mut counts = vec![0; self.rest.len()];
        for node in pairs.flat_map(|pair| pair.nodes).filter(|node| *node != NO_NODE) {
            counts.get_mut(node as usize).into_iter().for_each(|count| *count += 1);
        }
        counts.into_iter().max().unwrap_or(0)
    }

    /// 1 if the first element of a pair is of the first side of its contact, -1 if it is of the second; 0 of a contact
    /// with itself. A pair that fits both ways counts as the first.
    pub fn direction(&self, pair: &Candidate) -> f64 {
        let contact = &self.list[usize::from(pair.contact)];
        let super::near::Form::Pair(kind) = pair.form else { return 1.0 };
        let other = match &contact.other {
            Other::Itself => return 0.0,
            Other::Plane(_) => return 1.0,
            Other::Body(other) => other,
        };
        let has = |body: &Body, nodes: &[u32]| nodes.iter().all(|node| body.nodes.binary_search(node).is_ok());
        let [first, second] = super::bodies::sides(kind, &pair.nodes);
        if has(&contact.body, first) && has(other, second) { 1.0 } else { -1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::super::barrier::Barrier;
    use super::super::bodies::{Contact, Plane};
    use super::super::distance::PairKind;
    use super::super::near::{Form, Places};
    use super::super::touch::Touch;
    use super::*;
    use crate::mesh::random::SplitMix64;
    use nalgebra::{DMatrix, Vector3};

    const GAP: f64 = 0.6;

    /// Two triangles and a line with masses and stiffnesses that differ by up to 30 times.
    fn contacts(random: &mut SplitMix64, other: Other) -> Contacts {
        let body = Body::new(vec![[0, 1, 2], [3, 4, 5]], vec![[6, 7]], Vec::new());
        let contact = Contact { body, other, thickness: 0.0, gap: GAP, friction: 0.0, motion: None };
        let mut draw = || (0..8).map(|_| 30.0_f64.powf(random.uniform())).collect::<Vec<f64>>();
        let (stiffness, inverse_mass) = (draw(), draw());
        Contacts {
            list: vec![contact],
            rest: vec![Vector3::zeros(); 8],
            stiffness: vec![stiffness],
            inverse_mass,
            ..Contacts::default()
        }
    }

    /// No pair at any place has a larger eigenvalue, and a node on a plane, or two nodes that meet, have nearly it.
    #[test]
    fn no_pair_is_stiffer_along_its_normal() {
        let (mut random, mut closest) = (SplitMix64::new(5, 0), 0.0_f64);
        for round in 0..4000 {
            let plane = Plane { point: Vector3::zeros(), normal: Vector3::z() };
            let other = if round % 5 == 0 { Other::Plane(plane) } else { Other::Itself };
            let contacts = contacts(&mut random, other);
            let (form, nodes) = match round % 5 {
                0 => (Form::Plane, [(round / 5 % 8) as u32, NO_NODE, NO_NODE, NO_NODE]),
                1 => (Form::Pair(PairKind::NodeTriangle), [3, 0, 1, 2]),
                2 => (Form::Pair(PairKind::NodeEdge), [0, 6, 7, NO_NODE]),
                3 => (Form::Pair(PairKind::EdgeEdge), [0, 1, 6, 7]),
                _ => (Form::Pair(PairKind::NodeTriangle), [7, 3, 4, 5]),
            };
            let mut unit = || 2.0 * random.uniform() - 1.0;
            let x: Vec<Vector3<f64>> = (0..8).map(|_| Vector3::new(unit(), unit(), unit()) * 0.3).collect();
            let places = Places { contacts: &contacts, t: 0.0, x: &x, shifts: &[[Vector3::zeros(); 2]] };
            let stiffness = match form {
                Form::Plane => contacts.stiffness_of(0, [&nodes[..1], &[]]),
                Form::Pair(kind) => contacts.stiffness_of(0, super::super::bodies::sides(kind, &nodes)),
            };
            // Lengths of 0 keep parallel edges as they are.
            let pair = Candidate { contact: 0, form, nodes, stiffness, lengths: [0.0; 2], beyond: 0.0 };
            let Some(touch) = Touch::of(&pair, places, true) else { continue };
            let k = touch.tangent(true);
            let inverse = |i: usize| contacts.inverse_mass.get(nodes[i] as usize).map_or(0.0, |m| m.sqrt());
            let matrix =
                DMatrix::from_fn(12, 12, |i, j| k[i / 3][j / 3][(i % 3, j % 3)] * inverse(i / 3) * inverse(j / 3));
            let found = matrix.symmetric_eigenvalues().max() / contacts.most_rate(0);
            assert!(found <= 1.0 + 1e-12, "{round}: {found} of the bound");
            closest = closest.max(found);
        }
        assert!(closest > 0.5, "the bound is {closest} of what pairs have");
        let barrier = Barrier { stiffness: 3.0, gap: GAP, limited: true };
        let slope = |g: f64| barrier.at(g).map_or(0.0, |push| push.slope);
        assert!((0..100).all(|i| slope(0.01 * f64::from(i) * GAP) <= 3.0 * MOST_SLOPE * (1.0 + 1e-15)));
    }
}
