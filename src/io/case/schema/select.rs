//! Selections: the `"on"` of supports, springs, loads and probes.

use schemars::{JsonSchema, Schema};
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// The branches as a `oneOf`, that of `except` second: stand-ins are the first and the last one, which hold no others.
fn one_of(schema: &mut Schema) {
    if let Some(Value::Array(mut branches)) = schema.remove("anyOf") {
        branches.rotate_right(1);
        branches.swap(0, 1);
        schema.insert("oneOf".to_owned(), branches.into());
    }
}

/// Some nodes of the mesh. Nodes count from 0; positions are those of the mesh as given.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(transform = one_of)]
pub enum NodeSelection {
    /// Every node.
    All,
    /// The nodes of all boundary loops of the triangles.
    Boundary,
    /// The nodes of the boundary loop that encloses all others.
    Outer,
    /// The nodes of every other boundary loop: the edges of holes.
    Inner,
    /// [-] The nodes with these numbers, counted from 0.
    Ids(Vec<u32>),
    /// [m] The nodes inside an axis-aligned box, its faces included: lowest corner, highest corner.
    Box([[f64; 3]; 2]),
    /// The nodes inside a sphere, its surface included.
    Sphere(Ball),
    /// The members of the mesh's group with this name: its nodes, or, if it lists none, those of its edges and
    /// triangles. Where triangles are selected, its triangles.
    Group(String),
    /// What one selection has and another has not: `{"of": "outer", "except": {"group": "gate"}}`.
    #[serde(untagged)]
    Except(Box<NodesExcept>),
}

/// Nodes, or triangles, without some of them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NodesExcept {
    /// Those that are left out. Some of them are in `of`, and something is left.
    pub except: NodeSelection,
    /// Those from which they are taken.
    pub of: NodeSelection,
}

/// A solid sphere.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Ball {
    /// [m] Centre.
    pub center: [f64; 3],
    /// [m] Radius.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub radius: f64,
}

/// Some edges of the mesh; every edge can carry a spring.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(transform = one_of)]
pub enum EdgeSelection {
    /// Every edge.
    All,
    /// Edges of exactly one triangle.
    Boundary,
    /// Edges between triangles.
    Interior,
    /// The radial seam lines of the mesh, as given by its `seams`.
    Seams,
    /// Edges that belong to no triangle: chains, suspension lines.
    Lines,
    /// [-] The edges with these numbers, counted from 0.
    Ids(Vec<u32>),
    /// The edges of the mesh's group with this name: those it lists, or, if it lists none, those of its triangles.
    Group(String),
    /// What one selection has and another has not: `{"of": "boundary", "except": {"group": "gate"}}`.
    #[serde(untagged)]
    Except(Box<EdgesExcept>),
}

/// Edges without some of them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EdgesExcept {
    /// Those that are left out. Some of them are in `of`, and something is left.
    pub except: EdgeSelection,
    /// Those from which they are taken.
    pub of: EdgeSelection,
}

impl EdgeSelection {
    /// The group that it selects, or selects from.
    pub fn group(&self) -> Option<&str> {
        match self {
            Self::Group(name) => Some(name),
            Self::Except(both) => both.of.group(),
            _ => None,
        }
    }
}

/// Some nodes or some edges of the mesh, or a contact.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(transform = one_of)]
pub enum NodeOrEdgeSelection {
    /// Every node, or every edge.
    All,
    /// The nodes of all boundary loops of the triangles, or the edges of exactly one triangle.
    Boundary,
    /// The nodes of the boundary loop that encloses all others.
    Outer,
    /// The nodes of every other boundary loop: the edges of holes.
    Inner,
    /// Edges between triangles.
    Interior,
    /// The radial seam lines of the mesh, as given by its `seams`.
    Seams,
    /// Edges that belong to no triangle: chains, suspension lines.
    Lines,
    /// [-] The contact with this number in the section `contact`, counted from 0, for a gauge of `contact`.
    Contact(u32),
    /// [-] The nodes, or the edges, with these numbers, counted from 0.
    Ids(Vec<u32>),
    /// [m] The nodes inside an axis-aligned box, its faces included: lowest corner, highest corner.
    Box([[f64; 3]; 2]),
    /// The nodes inside a sphere, its surface included.
    Sphere(Ball),
    /// The nodes, or the edges, of the mesh's group with this name.
    Group(String),
    /// What one selection has and another has not: `{"of": "outer", "except": {"group": "gate"}}`.
    #[serde(untagged)]
    Except(Box<NodesOrEdgesExcept>),
}

/// Nodes, edges or triangles without some of them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NodesOrEdgesExcept {
    /// Those that are left out. Some of them are in `of`, and something is left.
    pub except: NodeOrEdgeSelection,
    /// Those from which they are taken.
    pub of: NodeOrEdgeSelection,
}

impl NodeOrEdgeSelection {
    /// The nodes it selects; `None` if it can only select edges.
    pub fn nodes(&self) -> Option<NodeSelection> {
        Some(match self {
            Self::All => NodeSelection::All,
            Self::Boundary => NodeSelection::Boundary,
            Self::Outer => NodeSelection::Outer,
            Self::Inner => NodeSelection::Inner,
            Self::Ids(list) => NodeSelection::Ids(list.clone()),
            Self::Box(corners) => NodeSelection::Box(*corners),
            Self::Sphere(ball) => NodeSelection::Sphere(*ball),
            Self::Group(name) => NodeSelection::Group(name.clone()),
            Self::Except(both) => {
                let (except, of) = (both.except.nodes()?, both.of.nodes()?);
                NodeSelection::Except(Box::new(NodesExcept { except, of }))
            }
            Self::Interior | Self::Seams | Self::Lines | Self::Contact(_) => return None,
        })
    }

    /// The edges it selects; `None` if it can only select nodes.
    pub fn edges(&self) -> Option<EdgeSelection> {
        Some(match self {
            Self::All => EdgeSelection::All,
            Self::Boundary => EdgeSelection::Boundary,
            Self::Interior => EdgeSelection::Interior,
            Self::Seams => EdgeSelection::Seams,
            Self::Lines => EdgeSelection::Lines,
            Self::Ids(list) => EdgeSelection::Ids(list.clone()),
            Self::Group(name) => EdgeSelection::Group(name.clone()),
            Self::Except(both) => {
                let (except, of) = (both.except.edges()?, both.of.edges()?);
                EdgeSelection::Except(Box::new(EdgesExcept { except, of }))
            }
            Self::Outer | Self::Inner | Self::Box(_) | Self::Sphere(_) | Self::Contact(_) => return None,
        })
    }
}

impl NodeSelection {
    /// The key of the selection in a case file.
    pub fn keyword(&self) -> &'static str {
        match self {
            Self::All => "all",
            Self::Boundary => "boundary",
            Self::Outer => "outer",
            Self::Inner => "inner",
            Self::Ids(_) => "ids",
            Self::Box(_) => "box",
            Self::Sphere(_) => "sphere",
            Self::Group(_) => "group",
            Self::Except(_) => "except",
        }
    }
}
