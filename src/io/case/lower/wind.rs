//! The wind: a sum of velocities over time and height.

use std::path::Path;

use super::events::{Plan, Waits};
use super::numbers::{rising, series};
use crate::case::diagnostics::Faults;
use crate::case::pointer::Pointer;
use crate::case::schema::{Gust, Wind, WindPart};
use crate::model::spec::{EventWind, GustSpec, Series, WindOverTime};

/// A wind, summed by kind.
#[derive(Clone, Debug)]
pub(super) struct Winds {
    /// [m/s] over time [s]
    pub table: Series<[f64; 3]>,
    /// gusts, added to it
    pub gusts: Vec<GustSpec>,
    /// [m/s] over the height above sea level [m], added to it
    pub profile: Option<Series<[f64; 3]>>,
    /// those that begin with events, added to it
    pub by_event: Vec<EventWind>,
}

impl Winds {
    /// Calm air.
    pub(super) fn calm() -> Self {
        let table = Series { t: vec![0.0], value: vec![[0.0; 3]] };
        Winds { table, gusts: Vec::new(), profile: None, by_event: Vec::new() }
    }
}

/// The parts of a wind, and where they stand.
pub(super) fn parts<'a>(at: &Pointer, wind: &'a Wind) -> Vec<(Pointer, &'a WindPart)> {
    match wind {
        Wind::Part(part) => vec![(at.clone(), part)],
        Wind::Sum(parts) => parts.sum.iter().enumerate().map(|(i, part)| (at.key("sum").index(i), part)).collect(),
    }
}

/// Checks a wind and sums its parts by the events of `plan`; files are found from the folder `base`.
pub(super) fn wind(
    at: &Pointer,
    wind: &Wind,
    (base, plan): (&Path, &Plan<'_>),
    faults: &mut Faults<'_>,
) -> Option<Winds> {
    let before = faults.count();
    let (mut tables, mut profiles, mut gusts, mut by_event) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for (i, (at, part)) in parts(at, wind).into_iter().enumerate() {
        let event = plan.event(Waits::Wind(i));
        let mut add = |table| match event {
            Some(event) => by_event.push(EventWind { event, over_time: WindOverTime::Table(table) }),
            None => tables.push(table),
        };
        let split = |[t, x, y, z]: &[f64; 4]| (*t, [*x, *y, *z]);
        match part {
            WindPart::Constant(wind) => add(Series { t: vec![0.0], value: vec![*wind] }),
            WindPart::Table { table, .. } => {
                series(&at.key("table"), table.iter().map(split), faults).into_iter().for_each(add);
            }
            WindPart::Profile { profile } => {
                profiles.extend(rising(&at.key("profile"), "height", profile.iter().map(split), faults));
            }
            WindPart::Gust { gust: Gust { velocity, start, duration }, .. } => {
                let gust = GustSpec { velocity: *velocity, start: *start, duration: *duration };
                match event {
                    Some(event) => by_event.push(EventWind { event, over_time: WindOverTime::Gust(gust) }),
                    None => gusts.push(gust),
                }
            }
            WindPart::File { file, .. } => match read(&base.join(file)) {
                Ok(rows) => series(&at.key("file"), rows.iter().map(split), faults).into_iter().for_each(add),
                Err(reason) => {
                    let allowed = "a text file with rows of t, x, y, z in s and m/s, separated by commas";
                    faults.add_hint(&at.key("file"), allowed, reason);
                }
            },
        }
    }
    let table = sum(tables).unwrap_or_else(|| Winds::calm().table);
    let found = faults.count() == before && faults.readable(at);
    found.then(|| Winds { table, gusts, profile: sum(profiles), by_event })
}

/// The sum of tables, which is linear between the rows of all of them. `None` without tables.
fn sum(mut tables: Vec<Series<[f64; 3]>>) -> Option<Series<[f64; 3]>> {
    if tables.len() <= 1 {
        return tables.pop();
    }
    let mut t: Vec<f64> = tables.iter().flat_map(|table| &table.t).copied().collect();
    t.sort_unstable_by(f64::total_cmp);
    t.dedup();
    let at = |t: f64| {
        let values = tables.iter().map(|table| table.at(t));
        values.fold([0.0; 3], |sum: [f64; 3], value| std::array::from_fn(|i| sum[i] + value[i]))
    };
    let value = t.iter().map(|t| at(*t)).collect();
    Some(Series { t, value })
}

/// Reads rows of four numbers. A first row of words, without a digit, is a heading; `#` begins a comment.
fn read(path: &Path) -> Result<Vec<[f64; 4]>, String> {
    let text = std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let lines = text.lines().map(|line| line.split('#').next().unwrap_or_default().trim()).zip(1..);
    let mut rows = Vec::new();
    for (line, number) in lines.filter(|(line, _)| !line.is_empty()) {
        let fields: Vec<&str> = line.split([',', ';', '\t']).map(str::trim).collect();
        let numbers: Option<Vec<f64>> = fields.iter().map(|field| field.parse().ok()).collect();
        let row = numbers.as_deref().and_then(|numbers| <[f64; 4]>::try_from(numbers).ok());
        match row.filter(|row| row.iter().all(|number| number.is_finite())) {
            Some(row) => rows.push(row),
            None if rows.is_empty() && !line.contains(|c: char| c.is_ascii_digit()) => {}
            None => return Err(format!("{}, line {number}: \"{line}\" is not a row of four numbers", path.display())),
        }
    }
    match rows.is_empty() {
        true => Err(format!("{}: no row of four numbers that commas separate", path.display())),
        false => Ok(rows),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sum has the corners of all its tables, and between them the sum of their values.
    #[test]
    fn a_sum_of_tables_is_the_table_of_the_sum() {
        let table = |t: &[f64], x: &[f64]| Series { t: t.to_vec(), value: x.iter().map(|x| [*x, 0.0, -x]).collect() };
        let tables = [table(&[0.0, 2.0], &[0.0, 4.0]), table(&[1.0, 3.0], &[10.0, 0.0]), table(&[0.0], &[1.0])];
        let sum = sum(tables.to_vec()).expect("tables");
        assert_eq!(sum.t, [0.0, 1.0, 2.0, 3.0]);
        for t in [-1.0, 0.0, 0.5, 1.0, 1.7, 2.0, 2.5, 3.0, 9.0] {
            let expected: f64 = tables.iter().map(|table| table.at(t)[0]).sum();
            let [x, y, z] = sum.at(t);
            assert!((x - expected).abs() < 1e-12 && y == 0.0 && (z + x).abs() < 1e-12, "{t}: {x}, {expected}");
        }
    }
}
