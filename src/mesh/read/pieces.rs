//! Outlines that are to be sewn: finds their sides, cuts seam allowances off, and divides both sides of a seam alike.

use super::cells::{Cells, Outline};
use super::divide::{divide, divide_alike};
use super::fill::Sheet;
use super::offset::inset;
use super::piece::{CORNER, GoreSides, Piece, Run, Span};
use crate::MeshFile;
use crate::format_number::counted;
use crate::sew::{Seam, SewError, Sewing};
use nalgebra::Vector3;
use std::collections::{BTreeMap, BTreeSet};

/// [-] Room between copies of an outline over its width.
const ROOM: f64 = 0.1;

/// [-] Area of a hole over that of its gore above which both are outlines of one gore.
const MOST_HOLE: f64 = 0.5;

/// A line that names a side: its number, the piece, and from where to where it runs [m].
type Drawn = (usize, usize, [f64; 2]);

impl Cells {
    /// Prepares the outlines for being sewn. Their sides become lines in groups, by which they are found in the mesh.
    ///
    /// # Errors
    /// Sides that are not there, allowances that are too wide, gores that are none.
    pub(super) fn lay_out(&mut self, wanted: &MeshFile) -> Result<Sewing, SewError> {
        self.number_cells(0);
        let seams = &wanted.sew;
        let mut sewing = Sewing::default();
        for (rule, seam) in seams.iter().enumerate() {
            sewing.sides.extend(seam.edges.clone().map(|sides| (sides, rule)));
        }
        let Some(edge) = wanted.edge else {
            let drawn = !self.outlines.is_empty() || seams.iter().any(|seam| seam.gores.is_some());
            return if drawn { Err(SewError::Unfilled) } else { Ok(sewing) };
        };
        let (mut pieces, rest, mut drawn) = self.pieces();
        let used = self.name_by_lines(seams, &mut pieces)?;
        for seam in seams {
            match (&seam.edges, &seam.gores) {
                (Some(sides), _) => self.number_sides(sides, seam, &mut pieces)?,
                (None, Some(layers)) => self.gores(layers, seam, &mut pieces, &mut sewing)?,
                (None, None) => {}
            }
        }
        for piece in &mut pieces {
            check_overlap(piece)?;
            cut_allowances(piece)?;
        }
        divide_alike(&mut pieces, seams, &sewing, edge);
        self.outlines = rest;
        drawn.extend(self.lines.iter().zip(&used).filter(|(_, used)| **used).flat_map(|(line, _)| *line));
        self.drop_lines(&used);
        self.drop_points(drawn);
        for piece in &pieces {
            self.draw(piece, edge);
        }
        Ok(sewing)
    }

    /// The outlines with an area, the others, and the points that are drawn for the former.
    fn pieces(&mut self) -> (Vec<Piece>, Vec<Outline>, Vec<u64>) {
        let distance = self.resolution.unwrap_or(0.0) * super::extent(&self.points);
        let (mut pieces, mut rest, mut drawn) = (Vec::new(), Vec::new(), Vec::new());
        for outline in std::mem::take(&mut self.outlines) {
            match Sheet::of(&outline, &self.points, distance) {
                Some(sheet) => {
                    drawn.extend(&outline.points);
                    let layers = self.cell_groups.get(&sheet.number).cloned().unwrap_or_default();
                    let places = sheet.points.iter().map(|point| Vector3::from(self.points[*point as usize]));
                    pieces.push(Piece::of(&sheet, layers, places));
                }
                None => rest.push(outline),
            }
        }
        (pieces, rest, drawn)
    }

    /// Makes sides of open lines that run along outlines; returns whether each line was used.
    fn name_by_lines(&self, seams: &[Seam], pieces: &mut [Piece]) -> Result<Vec<bool>, SewError> {
        let mut used = vec![false; self.lines.len()];
        let mut by_name: BTreeMap<&String, Vec<usize>> = BTreeMap::new();
        for (line, number) in self.numbers.lines.iter().enumerate() {
            for name in self.cell_groups.get(number).into_iter().flatten() {
                by_name.entry(name).or_default().push(line);
            }
        }
        let allowance = |name: &String| {
            let seam = seams.iter().find(|seam| seam.edges.as_ref().is_some_and(|sides| sides.contains(name)));
            seam.map(|seam| seam.allowance)
        };
        let place = |point: u64| Vector3::from(self.points[point as usize]);
        // Sides of seams come first; a part of them gets no other name.
        let (sewn, others): (Vec<_>, Vec<_>) = by_name.into_iter().partition(|(name, _)| allowance(name).is_some());
        for (name, lines) in sewn.into_iter().chain(others) {
            let on = |line: usize| -> Option<Drawn> {
                let ends = self.lines[line].map(place);
                let mut found = pieces.iter().enumerate().filter_map(|(p, piece)| Some((line, p, piece.along(ends)?)));
                found.next()
            };
            let found: Option<Vec<Drawn>> = lines.iter().map(|line| on(*line)).collect();
            let wanted = allowance(name);
            let off = |why: &str| SewError::OffOutline { name: name.clone(), why: why.to_owned() };
            let Some(found) = found else {
                match wanted.filter(|_| !pieces.is_empty()) {
                    Some(_) => return Err(off("but off it")),
                    None => continue,
                }
            };
            let mut by_piece: BTreeMap<usize, Vec<[f64; 2]>> = BTreeMap::new();
            found.iter().for_each(|(_, piece, ends)| by_piece.entry(*piece).or_default().push(*ends));
            for (p, lines) in by_piece {
                let piece = &mut pieces[p];
                let chain = match (piece.chain(lines), wanted) {
                    (Ok(chain), _) => chain,
                    (Err(count), Some(_)) => return Err(off(&format!("but in {count}, or all around it"))),
                    (Err(_), None) => continue,
                };
                let before = piece.clone();
                let ends = piece.mark(&chain);
                let span = Span {
                    name: name.clone(),
                    from: ends[0],
                    to: ends[1],
                    allowance: wanted.unwrap_or(0.0),
                    parts: Vec::new(),
                };
                piece.spans.push(span);
                match (check_overlap(piece), wanted) {
                    (Err(error), Some(_)) => return Err(error),
                    (Err(_), None) => *piece = before,
                    (Ok(()), _) => found.iter().filter(|drawn| drawn.1 == p).for_each(|drawn| used[drawn.0] = true),
                }
            }
        }
        Ok(used)
    }

    /// Finds the sides that are named by a layer and a number.
    fn number_sides(&self, names: &[String; 2], seam: &Seam, pieces: &mut [Piece]) -> Result<(), SewError> {
        for name in names {
            let known = pieces.iter().any(|piece| piece.spans.iter().any(|span| span.name == *name));
            let in_file = self.cell_groups.values().flatten().any(|group| group == name);
            if known || pieces.is_empty() {
                continue;
            }
            let numbered = name.rsplit_once('.').and_then(|(layer, k)| Some((layer, k.parse::<usize>().ok()?)));
            let found = numbered.and_then(|(layer, k)| {
                let mut of_layer = (0..pieces.len()).filter(|p| pieces[*p].layers.iter().any(|one| one == layer));
                let (one, None) = (of_layer.next()?, of_layer.next()) else { return None };
                Some((one, *pieces[one].sides().get(k.checked_sub(1)?)?))
            });
            match found {
                Some((p, [from, to])) => {
                    let (name, allowance) = (name.clone(), seam.allowance);
                    pieces[p].spans.push(Span { name, from, to, allowance, parts: Vec::new() });
                }
                // Edges of faces in the file may have this name, but not those of an outline.
                None if in_file && !pieces.iter().any(|piece| piece.layers.contains(name)) => {}
                None => return Err(SewError::NoSide { name: name.clone(), known: known_sides(pieces) }),
            }
        }
        Ok(())
    }

    /// Finds the sides of gores, and copies them.
    fn gores(
        &mut self,
        layers: &[String],
        seam: &Seam,
        pieces: &mut Vec<Piece>,
        sewing: &mut Sewing,
    ) -> Result<(), SewError> {
        let mut drawn = Vec::new();
        let mut known: BTreeSet<usize> = BTreeSet::new();
        for layer in layers {
            let on_layer = |p: &usize| pieces[*p].layers.contains(layer);
            let all: Vec<usize> = (0..pieces.len()).filter(on_layer).collect();
            // Outlines in others are holes.
            let outer = |p: &&usize| !all.iter().any(|other| other != *p && pieces[*other].holds(&pieces[**p]));
            let gores: Vec<usize> = all.iter().filter(outer).copied().collect();
            if gores.is_empty() {
                let names: BTreeSet<&String> = pieces.iter().flat_map(|piece| &piece.layers).collect();
                let names: Vec<&str> = names.into_iter().map(String::as_str).collect();
                let known = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
                return Err(SewError::NoOutline { name: layer.clone(), known });
            }
            for (number, &p) in gores.iter().enumerate() {
                let Some(GoreSides { seams: [up, down], others }) = pieces[p].gore_sides() else {
                    return Err(no_gore(layer, number + 1, &pieces[p]));
                };
                let inside = (0..pieces.len()).filter(|q| *q != p && pieces[p].holds(&pieces[*q]));
                for hole in inside.chain([p]) {
                    let share = pieces[hole].area() / pieces[p].area();
                    if hole != p && share > MOST_HOLE {
                        return Err(SewError::TwoOutlines { layer: layer.clone(), percent: 100.0 * share });
                    }
                    known.insert(hole);
                }
                drawn.push((layer, p, [up, down], others));
            }
        }
        self.leave_out(pieces, &known);
        // The pieces that stay keep their order.
        drawn.iter_mut().for_each(|(_, p, ..)| *p = known.range(..*p).count());
        let copies = seam.copies.unwrap_or(1);
        let count = drawn.len() * copies;
        if count < 3 {
            return Err(SewError::FewGores { found: count });
        }
        let name = |gore: usize, side: &str| {
            let (layer, ..) = &drawn[gore % count % drawn.len()];
            format!("gore {} of layer {layer}, {side}", gore % count + 1)
        };
        let mut next = None;
        for gore in 0..count {
            let (_, first, [up, down], others) = &drawn[gore % drawn.len()];
            let p = if gore < drawn.len() { *first } else { self.copy(*first, &mut next, pieces) };
            let side = |side: &str, [from, to]: [usize; 2], allowance: f64| Span {
                name: name(gore, side),
                from,
                to,
                allowance,
                parts: Vec::new(),
            };
            let mut spans = vec![side("right", *up, seam.allowance), side("left", *down, seam.allowance)];
            let hems = others.iter().enumerate().filter(|_| seam.hem > 0.0);
            spans.extend(hems.map(|(i, ends)| side(&format!("hem {i}"), *ends, seam.hem)));
            sewing.made.extend(spans.iter().map(|span| span.name.clone()));
            // Names that are drawn along the other sides stay.
            let named = std::mem::replace(&mut pieces[p].spans, spans);
            for span in named.into_iter().filter(|span| !sewing.made.contains(&span.name)) {
                pieces[p].spans.push(span);
                if check_overlap(&pieces[p]).is_err() {
                    pieces[p].spans.pop();
                }
            }
            sewing.sides.push(([name(gore, "right"), name(gore + 1, "left")], 0));
        }
        Ok(())
    }

    /// Leaves out pieces that no gore is, and that are no holes of gores.
    fn leave_out(&mut self, pieces: &mut Vec<Piece>, known: &BTreeSet<usize>) {
        let others: Vec<usize> = (0..pieces.len()).filter(|p| !known.contains(p)).collect();
        if others.is_empty() {
            return;
        }
        let layers: BTreeSet<&str> = others.iter().flat_map(|p| &pieces[*p].layers).map(String::as_str).collect();
        let layers = layers.into_iter().collect::<Vec<_>>().join(", ");
        let count = counted(others.len() as u64, "outline that is no gore was", "outlines that are no gores were");
        self.notes.push(format!("{count} left out, on layers: {layers}; name them in \"gores\" to sew them"));
        let mut p = 0..;
        pieces.retain(|_| p.next().is_some_and(|p| known.contains(&p)));
    }

    /// Copies an outline and what lies in it to where there is room; returns the number of the copy. `next` is the
    /// place of the next one [m].
    fn copy(&self, first: usize, next: &mut Option<f64>, pieces: &mut Vec<Piece>) -> usize {
        let axis = pieces[first].plane.axes[0];
        let along = |piece: &Piece| {
            let places = piece.points.iter().map(|p| axis.dot(&piece.plane.space(*p)));
            places.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
        };
        let [low, high] = along(&pieces[first]);
        let room = ROOM * (high - low);
        let right = |piece: &Piece| along(piece)[1];
        let of_points = self.points.iter().map(|p| axis.dot(&Vector3::from(*p)));
        let from = *next.get_or_insert_with(|| pieces.iter().map(right).chain(of_points).fold(high, f64::max));
        *next = Some(from + room + high - low);
        let shift = axis * (from + room - low);
        let inside: Vec<usize> =
            (0..pieces.len()).filter(|p| *p != first && pieces[first].holds(&pieces[*p])).collect();
        let number = pieces.len();
        for p in [first].into_iter().chain(inside) {
            let mut copy = pieces[p].clone();
            copy.plane.origin += shift;
            pieces.push(copy);
        }
        number
    }

    /// Drops lines that were used as names of sides.
    fn drop_lines(&mut self, used: &[bool]) {
        let stays = |line: usize| !used.get(line).copied().unwrap_or(false);
        fn keep<T>(list: &mut Vec<T>, stays: impl Fn(usize) -> bool) {
            let mut line = 0..;
            list.retain(|_| line.next().is_some_and(&stays));
        }
        keep(&mut self.lines, stays);
        keep(&mut self.seam, stays);
        keep(&mut self.numbers.lines, stays);
    }

    /// Drops points, but for those that a line or a face uses.
    fn drop_points(&mut self, drawn: Vec<u64>) {
        let mut stays = vec![true; self.points.len()];
        drawn.into_iter().for_each(|point| stays[point as usize] = false);
        self.used_points().for_each(|point| stays[point as usize] = true);
        self.outlines.iter().flat_map(|outline| &outline.points).for_each(|point| stays[*point as usize] = true);
        self.keep_points(&stays);
    }

    /// Adds a piece as an outline, and its sides as lines in groups.
    fn draw(&mut self, piece: &Piece, edge: f64) {
        if piece.spans.is_empty() {
            let points = piece.points.iter().map(|p| piece.plane.space(*p)).map(|p| self.new_point(p)).collect();
            self.outlines.push(Outline { points, number: piece.number });
            return;
        }
        let mut ends: Vec<usize> = piece.spans.iter().flat_map(|span| [span.from, span.to]).collect();
        ends.sort_unstable();
        ends.dedup();
        let mut outline = Vec::new();
        let mut starts = Vec::new();
        for (&from, &to) in ends.iter().zip(ends.iter().cycle().skip(1)) {
            let span = piece.spans.iter().find(|span| span.from == from);
            let alone = || divide(&piece.stops([from, to]), Run::of(piece.run([from, to])).length, edge);
            let parts = span.map(|span| span.parts.clone()).filter(|parts| !parts.is_empty()).unwrap_or_else(alone);
            starts.push((outline.len(), span));
            let run = Run::of(piece.run([from, to]));
            let places = parts[..parts.len() - 1].iter().map(|part| piece.plane.space(run.at(*part)));
            outline.extend(places.map(|place| self.new_point(place)));
        }
        let next = starts.iter().skip(1).map(|(start, _)| *start).chain([outline.len()]);
        for ((start, span), end) in starts.iter().zip(next) {
            if let Some(span) = span {
                let points: Vec<u64> = (*start..=end).map(|i| outline[i % outline.len()]).collect();
                self.add_line(&points, false);
                self.name_cells(std::slice::from_ref(&span.name));
            }
        }
        self.outlines.push(Outline { points: outline, number: piece.number });
    }

    fn new_point(&mut self, place: Vector3<f64>) -> u64 {
        self.points.push(place.into());
        self.points.len() as u64 - 1
    }
}

fn no_gore(layer: &str, outline: usize, piece: &Piece) -> SewError {
    let lengths: Vec<String> =
        piece.sides().iter().map(|side| format!("{:.4} m", Run::of(piece.run(*side)).length)).collect();
    let sides = if lengths.is_empty() { "no sides".to_owned() } else { format!("sides of {}", lengths.join(", ")) };
    SewError::NoGore { layer: layer.to_owned(), outline, corners: piece.corners().len(), least: CORNER, sides }
}

/// The sides that have a name, with their lengths.
fn known_sides(pieces: &[Piece]) -> String {
    let mut known = BTreeSet::new();
    for piece in pieces {
        known.extend(piece.spans.iter().map(|span| format!("\"{}\"", span.name)));
        for layer in &piece.layers {
            if pieces.iter().filter(|other| other.layers.contains(layer)).count() == 1 {
                let length = |side: &[usize; 2]| Run::of(piece.run(*side)).length;
                let sides = piece.sides().iter().enumerate().map(|(k, s)| (k + 1, length(s))).collect::<Vec<_>>();
                known.extend(sides.iter().map(|(k, length)| format!("\"{layer}.{k}\" of {length:.4} m")));
            }
        }
    }
    match known.is_empty() {
        true => "none: draw open lines along outlines, on layers with the names of the sides".to_owned(),
        false => known.into_iter().collect::<Vec<_>>().join(", "),
    }
}

/// A part of an outline is in one span.
fn check_overlap(piece: &Piece) -> Result<(), SewError> {
    let mut taken: Vec<Option<&str>> = vec![None; piece.points.len()];
    for span in &piece.spans {
        for segment in piece.segments([span.from, span.to]) {
            if let Some(first) = taken[segment].replace(&span.name) {
                return Err(SewError::Overlap { first: first.to_owned(), second: span.name.clone() });
            }
        }
    }
    Ok(())
}

fn cut_allowances(piece: &mut Piece) -> Result<(), SewError> {
    let mut widths = vec![0.0; piece.points.len()];
    let mut names: Vec<&Span> = Vec::new();
    for span in piece.spans.iter().filter(|span| span.allowance > 0.0) {
        piece.segments([span.from, span.to]).for_each(|segment| widths[segment] = span.allowance);
        names.push(span);
    }
    let Some(first) = names.first() else { return Ok(()) };
    let moved = inset(&piece.points, &widths).map_err(|(side, why)| {
        let at = piece.plane.space(piece.points[side]);
        let of = names.iter().find(|span| piece.segments([span.from, span.to]).any(|segment| segment == side));
        let Span { name, allowance, .. } = of.unwrap_or(first);
        SewError::Allowance { name: name.clone(), width: *allowance, x: at.x, y: at.y, why }
    })?;
    piece.points = moved;
    Ok(())
}
