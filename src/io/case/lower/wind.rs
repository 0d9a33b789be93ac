//! The wind: a sum of velocities over time and height.

use std::path::Path;

use super::numbers::{rising, series};
use crate::case::diagnostics::Faults;
use crate::case::pointer::Pointer;
use crate::case::schema::{Wind, WindPart};
use crate::model::spec::{GustSpec, Series};

/// A wind, summed by kind.
#[derive(Clone, Debug)]
pub(super) struct Winds {
    /// [m/s] over time [s]
    pub table: Series<[f64; 3]>,
    /// gusts, added to it
    pub gusts: Vec<GustSpec>,
    /// [m/s] over the height above sea level [m], added to it
    pub profile: Option<Series<[f64; 3]>>,
}

impl Winds {
    /// Calm air.
    pub(super) fn calm() -> Self {
        Winds { table: Series { t: vec![0.0], value: vec![[0.0; 3]] }, gusts: Vec::new(), profile: None }
    }
}

/// The parts of a wind, and where they stand.
pub(super) fn parts<'a>(at: &Pointer, wind: &'a Wind) -> Vec<(Pointer, &'a WindPart)> {
    match wind {
        Wind::Part(part) => vec![(at.clone(), part)],
        Wind::Sum(parts) => parts.sum.iter().enumerate().map(|(i, part)| (at.key("sum").index(i), part)).collect(),
    }
}

/// Checks a wind and sums its parts; files are found from the folder `base`.
pub(super) fn wind(at: &Pointer, wind: &Wind, base: &Path, faults: &mut Faults<'_>) -> Option<Winds> {
    let parts = parts(at, wind);
    let before = faults.count();
    let (mut tables, mut profiles, mut gusts) = (Vec::new(), Vec::new(), Vec::new());
    for (at, part) in parts {
        let split = |[t, x, y, z]: &[f64; 4]| (*t, [*x, *y, *z]);
        match part {
            WindPart::Constant(wind) => tables.push(Series { t: vec![0.0], value: vec![*wind] }),
            WindPart::Table { table } => tables.extend(series(&at.key("table"), table.iter().map(split), faults)),
            WindPart::Profile { profile } => {
                profiles.extend(rising(&at.key("profile"), "height", profile.iter().map(split), faults));
            }
            WindPart::Gust { gust } => {
                gusts.push(GustSpec { velocity: gust.velocity, start: gust.start, duration: gust.duration });
            }
            WindPart::File { file } => match read(&base.join(file)) {
                Ok(rows) => tables.extend(series(&at.key("file"), rows.iter().map(split), faults)),
                Err(reason) => {
                    let allowed = "a text file with rows of t, x, y, z in s and m/s, separated by commas";
                    faults.add_hint(&at.key("file"), allowed, reason);
                }
            },
        }
    }
    let table = sum(tables).unwrap_or_else(|| Winds::calm().table);
    (faults.count() == before && faults.readable(at)).then(|| Winds { table, gusts, profile: sum(profiles) })
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
