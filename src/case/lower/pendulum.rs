//! The simple pendulum.

use super::numbers::{not_negative, positive};
use crate::case::diagnostics::Faults;
use crate::case::pointer::Pointer;
use crate::case::schema::Pendulum;
use crate::model::spec::PendulumSpec;

/// Checks and builds a pendulum.
pub(super) fn pendulum(at: &Pointer, pendulum: &Pendulum, faults: &mut Faults<'_>) -> PendulumSpec {
    let Pendulum { length, mass, damping, gravity, angle, rate } = *pendulum;
    let long = positive(&at.key("length"), length, faults);
    let heavy = positive(&at.key("mass"), mass, faults);
    not_negative(&at.key("damping"), damping, faults);
    not_negative(&at.key("gravity"), gravity, faults);
    if long && heavy && !(mass * length * length).is_normal() {
        faults.add_value(
            at,
            format!("m L^2 = {:e}", mass * length * length),
            "m L^2 within the range of a double",
            None,
        );
    }
    let spec = PendulumSpec { length, mass, damping, gravity, angle, rate };
    if long && heavy {
        super::energy::pendulum(at, &spec, faults);
    }
    super::plausible::pendulum(at, &spec, faults);
    spec
}
