//! The stages in which a canopy fills.

use crate::case::diagnostics::Faults;
use crate::case::pointer::Pointer;
use crate::case::schema::{FillingSchedule, OneOrSeveral};
use crate::model::spec::FillingSpec;
use std::f64::consts::PI;

type Stages = OneOrSeveral<FillingSchedule>;

/// Where a stage is in the case.
fn place(at: &Pointer, stages: &Stages, i: usize) -> Pointer {
    match stages {
        OneOrSeveral::One(_) => at.clone(),
        OneOrSeveral::Several(_) => at.index(i),
    }
}

/// Checks the stages.
pub(super) fn check(at: &Pointer, stages: &Stages, faults: &mut Faults<'_>) {
    if stages.all().is_empty() {
        faults.add_value(at, "no stage", "at least one stage", None);
    }
    for (i, stage) in stages.all().iter().enumerate() {
        let at = place(at, stages, i);
        let FillingSchedule { drag_area, drag_coefficient, filling_constant, filling_time, start, speed, .. } = *stage;
        let waits = |stage: &FillingSchedule| stage.when.is_some();
        if waits(stage) && start != 0.0 {
            faults.add_hint(&at.key("when"), "not together with start", "a delay after an event is \"delay\"");
        }
        let one_of = "exactly one of drag_area and drag_coefficient";
        match (drag_area, drag_coefficient) {
            (Some(_), Some(_)) => faults.add_value(&at, "a stage with drag_area and drag_coefficient", one_of, None),
            (None, None) => faults.add_value(&at, "a stage without a drag area", one_of, None),
            _ => {}
        }
        let one_of = "exactly one of filling_constant and filling_time";
        match (filling_constant, filling_time) {
            (Some(_), Some(_)) => faults.add_value(&at, "a stage with filling_constant and filling_time", one_of, None),
            (None, None) => faults.add_value(&at, "a stage without a filling time", one_of, None),
            (Some(_), None) if i > 0 && speed.is_none() && !waits(stage) => {
                let hint =
                    "the speed at a later stage is found by the run itself; give filling_time if it is not known";
                faults.add_value(
                    &at.key("speed"),
                    "(missing)",
                    "the speed at the start of the stage",
                    Some(hint.into()),
                );
            }
            _ => {}
        }
        if i > 0 && start <= stages.all()[i - 1].start && !waits(stage) && !waits(&stages.all()[i - 1]) {
            faults.add(&at.key("start"), "a stage that starts after the one before it");
        }
    }
}

/// [-] Exponent of a stage that gives none.
const EXPONENT: f64 = 2.0;

/// The stages, for a canopy whose nominal diameter [m] is `diameter` where they do not give it. A filling time that
/// needs the speed at the start of the run is that for 1 m/s.
pub(super) fn stages(stages: &Stages, diameter: impl Fn() -> f64) -> Vec<FillingSpec> {
    let lowered = stages.all().iter().map(|stage| {
        let FillingSchedule { filling_constant, filling_time, exponent, start, speed, nominal_diameter, .. } = *stage;
        let diameter = || nominal_diameter.unwrap_or_else(&diameter);
        let by_constant = || filling_constant.unwrap_or(0.0) * diameter() / speed.unwrap_or(1.0);
        let by_coefficient = || stage.drag_coefficient.unwrap_or(0.0) * 0.25 * PI * diameter().powi(2);
        let drag_area = stage.drag_area.unwrap_or_else(by_coefficient);
        let exponent = exponent.unwrap_or(EXPONENT);
        let by_speed = stage.when.is_some() && filling_time.is_none() && speed.is_none();
        let duration = filling_time.unwrap_or_else(by_constant);
        FillingSpec { drag_area, start, duration, by_speed, exponent, event: None }
    });
    lowered.collect()
}

/// [-] Speed of a skirt against the air, over the speeds of both, below which it is rounding.
const ROUNDING: f64 = 1e-9;

/// The motion of a skirt at the start of a run.
#[derive(Clone, Copy)]
pub(super) struct SkirtMotion {
    /// [m/s] its speed against the air
    pub speed: f64,
    /// [m/s] that of the skirt and that of the wind together
    pub scale: f64,
}

/// Divides the filling time of the first stage by the speed against the air at the start of the run, if it needs it.
pub(super) fn at_speed(
    at: &Pointer,
    stages: &Stages,
    filling: &mut [FillingSpec],
    SkirtMotion { speed, scale }: SkirtMotion,
    faults: &mut Faults<'_>,
) {
    let ([first, ..], Some(stage)) = (filling, stages.all().first()) else { return };
    if stage.filling_time.is_some() || stage.speed.is_some() || stage.when.is_some() {
        return;
    }
    if speed > ROUNDING * scale {
        first.duration /= speed;
        return;
    }
    let hint = "the filling time of a filling_constant is n D0 over this speed: give the speed at line stretch, an \
                initial velocity or a wind, or a filling_time";
    let value = "the canopy is at rest in the air at the start";
    faults.add_value(&place(at, stages, 0).key("speed"), value, "a speed above 0", Some(hint.to_owned()));
}
