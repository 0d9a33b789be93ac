//! Names of gauges for people: that of a rule of springs is a path in the case, such as `springs[5] lines`.

use std::collections::BTreeMap;

/// `lines` of `springs[5] lines`, and any other name itself.
pub fn without_rule(gauge: &str) -> &str {
    gauge.strip_prefix("springs[").and_then(|rest| rest.split_once("] ")).map_or(gauge, |(_, group)| group)
}

/// What people read for each of these names: the group of a rule alone, where it tells the gauge from the others.
pub fn for_people<'a>(gauges: impl Iterator<Item = &'a str> + Clone) -> BTreeMap<&'a str, &'a str> {
    let alone = |name: &str| gauges.clone().all(|other| other == name || without_rule(other) != without_rule(name));
    gauges.clone().map(|name| (name, if alone(name) { without_rule(name) } else { name })).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_are_called_by_their_groups_where_these_differ() {
        let all = ["riser", "springs[2]", "springs[5] lines", "springs[6] tape (2 strands)", "springs[6] tape"];
        let names = for_people(all.into_iter());
        assert_eq!(names.values().copied().collect::<Vec<_>>().len(), all.len());
        assert_eq!(all.map(|name| names[name]), ["riser", "springs[2]", "lines", "tape (2 strands)", "tape"]);
        let both = for_people(["lines", "springs[5] lines"].into_iter());
        assert_eq!(both["springs[5] lines"], "springs[5] lines", "another gauge is called lines");
    }
}
