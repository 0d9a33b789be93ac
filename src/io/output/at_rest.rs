//! The largest values of an equilibrium, with the places and groups where they are, and what does not act there.

use crate::format_number::figures;
use crate::mesh::Group;
use crate::model::observables::{MembranePicture, Observables};
use crate::model::point::Point;
use crate::model::spec::{MembraneSpec, SpringGroup};
use crate::model::state::StateRef;
use serde::{Deserialize, Serialize};
use std::fmt;

/// The largest value of a quantity at rest; of the safety factor the smallest.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LargestValue {
    /// `displacement` (from where the search began), `tension`, `stress` (of membranes), `reaction` or `safety_factor`
    /// (strength over tension; of membranes over the force per width)
    pub quantity: String,
    /// the value
    pub value: f64,
    /// its unit
    pub unit: String,
    /// `node`, `edge` or `triangle`
    pub part: String,
    /// its number
    pub number: u32,
    /// groups that it is in
    pub groups: Vec<String>,
    /// [m] where it is: the node, or the middle of the edge or triangle
    pub place: [f64; 3],
}

/// A load that is 0 at one time, and not at others.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct IdleLoad {
    /// its key in the network of the case: `loads[0]`, `gas`, `aero.wind`
    pub load: String,
    /// [s] when it is 0
    pub at: f64,
    /// [s] when it is largest
    pub largest_at: f64,
}

impl fmt::Display for IdleLoad {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [at, most] = [self.at, self.largest_at].map(|t| figures(t, 6));
        write!(f, "{} is 0 at t = {at} s, and largest at t = {most} s: take at={most}", self.load)
    }
}

/// What an equilibrium shows first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AtRest {
    /// largest values, those that the scene has
    pub largest: Vec<LargestValue>,
    /// [N] sum of the reactions of all supports
    pub reactions: [f64; 3],
    /// edges whose springs carry nothing
    pub slack: usize,
}

/// A part of a scene.
#[derive(Clone, Copy)]
enum Part {
    Node,
    Edge,
    Triangle,
}

/// A scene at rest.
struct Scene<'a> {
    picture: &'a dyn Observables,
    /// [m] of every node
    positions: Vec<[f64; 3]>,
}

impl AtRest {
    /// Of a point; `start` is where the search began, and springs and membranes are those of the scene.
    pub fn of(
        picture: &dyn Observables,
        start: StateRef<'_>,
        at: &Point,
        (springs, membranes): (&[SpringGroup], &[MembraneSpec]),
    ) -> Self {
        let nodes = picture.reference().len();
        let trace = |at: StateRef<'_>| {
            let (mut x, mut v) = (vec![[0.0; 3]; nodes], vec![[0.0; 3]; nodes]);
            picture.trace(at, &mut x, &mut v);
            x
        };
        let (state, before) = (at.state.as_ref(), trace(start));
        let scene = Scene { picture, positions: trace(state) };
        let moved = scene.positions.iter().zip(&before).map(|(x, o)| size(std::array::from_fn(|i| x[i] - o[i])));
        let mut largest = vec![scene.largest("displacement", "m", Part::Node, moved)];
        let edges = picture.edges().len();
        let (mut tension, mut strain) = (vec![0.0; edges], vec![0.0; edges]);
        picture.edge_tension(state, &mut tension, &mut strain);
        let slack = tension.iter().filter(|tension| **tension == 0.0).count();
        largest.push(scene.largest("tension", "N", Part::Edge, tension.iter().copied()));
        let mut sheets = vec![MembranePicture::default(); picture.triangles().len()];
        picture.triangle_membranes(state, &mut sheets);
        let stress = sheets.iter().map(|sheet| if sheet.wrinkling < 0.0 { f64::NAN } else { sheet.stress[0] });
        largest.push(scene.largest("stress", "Pa", Part::Triangle, stress));
        let mut reactions = vec![[0.0; 3]; nodes];
        picture.node_reactions(&at.forces, &mut reactions);
        let sum = reactions.iter().fold([0.0; 3], |sum: [f64; 3], r| std::array::from_fn(|i| sum[i] + r[i]));
        let held = reactions.iter().map(|r| if *r == [0.0; 3] { f64::NAN } else { size(*r) });
        largest.push(scene.largest("reaction", "N", Part::Node, held));
        largest.push(scene.safety_factor(state, springs));
        largest.push(scene.membrane_factor(&sheets, membranes));
        AtRest { largest: largest.into_iter().flatten().collect(), reactions: sum, slack }
    }
}

impl Scene<'_> {
    /// The largest of values, of which those that are NaN are none; `None` without any.
    fn largest(
        &self,
        quantity: &str,
        unit: &str,
        part: Part,
        values: impl Iterator<Item = f64>,
    ) -> Option<LargestValue> {
        let numbered = (0..).zip(values).filter(|(_, value)| !value.is_nan());
        // Of equal ones the first.
        let (number, value) = numbered.reduce(|most, other| if other.1 > most.1 { other } else { most })?;
        Some(self.value(quantity, unit, part, (number, value)))
    }

    /// The smallest strength over tension of springs with a strength.
    fn safety_factor(&self, at: StateRef<'_>, springs: &[SpringGroup]) -> Option<LargestValue> {
        let all = self.picture.springs()?;
        let mut least: Option<(u32, f64)> = None;
        for (rule, group) in springs.iter().enumerate() {
            let Some(of) = &group.strength else { continue };
            for place in all.springs_on(&group.edges, Some(rule)) {
                let Some(edge) = all.edge_of(place) else { continue };
                let strands = of.strands.as_ref().zip(group.edges.binary_search(&edge).ok());
                let strands = strands.and_then(|(strands, i)| strands.get(i)).copied().unwrap_or(1.0);
                let tension = all.spring_tension(at, place);
                let factor = strands * of.strength / tension;
                if tension > 0.0 && least.is_none_or(|(_, least)| factor < least) {
                    least = Some((edge, factor));
                }
            }
        }
        least.map(|found| self.value("safety_factor", "-", Part::Edge, found))
    }

    /// The smallest strength over force per width of membranes with a strength.
    fn membrane_factor(&self, sheets: &[MembranePicture], membranes: &[MembraneSpec]) -> Option<LargestValue> {
        let of_rule = |rule: &MembraneSpec| rule.strength.map(|strength| strength / rule.thickness);
        let rules = membranes.iter().filter_map(|rule| Some((rule, of_rule(rule)?)));
        let all = rules.flat_map(|(rule, strength)| rule.triangles.iter().map(move |&triangle| (triangle, strength)));
        let factors = all.filter_map(|(triangle, strength)| {
            let [stress, _] = sheets.get(triangle as usize)?.stress;
            (stress > 0.0).then_some((triangle, strength / stress))
        });
        let least = factors.reduce(|least, other| if other.1 < least.1 { other } else { least })?;
        Some(self.value("safety_factor", "-", Part::Triangle, least))
    }

    fn value(&self, quantity: &str, unit: &str, part: Part, (number, value): (u32, f64)) -> LargestValue {
        let picture = self.picture;
        let edge = |edge: u32| picture.edges().get(edge as usize).map_or(&[][..], |ends| ends);
        let triangle = |triangle: u32| picture.triangles().get(triangle as usize).map_or(&[][..], |nodes| nodes);
        let (name, nodes) = match part {
            Part::Node => ("node", vec![number]),
            Part::Edge => ("edge", edge(number).to_vec()),
            Part::Triangle => ("triangle", triangle(number).to_vec()),
        };
        let has = |Group { nodes, edges, triangles }: &Group| match part {
            Part::Node => {
                let of_edges = || edges.iter().any(|&one| edge(one).contains(&number));
                nodes.contains(&number) || of_edges() || triangles.iter().any(|&one| triangle(one).contains(&number))
            }
            Part::Edge => edges.contains(&number),
            Part::Triangle => triangles.contains(&number),
        };
        let places = nodes.iter().filter_map(|&node| self.positions.get(node as usize));
        let sum = places.fold([0.0; 3], |sum: [f64; 3], x| std::array::from_fn(|i| sum[i] + x[i]));
        LargestValue {
            quantity: quantity.to_owned(),
            value,
            unit: unit.to_owned(),
            part: name.to_owned(),
            number,
            groups: picture.groups().iter().filter(|(_, group)| has(group)).map(|(name, _)| name.clone()).collect(),
            place: sum.map(|sum| sum / nodes.len().max(1) as f64),
        }
    }
}

fn size([x, y, z]: [f64; 3]) -> f64 {
    x.hypot(y).hypot(z)
}
