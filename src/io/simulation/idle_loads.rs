//! Loads that do not act at the time of an equilibrium, because their tables are 0 there.

use crate::case::schema::{Gas, Load, OneOrSeveral, OverTime};
use crate::case::spec::Problem;
use crate::model::spec::Series;
use crate::output::at_rest::IdleLoad;
use crate::scene::Scene;
use serde::de::DeserializeOwned;

/// The loads, gases and winds of a case that are 0 at the time `at` [s], and not at all times.
pub fn idle_loads(problem: &Problem, scene: &dyn Scene, at: f64) -> Vec<IdleLoad> {
    let idle = |load: String, rows: &Series<[f64; 1]>| {
        let largest = largest(rows.t.iter().zip(&rows.value).map(|(t, [value])| (*t, value.abs())))?;
        (rows.at(at) == [0.0]).then_some(IdleLoad { load, at, largest_at: largest })
    };
    let series = |rows: &[[f64; 2]]| {
        let (t, value) = rows.iter().map(|[t, value]| (*t, [*value])).unzip();
        Series { t, value }
    };
    let loads: Vec<Load> = section(problem, "loads").unwrap_or_default();
    let of_loads = loads.iter().enumerate().filter_map(|(i, load)| {
        let rows = load.table.as_ref().filter(|rows| !rows.is_empty())?;
        idle(format!("loads[{i}]"), &series(rows))
    });
    let gases: Option<OneOrSeveral<Gas>> = section(problem, "gas");
    let list = gases.as_ref().map_or(&[][..], OneOrSeveral::all);
    let several = matches!(gases, Some(OneOrSeveral::Several(_)));
    let of_gases = list.iter().enumerate().filter_map(|(i, gas)| match &gas.pressure {
        Some(OverTime::Table(rows)) if !rows.table.is_empty() => {
            idle(if several { format!("gas[{i}]") } else { "gas".to_owned() }, &series(&rows.table))
        }
        _ => None,
    });
    of_loads.chain(of_gases).chain(calm(scene, at)).collect()
}

/// The wind, where it is 0 at `at` [s] and not at all times.
fn calm(scene: &dyn Scene, at: f64) -> Option<IdleLoad> {
    let air = scene.air()?;
    let speed = |t: f64| air.winds(t).iter().map(|[x, y, z]| x.hypot(*y).hypot(*z)).fold(0.0, f64::max);
    let corners = scene.events().map_or_else(Vec::new, |events| events.corners());
    let largest_at = largest(corners.into_iter().map(|t| (t, speed(t))))?;
    (speed(at) == 0.0).then(|| IdleLoad { load: "aero.wind".to_owned(), at, largest_at })
}

/// [s] The first time of the largest size; `None` where all are 0.
fn largest(sizes: impl Iterator<Item = (f64, f64)>) -> Option<f64> {
    let most = sizes.fold((0.0, 0.0), |most, one| if one.1 > most.1 { one } else { most });
    (most.1 > 0.0).then_some(most.0)
}

/// A section of the network of a case.
fn section<T: DeserializeOwned>(problem: &Problem, key: &str) -> Option<T> {
    let given = problem.case_json.pointer("/system/network")?.get(key)?;
    T::deserialize(given).ok()
}
