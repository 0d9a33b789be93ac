//! Pieces of cloth that are cut flat and apart, joined along their seams.
//!
//! The nodes of both sides of a seam become one. Rest shapes stay those of the flat pieces ([`Cut`]); the pieces are
//! placed in space so that their seams meet (`place`). Sides and allowances of drawn outlines are found before, in
//! `read/pieces`.

mod chain;
mod ears;
mod error;
mod fit;
mod join;
mod place;
mod rig;
mod ring;

use super::Mesh;
use super::parachute::LineParameters;
use super::source::{FaultSink, check_count, check_length};
use chain::Stitch;
pub use error::SewError;
use serde::{Deserialize, Serialize};

/// [-] Least and largest number of times that an outline is used.
const COPIES: [usize; 2] = [1, 10_000];

/// A seam that joins two sides, or the gores of a canopy.
///
/// `edges` joins two sides; `gores` joins gores around an axis, each to the next one and the last to the first. One of
/// both is given.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Seam {
    /// Names of the two sides. A side is a group of edges on the boundary of a piece. In a drawing it is a layer of
    /// open lines along an outline, or a side of an outline by its number: `front.2` is the second one of the layer
    /// `front`, counter-clockwise from the first corner that is drawn. The same name twice stands for the two sides
    /// that have it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub edges: Option<[String; 2]>,
    /// Layers whose closed outlines are gores in their order around the axis, or one that holds them all. Their two
    /// long sides are found by their corners. The canopy gets the groups of a generated parachute.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gores: Option<Vec<String>>,
    /// [-] How often every outline of `gores` is used; 1 if absent
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(range(min = 1)))]
    pub copies: Option<usize>,
    /// Name of the group of the sewn edges; that of `gores` is `radials` if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// [m] Width of the cloth outside the seam, which is cut off drawn outlines; none if absent
    #[serde(default, skip_serializing_if = "is_zero")]
    pub allowance: f64,
    /// [m] Width that is cut off the other sides of drawn `gores`, skirt and vent; none if absent
    #[serde(default, skip_serializing_if = "is_zero")]
    pub hem: f64,
    /// Whether sides of unequal length are sewn, the longer one gathered evenly. Else they may differ by 1 %.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub ease: bool,
    /// Whether the second side is sewn the other way round, so that one of both pieces shows its lower side.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub reverse: bool,
    /// Suspension lines from the seams of `gores` at the skirt to the confluence on the axis; none if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lines: Option<LineParameters>,
}

fn is_zero(width: &f64) -> bool {
    *width == 0.0
}

impl Seam {
    /// Reports every value out of range; `at` is the JSON pointer of this seam.
    fn check(&self, at: &str, faults: FaultSink<'_>) {
        if self.edges.is_some() == self.gores.is_some() {
            let hint = "name two sides in edges, or the layers of gores".to_owned();
            let value = if self.edges.is_some() { "edges and gores" } else { "neither edges nor gores" };
            faults(at, value.to_owned(), "one of edges and gores".into(), hint);
        }
        for (key, width) in [("allowance", self.allowance), ("hem", self.hem)] {
            if width != 0.0 {
                check_length(at, key, width, faults);
            }
        }
        let layers = self.gores.as_deref().unwrap_or_default();
        if let Some(i) = (1..layers.len()).find(|&i| layers[..i].contains(&layers[i])) {
            let hint = "name each layer once; \"copies\" uses its outlines several times".to_owned();
            faults(&format!("{at}/gores/{i}"), format!("\"{}\" again", layers[i]), "each layer once".into(), hint);
        }
        if let Some(copies) = self.copies {
            check_count(at, "copies", copies, COPIES, faults);
        }
        if let Some(lines) = self.lines {
            check_length(&format!("{at}/lines"), "length", lines.length, faults);
            check_count(&format!("{at}/lines"), "segments", lines.segments, COPIES, faults);
        }
        let of_gores = [("copies", self.copies.is_some()), ("hem", self.hem != 0.0), ("lines", self.lines.is_some())];
        let of_edges = [("reverse", self.reverse)];
        let (keys, other): (&[_], _) = if self.gores.is_some() { (&of_edges, "edges") } else { (&of_gores, "gores") };
        for (key, _) in keys.iter().filter(|(_, given)| *given) {
            let hint = "leave it out".to_owned();
            faults(&format!("{at}/{key}"), "given".into(), format!("only with {other}"), hint);
        }
    }
}

/// Reports every value out of range of the seams of a mesh.
pub(super) fn check_seams(seams: &[Seam], faults: FaultSink<'_>) {
    seams.iter().enumerate().for_each(|(i, seam)| seam.check(&format!("/sew/{i}"), faults));
    if seams.len() > 1
        && let Some(i) = seams.iter().position(|seam| seam.gores.is_some())
    {
        let hint = "name their sides in edges".to_owned();
        faults(&format!("/sew/{i}/gores"), format!("beside {} seams", seams.len() - 1), "alone".into(), hint);
    }
}

/// The seams of a mesh, by groups of its edges.
#[derive(Clone, Debug, Default)]
pub(super) struct Sewing {
    /// for each seam the groups of its two sides and the rule that asks for it
    pub sides: Vec<([String; 2], usize)>,
    /// groups that were made for these sides alone
    pub made: Vec<String>,
}

/// What the triangles and edges of a sewn mesh are as they are cut, flat and apart. Masses, areas and rest shapes
/// follow from these.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct Cut {
    /// [m] corners of every triangle in the drawing, `[n_triangles][3][3]`
    pub triangles: Vec<[[f64; 3]; 3]>,
    /// [m] length of every edge, `[n_edges]`; on a seam the mean of both sides
    pub lengths: Vec<f64>,
}

/// Joins the pieces of a mesh along their seams, and places them in space. Returns sentences about what was done.
///
/// # Errors
/// Sides that are no chains of boundary edges, that do not fit each other, or pieces that cannot be placed.
pub(super) fn sew(mesh: &mut Mesh, seams: &[Seam], sewing: &Sewing) -> Result<Vec<String>, SewError> {
    let stitches = chain::stitches(mesh, seams, sewing)?;
    ears::turn_edges(mesh, &stitches);
    let placed = place::place(mesh, &stitches)?;
    let mut notes = stitches.iter().filter_map(Stitch::eased).collect::<Vec<_>>();
    let open = placed.gap(&stitches);
    let joined = join::join(mesh, seams, &stitches, &placed);
    let collapses = |pair: &[u32]| {
        let [a, b] = [0, 1].map(|i| mesh.point(joined.node[pair[i] as usize]));
        a == b
    };
    let sides = || stitches.iter().flat_map(|stitch| &stitch.sides);
    if let Some(side) = sides().find(|side| side.nodes.windows(2).any(collapses)) {
        return Err(SewError::Collapsed { name: side.name.clone() });
    }
    sewing.made.iter().for_each(|name| drop(mesh.groups.remove(name)));
    let (pieces, length) = (placed.pieces, mesh.cut.as_ref().map_or(0.0, |cut| cut.length(&mesh.seams)));
    notes.insert(0, format!("{pieces} pieces were sewn along {} seams of {length:.6} m", stitches.len()));
    if open > 0.0 {
        notes.push(format!(
            "the sides of seams are up to {open:.3e} m apart as the pieces are placed; the cloth starts strained there"
        ));
    }
    if let Some((seam, ring)) = seams.iter().zip(&placed.ring).find(|(seam, _)| seam.gores.is_some()) {
        rig::rig(mesh, seam, ring, &joined)?;
    }
    Ok(notes)
}

impl Cut {
    /// [m] Length of some edges.
    pub(super) fn length(&self, edges: &[u32]) -> f64 {
        edges.iter().filter_map(|&edge| self.lengths.get(edge as usize)).sum()
    }
}
