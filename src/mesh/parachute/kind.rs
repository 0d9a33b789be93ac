//! The types of canopies, and the parameters that belong to some of them only.

use super::{ParachuteParameters, outline};
use crate::format_number::figures;
use crate::source::FaultSink;
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_3, PI};
use std::fmt;

/// [-] length of an extended skirt over the diameter of the flat part, if not given
const SKIRT_EXTENSION: f64 = 0.1;
/// [-] least diameter of the mouth of an extended skirt that is drawn in, over that of the flat part
const LEAST_MOUTH: f64 = 0.1;
/// [-] width over length of a strip of a cruciform canopy, if not given
const ARM_RATIO: f64 = 1.0 / 3.0;
/// [-] diameter of the disc, height of the gap and of the band over D0, if not given: those of the Viking canopy. The
/// Tianwen-1 canopy has 0.722, 0.043 and 0.122 (Space: Science & Technology 2022, 9805457, table 3).
const VIKING: [f64; 3] = [0.72, 0.042, 0.121];
/// [rad] part of a sphere on which a ringsail is cut, if not given: it has a quarter of the sphere's area
const QUARTER_SPHERE: f64 = FRAC_PI_3;

/// How the canopy is cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum CanopyType {
    /// A flat disc of triangular gores.
    FlatCircular,
    /// A cone; needs `cone_angle`.
    Conical,
    /// Two cones, the outer one steeper; needs `cone_angles`.
    Biconical,
    /// Three cones; needs `cone_angles`.
    Triconical,
    /// Half a sphere.
    Hemispherical,
    /// A flat disc with a skirt below it, `skirt_extension` long, at the angle `skirt_angle`.
    ExtendedSkirt,
    /// A flat ring; needs `vent_diameter`, and has no vent lines unless they are asked for.
    Annular,
    /// Two crossing strips of the ratio `arm_ratio`; `gores` counts its lines, a multiple of four.
    Cruciform,
    /// Flat rings with slots between them; needs `rings` and `slot_porosity`.
    Ringslot,
    /// Ribbons around a disc, or around a cone of the angle `cone_angle`, with slots between them; needs `rings` and
    /// `slot_porosity`. Tapes cross them, `verticals` in each gore.
    Ribbon,
    /// Rings and sails on a part of a sphere; needs `rings`, `sails`, `slot_porosity` and `fullness`. The crown has
    /// slots; sails are wider than their gores at their lower edges, so that crescents open there.
    Ringsail,
    /// A flat disc, a gap and a cylinder: `disk`, `gap` and `band`.
    DiskGapBand,
    /// A part of an ellipsoid of the height `height_ratio`; with a `centre_line` its apex is pulled down.
    Elliptical,
    /// A ring with a round cross section, open at the skirt, whose vent is pulled down by `pull_down`; needs
    /// `vent_diameter` and, with lines, `inner_lines`.
    Toroidal,
    /// A flat square, perhaps with corners cut by `corner_cut`; `gores` counts its lines, a multiple of four.
    Square,
    /// A flat triangle of equal sides, likewise; a multiple of three.
    Triangular,
}

/// Its name in a case.
impl fmt::Display for CanopyType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.serialize(f)
    }
}

impl ParachuteParameters {
    /// [-] Length of the extended skirt over the diameter of the flat part.
    pub(super) fn skirt_extension(&self) -> f64 {
        self.skirt_extension.unwrap_or(SKIRT_EXTENSION)
    }

    /// [m] Distance from the axis and height of an extended skirt's lower edge below a flat disc of this radius [m].
    pub(super) fn extended_skirt(&self, radius: f64) -> [f64; 2] {
        let length = 2.0 * radius * self.skirt_extension();
        match self.skirt_angle {
            // A cylinder is exactly as wide as the disc.
            None => [radius, -length],
            Some(angle) => [radius + length * angle.cos(), -length * angle.sin()],
        }
    }

    /// [-] Width over length of a strip.
    pub(super) fn arm_ratio(&self) -> f64 {
        self.arm_ratio.unwrap_or(ARM_RATIO)
    }

    /// [rad] Angle of the part of a sphere from its apex to the skirt.
    pub(super) fn cap_angle(&self) -> f64 {
        self.cap_angle.unwrap_or(QUARTER_SPHERE)
    }

    /// [-] Depth of a pulled-down vent below the crest over that of the skirt.
    pub(super) fn pull_down(&self) -> f64 {
        self.pull_down.unwrap_or(1.0)
    }

    /// [-] Where the cone angle changes, as parts of the gore's length; equal parts if not given.
    pub(super) fn cone_breaks(&self) -> Vec<f64> {
        let count = self.cone_angles.as_ref().map_or(1, Vec::len);
        let equal = || (1..count).map(|i| i as f64 / count as f64).collect();
        self.cone_breaks.clone().unwrap_or_else(equal)
    }

    /// [-] Diameter of the disc, heights of gap and band, in proportion to each other.
    pub(super) fn disk_gap_band(&self) -> [f64; 3] {
        [self.disk.unwrap_or(VIKING[0]), self.gap.unwrap_or(VIKING[1]), self.band.unwrap_or(VIKING[2])]
    }

    /// Reports parameters that the type does not have, that it needs, or that are out of range.
    pub(super) fn check_kind(&self, at: &str, faults: FaultSink<'_>) {
        use CanopyType::{
            Biconical, Conical, Cruciform, DiskGapBand, Elliptical, ExtendedSkirt, Ribbon, Ringsail, Ringslot, Square,
            Toroidal, Triangular, Triconical,
        };
        let owners: [(&str, bool, &[CanopyType]); 18] = [
            ("cone_angle", self.cone_angle.is_some(), &[Conical, Ribbon]),
            ("cone_angles", self.cone_angles.is_some(), &[Biconical, Triconical]),
            ("cone_breaks", self.cone_breaks.is_some(), &[Biconical, Triconical]),
            ("skirt_extension", self.skirt_extension.is_some(), &[ExtendedSkirt]),
            ("skirt_angle", self.skirt_angle.is_some(), &[ExtendedSkirt]),
            ("arm_ratio", self.arm_ratio.is_some(), &[Cruciform]),
            ("rings", self.rings.is_some(), &[Ringslot, Ribbon, Ringsail]),
            ("slot_porosity", self.slot_porosity.is_some(), &[Ringslot, Ribbon, Ringsail]),
            ("verticals", self.verticals.is_some(), &[Ribbon]),
            ("sails", self.sails.is_some(), &[Ringsail]),
            ("fullness", self.fullness.is_some(), &[Ringsail]),
            ("cap_angle", self.cap_angle.is_some(), &[Ringsail]),
            ("height_ratio", self.height_ratio.is_some(), &[Elliptical, Toroidal]),
            ("pull_down", self.pull_down.is_some(), &[Toroidal]),
            ("corner_cut", self.corner_cut.is_some(), &[Square, Triangular]),
            ("disk", self.disk.is_some(), &[DiskGapBand]),
            ("gap", self.gap.is_some(), &[DiskGapBand]),
            ("band", self.band.is_some(), &[DiskGapBand]),
        ];
        for (key, given, types) in owners {
            if given && !types.contains(&self.kind) {
                let names: Vec<String> = types.iter().map(|t| format!("\"{t}\"")).collect();
                let hint = "leave it out, or change the type".to_owned();
                faults(&format!("{at}/{key}"), "given".into(), format!("only with type {}", names.join(" or ")), hint);
            }
        }
        let needed = |key: &str, faults: FaultSink<'_>| {
            let allowed = format!("a value: type \"{}\" needs it", self.kind);
            faults(&format!("{at}/{key}"), "(missing)".into(), allowed, "give it".into());
        };
        let mut number = |key: &str, value: Option<f64>, [low, high]: [f64; 2]| {
            if let Some(value) = value.filter(|v| !(*v > low && *v < high)) {
                let allowed =
                    if high.is_finite() { format!("above {low} and below {high}") } else { format!("above {low}") };
                let hint = if key.ends_with("angle") { in_radians(&[value]) } else { "correct it".to_owned() };
                faults(&format!("{at}/{key}"), value.to_string(), allowed, hint);
            }
        };
        number("cone_angle", self.cone_angle, [0.0, FRAC_PI_2]);
        number("skirt_extension", self.skirt_extension, [0.0, f64::INFINITY]);
        number("skirt_angle", self.skirt_angle, [0.0, PI]);
        number("arm_ratio", self.arm_ratio, [0.0, 1.0]);
        number("slot_porosity", self.slot_porosity, [0.0, 0.5]);
        number("fullness", self.fullness, [0.0, 1.0]);
        number("cap_angle", self.cap_angle, [0.0, FRAC_PI_2]);
        number("height_ratio", self.height_ratio, [0.0, 2.0]);
        number("pull_down", self.pull_down, [0.0, 2.0]);
        number("corner_cut", self.corner_cut, [0.0, 0.5]);
        for (key, value) in [("disk", self.disk), ("gap", self.gap), ("band", self.band)] {
            number(key, value, [0.0, f64::INFINITY]);
        }
        match self.kind {
            Conical if self.cone_angle.is_none() => needed("cone_angle", faults),
            Biconical | Triconical => self.check_cones(at, faults),
            Ringslot | Ribbon | Ringsail => self.check_rings(at, &needed, faults),
            Elliptical if self.height_ratio.is_none() => needed("height_ratio", faults),
            Toroidal => {
                if self.vent_diameter.is_none() {
                    needed("vent_diameter", faults);
                }
                if self.lines.is_some() && self.inner_lines.is_none() {
                    needed("inner_lines", faults);
                }
            }
            Square | Triangular => self.check_outline(at, faults),
            ExtendedSkirt => {
                // Drawn in by more than the radius, it would cross the axis.
                let [lower, _] = self.extended_skirt(1.0);
                if lower < LEAST_MOUTH {
                    let allowed =
                        format!("a skirt that leaves a mouth of at least {LEAST_MOUTH} of the disc's diameter");
                    let hint = "draw it in less: take a smaller angle or a shorter skirt".to_owned();
                    faults(&format!("{at}/skirt_extension"), self.skirt_extension().to_string(), allowed, hint);
                }
            }
            CanopyType::Annular if self.vent_diameter.is_none() => needed("vent_diameter", faults),
            Cruciform => {
                if !self.gores.is_multiple_of(4) || self.gores < 8 {
                    let hint =
                        "each of the four ends carries a quarter of the lines, one at each of its corners".to_owned();
                    faults(&format!("{at}/gores"), self.gores.to_string(), "a multiple of 4, at least 8".into(), hint);
                }
                if self.vent_diameter.is_some() {
                    let hint = "leave it out".to_owned();
                    faults(
                        &format!("{at}/vent_diameter"),
                        "given".into(),
                        "no vent in a cruciform canopy".into(),
                        hint,
                    );
                }
            }
            _ => {}
        }
    }

    fn check_rings(&self, at: &str, needed: &dyn Fn(&str, FaultSink<'_>), faults: FaultSink<'_>) {
        let mut range = |key: &str, value: usize, [low, high]: [usize; 2]| {
            if !(low..=high).contains(&value) {
                let hint = "correct it".to_owned();
                faults(&format!("{at}/{key}"), value.to_string(), format!("{low} to {high}"), hint);
            }
        };
        let rings = self.rings.unwrap_or(2);
        range("rings", rings, [2, 1000]);
        if let Some(sails) = self.sails.filter(|_| rings >= 2) {
            range("sails", sails, [2, rings]);
        }
        let strips = self.verticals.unwrap_or(0).saturating_add(1);
        let more = if self.kind == CanopyType::Ringsail {
            [self.sails.is_none(), self.fullness.is_none()]
        } else {
            [false; 2]
        };
        let missing = [self.rings.is_none(), self.slot_porosity.is_none(), more[0], more[1]];
        let keys = ["rings", "slot_porosity", "sails", "fullness"].into_iter().zip(missing);
        keys.filter(|(_, missing)| *missing).for_each(|(key, _)| needed(key, faults));
        if !self.gore_segments.is_multiple_of(strips) {
            let hint = "each tape runs along edges: take a multiple, e.g. that number itself".to_owned();
            let allowed = format!("a multiple of {strips}, with {} verticals in each gore", strips - 1);
            faults(&format!("{at}/gore_segments"), self.gore_segments.to_string(), allowed, hint);
        }
        if self.fullness.is_some() && self.gore_segments < 2 {
            let hint = "one edge across a gore stays straight, and no crescent opens".to_owned();
            faults(
                &format!("{at}/gore_segments"),
                self.gore_segments.to_string(),
                "at least 2 with fullness".into(),
                hint,
            );
        }
    }

    fn check_outline(&self, at: &str, faults: FaultSink<'_>) {
        let sides = outline::sides(self.kind).unwrap_or(1);
        let least = if self.corner_cut.is_some() { 2 * sides } else { sides };
        if !self.gores.is_multiple_of(sides) || self.gores < least {
            let hint = "lines are evenly spaced along each side; a cut corner takes one gore".to_owned();
            let allowed = format!("a multiple of {sides}, at least {least}");
            faults(&format!("{at}/gores"), self.gores.to_string(), allowed, hint);
        }
    }

    fn check_cones(&self, at: &str, faults: FaultSink<'_>) {
        let count = if self.kind == CanopyType::Biconical { 2 } else { 3 };
        let shown = |list: &Option<Vec<f64>>| list.as_ref().map_or("(missing)".to_owned(), |list| format!("{list:?}"));
        let angles = self.cone_angles.as_deref().unwrap_or_default();
        if angles.len() != count || !angles.iter().all(|a| (0.0..FRAC_PI_2).contains(a)) {
            let allowed = format!("{count} angles from 0 to below pi/2, from the apex outwards");
            faults(&format!("{at}/cone_angles"), shown(&self.cone_angles), allowed, in_radians(angles));
        }
        let ends: Vec<f64> = [vec![0.0], self.cone_breaks.clone().unwrap_or_default(), vec![1.0]].concat();
        let rises = ends.windows(2).all(|pair| pair[0] < pair[1]);
        if self.cone_breaks.is_some() && (ends.len() != count + 1 || !rises) {
            let allowed = format!("{} rising numbers between 0 and 1", count - 1);
            let hint = "where the angle changes, as parts of the gore's length".to_owned();
            faults(&format!("{at}/cone_breaks"), shown(&self.cone_breaks), allowed, hint);
        }
    }
}

/// Advice for angles that are too large, which are probably in degrees.
fn in_radians(angles: &[f64]) -> String {
    let list = |angles: &mut dyn Iterator<Item = f64>| angles.map(|a| figures(a, 4)).collect::<Vec<_>>().join(", ");
    if angles.iter().all(|a| a.abs() <= PI) || angles.iter().any(|a| a.abs() > 180.0) {
        return "give radians".to_owned();
    }
    let [degrees, radians] = [list(&mut angles.iter().copied()), list(&mut angles.iter().map(|a| a.to_radians()))];
    format!("give radians: {degrees} degrees are {radians}")
}
