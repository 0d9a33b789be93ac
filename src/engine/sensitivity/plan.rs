//! Which parts of a run are made again so that its steps are met in reverse order while few of them are kept.
//!
//! The steps are divided into segments of as many steps as can be kept. Segments are gone back over from the last one.
//! To make one again, the run is resumed from a snapshot before it. With s places for snapshots and every step made at
//! most r times more, C(s + r, s) segments can be reversed, which is the most there is (Griewank & Walther 2000,
//! Algorithm 799: Revolve).

/// Steps that are made again, from a snapshot on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Segment {
    /// from the newest snapshot make the steps up to this number, and take another snapshot there
    Snapshot(u64),
    /// from the newest snapshot make the steps up to the first number, then keep those up to the second one, and go
    /// back over them
    Reverse([u64; 2]),
    /// drop the newest snapshot
    Drop,
}

/// The parts of a run in the order in which they are made, after a snapshot at its start.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Plan {
    /// the parts
    pub parts: Vec<Segment>,
}

/// C(s + r, s), or the largest number.
fn reversible(s: u64, r: u64) -> u64 {
    (1..=s).try_fold(1_u64, |made, k| Some(made.checked_mul(r.checked_add(k)?)? / k)).unwrap_or(u64::MAX)
}

impl Plan {
    /// For a number of `steps`, of which `states` can be kept at once, snapshots included; at least 2.
    pub fn new(steps: u64, states: u64) -> Self {
        let states = states.max(2);
        let length = (states / 2).max(1);
        let mut plan = Plan::default();
        // The snapshot at the start has a place of its own.
        plan.reverse([0, steps], length, states - length - 1);
        plan
    }

    /// Goes back over steps, with a snapshot before them and places for some more.
    fn reverse(&mut self, [mut first, mut last]: [u64; 2], length: u64, places: u64) {
        let start = first;
        while last > start {
            let segments = (last - start).div_ceil(length);
            if segments == 1 || places == 0 {
                first = last.saturating_sub(length).max(start);
                self.parts.push(Segment::Reverse([first, last]));
                last = first;
                continue;
            }
            let repeats = (1..).find(|&r| reversible(places, r) >= segments).unwrap_or(u64::MAX);
            // As many after the snapshot as one place less can reverse.
            let after = reversible(places - 1, repeats).min(segments - 1);
            let middle = start + (segments - after) * length;
            self.parts.push(Segment::Snapshot(middle));
            self.reverse([middle, last], length, places - 1);
            self.parts.push(Segment::Drop);
            last = middle;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Follows a plan: steps that are made, most snapshots at once, and whether steps are met in reverse order.
    fn follow(steps: u64, states: u64) -> (u64, usize) {
        let plan = Plan::new(steps, states);
        let (mut snapshots, mut made, mut next, mut most) = (vec![0], 0, steps, 1);
        for part in plan.parts {
            let at = *snapshots.last().expect("a snapshot");
            match part {
                Segment::Snapshot(to) => {
                    assert!(to > at);
                    made += to - at;
                    snapshots.push(to);
                    most = most.max(snapshots.len());
                }
                Segment::Reverse([first, last]) => {
                    assert!(first >= at && last == next && last - first <= (states / 2).max(1), "{first} {last} {at}");
                    made += last - at;
                    next = first;
                }
                Segment::Drop => drop(snapshots.pop()),
            }
        }
        assert_eq!((next, snapshots.len()), (0, 1));
        (made, most)
    }

    /// All steps are met once, from the last to the first, with no more states than there are places for; with 20
    /// places 2,000 steps are made at most four times more.
    #[test]
    fn steps_are_met_in_reverse_order() {
        for steps in [1, 2, 7, 19, 20, 21, 100, 2000] {
            for states in [2, 3, 4, 5, 20, 64] {
                let (made, most) = follow(steps, states);
                assert!(most as u64 + (states / 2).max(1) <= states, "{steps} {states}: {most}");
                if states == 20 {
                    assert!(made <= 4 * steps, "{steps}: {made}");
                }
            }
        }
    }
}
