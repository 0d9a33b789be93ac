//! A tree of axis-aligned boxes around numbered things in space, such as triangles: built once, refitted as they move.
//!
//! The tree is complete and binary, so it needs no pointers: the children of node i are 2 i + 1 and 2 i + 2, and all
//! leaves are equally deep. Building it takes O(n log n), a refit O(n). Pairs come in an order that depends on the
//! boxes alone.
//!
//! This crate is built for size, where closures over arrays stay calls: so what runs for every box has plain loops.

use std::ops::Range;

/// Largest number of things in a leaf.
const LEAF: usize = 4;

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// [m] lowest corner
    pub low: [f64; 3],
    /// [m] highest corner
    pub high: [f64; 3],
}

impl Bounds {
    /// Around nothing.
    pub const EMPTY: Bounds = Bounds { low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3] };

    /// Around points.
    pub fn of<'a>(points: impl IntoIterator<Item = &'a [f64; 3]>) -> Self {
        let mut all = Bounds::EMPTY;
        for x in points {
            all.include(x, x);
        }
        all
    }

    #[inline]
    fn include(&mut self, low: &[f64; 3], high: &[f64; 3]) {
        for k in 0..3 {
            self.low[k] = if low[k] < self.low[k] { low[k] } else { self.low[k] };
            self.high[k] = if high[k] > self.high[k] { high[k] } else { self.high[k] };
        }
    }

    /// Around two boxes.
    #[must_use]
    #[inline]
    pub fn joined(mut self, other: Bounds) -> Bounds {
        self.include(&other.low, &other.high);
        self
    }

    /// The box with `margin` [m] on all sides.
    #[must_use]
    #[inline]
    pub fn grown(mut self, margin: f64) -> Bounds {
        for k in 0..3 {
            self.low[k] -= margin;
            self.high[k] += margin;
        }
        self
    }

    /// Whether both have more than a face in common. Flat boxes that cross each other do; two in one plane do not.
    #[inline]
    pub fn overlaps(&self, other: &Bounds) -> bool {
        let along = |k: usize| (self.low[k] < other.high[k]) & (other.low[k] < self.high[k]);
        along(0) & along(1) & along(2)
    }

    /// Whether it lies in a plane across an axis.
    pub fn is_flat(&self) -> bool {
        !self.overlaps(self)
    }

    /// [m] Length of its longest side; 0 around nothing.
    pub fn extent(&self) -> f64 {
        self.low.iter().zip(&self.high).fold(0.0, |most: f64, (low, high)| most.max(high - low))
    }

    /// [m] Least distance between points of two boxes.
    pub fn distance(&self, other: &Bounds) -> f64 {
        let along = |k: usize| (other.low[k] - self.high[k]).max(self.low[k] - other.high[k]).max(0.0);
        along(0).hypot(along(1)).hypot(along(2))
    }

    /// Twice the centre.
    fn middle(&self, axis: usize) -> f64 {
        self.low[axis] + self.high[axis]
    }

    /// The axis along which it is longest.
    pub fn longest_axis(&self) -> usize {
        let along = [0, 1, 2].map(|k| self.high[k] - self.low[k]);
        (1..3).fold(0, |longest, k| if along[k] > along[longest] { k } else { longest })
    }
}

/// Twice the middle of a thing's box, and its number: side by side, so that sorting stays in the caches.
type Middle = ([f64; 3], u32);

/// A tree of boxes; see the [module](self).
#[derive(Clone, Debug)]
pub struct BoxTree {
    /// numbers of the things, leaf after leaf
    order: Vec<u32>,
    /// their boxes, in that order
    items: Vec<Bounds>,
    /// boxes of the nodes; the last ones are the leaves, a power of two
    nodes: Vec<Bounds>,
}

impl BoxTree {
    /// Around things with these boxes; fewer than 2^32.
    pub fn new(boxes: &[Bounds]) -> Self {
        Self::of(boxes.len(), |item| boxes[item as usize])
    }

    /// Around so many things, with the box of each.
    pub fn of(count: usize, bounds: impl Fn(u32) -> Bounds) -> Self {
        let leaves = count.div_ceil(LEAF).next_power_of_two();
        let nodes = vec![Bounds::EMPTY; 2 * leaves - 1];
        let mut tree = BoxTree { order: vec![0; count], items: vec![Bounds::EMPTY; count], nodes };
        let middle = |item: u32| {
            let around = bounds(item);
            ([around.middle(0), around.middle(1), around.middle(2)], item)
        };
        let mut middles: Vec<Middle> = (0..count as u32).map(middle).collect();
        tree.split(&mut middles, 0..leaves);
        tree.order.iter_mut().zip(middles).for_each(|(to, (_, item))| *to = item);
        tree.refit(bounds);
        tree
    }

    /// How many there are, a power of two.
    #[inline]
    fn leaves(&self) -> usize {
        self.nodes.len().div_ceil(2)
    }

    /// Places of the things of some leaves.
    #[inline]
    fn places(&self, leaves: Range<usize>) -> Range<usize> {
        let place = |leaf: usize| ((leaf as u64 * self.order.len() as u64) >> self.leaves().trailing_zeros()) as usize;
        place(leaves.start)..place(leaves.end)
    }

    /// Sorts the things of some leaves into them: halves along the longest axis of their middles, again and again.
    fn split(&self, middles: &mut [Middle], leaves: Range<usize>) {
        if leaves.len() < 2 {
            return;
        }
        let half = leaves.start + leaves.len() / 2;
        let (places, middle) = (self.places(leaves.clone()), self.places(half..half).start);
        let part = &mut middles[places.clone()];
        let axis = Bounds::of(part.iter().map(|(middle, _)| middle)).longest_axis();
        if (1..part.len()).contains(&(middle - places.start)) {
            part.select_nth_unstable_by(middle - places.start, |(x, a), (y, b)| {
                x[axis].total_cmp(&y[axis]).then(a.cmp(b))
            });
        }
        self.split(middles, leaves.start..half);
        self.split(middles, half..leaves.end);
    }

    /// Fits the boxes to things that have moved.
    pub fn refit(&mut self, bounds: impl Fn(u32) -> Bounds) {
        for (to, item) in self.items.iter_mut().zip(&self.order) {
            *to = bounds(*item);
        }
        self.join();
    }

    fn join(&mut self) {
        let leaves = self.leaves();
        for leaf in 0..leaves {
            let mut around = Bounds::EMPTY;
            for item in &self.items[self.places(leaf..leaf + 1)] {
                around.include(&item.low, &item.high);
            }
            self.nodes[leaves - 1 + leaf] = around;
        }
        for node in (0..leaves - 1).rev() {
            self.nodes[node] = self.nodes[2 * node + 1].joined(self.nodes[2 * node + 2]);
        }
    }

    /// The box around everything.
    pub fn bounds(&self) -> Bounds {
        self.nodes[0]
    }

    /// Calls `visit` for all pairs of things whose boxes overlap, each once. Ends early when `looks`, the number of
    /// pairs of boxes that may be compared, is used up; `visit` may take more of it for its own work.
    pub fn pairs(&self, looks: &mut u64, mut visit: impl FnMut(u32, u32, &mut u64)) {
        // A pair of nodes leaves at most three more in the stack than it takes, on each level.
        let mut stack = Vec::with_capacity(4 * 64);
        stack.push([0, 0]);
        while let Some([a, b]) = stack.pop() {
            if *looks == 0 {
                return;
            }
            if a + 1 >= self.leaves() {
                self.pairs_of_leaves([a, b], looks, &mut visit);
                continue;
            }
            let ([a0, a1], [b0, b1]) = ([2 * a + 1, 2 * a + 2], [2 * b + 1, 2 * b + 2]);
            let (pairs, count) = if a == b {
                ([[a1, b1], [a0, b1], [a0, b0], [0, 0]], 3)
            } else {
                ([[a1, b1], [a1, b0], [a0, b1], [a0, b0]], 4)
            };
            *looks = looks.saturating_sub(count as u64);
            for [a, b] in &pairs[..count] {
                if self.nodes[*a].overlaps(&self.nodes[*b]) {
                    stack.push([*a, *b]);
                }
            }
        }
    }

    fn pairs_of_leaves(&self, [a, b]: [usize; 2], looks: &mut u64, visit: &mut impl FnMut(u32, u32, &mut u64)) {
        let (first, second) = (a + 1 - self.leaves(), b + 1 - self.leaves());
        let (of_a, of_b) = (self.places(first..first + 1), self.places(second..second + 1));
        for i in of_a {
            let others = if a == b { i + 1..of_b.end } else { of_b.clone() };
            *looks = looks.saturating_sub(1 + others.len() as u64);
            if a != b && !self.items[i].overlaps(&self.nodes[b]) {
                continue;
            }
            for j in others {
                if self.items[i].overlaps(&self.items[j]) {
                    visit(self.order[i], self.order[j], looks);
                }
            }
        }
    }

    /// Calls `visit` for all things whose boxes overlap a box. Ends early when `looks`, the number of boxes that may be
    /// looked at, is used up.
    pub fn within(&self, bounds: &Bounds, looks: &mut u64, mut visit: impl FnMut(u32)) {
        // Each level leaves one node more, and there are at most 32.
        let (mut stack, mut waiting) = ([0; 64], 1);
        while waiting > 0 && *looks > 0 {
            waiting -= 1;
            let node: usize = stack[waiting];
            *looks -= 1;
            if !self.nodes[node].overlaps(bounds) {
                continue;
            }
            if node + 1 < self.leaves() {
                (stack[waiting], stack[waiting + 1]) = (2 * node + 2, 2 * node + 1);
                waiting += 2;
                continue;
            }
            let leaf = node + 1 - self.leaves();
            let places = self.places(leaf..leaf + 1);
            for i in places {
                if self.items[i].overlaps(bounds) {
                    visit(self.order[i]);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::SplitMix64;

    fn boxes(n: usize, random: &mut SplitMix64) -> Vec<Bounds> {
        let mut point = || [0; 3].map(|_| (4.0 * random.signed()).floor());
        let mut one = || Bounds::of(&[point(), point()]);
        (0..n).map(|_| one()).collect()
    }

    /// Pairs, and boxes within another, are those that a comparison of all with all finds, also after a refit.
    #[test]
    fn all_overlaps_are_found() {
        let mut random = SplitMix64::new(5, 0);
        for n in [0, 1, 2, 3, 4, 5, 8, 9, 17, 100, 257] {
            let first = boxes(n, &mut random);
            let mut tree = BoxTree::new(&first);
            for moved in [first, boxes(n, &mut random)] {
                tree.refit(|item| moved[item as usize]);
                let (mut found, mut looks) = (Vec::new(), u64::MAX);
                tree.pairs(&mut looks, |a, b, _| found.push([a.min(b) as usize, a.max(b) as usize]));
                found.sort_unstable();
                let all = (0..n).flat_map(|a| (a + 1..n).map(move |b| [a, b]));
                let right: Vec<[usize; 2]> = all.filter(|[a, b]| moved[*a].overlaps(&moved[*b])).collect();
                assert_eq!(found, right, "{n}");
                let place = Bounds { low: [-1.5; 3], high: [0.5; 3] };
                let mut inside = Vec::new();
                tree.within(&place, &mut u64::MAX.clone(), |item| inside.push(item as usize));
                inside.sort_unstable();
                let right: Vec<usize> = (0..n).filter(|i| moved[*i].overlaps(&place)).collect();
                assert_eq!(inside, right, "{n}");
            }
        }
    }

    /// However many boxes overlap, the work has a bound.
    #[test]
    fn work_ends_when_it_is_used_up() {
        let tree = BoxTree::new(&[Bounds { low: [0.0; 3], high: [1.0; 3] }; 1000]);
        let (mut looks, mut seen) = (2000, 0);
        tree.pairs(&mut looks, |_, _, _| seen += 1);
        assert!(looks == 0 && seen > 500 && seen < 3000, "{looks} left, {seen} pairs");
    }
}
