//! Range checks of the numbers of lists, which the schema does not tell, and of tables over time.

use crate::case::diagnostics::Faults;
use crate::case::pointer::Pointer;
use crate::model::spec::Series;

/// Adds a fault unless `x` is above 0 and finite. Returns whether it is valid; a stand-in is not.
pub(super) fn positive(at: &Pointer, x: f64, faults: &mut Faults<'_>) -> bool {
    let good = x > 0.0 && x.is_finite();
    if !good {
        faults.add(at, "a number above 0");
    }
    good && faults.readable(at)
}

/// Adds a fault unless `x` is 0 or more and finite.
pub(super) fn not_negative(at: &Pointer, x: f64, faults: &mut Faults<'_>) -> bool {
    let good = x >= 0.0 && x.is_finite();
    if !good {
        faults.add(at, "a number of 0 or more");
    }
    good && faults.readable(at)
}

/// A table whose rows begin with the time; `None` if its times do not increase.
pub(super) fn series<T>(
    at: &Pointer,
    rows: impl Iterator<Item = (f64, T)>,
    faults: &mut Faults<'_>,
) -> Option<Series<T>> {
    rising(at, "time", rows, faults)
}

/// The same for rows that begin with something else than a time, such as a height.
pub(super) fn rising<T>(
    at: &Pointer,
    what: &str,
    rows: impl Iterator<Item = (f64, T)>,
    faults: &mut Faults<'_>,
) -> Option<Series<T>> {
    let (t, value): (Vec<f64>, Vec<T>) = rows.unzip();
    // A time that could not be read cannot be compared.
    if !faults.readable(at) {
        return None;
    }
    let before = faults.count();
    for (i, pair) in t.windows(2).enumerate() {
        if pair[1] <= pair[0] {
            faults.add_value(
                &at.index(i + 1),
                format!("{what} {} after {}", pair[1], pair[0]),
                format!("{what}s strictly increasing from row to row"),
                Some(format!("sort the rows by {what} and keep one row per {what}; for a jump use two close {what}s")),
            );
        }
    }
    (faults.count() == before).then_some(Series { t, value })
}
