//! Derivatives by what each spring and each node has.

use super::error::GradientError;
use super::reverse::{Asked, Reversed, ReversedRun, reverse};
use crate::case::Problem;
use crate::model::stop::Stop;
use crate::scene::{Adjoint, Scene};
use crate::sensitivity::ElementKinds;
use serde::{Deserialize, Serialize};

/// What springs or nodes have, each of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum EachOf {
    Stiffness,
    RestLength,
    Mass,
    Force,
    Position,
    Velocity,
}

/// How such a parameter begins in `--by`.
const PREFIX: &str = "each.";

impl EachOf {
    const ALL: [(EachOf, &'static str, &'static str); 6] = [
        (EachOf::Stiffness, "each.stiffness", "N/m"),
        (EachOf::RestLength, "each.rest_length", "m"),
        (EachOf::Mass, "each.mass", "kg"),
        (EachOf::Force, "each.force", "N"),
        (EachOf::Position, "each.position", "m"),
        (EachOf::Velocity, "each.velocity", "m/s"),
    ];

    /// The one of this name; `None` for a key of the case.
    pub(super) fn named(name: &str) -> Option<Result<Self, GradientError>> {
        name.strip_prefix(PREFIX)?;
        let found = EachOf::ALL.iter().find(|(_, known, _)| *known == name).map(|(of, ..)| *of);
        Some(found.ok_or_else(|| {
            let known: Vec<&str> = EachOf::ALL.iter().map(|(_, known, _)| *known).collect();
            GradientError::Key { key: name.to_owned(), why: format!("known are {}", known.join(", ")) }
        }))
    }

    fn words(self) -> (&'static str, &'static str) {
        EachOf::ALL.iter().find(|(of, ..)| *of == self).map_or(("", ""), |(_, name, unit)| (*name, *unit))
    }
}

/// What has a number of its own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Element {
    /// each edge of the mesh; of several springs on an edge, the sum
    #[default]
    Edge,
    /// each node
    Node,
}

/// The derivatives of a quantity by what each edge or each node has.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ElementDerivatives {
    /// what: `each.stiffness`, `each.rest_length`, `each.mass`, `each.force`, `each.position`, `each.velocity`
    pub by: String,
    /// its unit
    pub by_unit: String,
    /// what has it
    pub on: Element,
    /// 1, or 3 for x, y and z
    pub components: usize,
    /// the derivatives `[n, components]`, in the unit of the quantity over that of the parameter; null on an edge
    /// without spring, by a rest length or a stiffness of 0, and by a velocity that is held
    pub values: Vec<Option<f64>>,
    /// the largest of them
    pub largest: Option<LargestDerivative>,
    /// [-] relative change of the quantity over that of all of these numbers together; null for vectors
    pub elasticity: Option<f64>,
}

/// The largest derivative.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LargestDerivative {
    /// where, in words
    pub place: String,
    /// its value
    pub value: f64,
}

/// The derivatives by single springs and nodes of a run.
pub(super) struct ByElements {
    pub run: ReversedRun,
    /// of each quantity
    pub derivatives: Vec<Vec<ElementDerivatives>>,
}

/// What is asked for.
#[derive(Clone, Copy)]
pub(super) struct ByElementsSpec<'a> {
    pub problem: &'a Problem,
    pub of: &'a [EachOf],
    pub states: Option<u64>,
    pub interrupt: Stop<'a>,
}

/// Finds them.
pub(super) fn by_elements(spec: ByElementsSpec<'_>, scene: &dyn Scene) -> Result<ByElements, GradientError> {
    let ByElementsSpec { problem, of, states, interrupt } = spec;
    let fault = |of: EachOf, why: &str| GradientError::Key { key: of.words().0.to_owned(), why: why.to_owned() };
    let first = of.first().copied().unwrap_or(EachOf::Position);
    let adjoint = scene.adjoint().ok_or_else(|| fault(first, "this scene has no springs and nodes of its own"))?;
    if of.contains(&EachOf::Mass) && scene.added_mass().is_some() {
        return Err(fault(EachOf::Mass, "time.mass_scaling adds to masses; leave it out"));
    }
    let kinds = ElementKinds {
        stiffness: of.contains(&EachOf::Stiffness),
        rest_length: of.contains(&EachOf::RestLength),
        mass: of.contains(&EachOf::Mass),
    };
    let table = Table::of(scene, adjoint);
    let run = reverse(problem, (scene, adjoint), Asked { kinds, states }, interrupt)?;
    let derivatives = run.quantities.iter().map(|found| of.iter().map(|of| table.derivatives(*of, found)).collect());
    Ok(ByElements { derivatives: derivatives.collect(), run })
}

/// The springs and nodes of a scene, in the user's numbering.
struct Table<'a> {
    scene: &'a dyn Scene,
    adjoint: &'a dyn Adjoint,
    /// the edge of every spring
    edges: Vec<usize>,
    /// [N/m] and [m] its stiffness and rest length
    springs: Vec<[f64; 2]>,
    /// [kg] of every node
    masses: Vec<f64>,
    /// whether a degree of freedom is held at the start
    held: Vec<bool>,
}

impl<'a> Table<'a> {
    fn of(scene: &'a dyn Scene, adjoint: &'a dyn Adjoint) -> Self {
        let edge = |place| scene.springs().and_then(|all| all.edge_of(place)).unwrap_or(0) as usize;
        let edges = adjoint.springs().into_iter().map(edge).collect();
        let n = scene.n_dof();
        let mut masses = vec![0.0; n];
        scene.mass_times(&vec![1.0; n], &mut masses);
        let held = scene.inverse_mass().iter().map(|inverse| *inverse == 0.0).collect();
        Table { scene, adjoint, edges, springs: adjoint.spring_values(), masses, held }
    }

    fn derivatives(&self, of: EachOf, found: &Reversed) -> ElementDerivatives {
        let (by, by_unit) = of.words();
        let quantity = found.of.value.filter(|value| *value != 0.0);
        let made = |on, components, values: Vec<f64>, share: Option<f64>| ElementDerivatives {
            by: by.to_owned(),
            by_unit: by_unit.to_owned(),
            on,
            components,
            largest: self.largest(on, components, &values),
            values: values.into_iter().map(|value| Some(value).filter(|value| value.is_finite())).collect(),
            elasticity: quantity.and_then(|quantity| Some(share? / quantity)),
        };
        let vectors = |all: &[f64]| made(Element::Node, 3, self.by_node(all).into_flattened(), None);
        match of {
            EachOf::Stiffness | EachOf::RestLength => {
                let which = usize::from(of == EachOf::RestLength);
                let shares = [&found.slopes.stiffness, &found.slopes.rest_length][which];
                made(Element::Edge, 1, self.by_edge(shares, which), Some(shares.iter().sum()))
            }
            EachOf::Mass => {
                let slopes: Vec<[f64; 3]> = self.by_node(&found.slopes.mass);
                let share = found.slopes.mass.iter().zip(&self.masses).map(|(slope, mass)| slope * mass).sum();
                made(Element::Node, 1, slopes.iter().map(|of| of.iter().sum()).collect(), Some(share))
            }
            EachOf::Force => vectors(&found.slopes.force),
            EachOf::Position => vectors(&found.start[0]),
            EachOf::Velocity => {
                let free = found.start[1].iter().zip(&self.held);
                vectors(&free.map(|(slope, held)| if *held { f64::NAN } else { *slope }).collect::<Vec<_>>())
            }
        }
    }

    /// By the number itself, from that by shares of it; NaN where there is none.
    fn by_edge(&self, shares: &[f64], which: usize) -> Vec<f64> {
        let mut values = vec![f64::NAN; self.scene.edges().len()];
        for ((share, edge), own) in shares.iter().zip(&self.edges).zip(&self.springs) {
            let Some(value) = values.get_mut(*edge).filter(|_| own[which] != 0.0) else { continue };
            *value = if value.is_nan() { 0.0 } else { *value } + share / own[which];
        }
        values
    }

    fn by_node(&self, dofs: &[f64]) -> Vec<[f64; 3]> {
        let of = |node: usize| {
            let first = self.adjoint.first_dof(node as u32);
            std::array::from_fn(|axis| dofs.get(first + axis).copied().unwrap_or(f64::NAN))
        };
        (0..self.scene.reference().len()).map(of).collect()
    }

    fn largest(&self, on: Element, components: usize, values: &[f64]) -> Option<LargestDerivative> {
        let finite = values.iter().copied().enumerate().filter(|(_, value)| value.is_finite());
        let (place, value) = finite.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
        let number = (place / components) as u32;
        let place = match on {
            Element::Edge => self.scene.spring_in_words(number),
            Element::Node if components == 3 => {
                format!("{}, {}", self.scene.node_in_words(number), ["x", "y", "z"][place % 3])
            }
            Element::Node => self.scene.node_in_words(number),
        };
        Some(LargestDerivative { place, value })
    }
}
