//! What the air does: drag, apparent mass, gusts, wind and density over height.

use serde_json::{Value, json};

use super::{NETWORK, Search, selected};
use crate::case::spec::SystemSpec;
use crate::force::law::atmosphere::density;
use crate::model::spec::{AtmosphereSpec, NetworkSpec};
use crate::require::change::{Change, Variant};

impl Search<'_> {
    /// Each part of the air in turn.
    pub(super) fn air(&mut self) {
        let drag: Vec<_> = self.entries("aero/drag").collect();
        for (at, entry) in &drag {
            let name = selected(entry);
            let again = drag.iter().filter(|(_, other)| selected(other) == name).count() > 1;
            let number = at.rsplit('/').next().unwrap_or_default();
            let what = if again { format!("drag of {name} (entry {number})") } else { format!("drag of {name}") };
            self.off(&what, [at.clone()]);
        }
        let at = format!("{NETWORK}/aero/canopy");
        let canopies: Vec<(String, &Value)> = match self.get("aero/canopy") {
            Some(Value::Array(_)) => self.entries("aero/canopy").collect(),
            Some(one) => vec![(at, one)],
            None => Vec::new(),
        };
        let massive = canopies.iter().filter(|(_, canopy)| canopy.get("apparent_mass").is_some());
        self.off("apparent mass", massive.map(|(at, _)| format!("{at}/apparent_mass")));
        self.wind();
        self.density();
    }

    /// Gusts off, and a profile of the wind as it is where the scene starts.
    fn wind(&mut self) {
        let at = format!("{NETWORK}/aero/wind");
        let Some(wind) = self.get("aero/wind") else { return };
        let parts: Vec<(String, &Value)> = match wind.get("sum") {
            Some(_) => self.entries("aero/wind/sum").collect(),
            None => vec![(at, wind)],
        };
        self.off("gusts", parts.iter().filter(|(_, part)| part.get("gust").is_some()).map(|(at, _)| at.clone()));
        let SystemSpec::Network(spec) = &self.problem.system else { return };
        let Some(profile) = spec.stream.as_ref().and_then(|stream| stream.profile.as_ref()) else { return };
        let profiles: Vec<&String> =
            parts.iter().filter(|(_, part)| part.get("profile").is_some()).map(|(at, _)| at).collect();
        if let [at] = profiles.as_slice() {
            let there = at_height(&profile.t, &profile.value, height_at_start(spec));
            self.add(Variant::of(Change::UniformWind(there)).set((*at).clone(), json!(there)));
        }
    }

    /// A density over height as it is where the scene starts.
    fn density(&mut self) {
        let SystemSpec::Network(spec) = &self.problem.system else { return };
        let Some(stream) = spec.stream.as_ref() else { return };
        if !matches!(stream.atmosphere, AtmosphereSpec::Constant { .. }) {
            let [there, _] = density(stream.atmosphere, height_at_start(spec));
            let constant = Variant::of(Change::ConstantDensity(there));
            self.add(constant.set(format!("{NETWORK}/aero/atmosphere"), json!({"density": there})));
        }
    }
}

/// [m] Height of the centre of mass above sea level at the start.
fn height_at_start(spec: &NetworkSpec) -> f64 {
    let altitude = spec.stream.as_ref().map_or(0.0, |stream| stream.altitude);
    let moved = |node: usize| spec.displacement.get(node).map_or(0.0, |[_, _, z]| *z);
    let weighted = spec.mass.iter().zip(&spec.mesh.nodes).enumerate();
    let (mass, moment) =
        weighted.fold((0.0, 0.0), |(mass, moment), (node, (m, [_, _, z]))| (mass + m, moment + m * (z + moved(node))));
    altitude + if mass > 0.0 { moment / mass } else { 0.0 }
}

/// The value of a table at a height [m]: linear between rows, constant outside them.
fn at_height(heights: &[f64], values: &[[f64; 3]], height: f64) -> [f64; 3] {
    let above = heights.partition_point(|row| *row < height);
    let value = |row: usize| values.get(row).copied().unwrap_or_default();
    match (above, heights.get(above)) {
        (0, _) => value(0),
        (_, None) => value(values.len().saturating_sub(1)),
        (_, Some(upper)) => {
            let lower = heights.get(above - 1).copied().unwrap_or(*upper);
            let share = (height - lower) / (upper - lower);
            let (a, b) = (value(above - 1), value(above));
            std::array::from_fn(|axis| a[axis] + share * (b[axis] - a[axis]))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_profile_is_linear_between_its_rows_and_constant_outside() {
        let at = |height| at_height(&[0.0, 200.0], &[[3.0, 0.0, 0.0], [6.0, 2.0, 0.0]], height);
        assert_eq!([at(-1.0), at(50.0), at(900.0)], [[3.0, 0.0, 0.0], [3.75, 0.5, 0.0], [6.0, 2.0, 0.0]]);
    }
}
