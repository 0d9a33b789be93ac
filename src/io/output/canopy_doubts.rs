//! What canopies did in a run that leads to a warning: they leaned, or their drag was not that of their drag area.

use super::gauges::Peak;
use crate::format_number::figures;
use crate::model::gauge::{
    ANGLE_OF_ATTACK, AXIAL_SPEED, DRAG, DRAG_AREA, DYNAMIC_PRESSURE, PROJECTED_DIAMETER, PROJECTED_RATIO, Quantity,
};
use crate::warning::{Warning, WarningCode};

/// [deg] Angle of attack up to which the law of the air in a canopy is meant.
const LEAN: f64 = 30.0;
/// [-] Difference of the drag from that of the drag area, at the end of a run, that is told.
const OFF: f64 = 0.2;
/// [-] Dynamic pressure at the end, over the largest of the run, below which there is no drag to speak of.
const LITTLE: f64 = 1e-3;

/// Warnings about the canopies of a run until `end` [s] by their largest and last values.
pub fn canopy_doubts(peaks: &[Peak], end: f64) -> Vec<Warning> {
    let of = |name: &str, of: Quantity| peaks.iter().find(|peak| peak.name == name && peak.quantity == of.name);
    let canopies = peaks.iter().filter(|peak| peak.quantity == PROJECTED_RATIO.name).map(|peak| peak.name.as_str());
    let of_canopy = |name: &str| {
        let leaning = of(name, ANGLE_OF_ATTACK).and_then(leaning);
        let parts = [DRAG, DYNAMIC_PRESSURE, DRAG_AREA].map(|quantity| of(name, quantity));
        let [drag, pressure, area] = parts;
        // Cloth takes its shape while the air passes it.
        let passed = of(name, AXIAL_SPEED).zip(of(name, PROJECTED_DIAMETER));
        let passed = passed.is_some_and(|(speed, diameter)| speed.value.abs() * end > diameter.last);
        let off = drag
            .filter(|_| passed)
            .zip(pressure)
            .zip(area)
            .and_then(|((drag, pressure), area)| other_drag([drag, pressure, area]));
        [leaning, off]
    };
    canopies.flat_map(of_canopy).flatten().collect()
}

fn leaning(Peak { name, value, t, last, .. }: &Peak) -> Option<Warning> {
    (*value > LEAN).then(|| {
        let [angle, t, last] = [value, t, last].map(|number| figures(*number, 3));
        let text = format!(
            "{name} leaned {angle} degrees off its motion through the air at t = {t} s, and {last} at the end; the law of its \
             air is for up to about {LEAN}: beyond that its drag and side force are rough"
        );
        Warning::new(WarningCode::LeaningCanopy, text)
    })
}

fn other_drag([drag, pressure, area]: [&Peak; 3]) -> Option<Warning> {
    let found = drag.last / pressure.last;
    let flows = pressure.last.abs() > LITTLE * pressure.value.abs();
    let off = flows && drag.steady && area.steady && area.last > 0.0 && (found / area.last - 1.0).abs() > OFF;
    off.then(|| {
        let [found, given, ratio] = [found, area.last, found / area.last].map(|number| figures(number, 3));
        let text = format!(
            "the drag of {} at the end is that of {found} m^2, {ratio} times its drag area of {given} m^2: its opening is too \
             small or faces sideways, or its cloth is still in motion; look at the frames",
            drag.name
        );
        Warning::new(WarningCode::DragArea, text)
    })
}
