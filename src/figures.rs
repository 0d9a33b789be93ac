//! Numbers as people read them.

/// A number rounded to `digits` significant digits: plain if it is of everyday size, else with a power of ten.
///
/// ```
/// use canopy_fem::figures::figures;
/// assert_eq!(figures(0.1 + 0.2, 12), "0.3");
/// assert_eq!(figures(123456.0, 3), "123000");
/// assert_eq!(figures(1.5e-12, 4), "1.5e-12");
/// ```
pub fn figures(x: f64, digits: usize) -> String {
    let x = format!("{x:.*e}", digits.saturating_sub(1)).parse().unwrap_or(x);
    if x == 0.0 || (1e-3..1e6).contains(&x.abs()) { format!("{x}") } else { format!("{x:e}") }
}
