//! Canopies of rings with slots between them: ringslot, ribbon, ringsail.

use super::ParachuteParameters;
use super::kind::CanopyType;
use super::profile::{Curve, Piece, Scale};

/// [-] width of the gap between two sails over that of a slot of the crown: real ones touch along the radials, but two
/// rows of nodes need two places
const SAIL_GAP: f64 = 0.1;

/// Rings of equal width, with slots of equal width between them, on a disc or a cone. The slots' area is the porosity
/// times the nominal area: with m slots of width g, s of the skirt and s_v of the vent along the cone it is
/// n tan(pi/n) g m (s + s_v) cos(angle).
pub(super) fn on_cone(p: &ParachuteParameters, size: f64, vent: f64) -> Vec<Piece> {
    let angle = if p.kind == CanopyType::Ribbon { p.cone_angle.unwrap_or(0.0) } else { 0.0 };
    let (sin, cos) = angle.sin_cos();
    let vent = vent / cos;
    let place = |s: f64| if angle == 0.0 { [s, 0.0] } else { [s * cos, -s * sin] };
    let rings = p.rings.unwrap_or(1).max(1);
    let slots = (rings - 1) as f64;
    let gap = if rings > 1 { p.slot_porosity.unwrap_or(0.0) * size * size / (slots * (size + vent)) } else { 0.0 };
    let ring = (size - vent - slots * gap) / rings as f64;
    let mut pieces = Vec::new();
    let mut at = vent;
    for i in 0..rings {
        // The first ring begins at the apex here: the part inside the vent is cut off with that of other types.
        let from = if i == 0 { 0.0 } else { at };
        let to = if i + 1 == rings { size } else { at + ring };
        pieces.push(Piece { curve: Curve::Straight([place(from), place(to)]), cloth: true });
        if i + 1 < rings {
            pieces.push(Piece { curve: Curve::Straight([place(to), place(to + gap)]), cloth: false });
        }
        at = to + gap;
    }
    pieces
}

/// [rad] Angle of a slot from which the search begins; 0 without slots.
pub(super) fn first_guess(p: &ParachuteParameters) -> f64 {
    p.cap_angle() * p.slot_porosity.unwrap_or(0.0) / p.rings.unwrap_or(1).max(1) as f64
}

/// Rings of equal width on a part of a sphere around its apex. Slots of equal width are above the first sail and
/// between the rings of the crown, gaps of a tenth of it between sails.
pub(super) fn on_sphere(p: &ParachuteParameters, Scale { size, slot }: Scale, vent: f64) -> Vec<Piece> {
    let rings = p.rings.unwrap_or(1).max(1);
    let first_sail = rings.saturating_sub(p.sails.unwrap_or(0));
    let gap = |below: usize| if below < first_sail { slot } else { SAIL_GAP * slot };
    let whole = p.cap_angle();
    let from = (vent / size).clamp(0.0, 1.0).asin();
    let ring = (whole - from - (0..rings - 1).map(gap).sum::<f64>()) / rings as f64;
    let arc = |angles, cloth| Piece { curve: Curve::Ellipse { centre: 0.0, axes: [size; 2], angles }, cloth };
    let mut pieces = Vec::new();
    let mut at = from;
    for i in 0..rings {
        let to = if i + 1 == rings { whole } else { at + ring };
        pieces.push(arc([if i == 0 { 0.0 } else { at }, to], true));
        if i + 1 < rings {
            pieces.push(arc([to, to + gap(i)], false));
            at = to + gap(i);
        }
    }
    pieces
}
