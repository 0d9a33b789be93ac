//! Points, lines and faces, which all formats have. `assemble` makes the mesh of them.

use super::MOST_MEMBERS;
use crate::group::LONGEST_NAME;
use std::collections::{BTreeMap, HashMap};

/// A closed outline of a drawing.
#[derive(Clone, Debug)]
pub(super) struct Outline {
    pub points: Vec<u64>,
    /// number of its groups
    pub number: i64,
}

/// Points and cells of a file.
#[derive(Clone, Debug, Default)]
pub(super) struct Cells {
    pub points: Vec<[f64; 3]>,
    pub(super) lines: Vec<[u64; 2]>,
    /// for each line, whether it is on a seam
    pub(super) seam: Vec<bool>,
    /// corners of all faces, one face after the other
    corners: Vec<u64>,
    /// where the corners of each face end
    ends: Vec<usize>,
    /// closed outlines, to be filled or to become lines
    pub(super) outlines: Vec<Outline>,
    /// what the reader left out or changed: how often, and a sentence without its number
    pub remarks: BTreeMap<&'static str, usize>,
    /// members of groups of points, counted as they are named
    members: u64,
    /// the unit of lengths that the file's header tells: its name and [m]
    pub unit: Option<(&'static str, f64)>,
    /// whether the format has its y axis up
    pub y_is_up: bool,
    /// sentences about what the reader left out or changed
    pub notes: Vec<String>,
    /// number of the groups of each point, line and face; a list may end early: 0 = in no group
    pub(super) numbers: Numbers,
    /// for each such number, the names of its groups; of lines and faces, and of points
    pub cell_groups: BTreeMap<i64, Vec<String>>,
    /// number of each set of groups that [`Cells::name_cells`] was given
    numbers_of: HashMap<Vec<String>, i64>,
    /// the latest of them
    latest: (Vec<String>, i64),
    pub point_groups: BTreeMap<i64, Vec<String>>,
    /// points in groups by the name of the group, beside those with numbers
    pub named_points: BTreeMap<String, Vec<u64>>,
    /// whether a face that is listed again means that it is in several groups
    pub repeats_faces: bool,
    /// [-] distance, as a share of the mesh's extent, within which the format itself does not tell points apart
    pub resolution: Option<f64>,
    /// [m] displacement of each point at the start; empty = none
    pub displacement: Vec<[f64; 3]>,
}

/// Numbers of groups.
#[derive(Clone, Debug, Default)]
pub(super) struct Numbers {
    pub points: Vec<i64>,
    pub lines: Vec<i64>,
    pub faces: Vec<i64>,
}

impl Cells {
    /// Cells of a format that gives every face corners of its own, mostly in single precision: what its rounding
    /// divided is joined.
    pub(super) fn of_corners() -> Self {
        Cells { resolution: Some(RESOLUTION), ..Self::default() }
    }

    /// Adds a line through two or more nodes.
    pub(super) fn add_line(&mut self, nodes: &[u64], seam: bool) {
        for pair in nodes.windows(2) {
            self.lines.push([pair[0], pair[1]]);
            self.seam.push(seam);
        }
    }

    /// Adds a face with its corners in order around it.
    pub(super) fn add_face(&mut self, corners: &[u64]) {
        self.corners.extend_from_slice(corners);
        self.ends.push(self.corners.len());
    }

    /// Adds faces with their corners in order around them, face after face, and where those of each end.
    pub(super) fn add_faces(&mut self, mut corners: Vec<u64>, mut ends: Vec<usize>) {
        corners.truncate(ends.last().copied().unwrap_or(0));
        if self.ends.is_empty() {
            (self.corners, self.ends) = (corners, ends);
        } else {
            let first = self.corners.len();
            ends.iter_mut().for_each(|end| *end += first);
            self.corners.append(&mut corners);
            self.ends.append(&mut ends);
        }
    }

    /// Adds a strip of triangles, of which every second one turns the other way.
    pub(super) fn add_strip(&mut self, nodes: &[u64]) {
        for (i, t) in nodes.windows(3).enumerate() {
            self.add_face(&if i % 2 == 0 { [t[0], t[1], t[2]] } else { [t[1], t[0], t[2]] });
        }
    }

    /// Adds the cells of another file; groups of the same name become one.
    pub(super) fn append(&mut self, other: Cells) {
        let first = self.points.len() as u64;
        // A file without numbers or displacements has them as if they were 0.
        self.number_points([]);
        self.number_cells(0);
        let displaced = !(self.displacement.is_empty() && other.displacement.is_empty());
        let count = self.points.len() + other.points.len();
        let shift = |numbers: &BTreeMap<i64, Vec<String>>| numbers.keys().last().copied().unwrap_or(0).max(0);
        let (cells, points) = (shift(&self.cell_groups), shift(&self.point_groups));
        let moved = |number: i64, by: i64| if number == 0 { 0 } else { number.saturating_add(by) };
        if displaced {
            self.displacement.resize(self.points.len(), [0.0; 3]);
            self.displacement.extend(&other.displacement);
            self.displacement.resize(count, [0.0; 3]);
        }
        for (line, seam) in other.lines.iter().zip(&other.seam) {
            self.add_line(&line.map(|node| first.saturating_add(node)), *seam);
        }
        for face in other.faces() {
            let corners: Vec<u64> = face.iter().map(|node| first.saturating_add(*node)).collect();
            self.add_face(&corners);
        }
        for Outline { points, number } in other.outlines {
            let points = points.iter().map(|point| first.saturating_add(*point)).collect();
            self.outlines.push(Outline { points, number: moved(number, cells) });
        }
        self.numbers.lines.extend(other.numbers.lines.iter().map(|n| moved(*n, cells)));
        self.numbers.faces.extend(other.numbers.faces.iter().map(|n| moved(*n, cells)));
        self.numbers.points.extend(other.numbers.points.iter().map(|n| moved(*n, points)));
        self.points.extend(&other.points);
        self.number_points([]);
        self.number_cells(0);
        self.cell_groups.extend(other.cell_groups.into_iter().map(|(n, names)| (moved(n, cells), names)));
        self.point_groups.extend(other.point_groups.into_iter().map(|(n, names)| (moved(n, points), names)));
        for (name, points) in other.named_points {
            self.named_points.entry(name).or_default().extend(points.iter().map(|point| first.saturating_add(*point)));
        }
        for (what, count) in other.remarks {
            *self.remarks.entry(what).or_default() += count;
        }
        self.members += other.members;
        self.notes.extend(other.notes);
        self.repeats_faces |= other.repeats_faces;
        self.resolution = self.resolution.into_iter().chain(other.resolution).reduce(f64::max);
    }

    /// The corners of all faces.
    pub(super) fn faces(&self) -> impl ExactSizeIterator<Item = &[u64]> {
        let start = |face: usize| if face == 0 { 0 } else { self.ends[face - 1] };
        self.ends.iter().enumerate().map(move |(face, end)| &self.corners[start(face)..*end])
    }

    /// The points that lines and faces name.
    pub(super) fn used_points(&self) -> impl Iterator<Item = u64> {
        self.lines.as_flattened().iter().chain(&self.corners).copied()
    }

    /// Drops the points that do not stay; no line, face or outline uses these.
    pub(super) fn keep_points(&mut self, stays: &[bool]) {
        let number: Vec<u64> =
            stays.iter().scan(0, |next, stays| Some(std::mem::replace(next, *next + u64::from(*stays)))).collect();
        let stay = |point: u64| stays.get(point as usize).copied().unwrap_or(true);
        fn keep<T>(list: &mut Vec<T>, stay: impl Fn(u64) -> bool) {
            let mut point = 0..;
            list.retain(|_| point.next().is_some_and(&stay));
        }
        keep(&mut self.points, stay);
        keep(&mut self.displacement, stay);
        keep(&mut self.numbers.points, stay);
        let of_outlines = self.outlines.iter_mut().flat_map(|outline| &mut outline.points);
        let of_groups = self.named_points.values_mut().flat_map(|points| {
            points.retain(|point| stay(*point));
            points
        });
        let of_cells = self.lines.as_flattened_mut().iter_mut().chain(&mut self.corners);
        of_cells.chain(of_outlines).chain(of_groups).for_each(|point| *point = number[*point as usize]);
    }

    /// Checks that lines and faces name points that are there.
    pub(super) fn check_points(&self) -> Result<(), String> {
        let count = self.points.len();
        match self.used_points().find(|point| *point >= count as u64) {
            Some(node) => Err(format!("a cell names node {node}, but there are {count} nodes")),
            None => Ok(()),
        }
    }

    /// Counts something that the reader left out or changed; `what` is a sentence without its number.
    pub(super) fn remark(&mut self, what: &'static str) {
        *self.remarks.entry(what).or_default() += 1;
    }

    /// Gives the lines and faces that were added since the last call a number of groups.
    pub(super) fn number_cells(&mut self, number: i64) {
        self.numbers.lines.resize(self.lines.len(), number);
        self.numbers.faces.resize(self.ends.len(), number);
    }

    /// Gives the faces that were added since the last call a number of groups each; missing ones are 0.
    pub(super) fn number_faces(&mut self, mut numbers: Vec<i64>) {
        if !numbers.is_empty() {
            self.numbers.faces.append(&mut numbers);
            self.number_cells(0);
        }
    }

    /// Puts the lines and faces that were added since the last call into groups.
    pub(super) fn name_cells(&mut self, names: &[String]) {
        let number = self.number_of(names);
        self.number_cells(number);
    }

    /// Adds a closed outline that is in these groups.
    pub(super) fn add_outline(&mut self, points: Vec<u64>, names: &[String]) {
        let number = self.number_of(names);
        self.outlines.push(Outline { points, number });
    }

    /// The number of a set of groups.
    pub(super) fn number_of(&mut self, names: &[String]) -> i64 {
        if names.is_empty() {
            return 0;
        }
        // Neighbours in a file are mostly in the same groups.
        if self.latest.0 == names {
            return self.latest.1;
        }
        let next = self.numbers_of.len() as i64 + 1;
        let number = self.numbers_of.get(names).copied().unwrap_or(next);
        if number == next {
            self.numbers_of.insert(names.to_vec(), number);
            self.cell_groups.insert(number, names.to_vec());
        }
        self.latest = (names.to_vec(), number);
        number
    }

    /// Puts a point into groups.
    pub(super) fn name_point(&mut self, names: &[String], point: u64) {
        self.members += names.len() as u64;
        // Too many are refused at the end.
        let most = MOST_MEMBERS + 4 * self.points.len() as u64;
        for name in names.iter().filter(|_| self.members <= most) {
            match self.named_points.get_mut(name) {
                Some(points) => points.push(point),
                None => drop(self.named_points.insert(name.clone(), vec![point])),
            }
        }
    }

    /// Refuses groups with far more members than there are cells.
    pub(super) fn check_members(&self) -> Result<(), String> {
        let of = |names: &BTreeMap<i64, Vec<String>>, numbers: &[i64]| -> u64 {
            let alike = numbers.chunk_by(|a, b| a == b).filter(|alike| alike[0] != 0);
            alike.map(|alike| (alike.len() * names.get(&alike[0]).map_or(0, Vec::len)) as u64).sum()
        };
        let cells = of(&self.cell_groups, &self.numbers.lines) + of(&self.cell_groups, &self.numbers.faces);
        let members = self.members + cells + of(&self.point_groups, &self.numbers.points);
        let most = MOST_MEMBERS + 4 * (self.lines.len() + self.ends.len() + self.points.len()) as u64;
        if members > most { Err(format!("has groups of {members} members, more than {most}")) } else { Ok(()) }
    }

    /// Makes names that groups can have of those in the file.
    pub(super) fn clean_names(&mut self, notes: &mut Vec<String>) {
        let mut changed: Option<(String, String)> = None;
        let mut clean = |name: &mut String| {
            let plain = clean_name(name);
            if plain != *name {
                changed.get_or_insert_with(|| (name.chars().take(60).collect(), plain.chars().take(60).collect()));
                *name = plain;
            }
        };
        self.cell_groups.values_mut().chain(self.point_groups.values_mut()).flatten().for_each(&mut clean);
        for (mut name, mut points) in std::mem::take(&mut self.named_points) {
            clean(&mut name);
            self.named_points.entry(name).or_default().append(&mut points);
        }
        if let Some((old, new)) = changed {
            notes.push(format!(
                "names of groups were changed: {old:?} is called \"{new}\"; a name has 1 to {LONGEST_NAME} characters, \
                 without control characters, or blanks at its ends"
            ));
        }
    }

    /// Gives the points that were added since the last call their numbers of groups; missing ones are 0.
    pub(super) fn number_points(&mut self, numbers: impl IntoIterator<Item = i64>) {
        self.numbers.points.extend(numbers);
        self.numbers.points.resize(self.points.len(), 0);
    }
}

/// A name that a group can have.
fn clean_name(name: &str) -> String {
    let plain: String = name.chars().map(|c| if c.is_control() { ' ' } else { c }).take(LONGEST_NAME).collect();
    if plain.trim().is_empty() { "unnamed".to_owned() } else { plain.trim().to_owned() }
}

/// [-] Share of the extent within which corners are one node. Programs that compute in single precision leave some
/// units of its seventh digit between them.
pub(super) const RESOLUTION: f64 = 1e-5;

/// Cells that have no meaning for a network.
pub(super) const IGNORED: &str = "cells that are neither lines nor faces were ignored";
