//! Numbers in messages.

/// A number rounded to `digits` significant digits: plain if it is neither very large nor very small, else with a power
/// of ten.
///
/// ```
/// use canopy_fem_mesh::format_number::figures;
/// assert_eq!(figures(0.1 + 0.2, 12), "0.3");
/// assert_eq!(figures(123456.0, 3), "123000");
/// assert_eq!(figures(1.5e-12, 4), "1.5e-12");
/// ```
pub fn figures(x: f64, digits: usize) -> String {
    let x = format!("{x:.*e}", digits.saturating_sub(1)).parse().unwrap_or(x);
    if x == 0.0 || (1e-3..1e6).contains(&x.abs()) { format!("{x}") } else { format!("{x:e}") }
}

/// A positive number rounded down to two digits, for a recommended step.
///
/// ```
/// use canopy_fem_mesh::format_number::two_digits;
/// assert_eq!(two_digits(1.29e-3), 1.2e-3);
/// ```
pub fn two_digits(step: f64) -> f64 {
    let unit = 10_f64.powf(step.log10().floor() - 1.0);
    let rounded = (step / unit * (1.0 + 1e-12)).floor() * unit;
    // By way of text, so that it is exactly the number that is printed.
    format!("{rounded:.1e}").parse().unwrap_or(step)
}

/// A number with its error, to the digits that the error leaves: one, or two where that is a 1; at most six digits.
///
/// ```
/// use canopy_fem_mesh::format_number::with_error;
/// assert_eq!(with_error(4938.71, Some(3.6)), "4939 ± 4");
/// assert_eq!(with_error(0.0123456, Some(1.23e-4)), "0.01235 ± 0.00012");
/// assert_eq!(with_error(5.95, Some(1e-9)), "5.95000 ± 1e-9");
/// assert_eq!(with_error(5.951234, None), "5.951");
/// ```
pub fn with_error(value: f64, error: Option<f64>) -> String {
    let Some(error) = error.filter(|error| error.is_finite() && *error > 0.0) else { return figures(value, 4) };
    let place = |x: f64| x.abs().log10().floor() as i32;
    let rounded: f64 = format!("{error:.0e}").parse().unwrap_or(error);
    let leads_with_one = rounded / 10.0_f64.powi(place(rounded)) < 1.5;
    let wanted = -place(rounded) + i32::from(leads_with_one);
    let most = 5 - if value == 0.0 { place(error) } else { place(value) };
    let decimals = wanted.min(most).clamp(0, 12) as usize;
    let shown = if wanted <= 12 && wanted <= most && wanted >= 0 {
        format!("{error:.decimals$}")
    } else {
        figures(error, if wanted < 0 { (place(error) + 1).max(1) as usize } else { 1 })
    };
    format!("{value:.decimals$} ± {shown}")
}

/// A number with its noun: "1 step", "2 steps".
///
/// ```
/// use canopy_fem_mesh::format_number::counted;
/// assert_eq!([0, 1, 2].map(|n| counted(n, "step", "steps")), ["0 steps", "1 step", "2 steps"]);
/// ```
pub fn counted(n: u64, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}

/// Items for a message: the first few, and their number.
pub fn first_few<T: ToString>(items: &[T]) -> String {
    let shown: Vec<String> = items.iter().take(5).map(T::to_string).collect();
    let rest = if items.len() > 5 { format!(", … ({} in all)", items.len()) } else { String::new() };
    format!("{}{rest}", shown.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_rounded_down() {
        for (step, typed) in [(1.29e-3, 1.2e-3), (9.99e-4, 9.9e-4), (0.05, 0.05), (3.0, 3.0), (1e-12, 1e-12)] {
            assert_eq!(two_digits(step), typed, "{step}");
        }
    }
}
