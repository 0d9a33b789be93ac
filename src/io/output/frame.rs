//! The content of a frame, and how edge values become cell values.

use crate::case::spec::{CrossingSearch, Field, OutputSpec};
use crate::mesh::adjacency::Adjacency;
use crate::mesh::crossing::can_meet;
use crate::model::observables::{MembranePicture, Observables};

/// Fields of a case besides positions, displacements and velocities, which are always there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Fields {
    /// net force on every node
    pub force: bool,
    /// support reaction on every node
    pub reaction: bool,
    /// tension of every edge and triangle
    pub tension: bool,
    /// strain of every edge and triangle
    pub strain: bool,
    /// rest length of every edge
    pub rest_length: bool,
    /// pressure of the air on every triangle
    pub pressure: bool,
    /// what membranes carry
    pub membrane: bool,
    /// whether a triangle passes through another
    pub crossing: bool,
}

impl Fields {
    /// The fields in frames of a scene: with groups and air, the pressure as well; crossings only where cloth can meet.
    #[must_use]
    pub fn of_scene(self, picture: &dyn Observables) -> Self {
        let pressure = self.pressure || picture.air().is_some_and(|air| air.presses()) && !picture.groups().is_empty();
        Fields { pressure, crossing: self.crossing && can_meet(picture.triangles()), ..self }
    }
}

impl From<&OutputSpec> for Fields {
    /// The fields of a case.
    fn from(output: &OutputSpec) -> Self {
        let has = |field| output.fields.contains(&field);
        Fields {
            force: has(Field::Force),
            reaction: has(Field::Reaction),
            tension: has(Field::Tension),
            strain: has(Field::Strain),
            rest_length: has(Field::RestLength),
            pressure: has(Field::Pressure),
            membrane: has(Field::Membrane),
            crossing: output.crossings != CrossingSearch::None,
        }
    }
}

/// A frame to be written, in the user's numbering. Fields that are not wanted are empty.
#[derive(Clone, Debug, Default)]
pub struct Frame {
    /// [s] time
    pub time: f64,
    /// whether the state is [credible](crate::drive::observer::AcceptedStep::credible)
    pub credible: bool,
    /// [m] of every node
    pub positions: Vec<[f64; 3]>,
    /// [m/s] of every node
    pub velocities: Vec<[f64; 3]>,
    /// [N] net force on every node, 0 at held degrees of freedom
    pub force: Vec<[f64; 3]>,
    /// [N] support reaction on every node
    pub reaction: Vec<[f64; 3]>,
    /// [N] of every edge, NaN without a spring
    pub tension: Vec<f64>,
    /// [-] of every edge, NaN without a spring
    pub strain: Vec<f64>,
    /// [m] of every edge, NaN without a spring
    pub rest_length: Vec<f64>,
    /// [Pa] of every triangle
    pub pressure: Vec<f64>,
    /// of every triangle
    pub membrane: Vec<MembranePicture>,
    /// of every triangle: 1 if it passes through another, else 0
    pub crossing: Vec<u8>,
}

/// Sizes of a frame's arrays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FrameSize {
    /// nodes of the picture
    pub nodes: usize,
    /// edges of the picture
    pub edges: usize,
    /// triangles of the picture
    pub triangles: usize,
    /// fields that are wanted
    pub fields: Fields,
}

impl FrameSize {
    /// [byte] of a frame's arrays
    pub fn bytes(self) -> usize {
        let Fields { force, reaction, .. } = self.fields;
        let vectors = 2 + usize::from(force) + usize::from(reaction);
        let membranes = size_of::<MembranePicture>() * self.membranes();
        size_of::<f64>() * (3 * vectors * self.nodes + 2 * self.springs() + self.lengths() + self.faces())
            + membranes
            + self.flags()
    }

    /// Length of the array on triangles.
    fn faces(self) -> usize {
        if self.fields.pressure { self.triangles } else { 0 }
    }

    /// Length of the array of crossings.
    fn flags(self) -> usize {
        if self.fields.crossing { self.triangles } else { 0 }
    }

    /// Length of the array of membranes.
    fn membranes(self) -> usize {
        if self.fields.membrane { self.triangles } else { 0 }
    }

    /// Length of the array of rest lengths.
    fn lengths(self) -> usize {
        if self.fields.rest_length { self.edges } else { 0 }
    }

    /// Length of the arrays on edges: tension and strain come from one call, so both are needed for either.
    fn springs(self) -> usize {
        if self.fields.tension || self.fields.strain { self.edges } else { 0 }
    }
}

impl Frame {
    /// A frame of zeros.
    pub fn new(size: FrameSize) -> Self {
        let FrameSize { nodes, fields, .. } = size;
        let vectors = |on: bool| vec![[0.0; 3]; if on { nodes } else { 0 }];
        let springs = size.springs();
        Self {
            time: 0.0,
            credible: true,
            positions: vectors(true),
            velocities: vectors(true),
            force: vectors(fields.force),
            reaction: vectors(fields.reaction),
            tension: vec![0.0; springs],
            strain: vec![0.0; springs],
            rest_length: vec![0.0; size.lengths()],
            pressure: vec![0.0; size.faces()],
            membrane: vec![MembranePicture::default(); size.membranes()],
            crossing: vec![0; size.flags()],
        }
    }

    /// Whether all positions and velocities are finite.
    pub fn is_finite(&self) -> bool {
        [&self.positions, &self.velocities].into_iter().all(|v| all_finite(v.as_flattened()))
    }
}

/// Whether all numbers are finite. Exponents are compared as integers and without leaving early, so that the compiler
/// vectorises the loop.
fn all_finite(numbers: &[f64]) -> bool {
    const EXPONENT: u64 = f64::INFINITY.to_bits();
    const SMALLEST: u64 = f64::MIN_POSITIVE.to_bits();
    const SIGN: u64 = 1 << 63;
    // Only the largest exponent overflows into the sign.
    numbers.iter().fold(0, |seen, c| seen | ((c.to_bits() & EXPONENT) + SMALLEST)) & SIGN == 0
}

/// Kinds of cells, as the array `kind` of a frame has them.
const TRIANGLE: u8 = 0;
/// An edge that is a side of a triangle.
pub const SIDE: u8 = 1;
/// A line, or a node of a scene without cells.
const OTHER: u8 = 2;

/// The edges of every triangle, to average edge values over them.
#[derive(Clone, Debug, Default)]
pub struct CellMap {
    /// indices into the edges; `None` for a side that is not an edge
    sides: Vec<[Option<u32>; 3]>,
    cells: usize,
}

impl CellMap {
    /// For each cell 0 for a triangle, 1 for an edge that is a side of one, 2 for any other cell. `None` without
    /// triangles, where there is nothing to tell apart.
    pub fn kinds(&self) -> Option<Vec<u8>> {
        let mut kinds = vec![OTHER; self.cells];
        kinds.get_mut(..self.sides.len())?.fill(TRIANGLE);
        for edge in self.sides.iter().flatten().flatten() {
            *kinds.get_mut(self.sides.len() + *edge as usize)? = SIDE;
        }
        (!self.sides.is_empty()).then_some(kinds)
    }

    /// Cell values of triangle values; an edge shows 0.
    pub fn of_triangles<T: Copy + Default>(&self, triangles: &[T], out: &mut Vec<T>) {
        out.clear();
        out.extend_from_slice(triangles);
        out.resize(self.cells, T::default());
    }

    /// Finds the edges of every triangle; `cells` is the number of cells a frame shows.
    pub fn new(triangles: &[[u32; 3]], edges: &[[u32; 2]], cells: usize) -> Self {
        let nodes = edges.as_flattened().iter().max().map_or(0, |most| *most as usize + 1);
        let by_smaller = Adjacency::new(nodes, (0..).zip(edges).map(|(i, &[a, b])| (a.min(b), i)));
        let find = |a: u32, b: u32| {
            let row = if (a.min(b) as usize) < nodes { by_smaller.row(a.min(b)) } else { &[] };
            // The first of those that are listed twice.
            row.iter().copied().find(|edge| [[a, b], [b, a]].contains(&edges[*edge as usize]))
        };
        let sides = triangles.iter().map(|&[a, b, c]| [find(a, b), find(b, c), find(c, a)]).collect();
        Self { sides, cells }
    }

    /// Cell values of the lengths of edges: an edge shows its own, and -1 where it is NaN, as all other cells do.
    pub fn of_edges(&self, edges: &[f64], out: &mut Vec<f64>) {
        out.clear();
        out.resize(self.sides.len(), -1.0);
        out.extend(edges.iter().map(|length| if length.is_nan() { -1.0 } else { *length }));
        out.resize(self.cells, -1.0);
    }

    /// Cell values of edge values: an edge shows its own; a triangle the mean over those of its edges that carry
    /// a spring. Where there is no spring the value is NaN in `edges` and becomes 0, as NaN has no colour.
    pub fn spread(&self, edges: &[f64], out: &mut Vec<f64>) {
        out.clear();
        let spring = |value: &f64| value.is_finite();
        for sides in &self.sides {
            let values = sides.iter().flatten().filter_map(|&i| edges.get(i as usize).copied()).filter(spring);
            let (sum, count) = values.fold((0.0, 0u32), |(sum, count), value| (sum + value, count + 1));
            out.push(if count == 0 { 0.0 } else { sum / f64::from(count) });
        }
        out.extend(edges.iter().map(|v| if spring(v) { *v } else { 0.0 }));
        // A scene without triangles and edges has vertex cells.
        out.resize(self.cells, 0.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_number_that_is_not_finite_is_found() {
        let size = FrameSize { nodes: 5, ..FrameSize::default() };
        for number in [0.0, -0.0, 5e-324, f64::MIN_POSITIVE, 1.0, -1.0, f64::MAX, f64::MIN] {
            for place in 0..15 {
                let mut frame = Frame::new(size);
                frame.velocities.as_flattened_mut()[place] = number;
                assert!(frame.is_finite(), "{number} in {place}");
                for bad in [f64::NAN, -f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                    frame.positions.as_flattened_mut()[14 - place] = bad;
                    assert!(!frame.is_finite(), "{bad} in {place}");
                }
            }
        }
    }

    /// A triangle averages its springs, skips sides without one, and shows 0 where it has none.
    #[test]
    fn triangles_average_their_springs() {
        let map = CellMap::new(&[[0, 1, 2], [1, 3, 2], [4, 5, 6]], &[[1, 0], [2, 1], [0, 2], [1, 3]], 7);
        let mut out = Vec::new();
        map.spread(&[3.0, f64::NAN, 5.0, 8.0], &mut out);
        assert_eq!(out, [4.0, 8.0, 0.0, 3.0, 0.0, 5.0, 8.0]);
    }
}
