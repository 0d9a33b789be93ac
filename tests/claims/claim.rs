//! A claim: what is measured on a run of the program, what it should be, and how far off it may be.

use std::fmt;

/// One row of the table.
#[derive(Clone, Debug)]
pub struct Claim {
    /// the statement, with its parameters
    pub what: String,
    /// what a run gave
    pub measured: f64,
    /// what theory says
    pub expected: ExpectedUse,
}

/// What theory says of a measured number.
#[derive(Clone, Copy, Debug)]
pub enum ExpectedUse {
    /// a value, to a share of its size
    Relative { value: f64, tolerance: f64 },
    /// a value, to an absolute tolerance in its own unit
    Absolute { value: f64, tolerance: f64 },
    /// an error that must stay below a bound
    Below(f64),
    /// anything between two bounds
    Between(f64, f64),
    /// a statement that is so (1) or not (0)
    So,
}

impl Claim {
    /// `measured` equals `value` to the share `tolerance` of it.
    pub fn relative(what: impl Into<String>, measured: f64, value: f64, tolerance: f64) -> Self {
        Claim { what: what.into(), measured, expected: ExpectedUse::Relative { value, tolerance } }
    }

    /// `measured` equals `value` to `tolerance`, in the unit of both.
    pub fn absolute(what: impl Into<String>, measured: f64, value: f64, tolerance: f64) -> Self {
        Claim { what: what.into(), measured, expected: ExpectedUse::Absolute { value, tolerance } }
    }

    /// `measured`, an error, is below `bound`.
    pub fn below(what: impl Into<String>, measured: f64, bound: f64) -> Self {
        Claim { what: what.into(), measured, expected: ExpectedUse::Below(bound) }
    }

    /// `measured` is between two bounds.
    pub fn between(what: impl Into<String>, measured: f64, low: f64, high: f64) -> Self {
        Claim { what: what.into(), measured, expected: ExpectedUse::Between(low, high) }
    }

    /// A statement without a number.
    pub fn is(what: impl Into<String>, so: bool) -> Self {
        Claim { what: what.into(), measured: f64::from(u8::from(so)), expected: ExpectedUse::So }
    }

    /// How far from the expected value, in the tolerance's measure; nothing for a bound.
    pub fn off(&self) -> Option<f64> {
        match self.expected {
            ExpectedUse::Relative { value, .. } => Some((self.measured - value).abs() / value.abs()),
            ExpectedUse::Absolute { value, .. } => Some((self.measured - value).abs()),
            ExpectedUse::Below(_) | ExpectedUse::Between(..) | ExpectedUse::So => None,
        }
    }

    /// The measured value as the table shows it.
    fn shown(&self) -> String {
        match self.expected {
            ExpectedUse::So => if self.measured == 1.0 { "yes" } else { "no" }.to_owned(),
            _ => short(self.measured),
        }
    }

    /// Whether the claim stands; a number that is not finite never does.
    pub fn holds(&self) -> bool {
        let off = self.off().unwrap_or(0.0);
        match self.expected {
            ExpectedUse::Relative { tolerance, .. } | ExpectedUse::Absolute { tolerance, .. } => off <= tolerance,
            ExpectedUse::So => self.measured == 1.0,
            ExpectedUse::Below(bound) => self.measured.abs() <= bound,
            ExpectedUse::Between(low, high) => (low..=high).contains(&self.measured),
        }
    }
}

impl fmt::Display for ExpectedUse {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            ExpectedUse::Relative { value, tolerance } => write!(f, "{} to {tolerance:.1e} of it", short(value)),
            ExpectedUse::Absolute { value, tolerance } => write!(f, "{} +- {tolerance:.1e}", short(value)),
            ExpectedUse::Below(bound) => write!(f, "below {bound:.1e}"),
            ExpectedUse::So => f.write_str("yes"),
            ExpectedUse::Between(low, high) => write!(f, "{} .. {}", short(low), short(high)),
        }
    }
}

/// A number as a person reads it: few digits, powers of ten where they help.
pub fn short(value: f64) -> String {
    let size = value.abs();
    if size != 0.0 && !(1e-3..1e6).contains(&size) { format!("{value:.4e}") } else { format!("{value:.6}") }
}

/// Row by row: verdict, statement, measured, expected with its tolerance.
pub fn table(group: &str, claims: &[Claim]) -> String {
    let mut text = format!("\n{group}\n");
    for c in claims {
        let verdict = if c.holds() { "  ok " } else { "MISS " };
        let off = c.off().map_or_else(String::new, |off| format!("off by {off:.1e}"));
        text += &format!("{verdict} {:<92} {:>14}   {:<28} {off}\n", c.what, c.shown(), c.expected.to_string());
    }
    text
}
