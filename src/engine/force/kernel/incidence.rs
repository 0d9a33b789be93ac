//! Which elements meet at a node of a block.

use crate::force::kernel::local_buffer::RECORD;

/// The elements at every node, node after node in one list.
pub(in crate::force) struct Incidence {
    /// by node: where its own begin
    first: Vec<usize>,
    elements: Vec<usize>,
}

impl Incidence {
    /// Of elements by where the records of their nodes begin. One that has a node twice is there twice.
    pub(crate) fn new<const N: usize>(elements: &[[u16; N]]) -> Self {
        let places = elements.as_flattened();
        let nodes = places.iter().max().map_or(0, |&last| number(last) + 1);
        let mut first = vec![0; nodes + 1];
        places.iter().for_each(|&place| first[number(place) + 1] += 1);
        (0..nodes).for_each(|node| first[node + 1] += first[node]);
        let (mut list, mut next) = (vec![0; places.len()], first.clone());
        for (i, &place) in places.iter().enumerate() {
            let next = &mut next[number(place)];
            list[*next] = i / N;
            *next += 1;
        }
        Incidence { first, elements: list }
    }

    /// Where the records of all nodes begin, up to the last that has an element.
    pub(crate) fn places(&self) -> impl Iterator<Item = u16> {
        (0..self.first.len() - 1).map(|node| (RECORD * node) as u16)
    }

    /// Numbers of the elements at a node, ascending.
    pub(crate) fn at(&self, place: u16) -> &[usize] {
        let node = number(place);
        &self.elements[self.first[node]..self.first[node + 1]]
    }
}

fn number(place: u16) -> usize {
    usize::from(place) / RECORD
}
