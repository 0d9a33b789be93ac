//! The colour and the mark of a method, the same in all charts of all pages.
//!
//! The shape of its mark shows its family: discs and triangles for explicit methods, stars for those without a matrix,
//! squares and diamonds for implicit ones. A family takes another shape after every six methods.

use crate::integrate::registry::{Family, methods};
use crate::plot::chart::Marker;

/// Number of colours that methods and curves take, each its own as long as they suffice: those of the palette without
/// black, which is left for what is no method.
pub(crate) const COLORS: usize = 15;
/// Black.
pub(crate) const BLACK: usize = 6;
/// Methods of a family that have the same shape of marks.
const SHAPE: usize = 6;

/// The colour of a curve by its number.
pub(crate) fn curve_color(number: usize) -> usize {
    let color = number % COLORS;
    if color < BLACK { color } else { color + 1 }
}

/// The number in the palette of a method's colour; black for what is no method.
///
/// ```
/// use canopy_fem_study::method_color;
/// assert_ne!(method_color("newmark"), method_color("energy-momentum"));
/// ```
pub fn method_color(name: &str) -> usize {
    methods().iter().find(|method| method.name == name).map_or(BLACK, |method| curve_color(method.color))
}

/// The mark of a method, filled; none for what is no method.
///
/// ```
/// use canopy_fem_study::{method_mark, plot::chart::Marker};
/// assert_eq!((method_mark("kang"), method_mark("exact")), (Marker::Star, Marker::None));
/// ```
pub fn method_mark(name: &str) -> Marker {
    let Some(method) = methods().iter().find(|method| method.name == name) else { return Marker::None };
    let before = methods().iter().take_while(|other| other.name != name).filter(|other| other.family == method.family);
    shapes(method.family, before.count() / SHAPE)[0]
}

/// A filled shape of a family and its outline, by the number of its turn.
pub(crate) fn shapes(family: Family, turn: usize) -> [Marker; 2] {
    let explicit = [
        [Marker::Dot, Marker::Ring],
        [Marker::Triangle, Marker::OpenTriangle],
        [Marker::TriangleDown, Marker::OpenTriangleDown],
    ];
    let implicit = [[Marker::Square, Marker::OpenSquare], [Marker::Diamond, Marker::OpenDiamond]];
    let shapes: &[[Marker; 2]] = match family {
        Family::Explicit => &explicit,
        Family::MatrixFree => &[[Marker::Star, Marker::OpenStar]],
        Family::Implicit => &implicit,
    };
    shapes.get(turn % shapes.len().max(1)).copied().unwrap_or_default()
}

/// The outline of a filled mark.
pub(crate) fn outline(filled: Marker) -> Marker {
    match filled {
        Marker::Dot => Marker::Ring,
        Marker::Triangle => Marker::OpenTriangle,
        Marker::TriangleDown => Marker::OpenTriangleDown,
        Marker::Square => Marker::OpenSquare,
        Marker::Diamond => Marker::OpenDiamond,
        Marker::Star => Marker::OpenStar,
        other => other,
    }
}

/// Colours of the methods of a study. One whose colour is taken, such as a second HHT with other parameters, has the
/// first free one.
pub(crate) fn method_colors<'m>(names: impl Iterator<Item = &'m str> + Clone) -> Vec<usize> {
    let own: Vec<usize> = names.map(method_color).collect();
    let mut taken: Vec<usize> = Vec::with_capacity(own.len());
    for color in &own {
        let free = || (0..COLORS).map(curve_color).find(|free| !own.contains(free) && !taken.contains(free));
        let color = if taken.contains(color) { free().unwrap_or(*color) } else { *color };
        taken.push(color);
    }
    taken
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Families have their own marks, so a colour and a mark belong to one method.
    #[test]
    fn methods_look_different() {
        for (i, method) in methods().iter().enumerate() {
            assert!(method.color < COLORS, "{}", method.name);
            let alike = methods()[..i].iter().find(|m| (m.family, m.color) == (method.family, method.color));
            assert!(alike.is_none(), "{} looks like {}", method.name, alike.map_or("", |m| m.name));
            assert_ne!(method_mark(method.name), Marker::None);
            assert_ne!(outline(method_mark(method.name)), method_mark(method.name), "{}", method.name);
        }
    }
}
