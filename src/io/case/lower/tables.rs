//! Pulses of tables, and gusts, that fixed steps do not resolve.

use super::wind;
use crate::case::diagnostics::Faults;
use crate::case::pointer::Pointer;
use crate::case::schema::{
    Factor, FactorTable, Gust, Network, OneOrSeveral, OverTime, ValueTable, VectorTable, WindPart,
};
use crate::format_number::figures;
use crate::model::spec::NetworkSpec;
use crate::warning::WarningCode;

/// [-] A pulse shorter than this many steps loses its shape.
const STEPS: f64 = 2.0;
/// [-] A pulse below this share of the table's range is noise.
const NOISE: f64 = 1e-3;
/// [-] A row closer to the end of a step than this share of the step counts as at the end.
const AT_END: f64 = 1e-6;

/// Times of a run in fixed steps.
#[derive(Clone, Copy)]
pub(super) struct StepTimes {
    /// [s] step
    pub h: f64,
    /// [s] end of the run
    pub end: f64,
}

/// Warns once per table: about the first pulse of a load, of the base, of a rest length or of the wind that is shorter
/// than two steps and does not begin and end with steps; and of every gust that is shorter.
pub(super) fn warn_of_short_pulses(
    at: &Pointer,
    network: &Network,
    spec: &NetworkSpec,
    steps: StepTimes,
    faults: &mut Faults<'_>,
) {
    let loads = network.loads.iter().enumerate();
    for (i, table) in loads.filter_map(|(i, load)| Some((i, load.table.as_ref()?))) {
        let at = at.key("loads").index(i).key("table");
        warn(&at, "impulse", pulses(table.iter().copied(), steps), steps, faults);
    }
    let gases = network.gas.as_ref();
    for (i, gas) in gases.map_or(&[][..], OneOrSeveral::all).iter().enumerate() {
        let at = at.key("gas");
        let at = if let Some(OneOrSeveral::Several(_)) = gases { at.index(i) } else { at };
        for (key, given) in [("pressure", &gas.pressure), ("amount", &gas.amount)] {
            let Some(OverTime::Table(ValueTable { table })) = given else { continue };
            warn(&at.key(key).key("table"), "mean", pulses(table.iter().copied(), steps), steps, faults);
        }
    }
    let vector = |rows: &[[f64; 4]]| {
        let component = |c: usize| pulses(rows.iter().map(move |row| [row[0], row[c]]), steps);
        [1, 2, 3].map(component).into_iter().max_by_key(|found| found.count).unwrap_or_default()
    };
    if let Some(VectorTable { table }) = &network.base_acceleration {
        warn(&at.key("base_acceleration").key("table"), "impulse", vector(table), steps, faults);
    }
    for (i, rule) in network.springs.iter().enumerate() {
        let Some(Factor::Table(FactorTable { table })) = &rule.rest_scale else { continue };
        let at = at.key("springs").index(i).key("rest_scale").key("table");
        warn(&at, "mean", pulses(table.iter().copied(), steps), steps, faults);
    }
    let wind = network.aero.as_ref().and_then(|aero| aero.wind.as_ref());
    for (at, part) in wind.into_iter().flat_map(|wind| wind::parts(&at.key("aero").key("wind"), wind)) {
        match part {
            WindPart::Table { table, when: None } => warn(&at.key("table"), "mean", vector(table), steps, faults),
            // The sum of all tables is at hand, the file is not.
            WindPart::File { when: None, .. } => {
                let of_stream = spec.stream.as_ref().map(|stream| &stream.wind);
                let sum = of_stream.or_else(|| spec.air.as_ref().map(|air| &air.wind));
                let rows = sum.into_iter().flat_map(|sum| sum.t.iter().zip(&sum.value));
                let rows: Vec<[f64; 4]> = rows.map(|(t, [x, y, z])| [*t, *x, *y, *z]).collect();
                warn(&at.key("file"), "mean", vector(&rows), steps, faults);
            }
            WindPart::Gust { gust, when: None } => {
                warn(&at.key("gust"), "mean", short_gust(gust, steps), steps, faults)
            }
            // Steps end at the corners of what begins with an event.
            WindPart::Table { .. } | WindPart::File { .. } | WindPart::Gust { .. } => {}
            WindPart::Constant(_) | WindPart::Profile { .. } => {}
        }
    }
}

/// A gust of which steps do not see the shape; one of two steps that begins with a step has its peak at their middle.
fn short_gust(gust: &Gust, StepTimes { h, end }: StepTimes) -> ShortPulses {
    let Gust { start, duration, .. } = *gust;
    let counts = duration < (1.0 - AT_END) * STEPS * h && start < end && start + duration > 0.0;
    ShortPulses { count: usize::from(counts), first: [start, duration] }
}

/// Short pulses of a table.
#[derive(Clone, Copy, Default)]
struct ShortPulses {
    count: usize,
    /// [s] start and duration of the first
    first: [f64; 2],
}

/// A pulse goes up and then down, or down and then up.
fn pulses(rows: impl Iterator<Item = [f64; 2]> + Clone, StepTimes { h, end }: StepTimes) -> ShortPulses {
    let extremes = |[low, high]: [f64; 2], [_, value]: [f64; 2]| [low.min(value), high.max(value)];
    let [low, high] = rows.clone().fold([f64::INFINITY, f64::NEG_INFINITY], extremes);
    let at_end = |t: f64| (t / h - (t / h).round()).abs() <= AT_END;
    let mut found = ShortPulses::default();
    // The last part that is not constant: its start and rise, and whether all rows since are at the ends of steps.
    let mut before: Option<([f64; 2], bool)> = None;
    for ([t, value], [t_next, next]) in rows.clone().zip(rows.skip(1)) {
        let rise = next - value;
        let met = at_end(t) && at_end(t_next);
        if rise == 0.0 {
            before = before.map(|(stretch, all)| (stretch, all && met));
            continue;
        }
        if let Some(([start, earlier], all)) = before {
            let counts = rise * earlier < 0.0 && rise.abs().min(earlier.abs()) > NOISE * (high - low);
            if counts && t_next - start < STEPS * h && !(all && met) && t_next > 0.0 && start < end {
                if found.count == 0 {
                    found.first = [start, t_next - start];
                }
                found.count += 1;
            }
        }
        before = Some(([t, rise], met));
    }
    found
}

fn warn(at: &Pointer, kept: &str, found: ShortPulses, StepTimes { h, .. }: StepTimes, faults: &mut Faults<'_>) {
    let ShortPulses { count, first: [start, lasts] } = found;
    if count == 0 {
        return;
    }
    let more = if count > 1 { format!(" ({} more like it)", count - 1) } else { String::new() };
    let text = format!(
        "{at}: the pulse at t = {} s lasts {} s, the step is {} s{more}; its {kept} is kept, but not its shape: take time.step={} or less, or \
         time.tolerance",
        figures(start, 6),
        figures(lasts, 4),
        figures(h, 4),
        figures(0.5 * lasts, 2)
    );
    faults.warn(WarningCode::ShortPulse, text);
}
