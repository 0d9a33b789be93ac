//! The profile of a gore: rows of nodes from the vent to the skirt.
//!
//! A gore is a sequence of flat trapezoids. A row crosses it straight, at the apothem r (the distance of the gore's
//! centre line from the axis) and the height z; its width is 2 r tan(pi/n). With n gores the trapezoids between two
//! rows have the area n tan(pi/n) (r1 + r2) ds, ds being the distance of the rows along the centre line.

use super::kind::CanopyType;
use super::{ParachuteParameters, outline, slots};
use crate::MeshError;
use nalgebra::Vector3;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// [-] relative error of the nominal area at which the size of a canopy counts as found
const AREA_TOLERANCE: f64 = 1e-15;
/// [-] chords by which the length of an ellipse is measured, which shares out rows alone
const CHORDS: usize = 64;

/// A row of nodes across a gore.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Row {
    /// [m] distance of the gore's centre line from the axis
    pub apothem: f64,
    /// [m] height above the skirt
    pub height: f64,
    /// whether there is no cloth between this row and the one before
    pub after_gap: bool,
}

/// The curve of a part of the centre line, from the apex outwards; radii and heights [m] in the pattern's own frame.
#[derive(Clone, Copy, Debug)]
pub(super) enum Curve {
    /// a straight line between two points (r, z)
    Straight([[f64; 2]; 2]),
    /// a circle of this radius from an angle to its widest place, the angle being 0 at the apex [m, rad]
    Arc { radius: f64, from: f64 },
    /// an ellipse about a place at the distance `centre` from the axis, with half axes across and along that axis,
    /// between two eccentric angles, which are 0 at its top; the top is at the height 0 [m, rad]
    Ellipse { centre: f64, axes: [f64; 2], angles: [f64; 2] },
}

impl Curve {
    fn length(self) -> f64 {
        match self {
            Self::Straight([from, to]) => (to[0] - from[0]).hypot(to[1] - from[1]),
            Self::Arc { radius, from } => radius * (FRAC_PI_2 - from),
            Self::Ellipse { .. } => {
                let place = |i: usize| self.at(i as f64 / CHORDS as f64);
                let chord = |i: usize| {
                    let [from, to] = [place(i), place(i + 1)];
                    (to[0] - from[0]).hypot(to[1] - from[1])
                };
                (0..CHORDS).map(chord).sum()
            }
        }
    }

    /// The point at a part of its length, of an ellipse at a part of its angle.
    fn at(self, part: f64) -> [f64; 2] {
        match self {
            Self::Straight([from, to]) => [0, 1].map(|c| (1.0 - part) * from[c] + part * to[c]),
            // The skirt is exactly as wide as the sphere.
            Self::Arc { radius, .. } if part == 1.0 => [radius, -radius],
            Self::Arc { radius, from } => {
                let (sin, cos) = (from + (FRAC_PI_2 - from) * part).sin_cos();
                [radius * sin, radius * cos - radius]
            }
            Self::Ellipse { centre, axes, angles } => {
                let (sin, cos) = ((1.0 - part) * angles[0] + part * angles[1]).sin_cos();
                [centre + axes[0] * sin, axes[1] * cos - axes[1]]
            }
        }
    }

    /// The rest of it from where it is `apothem` from the axis; `None` if it does not reach farther.
    fn beyond(self, apothem: f64) -> Option<Self> {
        match self {
            Self::Straight([from, to]) => {
                let part = (apothem - from[0]) / (to[0] - from[0]);
                let start = [apothem, (1.0 - part) * from[1] + part * to[1]];
                (0.0..1.0).contains(&part).then_some(Self::Straight([start, to]))
            }
            Self::Arc { radius, .. } => {
                (apothem < radius).then(|| Self::Arc { radius, from: (apothem / radius).asin() })
            }
            Self::Ellipse { centre, axes, angles: [from, to] } => {
                let from = ((apothem - centre) / axes[0]).asin().max(from);
                (from < to).then_some(Self::Ellipse { centre, axes, angles: [from, to] })
            }
        }
    }
}

/// A part of the centre line, of cloth or open.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    pub curve: Curve,
    pub cloth: bool,
}

/// What the areas of a pattern determine.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scale {
    /// [m] apothem of a flat pattern's skirt, length of a conical one; radius of a sphere
    pub size: f64,
    /// [rad] angle of the widest slots of a ringsail, seen from the centre of its sphere
    pub slot: f64,
}

/// The rows of a canopy, from the vent or the apex to the skirt.
#[derive(Clone, Debug)]
pub(super) struct Profile {
    /// rows; the first is the vent's, or the apex with an apothem of 0
    pub rows: Vec<Row>,
    /// [m^2] nominal area S0: cloth, gaps and vent
    pub nominal_area: f64,
    /// [m^2] cloth
    pub cloth_area: f64,
    /// [m^2] gaps
    slot_area: f64,
    /// [m] height of the pattern's apex above the skirt; a vent is cut out below it
    pub apex_height: f64,
    /// [m] length of the gore's centre line from the apex to the skirt
    pub gore_length: f64,
    /// corners of a row of apothem 1, counter-clockwise; of a regular polygon of gores if absent
    outline: Option<Vec<[f64; 2]>>,
    gores: usize,
}

impl Profile {
    /// [-] Distance of the corners of a row from the axis over its apothem: the radials run along the corners, which
    /// are farther from the axis than the gores' centre lines. 1 where the canopy is not round.
    pub(super) fn to_corner(&self) -> f64 {
        if self.outline.is_some() { 1.0 } else { 1.0 / (PI / self.gores as f64).cos() }
    }

    /// [m] The corner at the beginning of a gore of a row with this distance of its corners, or of its sides if it is
    /// not round, and this height.
    pub(super) fn corner(&self, radius: f64, height: f64, gore: usize) -> Vector3<f64> {
        let n = self.gores;
        if let Some(&[x, y]) = self.outline.as_ref().and_then(|outline| outline.get(gore % n)) {
            return Vector3::new(radius * x, radius * y, height);
        }
        let (sin, cos) = (TAU * (gore % n) as f64 / n as f64).sin_cos();
        Vector3::new(radius * cos, radius * sin, height)
    }

    /// The profile whose nominal area is that of the nominal diameter.
    ///
    /// # Errors
    /// A vent or a gap that leaves no cloth, and too few rows.
    pub(super) fn of(p: &ParachuteParameters) -> Result<Self, MeshError> {
        let wanted = 0.25 * PI * p.d0() * p.d0();
        let mut scale = Scale { size: 0.5 * p.d0(), slot: slots::first_guess(p) };
        // The area is nearly the square of the size, but for the shape of a curved profile near its vent.
        for _ in 0..100 {
            let profile = Self::of_scale(p, scale)?;
            let found = profile.nominal_area;
            scale.size *= (wanted / found).sqrt();
            let porosity = p.slot_porosity.filter(|_| p.kind == CanopyType::Ringsail);
            let slots = porosity.map_or(1.0, |porosity| porosity * found / profile.slot_area);
            scale.slot *= slots;
            if (found / wanted - 1.0).abs() < AREA_TOLERANCE && (slots - 1.0).abs() < 10.0 * AREA_TOLERANCE {
                break;
            }
        }
        let profile = Self::of_scale(p, scale)?;
        // A dome that grows with its vent may shrink below it.
        let narrow = |[first, last]: [&Row; 2]| first.apothem >= last.apothem;
        match profile.rows.first().zip(profile.rows.last()) {
            Some((first, last)) if narrow([first, last]) => Err(too_much_vent(p)),
            _ => Ok(profile),
        }
    }

    /// The profile of a pattern of this scale.
    fn of_scale(p: &ParachuteParameters, scale: Scale) -> Result<Self, MeshError> {
        let outline = outline::of(p);
        let to_vent = outline.as_deref().map_or((PI / p.gores as f64).cos(), outline::apothem);
        let vent = 0.5 * p.vent_diameter.unwrap_or(0.0) * to_vent;
        if p.kind == CanopyType::Toroidal && vent >= scale.size {
            return Err(too_much_vent(p));
        }
        let pieces = pieces(p, scale, vent);
        // Only the skirt of an extended canopy may be drawn in; else a ring has no width left.
        let narrows =
            |piece: &Piece| p.kind != CanopyType::ExtendedSkirt && piece.curve.at(1.0)[0] < piece.curve.at(0.0)[0];
        if pieces.iter().any(|piece| piece.curve.length() <= 0.0 || narrows(piece)) {
            return Err(no_ring_left(p));
        }
        let (pieces, before) = match p.kind {
            // It begins at its vent, which is level.
            CanopyType::Toroidal => (pieces, vent),
            _ => after_vent(pieces, vent).ok_or_else(|| too_much_vent(p))?,
        };
        let counts = share_rows(p, &pieces)?;
        let first = pieces.first().map_or([0.0; 2], |piece| piece.curve.at(0.0));
        let mut rows = vec![Row { apothem: vent, height: first[1], after_gap: false }];
        for (piece, &count) in pieces.iter().zip(&counts) {
            rows.extend((1..=count).map(|i| {
                let [apothem, height] = piece.curve.at(i as f64 / count as f64);
                Row { apothem, height, after_gap: !piece.cloth }
            }));
        }
        let skirt = rows.last().map_or(0.0, |row| row.height);
        rows.iter_mut().for_each(|row| row.height -= skirt);
        let width = outline.as_deref().map_or(p.gores as f64 * (PI / p.gores as f64).tan(), outline::area);
        let band = |pair: &[Row]| {
            let step = (pair[1].apothem - pair[0].apothem).hypot(pair[1].height - pair[0].height);
            (width * (pair[0].apothem + pair[1].apothem) * step, step)
        };
        let (mut nominal_area, mut cloth_area, mut gore_length) = (width * vent * before, 0.0, before);
        let mut slot_area = 0.0;
        for pair in rows.windows(2) {
            let (area, step) = band(pair);
            nominal_area += area;
            gore_length += step;
            *(if pair[1].after_gap { &mut slot_area } else { &mut cloth_area }) += area;
        }
        let apex_height = if p.kind == CanopyType::Toroidal { rows[0].height } else { -skirt };
        Ok(Self { rows, nominal_area, cloth_area, slot_area, apex_height, gore_length, outline, gores: p.gores })
    }
}

fn no_ring_left(p: &ParachuteParameters) -> MeshError {
    MeshError::Parameter {
        pointer: "/parachute/slot_porosity".to_owned(),
        value: p.slot_porosity.unwrap_or(0.0).to_string(),
        allowed: "slots that leave cloth between vent and skirt".to_owned(),
        hint: "take a smaller porosity or a smaller vent".to_owned(),
    }
}

fn too_much_vent(p: &ParachuteParameters) -> MeshError {
    MeshError::Parameter {
        pointer: "/parachute/vent_diameter".to_owned(),
        value: p.vent_diameter.unwrap_or(0.0).to_string(),
        allowed: "a vent inside the first part of the canopy".to_owned(),
        hint: "make the vent smaller, it leaves no cloth there".to_owned(),
    }
}

/// The pieces of a type's centre line, from the apex; `vent` [m] is the apothem of the vent.
fn pieces(p: &ParachuteParameters, scale: Scale, vent: f64) -> Vec<Piece> {
    let size = scale.size;
    let straight = |corners: &[[f64; 2]]| -> Vec<Piece> {
        corners.windows(2).map(|pair| Piece { curve: Curve::Straight([pair[0], pair[1]]), cloth: true }).collect()
    };
    let cones = |angles: &[f64], breaks: &[f64]| {
        let ends: Vec<f64> = [&[0.0], breaks, &[1.0]].concat();
        let mut corners = vec![[0.0, 0.0]];
        let mut at = [0.0, 0.0];
        for (angle, pair) in angles.iter().zip(ends.windows(2)) {
            let length = size * (pair[1] - pair[0]);
            at = [at[0] + length * angle.cos(), at[1] - length * angle.sin()];
            corners.push(at);
        }
        straight(&corners)
    };
    match p.kind {
        CanopyType::FlatCircular
        | CanopyType::Annular
        | CanopyType::Cruciform
        | CanopyType::Square
        | CanopyType::Triangular => straight(&[[0.0, 0.0], [size, 0.0]]),
        CanopyType::Conical => cones(&[p.cone_angle.unwrap_or(0.0)], &[]),
        CanopyType::Biconical | CanopyType::Triconical => {
            cones(p.cone_angles.as_deref().unwrap_or_default(), &p.cone_breaks())
        }
        CanopyType::Hemispherical => vec![Piece { curve: Curve::Arc { radius: size, from: 0.0 }, cloth: true }],
        CanopyType::ExtendedSkirt => straight(&[[0.0, 0.0], [size, 0.0], p.extended_skirt(size)]),
        CanopyType::Elliptical => {
            let axes = [size, size * p.height_ratio.unwrap_or(1.0)];
            vec![Piece { curve: Curve::Ellipse { centre: 0.0, axes, angles: [0.0, FRAC_PI_2] }, cloth: true }]
        }
        CanopyType::Toroidal => {
            let half = 0.5 * (size - vent);
            let height = p.height_ratio.map_or(half, |ratio| ratio * size);
            let quarter = |height: f64, angles| {
                let curve = Curve::Ellipse { centre: 0.5 * (size + vent), axes: [half, height], angles };
                Piece { curve, cloth: true }
            };
            vec![quarter(height * p.pull_down(), [-FRAC_PI_2, 0.0]), quarter(height, [0.0, FRAC_PI_2])]
        }
        CanopyType::Ringslot | CanopyType::Ribbon => slots::on_cone(p, size, vent),
        CanopyType::Ringsail => slots::on_sphere(p, scale, vent),
        CanopyType::DiskGapBand => {
            let [disk, gap, band] = p.disk_gap_band();
            let unit = size / (0.5 * disk);
            let z = [0.0, gap, gap + band].map(|z| -unit * z);
            let mut pieces = straight(&[[0.0, 0.0], [size, z[0]], [size, z[1]], [size, z[2]]]);
            pieces[1].cloth = false;
            pieces
        }
    }
}

/// The pieces outside the vent, and the length of the centre line inside it [m].
fn after_vent(mut pieces: Vec<Piece>, vent: f64) -> Option<(Vec<Piece>, f64)> {
    let first = pieces.first_mut()?;
    first.curve = first.curve.beyond(vent)?;
    // The tip of a gore is a flat triangle from the apex to the vent.
    let [r, z] = first.curve.at(0.0);
    Some((pieces, r.hypot(z)))
}

/// The number of rows of each piece: one for a gap, and `radial_segments` shared over the cloth by length, at least one
/// for each piece.
fn share_rows(p: &ParachuteParameters, pieces: &[Piece]) -> Result<Vec<usize>, MeshError> {
    let cloth = || pieces.iter().filter(|piece| piece.cloth);
    let count = cloth().count();
    if p.radial_segments < count {
        return Err(MeshError::Parameter {
            pointer: "/parachute/radial_segments".to_owned(),
            value: p.radial_segments.to_string(),
            allowed: format!("at least {count}: this canopy has {count} parts of cloth from the vent to the skirt"),
            hint: "take more".to_owned(),
        });
    }
    let total: f64 = cloth().map(|piece| piece.curve.length()).sum();
    let spare = p.radial_segments - count;
    let mut counts = Vec::new();
    let (mut length, mut given) = (0.0, 0);
    for piece in pieces {
        if !piece.cloth {
            counts.push(1);
            continue;
        }
        // Rounding the running sum keeps the total.
        length += piece.curve.length();
        let until = (spare as f64 * length / total).round() as usize;
        counts.push(1 + until - given);
        given = until;
    }
    Ok(counts)
}
