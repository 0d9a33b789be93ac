//! The search for the step at which runs begin to fail.

use super::Kind;

/// Share of the prediction by which it is tried on either side.
const NEAR: f64 = 0.02;
/// [-] relative widths at which bisection ends: about a confirmed prediction, elsewhere, for methods whose steps are
/// dear.
const WIDTHS: [f64; 3] = [0.0051, 0.01, 0.05];
/// Largest factor between two steps of the search outwards.
const STRIDE: f64 = 256.0;
/// Factor from where nothing is searched any more.
const FARTHEST: f64 = 1e12;
/// Steps beyond this many times the start of a search that all hold: no limit.
const BEYOND: f64 = 1e9;
/// Factor between rungs for methods without limit.
const RUNG: f64 = 4.0;
/// Part of a run, one over this, that is the longest step tried of them.
const PARTS: f64 = 4.0;

/// What was found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Bracket {
    /// [s] largest step that held
    pub stable: Option<f64>,
    /// [s] least step above it that did not
    pub unstable: Option<f64>,
}

/// Brackets the largest stable step; `reference` [s] is where the search begins if nothing is predicted, `end` [s] that
/// of the case.
///
/// # Errors
/// Those of `holds`.
pub(super) fn largest<E>(
    kind: Kind,
    reference: f64,
    end: f64,
    holds: &mut dyn FnMut(f64) -> Result<bool, E>,
) -> Result<Bracket, E> {
    match kind {
        Kind::Near(predicted) => near(predicted, holds),
        Kind::Somewhere => {
            let held = holds(reference)?;
            let found = outwards(reference, held, holds)?;
            bisect(found, WIDTHS[1], holds)
        }
        Kind::Unlimited => growing_steps(reference, end, holds),
    }
}

fn near<E>(predicted: f64, holds: &mut dyn FnMut(f64) -> Result<bool, E>) -> Result<Bracket, E> {
    let (well_below, below, above) = (0.5 * predicted, (1.0 - NEAR) * predicted, (1.0 + NEAR) * predicted);
    // What a run well below the limit does is what the others are compared with.
    if !holds(well_below)? {
        let found = outwards(well_below, false, holds)?;
        return bisect(found, WIDTHS[1], holds);
    }
    if !holds(below)? {
        return bisect(Bracket { stable: Some(well_below), unstable: Some(below) }, WIDTHS[1], holds);
    }
    if holds(above)? {
        let found = outwards(above, true, holds)?;
        return bisect(found, WIDTHS[1], holds);
    }
    bisect(Bracket { stable: Some(below), unstable: Some(above) }, WIDTHS[0], holds)
}

/// From a step that holds to ever longer ones, or from one that fails to ever shorter ones.
fn outwards<E>(from: f64, held: bool, holds: &mut dyn FnMut(f64) -> Result<bool, E>) -> Result<Bracket, E> {
    let bracket = |held_at, failed_at| Bracket { stable: held_at, unstable: failed_at };
    let (mut last, mut factor) = (from, 2.0_f64);
    while if held { last < BEYOND * from } else { last > from / FARTHEST } {
        let next = if held { last * factor } else { last / factor };
        if holds(next)? != held {
            return Ok(if held { bracket(Some(last), Some(next)) } else { bracket(Some(next), Some(last)) });
        }
        last = next;
        factor = (factor * factor).min(STRIDE);
    }
    Ok(if held { bracket(Some(last), None) } else { bracket(None, Some(last)) })
}

/// Rungs from the first on up to a part of the run; the first that fails is bisected.
fn growing_steps<E>(first: f64, end: f64, holds: &mut dyn FnMut(f64) -> Result<bool, E>) -> Result<Bracket, E> {
    let top = (end / PARTS).max(first);
    let mut stable = None;
    let mut rung = first;
    loop {
        if !holds(rung)? {
            let found = match stable {
                Some(_) => Bracket { stable, unstable: Some(rung) },
                None => outwards(rung, false, holds)?,
            };
            return bisect(found, WIDTHS[2], holds);
        }
        stable = Some(rung);
        if rung >= top {
            return Ok(Bracket { stable, unstable: None });
        }
        // No last rung just above the one before.
        rung = if rung * RUNG * 1.5 > top { top } else { rung * RUNG };
    }
}

/// Halves the bracket, in logarithms, until it is narrow.
fn bisect<E>(bracket: Bracket, width: f64, holds: &mut dyn FnMut(f64) -> Result<bool, E>) -> Result<Bracket, E> {
    let Bracket { stable: Some(mut stable), unstable: Some(mut unstable) } = bracket else { return Ok(bracket) };
    while unstable > stable * (1.0 + width) {
        let middle = (stable * unstable).sqrt();
        if !(middle > stable && middle < unstable) {
            break;
        }
        if holds(middle)? {
            stable = middle;
        } else {
            unstable = middle;
        }
    }
    Ok(Bracket { stable: Some(stable), unstable: Some(unstable) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    /// The bracket around a sharp limit, and the number of runs it took.
    fn search(kind: Kind, limit: f64) -> (Bracket, u32) {
        let mut runs = 0;
        let mut holds = |h: f64| {
            runs += 1;
            Ok::<_, Infallible>(h <= limit)
        };
        let found = largest(kind, 1e-3, 2.0, &mut holds).expect("cannot fail");
        (found, runs)
    }

    /// A right prediction is confirmed to half a percent in six runs; a wrong one is corrected to a percent, however
    /// wrong it is.
    #[test]
    fn brackets_hold_the_limit() {
        for (limit, width, most) in
            [(1.0, 0.0051, 6), (1.015, 0.0051, 6), (0.3, 0.01, 12), (40.0, 0.01, 16), (1e-7, 0.01, 24)]
        {
            let (Bracket { stable, unstable }, runs) = search(Kind::Near(1.0), limit);
            let (stable, unstable) = (stable.expect("a stable step"), unstable.expect("an unstable step"));
            assert!(stable <= limit && limit < unstable, "{stable} {limit} {unstable}");
            assert!(unstable / stable - 1.0 <= width && runs <= most, "{limit}: {stable} to {unstable} in {runs} runs");
        }
    }

    /// What never fails is said to be so, up to the longest step tried; what always fails has no stable step.
    #[test]
    fn all_or_nothing() {
        let (found, _) = search(Kind::Unlimited, f64::INFINITY);
        assert_eq!(found, Bracket { stable: Some(0.5), unstable: None });
        let (found, _) = search(Kind::Unlimited, 0.1);
        let (stable, unstable) = (found.stable.expect("a stable step"), found.unstable.expect("an unstable step"));
        assert!(stable <= 0.1 && unstable > 0.1 && unstable / stable <= 1.05, "{found:?}");
        assert_eq!(search(Kind::Somewhere, 0.0).0.stable, None);
        assert_eq!(search(Kind::Near(1.0), f64::INFINITY).0.unstable, None);
    }
}
