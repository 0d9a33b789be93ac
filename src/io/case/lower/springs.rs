//! Spring rules: which edge follows which rule, and the springs that result.

use super::cut;
use super::elastic_law::elastic_law;
use super::events::{Plan, Waits};
use super::geometry::Geometry;
use super::mass;
use super::numbers::{positive, series};
use super::prestress::{Law, Prestress};
use super::select;
use super::stiffness::{Springs, Stiffness, dashpot, rest_lengths, stiffness};
use crate::case::diagnostics::Faults;
use crate::case::pointer::Pointer;
use crate::case::schema::{Factor, FactorTable, Membrane, SlackRule, SpringRule};
use crate::drive::clock::Step;
use crate::format_number::first_few;
use crate::model::spec::{ElasticLaw, MembraneSpec, Series, SheetSpec, Slack, SpringGroup, SpringValues, StrengthSpec};
use crate::warning::WarningCode;

/// What springs are made from.
#[derive(Debug)]
pub(super) struct SpringSources<'a> {
    pub rules: &'a [SpringRule],
    /// they carry their edges too
    pub membranes: &'a [MembraneSpec],
    /// the steps of the run, if known
    pub step: Option<Step>,
    /// what an earlier run says of their rest lengths
    pub prestress: Option<Prestress>,
    /// what cuts them
    pub plan: &'a Plan<'a>,
}

/// Groups of springs in the order of the rules; adds the springs' own mass to `mass` `[n_nodes]`.
pub(super) fn springs(
    at: &Pointer,
    SpringSources { rules, membranes, step, prestress, plan }: SpringSources<'_>,
    geometry: Option<&Geometry>,
    mass: &mut [f64],
    faults: &mut Faults<'_>,
) -> Vec<SpringGroup> {
    let bare = vec![false; geometry.map_or(0, |g| g.mesh.edges.len())];
    let mut claimed = Claimed { by_rule: bare.clone(), by_any: bare };
    let whole = geometry;
    let mut geometry = geometry;
    let mut followed = Vec::new();
    for (i, rule) in rules.iter().enumerate() {
        let at = at.index(i);
        if rule.loads_only {
            check_loads_only(&at, rule, faults);
        }
        let values = if rule.loads_only { None } else { values(&at, rule, faults) };
        cut::check(&at, rule, faults);
        if rule.breaks && rule.strength.is_none() {
            faults.add_hint(&at.key("strength"), "the strength of springs that break", "give it in N");
        }
        if rule.breaks && rule.when.is_some() {
            let hint = "what is cut by an event cannot break before; make two rules for two groups";
            faults.add_hint(&at.key("breaks"), "not together with when", hint);
        }
        let factor = rest_factor(&at.key("rest_scale"), rule, faults);
        // The edges of an unreadable rule are not known, so those of the next rules are not known either.
        geometry = geometry.filter(|_| faults.readable(&at.key("on")));
        let Some(geometry) = geometry else { continue };
        let Some(edges) = claim(&at, rule, geometry, &mut claimed, faults) else { continue };
        if rule.loads_only {
            continue;
        }
        // A sheet is one, whatever tapes are on it.
        let strands = geometry.strands(&rule.on, &edges).filter(|_| rule.membrane.is_none());
        if let Some(density) = rule.linear_density.filter(|d| *d > 0.0) {
            let densities = SpringValues::Uniform(density);
            let densities = strands.as_deref().map_or(densities.clone(), |strands| densities.times(strands));
            add_mass(&densities, &edges, geometry, mass);
        }
        followed.push(RuleEdges {
            number: i,
            cut_by: plan.event(Waits::Springs(i)),
            rule,
            values,
            factor,
            edges,
            strands,
            step,
        });
    }
    let Some(whole) = whole else { return Vec::new() };
    let prestress = prestress.map(|prestress| shared(prestress, &followed, whole));
    let mut groups = Vec::new();
    for followed in followed {
        let rule = followed.rule.cut.as_ref();
        let springs = group(at, followed, prestress.as_ref(), whole, faults);
        groups.extend(springs.into_iter().flat_map(|springs| cut::groups(rule, springs)));
    }
    let Some(geometry) = geometry else { return groups };
    let mut of_membrane = vec![false; geometry.mesh.triangles.len()];
    membranes.iter().flat_map(|m| &m.triangles).for_each(|&t| of_membrane[t as usize] = true);
    for (edge, taken) in claimed.by_any.iter_mut().enumerate() {
        *taken |= geometry.topology.edge_triangles(edge).iter().any(|&t| of_membrane[t as usize]);
    }
    warn_bare(&claimed.by_any, faults);
    groups
}

/// What an earlier run says, with the rigidities of all springs that share the tension of an edge.
fn shared(mut prestress: Prestress, rules: &[RuleEdges<'_>], geometry: &Geometry) -> Prestress {
    for RuleEdges { values, edges, strands, .. } in rules {
        if let Some(values) = values {
            prestress.add(values.law(), edges, strands.as_deref(), geometry);
        }
    }
    prestress
}

/// Refuses what makes or describes springs in a rule that makes none.
fn check_loads_only(at: &Pointer, rule: &SpringRule, faults: &mut Faults<'_>) {
    let SpringRule {
        on: _,
        loads_only: _,
        material,
        stiffness,
        axial_rigidity,
        membrane,
        law,
        rest_length,
        rest_scale,
        linear_density,
        cut,
        when,
        strength,
        breaks,
        slack,
        dashpot,
    } = rule;
    let given = [
        ("material", material.is_some()),
        ("stiffness", stiffness.is_some()),
        ("axial_rigidity", axial_rigidity.is_some()),
        ("membrane", membrane.is_some()),
        ("law", law.is_some()),
        ("rest_length", rest_length.is_some()),
        ("rest_scale", rest_scale.is_some()),
        ("linear_density", linear_density.is_some()),
        ("cut", cut.is_some()),
        ("when", when.is_some()),
        ("breaks", *breaks),
        ("strength", strength.is_some()),
        ("slack", slack.is_some()),
        ("dashpot", dashpot.is_some()),
    ];
    for (key, _) in given.iter().filter(|(_, given)| *given) {
        faults.add_hint(&at.key(key), "not together with loads_only", "edges that only carry loads have no springs");
    }
}

/// Values of a rule that need no edge.
#[derive(Clone, Debug)]
struct RuleValues {
    stiffness: Stiffness,
    law: ElasticLaw,
    slack: Slack,
}

impl RuleValues {
    fn law(&self) -> Law<'_> {
        Law { stiffness: self.stiffness, curve: &self.law, slack: self.slack }
    }
}

fn values(at: &Pointer, rule: &SpringRule, faults: &mut Faults<'_>) -> Option<RuleValues> {
    let stiffness = stiffness(at, rule, faults);
    let slack = match rule.slack {
        None => Slack::None,
        Some(SlackRule::TensionOnly) => Slack::TensionOnly,
        Some(SlackRule::CompressionOnly) => Slack::CompressionOnly,
        Some(SlackRule::DeadZone(eps)) => Slack::DeadZone { eps },
        Some(SlackRule::CompressionLimit(eps)) => Slack::CompressionLimit { eps },
    };
    let law = elastic_law(at, rule, faults);
    Some(RuleValues { stiffness: stiffness?, law: law?, slack })
}

/// The factor of the rest lengths over time; `None` if it is constant, or faulty.
fn rest_factor(at: &Pointer, rule: &SpringRule, faults: &mut Faults<'_>) -> Option<Series<f64>> {
    let Some(Factor::Table(FactorTable { table })) = &rule.rest_scale else { return None };
    let at = at.key("table");
    let before = faults.count();
    for (i, [_, factor]) in table.iter().enumerate() {
        positive(&at.index(i).index(1), *factor, faults);
    }
    series(&at, table.iter().map(|[t, factor]| (*t, *factor)), faults).filter(|_| faults.count() == before)
}

/// The edges that have a spring so far.
struct Claimed {
    /// of a rule that is not for a group; later such rules pass over these edges
    by_rule: Vec<bool>,
    /// of any rule
    by_any: Vec<bool>,
}

/// The edges that follow this rule: all of a group, else the selected ones that follow no earlier rule.
fn claim(
    at: &Pointer,
    rule: &SpringRule,
    geometry: &Geometry,
    claimed: &mut Claimed,
    faults: &mut Faults<'_>,
) -> Option<Vec<u32>> {
    let selected = select::edges(&at.key("on"), &rule.on, geometry, faults)?;
    let adds = rule.on.group().is_some() && !rule.loads_only;
    let mut edges = Vec::new();
    let flags = claimed.by_rule.iter_mut().zip(&mut claimed.by_any);
    for (((by_rule, by_any), selected), edge) in flags.zip(selected).zip(0_u32..) {
        if selected && (adds || !*by_rule) {
            *by_rule |= !adds;
            *by_any = true;
            edges.push(edge);
        }
    }
    if edges.is_empty() {
        let text = "earlier rules take all the edges it selects, so it has no effect; order the special rules first";
        faults.warn(WarningCode::UnusedRule, format!("{at}: {text}"));
    }
    Some(edges)
}

/// A rule with the edges that follow it.
#[derive(Debug)]
struct RuleEdges<'a> {
    /// of the rule
    number: usize,
    /// the event that cuts them
    cut_by: Option<usize>,
    rule: &'a SpringRule,
    /// `None` where they are faulty
    values: Option<RuleValues>,
    /// of the rest lengths over time, if they change
    factor: Option<Series<f64>>,
    edges: Vec<u32>,
    /// [-] tapes or lines that each edge stands for; `None` where it is one
    strands: Option<Vec<f64>>,
    /// the steps of the run, if known
    step: Option<Step>,
}

fn group(
    at: &Pointer,
    members: RuleEdges<'_>,
    prestress: Option<&Prestress>,
    geometry: &Geometry,
    faults: &mut Faults<'_>,
) -> Option<SpringGroup> {
    let RuleEdges { number, cut_by, rule, values, factor, edges, strands, step } = members;
    let at = &at.index(number);
    let kept = prestress.zip(values.as_ref()).map(|(kept, values)| kept.rest_lengths(values.law(), &edges, geometry));
    let kept = match kept.transpose() {
        Ok(kept) => kept,
        Err(bad) if rule.rest_length.is_none() && !matches!(rule.rest_scale, Some(Factor::Constant(_))) => {
            let value = format!("a law that does not have the tensions kept on edges {}", first_few(&bad));
            let hint =
                "give these edges a rule whose springs carry them: stiff enough, and in compression where they push";
            faults.add_value(at, value, "springs that can carry what initial.keep says", Some(hint.to_owned()));
            return None;
        }
        Err(_) => None,
    };
    // Before the values, so that faults of both are reported at once.
    let rest_length = rest_lengths(at, rule, &edges, kept, geometry, faults);
    let (RuleValues { stiffness, law, slack }, rest_length) = (values?, rest_length?);
    if edges.is_empty() {
        return None;
    }
    let strands = strands.as_deref();
    let stiffness = stiffness.of_edges(at, &edges, &rest_length, geometry, faults)?;
    let stiffness = strands.map_or(stiffness.clone(), |strands| stiffness.times(strands));
    let dashpot = match rule.dashpot {
        None => None,
        Some(rule) => {
            let springs = Springs { stiffness: &stiffness, rest: &rest_length, strands, step };
            Some(dashpot(&at.key("dashpot"), rule, &springs, faults)?)
        }
    };
    let name = || match rule.on.group() {
        Some(group) => format!("springs[{number}] {group}"),
        None => format!("springs[{number}]"),
    };
    let breaks = rule.strength.filter(|_| rule.breaks).map_or_else(Vec::new, |strength| {
        (0..edges.len()).map(|i| strength * strands.map_or(1.0, |strands| strands[i])).collect()
    });
    let strands = strands.map(<[f64]>::to_vec);
    let strength = rule.strength.map(|strength| StrengthSpec { name: name(), strength, strands });
    let sheet = rule.membrane.map(|Membrane { modulus, thickness }| SheetSpec { modulus, thickness });
    Some(SpringGroup {
        edges,
        stiffness,
        rest_length,
        law,
        slack,
        dashpot,
        cut: None,
        cut_by,
        breaks,
        rest_scale: factor,
        strength,
        sheet,
    })
}

/// Adds half of an edge's mass to each of its ends; `densities` [kg/m], `total` [kg] `[n_nodes]`.
fn add_mass(densities: &SpringValues, edges: &[u32], geometry: &Geometry, total: &mut [f64]) {
    for (&edge, density) in edges.iter().zip(densities.of(edges.len())) {
        let length = geometry.unstretched.get(edge as usize).copied().unwrap_or_default();
        for &node in geometry.mesh.edges.get(edge as usize).into_iter().flatten() {
            mass::add(total, node, 0.5 * density * length);
        }
    }
}

fn warn_bare(taken: &[bool], faults: &mut Faults<'_>) {
    let bare: Vec<u32> = taken.iter().zip(0_u32..).filter(|(taken, _)| !**taken).map(|(_, e)| e).collect();
    if !bare.is_empty() {
        let text = format!("no spring rule selects the edges {}: they carry no spring", first_few(&bare));
        faults.warn(WarningCode::UnselectedEdges, text);
    }
}
