//! The accuracy that numbers are asked for with: a share of them, or a number with its unit.

use super::error::StudyError;
use crate::format_number::figures;
use crate::output::gauges::MeasuredQuantity;

/// The accuracy that is asked for.
#[derive(Clone, Debug, PartialEq)]
pub enum Accuracy {
    /// [-] share of the value
    Relative(f64),
    /// in a unit
    Absolute(f64, String),
}

impl std::str::FromStr for Accuracy {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let text = text.trim();
        let end = text.find(|c: char| !(c.is_ascii_digit() || "+-.eE".contains(c))).unwrap_or(text.len());
        let (number, unit) = text.split_at(end);
        let expected = || "expected a share such as 1% or 5e-3, or a number with its unit such as 20N".to_owned();
        let number: f64 = number.trim().parse().map_err(|_| expected())?;
        if !(number > 0.0 && number.is_finite()) {
            return Err(format!("{number} is not above 0"));
        }
        match unit.trim() {
            "%" if number < 100.0 => Ok(Accuracy::Relative(number / 100.0)),
            "" if number < 1.0 => Ok(Accuracy::Relative(number)),
            "" | "%" => Err(format!("{text} is not below the whole value; {}", expected())),
            unit => Ok(Accuracy::Absolute(number, unit.to_owned())),
        }
    }
}

impl std::fmt::Display for Accuracy {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Accuracy::Relative(share) => write!(f, "{} %", figures(100.0 * share, 3)),
            Accuracy::Absolute(number, unit) => write!(f, "{} {unit}", figures(*number, 4)),
        }
    }
}

/// [-] Share of the largest magnitude of a series below which a value of it is small.
const SMALL: f64 = 0.01;

impl Accuracy {
    /// [-] The share; of a unit, 1 %.
    pub fn share(&self) -> f64 {
        match self {
            Accuracy::Relative(share) => *share,
            Accuracy::Absolute(..) => 0.01,
        }
    }

    /// The error that a quantity may have, relative to its size.
    ///
    /// # Errors
    /// Another unit.
    pub fn allows(&self, quantity: &MeasuredQuantity) -> Result<f64, StudyError> {
        let scale = quantity.value.map_or(1.0, |value| measure_of(value, quantity.largest));
        self.allowed(&quantity.name, quantity.unit, scale)
    }

    /// The error that a quantity may have whose measure is `scale`.
    ///
    /// # Errors
    /// Another unit.
    pub(super) fn allowed(&self, name: &str, of: &str, scale: f64) -> Result<f64, StudyError> {
        match self {
            Accuracy::Relative(share) => Ok(share * scale),
            Accuracy::Absolute(number, unit) if unit == of => Ok(*number),
            Accuracy::Absolute(_, unit) => Err(StudyError::Usage(format!(
                "--within {self}: {name} is in {of}, not in {unit}; name the quantities that are meant with --quantity"
            ))),
        }
    }
}

/// What errors of a value are shares of: the value, or, where it is small beside the largest of its series, as of a
/// vibration that has died away, a hundredth of that.
pub(super) fn measure_of(value: f64, largest: f64) -> f64 {
    value.abs().max(SMALL * largest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn accuracies_as_typed() {
        assert_eq!("1%".parse(), Ok(Accuracy::Relative(0.01)));
        assert_eq!("5e-3".parse(), Ok(Accuracy::Relative(5e-3)));
        assert_eq!("20N".parse(), Ok(Accuracy::Absolute(20.0, "N".to_owned())));
        assert_eq!("0.1 m/s".parse(), Ok(Accuracy::Absolute(0.1, "m/s".to_owned())));
        assert_eq!("0.5 m/s^2".parse(), Ok(Accuracy::Absolute(0.5, "m/s^2".to_owned())));
        for wrong in ["", "%", "N", "0", "-1%", "2", "100%", "soon"] {
            assert!(wrong.parse::<Accuracy>().is_err(), "{wrong}");
        }
    }
}
