//! The air section.

use super::geometry::{Geometry, Needs, triangles};
use super::numbers::{fraction, not_negative, positive, series};
use crate::case::diagnostics::Faults;
use crate::case::ergun::coefficients;
use crate::case::pointer::Pointer;
use crate::case::schema::{Aero, PorousLaw, Wind};
use crate::model::spec::{AirSpec, Series};

/// The air as two coefficients and the wind.
pub(super) fn air(
    at: &Pointer,
    aero: Option<&Aero>,
    geometry: Option<&Geometry>,
    faults: &mut Faults<'_>,
) -> Option<AirSpec> {
    let aero = aero?;
    if let Some(geometry) = geometry {
        triangles(at, "the air", geometry, Needs::Normals, faults);
    }
    let wind = match &aero.wind {
        Wind::Constant(wind) => Some(Series { t: vec![0.0], value: vec![*wind] }),
        Wind::Table { table } => {
            let rows = table.iter().map(|[t, x, y, z]| (*t, [*x, *y, *z]));
            series(&at.key("wind").key("table"), rows, faults)
        }
    };
    let at = at.key("law");
    if !law(&at, &aero.law, faults) {
        return None;
    }
    let c = coefficients(&aero.law);
    if !(c.linear.is_finite() && c.quadratic.is_finite()) {
        faults.add(&at, "values whose pressure is a finite number");
        return None;
    }
    Some(AirSpec { linear: c.linear, quadratic: c.quadratic, wind: wind? })
}

fn law(at: &Pointer, law: &PorousLaw, faults: &mut Faults<'_>) -> bool {
    let before = faults.count();
    match law {
        PorousLaw::Ergun(p) => {
            let at = at.key("ergun");
            fraction(&at.key("porosity"), p.porosity, faults);
            positive(&at.key("pore_diameter"), p.pore_diameter, faults);
            positive(&at.key("thickness"), p.thickness, faults);
            positive(&at.key("air_density"), p.air_density, faults);
            positive(&at.key("air_viscosity"), p.air_viscosity, faults);
        }
        PorousLaw::Permeable(p) => {
            let at = at.key("permeable");
            let a = not_negative(&at.key("a"), p.a, faults);
            let b = not_negative(&at.key("b"), p.b, faults);
            positive(&at.key("thickness"), p.thickness, faults);
            if a && b && p.a == 0.0 && p.b == 0.0 {
                faults.add(&at, "a or b above 0; leave the section out for no air");
            }
        }
        PorousLaw::PressureCoefficient(p) => {
            let at = at.key("pressure_coefficient");
            positive(&at.key("cp"), p.cp, faults);
            positive(&at.key("air_density"), p.air_density, faults);
        }
    }
    faults.count() == before
}
