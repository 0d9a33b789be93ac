//! Porous laws reduced to the two coefficients of dp = linear v_n + quadratic v_n |v_n|.

use super::schema::{ErgunForm, ErgunLaw, PorousLaw};

/// Coefficients of dp = linear v_n + quadratic v_n |v_n|.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Coefficients {
    /// [Pa s/m] viscous coefficient
    pub linear: f64,
    /// [Pa s^2/m^2] inertial coefficient
    pub quadratic: f64,
}

/// The coefficients of any law.
pub(crate) fn coefficients(law: &PorousLaw) -> Coefficients {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn law(form: ErgunForm) -> PorousLaw {
        PorousLaw::Ergun(ErgunLaw {
            porosity: 0.1,
            pore_diameter: 5e-5,
            thickness: 1e-4,
            air_density: 1.225,
            air_viscosity: 1.81e-5,
            form,
        })
    }

    /// The check values of the equations page: 44947.7 Pa and 440.79 Pa at 0.5 m/s, to the digits given.
    #[test]
    fn meets_the_check_values() {
        let v: f64 = 0.5;
        for (form, expected, digits) in [(ErgunForm::Corrected, 44947.7, 0.05), (ErgunForm::Paper, 440.79, 0.005)] {
            let c = coefficients(&law(form));
            let dp = c.linear * v + c.quadratic * v * v.abs();
            assert!((dp - expected).abs() <= digits, "{form:?}: {dp} Pa instead of {expected} Pa");
        }
    }
}
