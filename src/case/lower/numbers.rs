//! Range checks of single numbers.

use crate::case::diagnostics::Faults;
use crate::case::pointer::Pointer;

/// Notes a fault unless `x` is above 0 and finite; says whether it is good, which a stand-in is not.
pub(super) fn positive(at: &Pointer, x: f64, faults: &mut Faults<'_>) -> bool {
    let good = x > 0.0 && x.is_finite();
    if !good {
        faults.add(at, "a number above 0");
    }
    good && faults.readable(at)
}

/// Notes a fault unless `x` is 0 or more and finite.
pub(super) fn not_negative(at: &Pointer, x: f64, faults: &mut Faults<'_>) -> bool {
    let good = x >= 0.0 && x.is_finite();
    if !good {
        faults.add(at, "a number of 0 or more");
    }
    good && faults.readable(at)
}

/// Notes a fault unless 0 < x < 1.
pub(super) fn fraction(at: &Pointer, x: f64, faults: &mut Faults<'_>) -> bool {
    let good = x > 0.0 && x < 1.0;
    if !good {
        faults.add(at, "a number above 0 and below 1");
    }
    good && faults.readable(at)
}
