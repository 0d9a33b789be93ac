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
pub fn first_few(items: &[u32]) -> String {
    let shown: Vec<String> = items.iter().take(5).map(u32::to_string).collect();
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
