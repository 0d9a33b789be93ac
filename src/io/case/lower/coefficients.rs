//! Porous laws, reduced to the two coefficients of dp = linear v_n + quadratic v_n |v_n|.

use crate::case::diagnostics::Faults;
use crate::case::pointer::Pointer;
use crate::case::schema::{ErgunForm, ErgunLaw, PorousLaw};

/// The coefficients of a law, if it is a sound one.
pub(super) fn checked_coefficients(at: &Pointer, given: &PorousLaw, faults: &mut Faults<'_>) -> Option<Coefficients> {
    if let PorousLaw::Permeable(p) = given
        && p.a == 0.0
        && p.b == 0.0
    {
        faults.add(&at.key("permeable"), "a or b above 0; leave the section out for no air");
        return None;
    }
    let found = coefficients(given)?;
    if !(found.linear.is_finite() && found.quadratic.is_finite()) {
        faults.add(at, "values whose pressure is a finite number");
        return None;
    }
    Some(found)
}

/// Coefficients of dp = linear v_n + quadratic v_n |v_n|.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Coefficients {
    /// [Pa s/m] viscous coefficient
    pub linear: f64,
    /// [Pa s^2/m^2] inertial coefficient
    pub quadratic: f64,
}

/// The coefficients of a law that has them: pressures by zone do not depend on v_n.
fn coefficients(law: &PorousLaw) -> Option<Coefficients> {
    let found = match law {
        PorousLaw::SurfacePressure(_) => return None,
        PorousLaw::Ergun(ergun) => ergun_coefficients(ergun),
        PorousLaw::Permeable(p) => Coefficients { linear: p.thickness * p.a, quadratic: p.thickness * p.b },
        PorousLaw::PressureCoefficient(p) => Coefficients { linear: 0.0, quadratic: 0.5 * p.cp * p.air_density },
    };
    Some(found)
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
