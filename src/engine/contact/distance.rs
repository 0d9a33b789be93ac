//! The distance of two elements of contact, its closest points and its derivatives.
//!
//! With weights w that are positive at the nodes of the first element and negative at those of the second, the vector
//! between points of them is r = sum w_j x_j. It is linear in the parameters a of the closest points that are free (the
//! share along an edge, two shares in a triangle), and at the closest points r is normal to all its directions e_a =
//! dr/da_a. Then, with c_ja = dw_j/da_a and directions that are orthonormal,
//!
//! ```text
//! d = |r|,   n = r/d,   dd/dx_j = w_j n
//! d2d/dx_j dx_k = (w_j w_k (I - n n^T) - sum_a (c_ja r + w_j e_a) (c_ka r + w_k e_a)^T) / d
//! ```
//!
//! The first is the envelope theorem; the second follows from the derivative of r . e_a = 0. Both are exact as long as
//! the closest points stay on the same corner, side or inside.
//!
//! Everything is made of differences of coordinates, so that an origin far away costs no digits.

use nalgebra::{Matrix3, Vector3};

/// [m^2] Square of the length up to which an edge is a point. Second derivatives of shorter ones could overflow.
const POINT: f64 = 1e-200;
/// [-] Sine of the angle between two directions up to which they are parallel: rounding.
const PARALLEL: f64 = 8.0 * f64::EPSILON;
/// [-] Sine from which on the closest points found inside need no comparison with those on the border.
const STEADY: f64 = 1e-3;

/// Which two elements, and how they number their nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum PairKind {
    /// node 0 and node 1
    NodeNode,
    /// node 0 and the edge 1-2
    NodeEdge,
    /// node 0 and the triangle 1-2-3
    NodeTriangle,
    /// the edges 0-1 and 2-3
    EdgeEdge,
}

impl PairKind {
    /// How many nodes it has.
    pub fn nodes(self) -> usize {
        match self {
            Self::NodeNode => 2,
            Self::NodeEdge => 3,
            Self::NodeTriangle | Self::EdgeEdge => 4,
        }
    }

    /// How many of them belong to the first element.
    pub fn nodes_of_first(self) -> usize {
        if self == Self::EdgeEdge { 2 } else { 1 }
    }

    /// Where the closest points are if none is on the border of its element.
    fn whole(self) -> Feature {
        let (first, second) = match self {
            Self::NodeNode => (Place::Corner(0), Place::Corner(1)),
            Self::NodeEdge => (Place::Corner(0), Place::Side(1, 2)),
            Self::NodeTriangle => (Place::Corner(0), Place::Inside),
            Self::EdgeEdge => (Place::Side(0, 1), Place::Side(2, 3)),
        };
        Feature { first, second }
    }

    /// A corner and a side each, on which the closest points are if they are not inside both elements.
    fn strips(self) -> &'static [Strip] {
        match self {
            Self::NodeNode => &[],
            Self::NodeEdge => &[Strip(0, 1, 2)],
            Self::NodeTriangle => &[Strip(0, 1, 2), Strip(0, 2, 3), Strip(0, 3, 1)],
            Self::EdgeEdge => &[Strip(0, 2, 3), Strip(1, 2, 3), Strip(2, 0, 1), Strip(3, 0, 1)],
        }
    }
}

/// Where on an element the closest point is, by the numbers that nodes have in the pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Place {
    /// at this node
    Corner(usize),
    /// between these two
    Side(usize, usize),
    /// inside the triangle 1-2-3
    Inside,
}

impl Place {
    /// The node where the parameters are 0.
    fn base(self) -> usize {
        match self {
            Self::Corner(a) | Self::Side(a, _) => a,
            Self::Inside => 1,
        }
    }
}

/// Where the closest points of a pair are. Where more than one answer is right, as between parallel edges, it is one of
/// them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Feature {
    /// on the first element
    pub first: Place,
    /// on the second element
    pub second: Place,
}

impl Feature {
    /// The spans along which points on both sides are free, with the sign of the element that they belong to.
    fn spans(self) -> [Option<(usize, usize, f64)>; 2] {
        match (self.first, self.second) {
            (Place::Side(a, b), Place::Side(c, d)) => [Some((a, b, 1.0)), Some((c, d, -1.0))],
            (Place::Side(a, b), _) => [Some((a, b, 1.0)), None],
            (_, Place::Side(a, b)) => [Some((a, b, -1.0)), None],
            (_, Place::Inside) => [Some((1, 2, -1.0)), Some((1, 3, -1.0))],
            _ => [None, None],
        }
    }
}

/// A way in which the closest points may move without the nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Free {
    /// [1/m] c_j: how much the weights change by length
    pub change: [f64; 4],
    /// [-] e = sum c_j x_j: the unit vector in which the one closest point moves against the other
    pub direction: Vector3<f64>,
}

impl Free {
    const NONE: Free = Free { change: [0.0; 4], direction: Vector3::new(0.0, 0.0, 0.0) };
}

/// The closest points of a pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// [-] r = sum w_j x_j: not below 0 for the nodes of the first element, not above 0 for those of the second; they
    /// sum to 1 and -1; 0 in unused places
    pub weights: [f64; 4],
    /// [m] vector from the closest point of the second element to that of the first
    pub r: Vector3<f64>,
    /// [m] its length: the least distance of a point of the one to a point of the other
    pub distance: f64,
    /// where they are
    pub feature: Feature,
    free: [Free; 2],
    frees: usize,
}

/// Finds the closest points of a pair of elements. Places of `x` [m] beyond the kind's nodes are not read. Edges
/// without length and triangles without area are as good as any.
pub fn nearest(kind: PairKind, x: &[Vector3<f64>; 4]) -> Nearest {
    if kind == PairKind::NodeNode {
        return Nearest::at(kind.whole(), x).0;
    }
    if kind == PairKind::NodeEdge {
        return on_border(kind, x);
    }
    let (inside, sine) = Nearest::at(kind.whole(), x);
    // The distance is convex in the parameters: where it is least for all points of line or plane, and that is inside,
    // nothing else can be nearer. Directions that are almost parallel leave the parameters open.
    let within = sine > PARALLEL && inside.is_inside(kind);
    if within && sine > STEADY {
        return inside;
    }
    let border = on_border(kind, x);
    if within && inside.distance < border.distance { inside } else { border }
}

/// Whether a pair is farther apart than a distance [m], as far as a look along few directions tells: that between the
/// means of the nodes of its elements, and of two edges what of it is normal to each.
pub fn is_beyond(kind: PairKind, x: &[Vector3<f64>; 4], distance: f64) -> bool {
    let (first, second) = x[..kind.nodes()].split_at(kind.nodes_of_first());
    let from = second[0];
    let mean = |side: &[Vector3<f64>]| side.iter().map(|x| x - from).sum::<Vector3<f64>>() / side.len() as f64;
    let line = mean(first) - mean(second);
    // False along a direction without length.
    let beyond = |direction: Vector3<f64>| {
        let along = |x: &Vector3<f64>| direction.dot(&(x - from));
        let lowest = first.iter().map(along).fold(f64::INFINITY, f64::min);
        let highest = second.iter().map(along).fold(f64::NEG_INFINITY, f64::max);
        lowest - highest > distance * direction.norm()
    };
    let normal_to = |edge: Vector3<f64>| line - edge * (line.dot(&edge) / edge.norm_squared());
    beyond(line) || kind == PairKind::EdgeEdge && (beyond(normal_to(x[1] - x[0])) || beyond(normal_to(x[3] - x[2])))
}

/// The closest points among those of which one at least is on the border of its element.
fn on_border(kind: PairKind, x: &[Vector3<f64>; 4]) -> Nearest {
    let mut best = (f64::INFINITY, kind.whole());
    for &strip in kind.strips() {
        let (square, place) = strip.closest(x);
        if square < best.0 {
            best = (square, strip.feature(place));
        }
    }
    let mut nearest = Nearest::at(best.1, x).0;
    // Rounding may put a point past an end by the last digit.
    let (first, second) = nearest.weights.split_at_mut(kind.nodes_of_first());
    first.iter_mut().for_each(|w| *w = w.clamp(0.0, 1.0));
    second.iter_mut().for_each(|w| *w = w.clamp(-1.0, 0.0));
    nearest
}

/// A node and a side: closest points are at the node and somewhere on the side.
#[derive(Clone, Copy)]
struct Strip(usize, usize, usize);

impl Strip {
    /// [m^2] square of the distance, and where on the side it is taken
    fn closest(self, x: &[Vector3<f64>; 4]) -> (f64, Place) {
        let Strip(node, from, to) = self;
        let (r, e) = (x[node] - x[from], x[to] - x[from]);
        let (along, square) = (r.dot(&e), e.norm_squared());
        if square <= POINT || along <= 0.0 {
            (r.norm_squared(), Place::Corner(from))
        } else if along >= square {
            ((x[node] - x[to]).norm_squared(), Place::Corner(to))
        } else {
            ((r - e * (along / square)).norm_squared(), Place::Side(from, to))
        }
    }

    fn feature(self, place: Place) -> Feature {
        let node = Place::Corner(self.0);
        // Of two edges the nodes 2 and 3 are the second one.
        if self.0 < self.1 { Feature { first: node, second: place } } else { Feature { first: place, second: node } }
    }
}

impl Nearest {
    /// The closest points of line, plane or corner at this feature, and the sine [-] of the angle between its free
    /// directions, 1 if there are less than two and 0 if one of them has no length.
    fn at(feature: Feature, x: &[Vector3<f64>; 4]) -> (Nearest, f64) {
        let (p, q) = (feature.first.base(), feature.second.base());
        let start = x[p] - x[q];
        let (free, frees, sine) = orthonormal(feature.spans(), x);
        let mut weights = [0.0; 4];
        weights[p] += 1.0;
        weights[q] -= 1.0;
        let mut r = start;
        // The second round takes away what rounding left along the directions, so that r is normal to them even where
        // it is short.
        for _ in 0..2 {
            for one in &free[..frees] {
                let way = -r.dot(&one.direction);
                r += one.direction * way;
                for (weight, change) in weights.iter_mut().zip(one.change) {
                    *weight += way * change;
                }
            }
        }
        (Nearest { weights, r, distance: r.norm(), feature, free, frees }, sine)
    }

    /// Whether both points are strictly inside their elements.
    fn is_inside(&self, kind: PairKind) -> bool {
        let (first, second) = self.weights.split_at(kind.nodes_of_first());
        first.iter().all(|&w| w > 0.0) && second.iter().all(|&w| w < 0.0)
    }

    /// In which ways the closest points may move on their elements: none, one or two, with directions that are
    /// orthonormal and normal to r.
    pub fn free(&self) -> &[Free] {
        &self.free[..self.frees]
    }

    /// [-] The unit vector r/d from the second element to the first; 0 at distance 0, where there is none.
    pub fn normal(&self) -> Vector3<f64> {
        if self.distance > 0.0 { self.r / self.distance } else { Vector3::zeros() }
    }

    /// [-] First derivatives of the distance by node j: w_j n. All 0 at distance 0, where there are none.
    pub fn gradient(&self) -> [Vector3<f64>; 4] {
        let n = self.normal();
        self.weights.map(|w| n * w)
    }

    /// [1/m] Second derivatives of the distance by pairs of nodes, exact where the feature does not change. All 0 at
    /// distance 0, where there are none.
    pub fn hessian(&self) -> [[Matrix3<f64>; 4]; 4] {
        let mut hessian = [[Matrix3::zeros(); 4]; 4];
        if self.distance == 0.0 {
            return hessian;
        }
        let (n, d, w) = (self.normal(), self.distance, &self.weights);
        let (across, along) = (self.across(&n) / d, n * n.transpose() * d);
        let turns = self.free.map(|one| n * one.direction.transpose());
        for (j, row) in hessian.iter_mut().enumerate() {
            for (k, block) in row.iter_mut().enumerate() {
                *block = across * (w[j] * w[k]);
                for (Free { change: c, .. }, turn) in self.free().iter().zip(&turns) {
                    *block -= along * (c[j] * c[k]) + turn * (c[j] * w[k]) + turn.transpose() * (w[j] * c[k]);
                }
            }
        }
        hessian
    }

    /// [-] I - n n^T - sum e_a e_a^T, in the form that loses no digits.
    fn across(&self, n: &Vector3<f64>) -> Matrix3<f64> {
        match self.free() {
            [] => Matrix3::identity() - n * n.transpose(),
            [one] => {
                let third = n.cross(&one.direction);
                third * third.transpose()
            }
            _ => Matrix3::zeros(),
        }
    }
}

/// The ways along spans of nodes, made orthonormal (Gram-Schmidt, the longer one first, twice), how many there are, and
/// the sine of the angle between them.
fn orthonormal(spans: [Option<(usize, usize, f64)>; 2], x: &[Vector3<f64>; 4]) -> ([Free; 2], usize, f64) {
    let mut ways = [Free::NONE; 2];
    let mut count = 0;
    for (from, to, sign) in spans.into_iter().flatten() {
        let way = &mut ways[count];
        way.change[from] = -sign;
        way.change[to] = sign;
        way.direction = (x[to] - x[from]) * sign;
        count += 1;
    }
    if count == 2 && ways[1].direction.norm_squared() > ways[0].direction.norm_squared() {
        ways.swap(0, 1);
    }
    let mut sine = 1.0;
    for i in 0..count {
        let length = ways[i].direction.norm();
        if length * length <= POINT {
            return (ways, i, 0.0);
        }
        if i == 1 {
            let first = ways[0];
            for _ in 0..2 {
                let along = ways[1].direction.dot(&first.direction);
                ways[1].direction -= first.direction * along;
                subtract(&mut ways[1].change, &first.change, along);
            }
            sine = ways[1].direction.norm() / length;
            if sine <= PARALLEL {
                return (ways, 1, sine);
            }
        }
        let length = ways[i].direction.norm();
        ways[i].direction /= length;
        ways[i].change.iter_mut().for_each(|c| *c /= length);
    }
    (ways, count, sine)
}

fn subtract(from: &mut [f64; 4], what: &[f64; 4], times: f64) {
    for (a, b) in from.iter_mut().zip(what) {
        *a -= times * b;
    }
}

#[cfg(test)]
mod tests;
