//! The whole parachute as one mass with a drag area.

use super::{NETWORK, Search};
use crate::case::Case;
use crate::case::spec::SystemSpec;
use crate::require::change::{Change, Variant, changed};
use crate::require::plan::briefly;

/// What of the output a point may not have.
const MEASURED: [&str; 2] = ["/output/gauges/", "/output/probes/"];

impl Search<'_> {
    /// The model of one mass, without the gauges and probes that it cannot have.
    pub(super) fn point(&mut self, case: &Case) {
        let SystemSpec::Network(spec) = &self.problem.system else { return };
        if spec.canopies.is_empty() || self.get("model").is_some() {
            return;
        }
        let point = Variant::of(Change::Point).set(format!("{NETWORK}/model"), "point");
        let point = match changed(case, [&point]) {
            Ok(_) => point,
            Err(why) => why.faults().iter().fold(point, |point, fault| self.without(point, &fault.pointer)),
        };
        match changed(case, [&point]) {
            Ok(_) => self.add(point),
            Err(why) => self.found.kept.push(format!("parachute as one mass: {}", briefly(&why))),
        }
    }

    /// Without the gauge or probe that a fault is of, and without its quantities.
    fn without(&self, point: Variant, fault: &str) -> Variant {
        let entry = MEASURED.iter().find_map(|list| {
            let number = fault.strip_prefix(list)?.split('/').next()?;
            Some(format!("{list}{number}"))
        });
        let Some(entry) = entry else { return point };
        let name = self.json.pointer(&format!("{entry}/name")).and_then(|name| name.as_str()).unwrap_or_default();
        let of_entry = |quantity: &str| quantity.strip_prefix(name).is_some_and(|rest| rest.starts_with('.'));
        let quantities = self.json.pointer("/study/quantities").and_then(|list| list.as_array()).into_iter().flatten();
        let gone = quantities.enumerate().filter(|(_, of)| of.as_str().is_some_and(of_entry)).map(|(i, _)| i);
        gone.fold(point.without(entry), |point, i| point.without(format!("/study/quantities/{i}")))
    }
}
