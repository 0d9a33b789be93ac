//! Numbers of the field by type, which a case takes where it gives none.
//!
//! T. W. Knacke, Parachute Recovery Systems Design Manual, 1991, tables 5-1, 5-2 and 5-6, quoted by way of a public
//! code that cites its pages. Ranges are those of the tables, and the lower end of a drag coefficient is the default:
//! it falls faster.

use super::CanopyType;
use crate::format_number::figures;

/// Where the numbers are from.
const SOURCE: &str = "Knacke 1991, tables 5-1, 5-2 and 5-6";

/// What is known of a type; `None` where no number was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldNumbers {
    /// [-] least and largest drag coefficient CD0, on S0
    pub drag_coefficient: Option<[f64; 2]>,
    /// [-] filling constant n, without a reefing line
    pub filling_constant: Option<f64>,
    /// [-] exponent of the growth of the drag area; 2 where none was found
    pub exponent: Option<f64>,
    /// [-] least and largest projected diameter over D0
    pub projected_diameter: Option<[f64; 2]>,
    /// [-] opening-force coefficient at infinite mass
    pub opening_force: Option<f64>,
    /// [-] length of the suspension lines over D0, where a case gives none: 1.7 of the Viking canopy, else assumed to
    /// be 1; usual lines have 0.8 to 1
    pub line_length: Option<f64>,
}

/// Nothing but lines of D0.
impl Default for FieldNumbers {
    fn default() -> Self {
        Self {
            drag_coefficient: None,
            filling_constant: None,
            exponent: None,
            projected_diameter: None,
            opening_force: None,
            line_length: Some(1.0),
        }
    }
}

impl FieldNumbers {
    /// Where the numbers but the length of the lines are from.
    pub const fn source() -> &'static str {
        SOURCE
    }

    /// The numbers in words; `None` if there is none but the length of the lines.
    pub fn describe(&self) -> Option<String> {
        let number = |value: f64| figures(value, 4);
        let range = |[low, high]: [f64; 2]| {
            if low == high { number(low) } else { format!("{} to {}", number(low), number(high)) }
        };
        let parts = [
            self.drag_coefficient.map(|cd| format!("CD0 {}", range(cd))),
            self.filling_constant.map(|n| format!("n {}", number(n))),
            self.exponent.map(|j| format!("exponent {}", number(j))),
            self.projected_diameter.map(|d| format!("Dp/D0 {}", range(d))),
            self.opening_force.map(|c| format!("Cx {}", number(c))),
        ];
        let known: Vec<String> = parts.into_iter().flatten().collect();
        (!known.is_empty()).then(|| format!("{} ({SOURCE})", known.join(", ")))
    }
}

impl CanopyType {
    /// All types.
    pub const ALL: [Self; 16] = [
        Self::FlatCircular,
        Self::Conical,
        Self::Biconical,
        Self::Triconical,
        Self::Hemispherical,
        Self::ExtendedSkirt,
        Self::Annular,
        Self::Cruciform,
        Self::Ringslot,
        Self::Ribbon,
        Self::Ringsail,
        Self::DiskGapBand,
        Self::Elliptical,
        Self::Toroidal,
        Self::Square,
        Self::Triangular,
    ];

    /// What is known of this type.
    pub fn numbers(self) -> FieldNumbers {
        match self {
            Self::FlatCircular => row([0.75, 0.80], [Some(8.0), Some(2.0)], Some([0.64, 0.70]), 1.7),
            Self::Conical => row([0.75, 0.90], [None; 2], Some([0.70; 2]), 1.8),
            Self::Biconical => row([0.75, 0.92], [None; 2], Some([0.70; 2]), 1.8),
            Self::Triconical => row([0.80, 0.96], [None; 2], Some([0.70; 2]), 1.8),
            Self::Hemispherical => row([0.62, 0.77], [None; 2], Some([0.66; 2]), 1.6),
            Self::ExtendedSkirt => row([0.78, 0.87], [Some(10.0), Some(2.0)], Some([0.66, 0.70]), 1.4),
            Self::Annular => row([0.85, 0.95], [None; 2], Some([0.94; 2]), 1.4),
            Self::Cruciform => row([0.60, 0.85], [Some(11.7), None], Some([0.66, 0.72]), 1.2),
            Self::Ringslot => row([0.56, 0.65], [Some(14.0), Some(1.0)], Some([0.67, 0.70]), 1.05),
            Self::Ribbon => row([0.45, 0.50], [Some(14.0), Some(1.0)], Some([0.67; 2]), 1.05),
            Self::Ringsail => row([0.75, 0.85], [Some(7.0), None], None, 1.10),
            Self::DiskGapBand => FieldNumbers { line_length: Some(1.7), ..FieldNumbers::default() },
            Self::Elliptical | Self::Toroidal | Self::Square | Self::Triangular => FieldNumbers::default(),
        }
    }
}

/// CD0, filling constant and exponent, Dp/D0 and Cx of a type.
fn row(cd: [f64; 2], [n, j]: [Option<f64>; 2], projected: Option<[f64; 2]>, opening: f64) -> FieldNumbers {
    FieldNumbers {
        drag_coefficient: Some(cd),
        filling_constant: n,
        exponent: j,
        projected_diameter: projected,
        opening_force: Some(opening),
        ..FieldNumbers::default()
    }
}
