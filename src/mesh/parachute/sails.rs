//! What ribbons and sails have beside their rows: tapes between the radials, and cloth that is wider than the gore.

use super::assembly::Assembly;
use super::profile::Profile;
use super::{CanopyType, ParachuteParameters};
use crate::Mesh;
use std::collections::HashMap;

/// A node of a row: the row, the gore at whose beginning or inside which it is, and the part of the gore's width.
#[derive(Clone, Copy, Debug)]
struct Place {
    row: usize,
    gore: usize,
    part: f64,
}

impl Assembly {
    /// Names the tapes that cross the ribbons and the slots between them, `verticals` in each gore, evenly spaced
    /// there.
    pub(super) fn add_verticals(&mut self, p: &ParachuteParameters) {
        let strips = p.verticals.unwrap_or(0) + 1;
        let at = |row: &[u32], gore: usize, tape: usize| {
            let across = row.len() / p.gores;
            let place = tape * across;
            (across > 0 && place.is_multiple_of(strips)).then(|| row[gore * across + place / strips])
        };
        for (gore, tape) in (0..p.gores).flat_map(|gore| (1..strips).map(move |tape| (gore, tape))) {
            let ends =
                self.rows.windows(2).filter_map(|pair| Some([at(&pair[0], gore, tape)?, at(&pair[1], gore, tape)?]));
            self.edges.extend(ends.map(|pair| ("verticals", pair)));
        }
    }
}

/// [-] By row of a ringsail: by how much its cloth is wider than the gore. It grows along each sail from its upper edge
/// to its lower edge; the skirt's sail has none.
fn excess(p: &ParachuteParameters, profile: &Profile) -> Vec<f64> {
    let fullness = p.fullness.unwrap_or(0.0);
    let rings = profile.rows.chunk_by(|_, next| !next.after_gap);
    let count = p.rings.unwrap_or(1);
    let full = count.saturating_sub(p.sails.unwrap_or(0))..count.saturating_sub(1);
    let of_ring = |(ring, rows): (usize, &[_])| {
        let most = if full.contains(&ring) { fullness } else { 0.0 };
        let last = rows.len().saturating_sub(1).max(1) as f64;
        (0..rows.len()).map(move |i| most * i as f64 / last).collect::<Vec<_>>()
    };
    rings.enumerate().flat_map(of_ring).collect()
}

/// [m] Lengths of the edges of sails that are wider than their gore, as on the flat piece of cloth. At the seams with
/// the radials it is eased in, so edges along these are as long as on the mesh.
pub(super) fn full_lengths(p: &ParachuteParameters, mesh: &Mesh) -> Vec<(u32, f64)> {
    let Some(profile) = Profile::of(p).ok().filter(|_| p.kind == CanopyType::Ringsail) else { return Vec::new() };
    let excess = excess(p, &profile);
    // Rows of a cluster come canopy by canopy.
    let rows = excess.len();
    let mut places: HashMap<u32, Place> = HashMap::new();
    for (i, row) in mesh.rows.iter().enumerate() {
        let across = row.len() / p.gores;
        for (k, &node) in row.iter().enumerate().filter(|_| across > 0) {
            let part = (k % across) as f64 / across as f64;
            places.insert(node, Place { row: i, gore: k / across, part });
        }
    }
    let cloth = mesh.groups.get("cloth").map(|group| group.edges.as_slice()).unwrap_or_default();
    let told = |&edge: &u32| {
        let [a, b] = mesh.edges.get(edge as usize)?.map(|node| places.get(&node).copied());
        let ([a, b], [wide_a, wide_b]) = ([a?, b?], [a?, b?].map(|place| excess[place.row % rows]));
        if wide_a == 0.0 && wide_b == 0.0 {
            return None;
        }
        let ends = mesh.edges[edge as usize].map(|node| mesh.point(node));
        let flat = (ends[0] - ends[1]).norm();
        let [across_a, across_b] = across_gore(a, b)?;
        let width = |place: Place| {
            let row = &profile.rows[place.row % rows];
            let corner = |gore| profile.corner(row.apothem * profile.to_corner(), row.height, gore);
            (corner(1) - corner(0)).norm()
        };
        // Coordinates across the gore from its middle, on the gore and on the wider cloth.
        let [on_gore_a, on_gore_b] = [(a, across_a), (b, across_b)].map(|(place, part)| (part - 0.5) * width(place));
        let step = on_gore_a - on_gore_b;
        let wide = on_gore_a * (1.0 + wide_a) - on_gore_b * (1.0 + wide_b);
        Some((edge, (flat * flat - step * step + wide * wide).max(0.0).sqrt()))
    };
    cloth.iter().filter_map(told).collect()
}

/// Parts of the width of their gore at which the ends of an edge are; `None` along a radial.
fn across_gore(a: Place, b: Place) -> Option<[f64; 2]> {
    if a.part == 0.0 && b.part == 0.0 {
        return None;
    }
    // The end that is on a radial is at the end of the gore before, unless it begins this one.
    let gore = if a.part > 0.0 { a.gore } else { b.gore };
    let part = |place: Place| if place.part > 0.0 || place.gore == gore { place.part } else { 1.0 };
    Some([part(a), part(b)])
}
