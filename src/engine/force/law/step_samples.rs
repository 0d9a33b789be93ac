//! Tables in runs of fixed steps, whose samples miss changes between them. A pulse within a step would be missed, and
//! one of the length of a step would count three times in the four stages of RK4.
//!
//! The steps t_n = n h are not changed. A table g with corners within steps is replaced by one that is linear within
//! these steps. Its values g_n at their ends keep the integral of g, so every scheme transfers the whole impulse,
//! wherever in a step it samples. With the deviation e of g from its chord over the step from t_n to t_{n+1} and s = (t
//! - t_n)/h,
//! ```text
//! d0 = integral of e ds,   d1 = integral of e s ds,     g_n = g(t_n) + d0 - d1,   g_{n+1} = g(t_{n+1}) + d1
//! ```
//! are the values that keep integral and first moment: a change at t_n acts over the steps on both sides of it, h in
//! total. Where one of the two would leave the range of g in the step (a jump would overshoot), the excess goes to the
//! other. This keeps the integral only; an impulse h J that is up to a step early or late is an error of second order.
//! At t = 0 a value counts for half a step only, because no force acts before: there all of d0 goes to t_1, and any
//! excess over the range goes to t_0, twice.
//!
//! Steps without a corner inside, and not next to such steps, use the table itself, bit for bit; schemes then have
//! their full order.

use crate::model::spec::Series;

/// [-] Relative rounding error of a time, and of a value after that many steps.
const ROUNDINGS: f64 = 4.0 * f64::EPSILON;
/// Rows after this many steps are never reached.
const LAST: f64 = 1e15;

/// The replacement of a table in steps of `h` [s] from t = 0; `None` if it has no corner within a step. Work: rows
/// times the logarithm of their number.
pub(crate) fn sampled_by_steps<const N: usize>(given: &Series<[f64; N]>, h: f64) -> Option<Series<[f64; N]>> {
    let mut bent = Vec::new();
    let mut corrections: Vec<(u64, [f64; N])> = Vec::new();
    let mut first = 0;
    for n in steps_with_rows(&given.t, h) {
        let (start, end) = (time(n, h), time(n + 1, h));
        first += given.t[first..].partition_point(|&t| t <= start);
        let last = first + given.t[first..].partition_point(|&t| t < end);
        let inside = given.t[first..last].iter().map(|t| (t - start) / h).zip(&given.value[first..last]);
        let ends = [start, end].map(|t| given.at(t));
        let shares: [[f64; 2]; N] = std::array::from_fn(|i| {
            correction(n, inside.clone().map(|(s, value)| (s, value[i])), ends.map(|value| value[i]))
        });
        if shares.iter().all(|share| share.iter().all(|c| c.is_nan())) {
            continue;
        }
        bent.push(n);
        for (node, which) in [(n, 0), (n + 1, 1)] {
            let add = shares.map(|share| if share[which].is_nan() { 0.0 } else { share[which] });
            match corrections.last_mut() {
                Some((last, sum)) if *last == node => sum.iter_mut().zip(add).for_each(|(sum, add)| *sum += add),
                _ => corrections.push((node, add)),
            }
        }
    }
    if bent.is_empty() { None } else { Some(replaced(given, h, &bent, &corrections)) }
}

/// [s] Time at the end of step `n`, in the bits of the clock of fixed steps.
fn time(n: u64, h: f64) -> f64 {
    n as f64 * h
}

/// The steps, counted from 0 and ascending, that have a row inside; for a row at the end of a step, both steps beside
/// it, in spite of rounding.
fn steps_with_rows(t: &[f64], h: f64) -> Vec<u64> {
    let mut steps = Vec::new();
    for at in t.iter().map(|t| t / h).filter(|at| *at > -ROUNDINGS && *at < LAST) {
        let end = at.round();
        if (at - end).abs() <= ROUNDINGS * end.max(1.0) {
            steps.extend((end as u64).checked_sub(1));
            steps.push(end as u64);
        } else {
            steps.push(at as u64);
        }
    }
    steps.sort_unstable();
    steps.dedup();
    steps
}

/// The corrections of the values at the two ends of step `n`, for a table with rows (s, value) `inside`, s from 0 to 1;
/// NaN where it has no corner in the step.
fn correction(n: u64, inside: impl Iterator<Item = (f64, f64)>, ends: [f64; 2]) -> [f64; 2] {
    let chord = |s: f64| ends[0] * (1.0 - s) + ends[1] * s;
    let [mut d0, mut d1] = [0.0; 2];
    let [mut low, mut high] = [ends[0].min(ends[1]), ends[0].max(ends[1])];
    let (mut before, mut largest) = ((0.0, 0.0), 0.0_f64);
    for (s, value) in inside.chain([(1.0, ends[1])]) {
        let here = (s, value - chord(s));
        let (width, [a, b]) = (s - before.0, [before.1, here.1]);
        d0 += 0.5 * width * (a + b);
        d1 += width / 6.0 * (a * (2.0 * before.0 + s) + b * (before.0 + 2.0 * s));
        (low, high, largest) = (low.min(value), high.max(value), largest.max(here.1.abs()));
        before = here;
    }
    if largest <= ROUNDINGS * (n + 1) as f64 * low.abs().max(high.abs()) {
        return [f64::NAN; 2];
    }
    let halo = |value: f64| value - value.clamp(low, high);
    if n == 0 {
        let excess = halo(ends[1] + d0);
        return [2.0 * excess, d0 - excess];
    }
    // The sum is always d0.
    let [early, late] = [halo(ends[0] + d0 - d1), halo(ends[1] + d1)];
    let moved = if early == 0.0 { late } else { -early };
    [d0 - d1 + moved, d1 - moved]
}

/// The table with its rows within the steps `bent`, and those next to them, replaced by rows at the ends of these
/// steps.
fn replaced<const N: usize>(
    given: &Series<[f64; N]>,
    h: f64,
    bent: &[u64],
    corrections: &[(u64, [f64; N])],
) -> Series<[f64; N]> {
    let mut nodes: Vec<u64> = bent.iter().flat_map(|&n| n.saturating_sub(1)..=n + 2).collect();
    nodes.sort_unstable();
    nodes.dedup();
    let at_end = |&node: &u64| {
        let t = time(node, h);
        let found = corrections.binary_search_by_key(&node, |(node, _)| *node);
        let add = found.map_or([0.0; N], |i| corrections[i].1);
        let value = given.at(t);
        (t, std::array::from_fn(|i| value[i] + add[i]))
    };
    // Between two neighbouring ends there are no other rows.
    let kept = |t: f64| {
        let after = nodes.partition_point(|&node| time(node, h) < t);
        let at = nodes.get(after).is_some_and(|&node| time(node, h) == t);
        let within = after > 0 && after < nodes.len() && nodes[after] == nodes[after - 1] + 1;
        !at && !within
    };
    let own = given.t.iter().copied().zip(given.value.iter().copied()).filter(|(t, _)| kept(*t));
    let mut rows: Vec<(f64, [f64; N])> = own.chain(nodes.iter().map(at_end)).collect();
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (t, value) = rows.into_iter().unzip();
    Series { t, value }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(rows: &[[f64; 2]]) -> Series<[f64; 1]> {
        Series { t: rows.iter().map(|r| r[0]).collect(), value: rows.iter().map(|r| [r[1]]).collect() }
    }

    fn values(rows: &[[f64; 2]], h: f64, n: u64) -> Vec<f64> {
        let made = sampled_by_steps(&table(rows), h).expect("a corner within a step");
        (0..n).map(|n| made.at(time(n, h))[0]).collect()
    }

    fn close(found: &[f64], expected: &[f64]) {
        let same = found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12);
        assert!(same && found.len() == expected.len(), "{found:?}, expected {expected:?}");
    }

    #[test]
    fn corners_at_the_ends_of_steps_change_nothing() {
        let rows = [[0.0, 0.0], [0.1, 1.0], [0.3, 1.0], [0.7, -2.0], [5.0, 0.0]];
        assert_eq!(sampled_by_steps(&table(&rows), 0.1), None);
        assert_eq!(sampled_by_steps(&table(&[[0.05, 3.0]]), 0.1), None);
        assert_eq!(sampled_by_steps(&table(&[[0.0, 0.0], [0.05, 1.0], [0.1, 2.0]]), 0.1), None, "no bend");
    }

    #[test]
    fn jumps_do_not_overshoot() {
        let tiny = 1e-9;
        close(&values(&[[2.25, 0.0], [2.25 + tiny, 1.0]], 1.0, 5), &[0.0, 0.0, 0.25 - tiny / 2.0, 1.0, 1.0]);
        close(&values(&[[2.75, 0.0], [2.75 + tiny, 1.0]], 1.0, 5), &[0.0, 0.0, 0.0, 0.75 - tiny / 2.0, 1.0]);
        close(&values(&[[2.0, 0.0], [2.0 + tiny, 1.0]], 1.0, 5), &[0.0, 0.0, 0.5 - tiny / 2.0, 1.0, 1.0]);
        close(&values(&[[2.0 - tiny, 0.0], [2.0, 1.0]], 1.0, 5), &[0.0, 0.0, 0.5 + tiny / 2.0, 1.0, 1.0]);
        close(&values(&[[0.0, 0.0], [tiny, 1.0]], 1.0, 3), &[1.0 - tiny, 1.0, 1.0]);
    }

    #[test]
    fn a_pulse_keeps_integral_and_first_moment() {
        // Area 0.1, centroid at 2.4.
        let g = values(&[[2.3, 0.0], [2.4, 1.0], [2.5, 0.0]], 1.0, 6);
        close(&g, &[0.0, 0.0, 0.06, 0.04, 0.0, 0.0]);
        // Before the first end no force acts: all of it goes to the next.
        close(&values(&[[0.3, 0.0], [0.4, 1.0], [0.5, 0.0]], 1.0, 4), &[0.0, 0.1, 0.0, 0.0]);
    }

    #[test]
    fn many_rows_cost_what_they_are() {
        let rows: Vec<[f64; 2]> = (0..100_000).map(|i| [f64::from(i) * 1e-5, f64::from(i % 7)]).collect();
        let made = sampled_by_steps(&table(&rows), 1e-2).expect("corners");
        assert_eq!(made.t.len(), 102);
        assert!(made.t.is_sorted_by(|a, b| a < b));
        // Trapezia of the rows.
        let whole: f64 = rows.windows(2).map(|w| 0.5 * (w[0][1] + w[1][1]) * (w[1][0] - w[0][0])).sum();
        let kept: f64 =
            made.t.windows(2).zip(made.value.windows(2)).map(|(t, v)| 0.5 * (v[0][0] + v[1][0]) * (t[1] - t[0])).sum();
        let last = rows.last().map_or(0.0, |row| row[1]);
        let halo = made.t[101] - 0.99999;
        assert!((kept - whole - last * halo).abs() < 1e-12, "{kept} {whole}");
    }
}
