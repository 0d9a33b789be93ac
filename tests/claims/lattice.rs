//! Equilateral nets, whose continuum is known: springs of axial rigidity EA = (sqrt 3/2) E t a on all edges of length a
//! are a sheet of modulus E, thickness t and Poisson ratio 1/3; a force T in all of them is the tension N = sqrt 3 T/a.
//! A node stands for the area (sqrt 3/2) a^2.
//!
//! A disc is cut out exactly: where a lattice edge leaves it, a node is pinned on the circle and the edge keeps its EA
//! (and its T). A uniform strain stays in equilibrium next to such an edge, so that only the second differences of the
//! outermost nodes are off; that costs order h^2, as in Shortley and Weller's scheme, where a trimmed lattice costs
//! order h.

use std::collections::HashMap;

/// An equilateral net.
#[derive(Clone, Debug, Default)]
pub struct Lattice {
    /// [m] edge
    pub edge: f64,
    pub nodes: Vec<[f64; 3]>,
    pub springs: Vec<[u32; 2]>,
    /// whole lattice triangles, counter-clockwise
    pub triangles: Vec<[u32; 3]>,
    /// nodes on the boundary
    pub pinned: Vec<u32>,
}

/// The six lattice neighbours, counter-clockwise, in lattice coordinates (i, j): position a (i + j/2, j sqrt 3/2).
const AROUND: [(i32, i32); 6] = [(1, 0), (0, 1), (-1, 1), (-1, 0), (0, -1), (1, -1)];

fn position(edge: f64, (i, j): (i32, i32)) -> [f64; 3] {
    [edge * (f64::from(i) + 0.5 * f64::from(j)), edge * f64::from(j) * 0.75_f64.sqrt(), 0.0]
}

fn radius(p: [f64; 3]) -> f64 {
    p[0].hypot(p[1])
}

impl Lattice {
    /// [m^2] the area that a node stands for
    pub fn cell(&self) -> f64 {
        0.75_f64.sqrt() * self.edge * self.edge
    }

    /// An equilateral triangle of side 1 with `n` edges a side.
    pub fn triangle(n: u16) -> Self {
        let (n, mut net) = (i32::from(n), Lattice { edge: 1.0 / f64::from(n), ..Lattice::default() });
        let places: Vec<(i32, i32)> = (0..=n).flat_map(|j| (0..=n - j).map(move |i| (i, j))).collect();
        let number = net.place(&places);
        net.pinned = places.iter().filter(|(i, j)| *i == 0 || *j == 0 || i + j == n).map(|p| number[p]).collect();
        net.join(&places, &number);
        net
    }

    /// A disc of radius 1 around a node, with edges of 1/`n`, cut along the circle.
    pub fn disc(n: u16) -> Self {
        let mut net = Lattice { edge: 1.0 / f64::from(n), ..Lattice::default() };
        // A node that the rounding of its position decides about belongs to the circle.
        let inside = |p| radius(position(net.edge, p)) < 1.0 - 1e-9;
        let span = 2 * i32::from(n);
        let all = (-span..=span).flat_map(|j| (-span..=span).map(move |i| (i, j)));
        let places: Vec<(i32, i32)> = all.filter(|&p| inside(p)).collect();
        let number = net.place(&places);
        net.join(&places, &number);
        for &(i, j) in &places {
            for (di, dj) in AROUND {
                if !number.contains_key(&(i + di, j + dj)) {
                    net.cut(number[&(i, j)], position(net.edge, (di, dj)));
                }
            }
        }
        net
    }

    fn place(&mut self, places: &[(i32, i32)]) -> HashMap<(i32, i32), u32> {
        self.nodes = places.iter().map(|&p| position(self.edge, p)).collect();
        places.iter().copied().zip(0..).collect()
    }

    /// Springs and triangles between the placed nodes.
    fn join(&mut self, places: &[(i32, i32)], number: &HashMap<(i32, i32), u32>) {
        for &(i, j) in places {
            let at = |k: usize| number.get(&(i + AROUND[k].0, j + AROUND[k].1)).copied();
            let here = number[&(i, j)];
            self.springs.extend((0..3).filter_map(at).map(|there| [here, there]));
            // The triangles above and below the edge to the right.
            self.triangles.extend(at(0).zip(at(1)).map(|(right, above)| [here, right, above]));
            self.triangles.extend(at(5).zip(at(0)).map(|(below, right)| [here, below, right]));
        }
    }

    /// A spring from an inner node along `step` to the circle, where it is pinned.
    fn cut(&mut self, from: u32, step: [f64; 3]) {
        let p = self.nodes[from as usize];
        let (along, square) = (p[0] * step[0] + p[1] * step[1], step[0] * step[0] + step[1] * step[1]);
        // |p + s step| = 1
        let s = ((along * along + square * (1.0 - radius(p).powi(2))).sqrt() - along) / square;
        self.springs.push([from, self.nodes.len() as u32]);
        self.pinned.push(self.nodes.len() as u32);
        self.nodes.push([p[0] + s * step[0], p[1] + s * step[1], 0.0]);
    }

    /// How many of the six triangles around every node are there.
    pub fn triangles_around(&self) -> Vec<usize> {
        let mut count = vec![0; self.nodes.len()];
        self.triangles.as_flattened().iter().for_each(|&n| count[n as usize] += 1);
        count
    }
}
