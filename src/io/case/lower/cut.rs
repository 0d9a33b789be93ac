//! Springs that are cut: at a time, or one after another by a table.

use super::numbers::not_negative;
use crate::case::diagnostics::Faults;
use crate::case::pointer::Pointer;
use crate::case::schema::{CutRule, CutTable, SpringRule};
use crate::model::spec::{DashpotSpec, SpringGroup, SpringValues};

/// [-] Rounding of shares: a share is reached within it.
const ROUNDING: f64 = 1e-12;

impl CutRule {
    /// [s] The time from which on no more springs are cut; `None` if none is.
    pub(super) fn last(&self) -> Option<f64> {
        match self {
            CutRule::At(t) => Some(*t),
            CutRule::Table(table) => {
                let [_, share] = *table.table.last()?;
                table.time_of(share).filter(|_| share > 0.0)
            }
        }
    }
}

impl CutTable {
    /// [s] When this share of the springs is cut; `None` where the table does not reach it.
    fn time_of(&self, share: f64) -> Option<f64> {
        let reached = |row: &[f64; 2]| row[1] >= share - ROUNDING;
        let i = self.table.iter().position(reached)?;
        let [to, share_then] = self.table[i];
        Some(match i.checked_sub(1).map(|before| self.table[before]) {
            Some([from, share_before]) => {
                let part = ((share - share_before) / (share_then - share_before)).min(1.0);
                from + part * (to - from)
            }
            None => to,
        })
    }

    /// [s] When each of `springs` springs is cut: spring k, counted from 0, with those of its number, whose last one is
    /// k', when the share is (k' + 1)/n. `None` where it is not.
    fn times(&self, springs: usize) -> Vec<Option<f64>> {
        // None together is a fault of its own.
        let together = self.together.max(1);
        let last = |spring: usize| ((spring / together + 1) * together).min(springs);
        (0..springs).map(|spring| self.time_of(last(spring) as f64 / springs as f64)).collect()
    }
}

/// Reports what a rule cannot cut.
pub(super) fn check(at: &Pointer, rule: &SpringRule, faults: &mut Faults<'_>) {
    let Some(cut) = &rule.cut else { return };
    if rule.when.is_some() {
        faults.add_hint(&at.key("when"), "not together with cut", "a time is \"when\": {\"time\": ...} too");
    }
    let CutRule::Table(CutTable { table, together }) = cut else { return };
    let hint = "they are cut one after another, so that each is a rule of its own; a gauge measures their tensions";
    for (key, given) in [("strength", rule.strength.is_some()), ("breaks", rule.breaks)] {
        if given {
            faults.add_hint(&at.key(key), "not together with a table of cuts", hint);
        }
    }
    let at = at.key("cut");
    if *together == 0 {
        faults.add(&at.key("together"), "1 or more");
    }
    let at = at.key("table");
    let mut before = [0.0, 0.0];
    for (i, &[t, share]) in table.iter().enumerate() {
        let row = at.index(i);
        if !not_negative(&row.index(0), t, faults) {
            return;
        }
        if !(0.0..=1.0).contains(&share) {
            return faults.add(&row.index(1), "a share from 0 to 1");
        }
        let told = [("time", t, before[0]), ("share", share, before[1])];
        if let Some((what, now, earlier)) = told.into_iter().find(|(_, now, earlier)| now < earlier) {
            let hint = "sort the rows; a jump is two rows with the same time".to_owned();
            let value = format!("{what} {now} after {earlier}");
            return faults.add_value(&row, value, "times and shares that do not fall", Some(hint));
        }
        if t == 0.0 && share > 0.0 {
            let hint = "springs that are cut from the start need no rule; begin with [0, 0] or a later time";
            return faults.add_value(
                &row,
                format!("share {share} at the time 0"),
                "0 at the time 0",
                Some(hint.into()),
            );
        }
        before = [t, share];
    }
}

/// The springs of a rule by the times at which they are cut, those of a time together.
pub(super) fn groups(cut: Option<&CutRule>, group: SpringGroup) -> Vec<SpringGroup> {
    let table = match cut {
        None => return vec![group],
        Some(CutRule::At(t)) => return vec![SpringGroup { cut: Some(*t), ..group }],
        Some(CutRule::Table(table)) => table,
    };
    let times = table.times(group.edges.len());
    let springs: Vec<usize> = (0..times.len()).collect();
    let together = springs.chunk_by(|a, b| times[*a] == times[*b]);
    together.map(|springs| part(&group, springs, times[springs[0]])).collect()
}

/// Some springs of a group, which are cut at this time [s].
fn part(group: &SpringGroup, springs: &[usize], cut: Option<f64>) -> SpringGroup {
    let of = |values: &SpringValues| match values {
        SpringValues::Uniform(value) => SpringValues::Uniform(*value),
        SpringValues::PerEdge(values) => SpringValues::PerEdge(springs.iter().map(|&i| values[i]).collect()),
    };
    let dashpot = |dashpot: &DashpotSpec| DashpotSpec { coefficient: of(&dashpot.coefficient), ..dashpot.clone() };
    SpringGroup {
        edges: springs.iter().map(|&i| group.edges[i]).collect(),
        stiffness: of(&group.stiffness),
        rest_length: springs.iter().map(|&i| group.rest_length[i]).collect(),
        dashpot: group.dashpot.as_ref().map(dashpot),
        cut,
        ..group.clone()
    }
}
