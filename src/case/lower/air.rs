//! The air section: checks, and porous laws reduced to the two coefficients of dp = linear v_n + quadratic v_n |v_n|.

use super::geometry::{Geometry, TriangleUse, triangles};
use super::numbers::{fraction, not_negative, positive, series};
use crate::case::diagnostics::Faults;
use crate::case::pointer::Pointer;
use crate::case::schema::{Aero, ErgunForm, ErgunLaw, PorousLaw, Wind};
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
        triangles(at, "the air", geometry, TriangleUse::Normals, faults);
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

/// Coefficients of dp = linear v_n + quadratic v_n |v_n|.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Coefficients {
    /// [Pa s/m] viscous coefficient
    linear: f64,
    /// [Pa s^2/m^2] inertial coefficient
    quadratic: f64,
}

/// The coefficients of any law.
fn coefficients(law: &PorousLaw) -> Coefficients {
    match law {
        PorousLaw::Ergun(ergun) => ergun_coefficients(ergun),
        PorousLaw::Permeable(p) => Coefficients { linear: p.thickness * p.a, quadratic: p.thickness * p.b },
        PorousLaw::PressureCoefficient(p) => Coefficients { linear: 0.0, quadratic: 0.5 * p.cp * p.air_density },
    }
}

/// Ergun 1952: dp/e = 150 mu (1-eps)^2/(D^2 eps^3) v_s + 1.75 rho (1-eps)/(D eps^3) v_s |v_s|, v_s = v_n superficial.
///
/// The `paper` form has the thesis' Eq. 7 and 8, which print eps^2, and Eq. 9, v_s = eps v_n.
fn ergun_coefficients(law: &ErgunLaw) -> Coefficients {
    let (eps, d, e) = (law.porosity, law.pore_diameter, law.thickness);
    let viscous = 150.0 * law.air_viscosity * (1.0 - eps).powi(2) / d.powi(2);
    let inertial = 1.75 * law.air_density * (1.0 - eps) / d;
    match law.form {
        ErgunForm::Corrected => {
            Coefficients { linear: e * viscous / eps.powi(3), quadratic: e * inertial / eps.powi(3) }
        }
        // eps^2 of the denominators against one and two powers of eps from v_s = eps v_n.
        ErgunForm::Paper => Coefficients { linear: e * viscous / eps, quadratic: e * inertial },
    }
}
