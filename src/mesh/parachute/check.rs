//! What a parachute can be asked for.

use super::{
    CanopyType, InnerLineParameters, MOST, MOST_VENT, PackedStart, ParachuteParameters, RigLineParameters, StartShape,
    outline, place,
};
use crate::source::{FaultSink, MAX_NODES, check_count, check_length};

impl ParachuteParameters {
    /// Reports every value out of range; `at` is the JSON pointer of this section.
    pub fn check(&self, at: &str, faults: FaultSink<'_>) {
        self.check_size(at, faults);
        check_count(at, "gores", self.gores, [3, MOST], faults);
        check_count(at, "radial_segments", self.radial_segments, [1, MOST], faults);
        check_count(at, "gore_segments", self.gore_segments, [1, MOST], faults);
        let rows = self.radial_segments.saturating_add(self.rings.unwrap_or(1)).saturating_add(2);
        let of_canopy = self.gores.saturating_mul(self.gore_segments).saturating_mul(rows);
        let segments =
            self.lines.as_ref().map_or(0, |l| l.segments) + self.inner_lines.as_ref().map_or(0, |l| l.segments);
        let of_centre = self.centre_line.as_ref().map_or(0, |line| line.segments);
        let of_lines = self.gores.saturating_mul(segments).saturating_add(of_centre);
        let nodes = of_canopy.saturating_add(of_lines).saturating_mul(self.cluster.map_or(1, |c| c.canopies));
        if nodes > MAX_NODES {
            let value = format!("about {nodes} nodes");
            faults(at, value, format!("at most {MAX_NODES} nodes"), "take fewer segments".into());
        }
        self.check_kind(at, faults);
        self.check_vent(at, faults);
        let strips = matches!(self.kind, CanopyType::Cruciform | CanopyType::Ringsail) || self.verticals.is_some();
        if self.coarsen && (strips || outline::sides(self.kind).is_some()) {
            let hint = "leave it out, or change the type".to_owned();
            faults(
                &format!("{at}/coarsen"),
                "true".into(),
                "only with a round canopy of gores without sails and verticals".into(),
                hint,
            );
        }
        let of_type = self.kind.numbers().line_length;
        for (key, line, default) in
            [("lines", &self.lines, of_type), ("riser", &self.riser, None), ("centre_line", &self.centre_line, None)]
        {
            if let Some(RigLineParameters { length, segments, .. }) = line {
                let at = format!("{at}/{key}");
                match length {
                    Some(length) => check_length(&at, "length", *length, faults),
                    None if default.is_none() => {
                        let allowed = "the key \"length\" is required here".to_owned();
                        faults(&format!("{at}/length"), "(missing)".into(), allowed, "give metres".into());
                    }
                    None => {}
                }
                check_count(&at, "segments", *segments, [1, MOST], faults);
            }
        }
        if let Some(inner) = &self.inner_lines {
            self.check_inner_lines(&format!("{at}/inner_lines"), inner, faults);
        }
        self.check_centre_line(at, faults);
        if let Some(cluster) = self.cluster {
            check_count(&format!("{at}/cluster"), "canopies", cluster.canopies, [2, 20], faults);
        }
        let parts = [("riser", self.riser.is_some()), ("payload", self.payload.is_some())];
        for (key, given) in parts.into_iter().chain([("cluster", self.cluster.is_some())]) {
            if given && self.lines.is_none() {
                let hint = "give `lines`, or leave it out".to_owned();
                faults(&format!("{at}/{key}"), "without lines".into(), "only below suspension lines".into(), hint);
            }
        }
        if let Some(payload) = &self.payload {
            payload.check(&format!("{at}/payload"), faults);
        }
        if let Some(reefing) = &self.reefing {
            let at = format!("{at}/reefing");
            check_length(&at, "diameter", reefing.diameter, faults);
            // A vent that is too large itself is a fault of its own.
            let vent = self.vent_diameter.filter(|vent| (reefing.diameter..=self.largest_vent()).contains(vent));
            if let Some(vent) = vent {
                let hint = "the air would fill the canopy through its vent".to_owned();
                let allowed = format!("more than the vent's {vent}");
                faults(&format!("{at}/diameter"), reefing.diameter.to_string(), allowed, hint);
            }
        }
        if let Some(axis) = self.axis.filter(|axis| !place::is_direction(*axis)) {
            let hint = "it leads from the payload to the apex, e.g. [0, 0, 1]".to_owned();
            faults(&format!("{at}/axis"), format!("{axis:?}"), "a direction: three numbers, not all 0".into(), hint);
        }
        if let Some(place) = self.at.filter(|place| place.iter().any(|c| !c.is_finite())) {
            faults(&format!("{at}/at"), format!("{place:?}"), "three finite numbers".into(), "give metres".into());
        }
        self.check_start(at, faults);
    }

    fn check_start(&self, at: &str, faults: FaultSink<'_>) {
        let shape = match self.start.shape() {
            StartShape::Flat => None,
            StartShape::Inflated => Some(("inflated", "an inflated start needs lines")),
            StartShape::Stretched => Some(("stretched", "a stretched start needs lines")),
            StartShape::Packed => Some(("packed", "a packed start needs lines")),
        };
        if let (Some((name, allowed)), None) = (shape, &self.lines) {
            let hint = "give `lines`, or start flat".to_owned();
            faults(&format!("{at}/start"), name.into(), allowed.into(), hint);
        }
        if let Some(radius) = self.start.stretched_radius() {
            check_length(&format!("{at}/start/stretched"), "radius", radius, faults);
        }
        if let Some(PackedStart { length, radius, .. }) = self.start.packed() {
            let at = format!("{at}/start/packed");
            for (key, value) in [("length", length), ("radius", radius)] {
                value.into_iter().for_each(|value| check_length(&at, key, value, faults));
            }
        }
        let Some(radius) = self.start_radius else { return };
        let at = format!("{at}/start_radius");
        if self.start.shape() != StartShape::Stretched {
            let hint = "leave it out, or start stretched".to_owned();
            faults(&at, "given".into(), "only with the start \"stretched\"".into(), hint);
        } else if self.start.stretched_radius().is_some() {
            let hint = "keep one: start.stretched.radius is in metres, start_radius over D0".to_owned();
            faults(&at, "given".into(), "not together with start.stretched.radius".into(), hint);
        }
        if !(radius.is_normal() && radius > 0.0) {
            let hint = "the radius of the skirt over D0, about 0.025".to_owned();
            faults(&at, radius.to_string(), "above 0".into(), hint);
        }
    }

    fn check_inner_lines(&self, at: &str, inner: &InnerLineParameters, faults: FaultSink<'_>) {
        check_count(at, "segments", inner.segments, [1, MOST], faults);
        if let Some(length) = inner.length {
            check_length(at, "length", length, faults);
        }
        let (vent, lines) = (self.vent_diameter.is_some(), self.lines.is_some());
        if !(vent && lines) {
            let value = if vent { "without lines" } else { "without a vent" };
            let hint = "give `vent_diameter` and `lines`, or leave it out".to_owned();
            faults(at, value.into(), "only from a vent to the confluence of lines".into(), hint);
        }
    }

    fn check_centre_line(&self, at: &str, faults: FaultSink<'_>) {
        if self.centre_line.is_none() {
            return;
        }
        let refused = match (self.vent_diameter, &self.lines) {
            _ if self.kind == CanopyType::Cruciform => Some("a cruciform canopy"),
            (Some(_), _) => Some("with a vent"),
            (None, None) => Some("without lines"),
            (None, Some(_)) => None,
        };
        if let Some(value) = refused {
            let hint = "a vent is held by `inner_lines`; else leave it out".to_owned();
            let allowed = "only from the apex of gores to the confluence of lines".to_owned();
            faults(&format!("{at}/centre_line"), value.into(), allowed, hint);
        }
    }

    /// Exactly one diameter.
    fn check_size(&self, at: &str, faults: FaultSink<'_>) {
        match (self.nominal_diameter, self.constructed_diameter) {
            (Some(d0), None) => check_length(at, "nominal_diameter", d0, faults),
            (None, Some(dc)) => check_length(at, "constructed_diameter", dc, faults),
            (None, None) => {
                let allowed = "the key \"nominal_diameter\" is required here".to_owned();
                let hint = "or give \"constructed_diameter\", the size by which shops sell".to_owned();
                faults(&format!("{at}/nominal_diameter"), "(missing)".into(), allowed, hint);
            }
            (Some(_), Some(_)) => {
                let allowed = "exactly one of nominal_diameter and constructed_diameter".to_owned();
                let hint = "the one follows from the other by the pattern; keep the one that was measured".to_owned();
                faults(&format!("{at}/constructed_diameter"), "given beside nominal_diameter".into(), allowed, hint);
            }
        }
    }

    /// [m] Not a number if D0 is not given: then the pattern is checked when it is cut.
    fn largest_vent(&self) -> f64 {
        self.d0() * MOST_VENT.sqrt()
    }

    fn check_vent(&self, at: &str, faults: FaultSink<'_>) {
        let Some(vent) = self.vent_diameter else {
            if self.vent_lines == Some(true) {
                let hint = "give `vent_diameter`, or leave it out".to_owned();
                faults(&format!("{at}/vent_lines"), "true".into(), "vent lines need a vent".into(), hint);
            }
            return;
        };
        check_length(at, "vent_diameter", vent, faults);
        let most = self.largest_vent();
        if self.d0() > 0.0 && vent > most && vent.is_finite() {
            let allowed = format!("at most {most:.6}, half of the nominal area");
            let hint = "the canopy would be more vent than cloth; make the vent smaller".to_owned();
            faults(&format!("{at}/vent_diameter"), vent.to_string(), allowed, hint);
        }
        if self.has_vent_lines() && !self.gores.is_multiple_of(2) {
            let hint =
                "each vent line joins opposite corners of the vent; say \"vent_lines\": false without them".to_owned();
            faults(&format!("{at}/gores"), self.gores.to_string(), "an even number with vent lines".into(), hint);
        }
    }
}
