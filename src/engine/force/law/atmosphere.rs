//! The density of the air over height.
//!
//! The standard atmosphere (ISO 2533; U.S. Standard Atmosphere, 1976) is hydrostatic, with a temperature that is linear
//! in the geopotential height H between the bases of its layers:
//! ```text
//! H = r z/(r + z)
//! T = T_b + L (H - H_b),   p = p_b (T/T_b)^(-g/(R L)),  or  p_b exp(-g (H - H_b)/(R T_b)) where L = 0
//! rho = p/(R T),           d rho/dH = -rho (g/(R T) + L/T)
//! ```

use crate::model::spec::AtmosphereSpec;

/// [m] effective radius of the earth
const RADIUS: f64 = 6_356_766.0;
/// [m/s^2] standard gravity
const GRAVITY: f64 = 9.80665;
/// [J/(kg K)] specific gas constant of dry air
const GAS: f64 = 287.05287;

/// A layer of the standard atmosphere, by its base.
#[derive(Clone, Copy, Debug)]
struct Layer {
    /// [m] geopotential height
    base: f64,
    /// [K]
    temperature: f64,
    /// [K/m]
    lapse: f64,
    /// [Pa]
    pressure: f64,
}

/// The layers up to 84,852 m of geopotential height; pressures of the bases follow from those below.
const LAYERS: [Layer; 7] = [
    Layer { base: 0.0, temperature: 288.15, lapse: -6.5e-3, pressure: 101_325.0 },
    Layer { base: 11_000.0, temperature: 216.65, lapse: 0.0, pressure: 22_632.040_095_007_8 },
    Layer { base: 20_000.0, temperature: 216.65, lapse: 1e-3, pressure: 5_474.877_424_281_046 },
    Layer { base: 32_000.0, temperature: 228.65, lapse: 2.8e-3, pressure: 868.015_776_620_215_3 },
    Layer { base: 47_000.0, temperature: 270.65, lapse: 0.0, pressure: 110.905_773_367_310_4 },
    Layer { base: 51_000.0, temperature: 270.65, lapse: -2.8e-3, pressure: 66.938_528_121_179_96 },
    Layer { base: 71_000.0, temperature: 214.65, lapse: -2e-3, pressure: 3.956_392_160_396_618 },
];

impl Layer {
    /// [kg/m^3] density and [kg/m^4] its slope over the geopotential height [m].
    fn density(&self, height: f64) -> [f64; 2] {
        let Layer { base, temperature, lapse, pressure } = *self;
        let t = temperature + lapse * (height - base);
        let p = if lapse == 0.0 {
            pressure * (-GRAVITY * (height - base) / (GAS * temperature)).exp()
        } else {
            pressure * (t / temperature).powf(-GRAVITY / (GAS * lapse))
        };
        let density = p / (GAS * t);
        [density, -density * (GRAVITY / (GAS * t) + lapse / t)]
    }
}

/// The density [kg/m^3] at a geometric height `z` [m] above sea level, and its slope [kg/m^4].
pub fn density(atmosphere: AtmosphereSpec, z: f64) -> [f64; 2] {
    match atmosphere {
        AtmosphereSpec::Constant { density } => [density, 0.0],
        AtmosphereSpec::Exponential { density, scale_height } => {
            let density = density * (-z / scale_height).exp();
            [density, -density / scale_height]
        }
        AtmosphereSpec::Isa => {
            let share = RADIUS / (RADIUS + z);
            let height = share * z;
            let above = LAYERS.iter().rev().find(|layer| layer.base <= height);
            let [density, slope] = above.unwrap_or(&LAYERS[0]).density(height);
            [density, slope * share * share]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The table of the standard: geometric heights in km.
    #[test]
    fn the_standard_atmosphere_has_the_densities_of_its_table() {
        let table = [
            (0.0, 1.225000),
            (1.0, 1.111659),
            (3.0, 0.909254),
            (5.0, 0.736428),
            (11.0, 0.364802),
            (20.0, 0.088910),
            (30.0, 0.018410),
            (40.0, 0.003996),
        ];
        for (height, expected) in table {
            let [found, _] = density(AtmosphereSpec::Isa, 1e3 * height);
            assert!((found - expected).abs() < 1e-5 * expected + 5e-7, "{height} km: {found}, {expected}");
        }
    }

    /// Each layer begins with the pressure in which the one below ends.
    #[test]
    fn layers_fit_together() {
        for pair in LAYERS.windows(2) {
            let height = pair[1].base;
            let [below, above] = [pair[0].density(height)[0], pair[1].density(height)[0]];
            assert!((below / above - 1.0).abs() < 1e-9, "{height}: {below} {above}");
        }
    }

    #[test]
    fn slopes_are_those_of_the_density() {
        let exponential = AtmosphereSpec::Exponential { density: 1.3, scale_height: 8500.0 };
        for atmosphere in [AtmosphereSpec::Isa, exponential, AtmosphereSpec::Constant { density: 2.0 }] {
            for z in [-400.0, 10.0, 9e3, 15e3, 25e3, 40e3, 49e3, 60e3, 80e3] {
                let [before, after] = [-1.0, 1.0].map(|d| density(atmosphere, z + d)[0]);
                let [value, slope] = density(atmosphere, z);
                assert!((slope - 0.5 * (after - before)).abs() < 1e-7 * value, "{atmosphere:?} at {z}");
            }
        }
    }
}
