//! Lift of canopies and bodies that glide.

use super::numbers::series;
use crate::case::diagnostics::Faults;
use crate::case::pointer::Pointer;
use crate::case::schema::{Glide, Network, NetworkModel, OneOrSeveral, OverTime};
use crate::model::spec::{GlideSpec, Series};

/// Checks and resolves a glide.
pub(super) fn glide(at: &Pointer, given: &Glide, faults: &mut Faults<'_>) -> Option<GlideSpec> {
    let Glide { ratio, heading } = given;
    let heading = match heading {
        OverTime::Constant(heading) => Some(Series { t: vec![0.0], value: vec![*heading] }),
        OverTime::Table(table) => {
            let rows = table.table.iter().map(|&[t, heading]| (t, heading));
            series(&at.key("heading").key("table"), rows, faults)
        }
    };
    heading.map(|heading| GlideSpec { ratio: *ratio, heading })
}

/// Adds a fault for every canopy of a net that is to glide.
pub(super) fn refuse_nets(at: &Pointer, network: &Network, faults: &mut Faults<'_>) {
    let canopies = network.aero.as_ref().and_then(|aero| aero.canopy.as_ref());
    if network.model == Some(NetworkModel::Point) {
        return;
    }
    let at = at.key("aero").key("canopy");
    for (i, canopy) in canopies.map_or(&[][..], OneOrSeveral::all).iter().enumerate() {
        if canopy.glide.is_some() {
            let at = if let Some(OneOrSeveral::Several(_)) = canopies { at.index(i) } else { at.clone() };
            let hint = "the pressure of a net is even about its axis, so its cloth has no lift: take the network's \
                        \"model\": \"point\", or leave \"glide\" out";
            faults.add_value(
                &at.key("glide"),
                "a net that glides",
                "a canopy of \"model\": \"point\"",
                Some(hint.to_owned()),
            );
        }
    }
}
