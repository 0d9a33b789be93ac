//! What all frames of a run share: cells, groups, and the values that they have.

use crate::vtk::read::{DataSet, Piece};
use serde::Serialize;
use std::collections::BTreeMap;

/// What begins the names of the arrays that list the numbers of a group.
const PREFIXES: [(&str, bool); 2] = [("group ", false), ("node group ", true)];
/// VTK's numbers of the types of cells that frames have.
const TYPES: [(u8, usize); 3] = [(5, 3), (3, 2), (1, 1)];

/// Something that colours show.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Field {
    /// name of the array in the frames
    #[serde(skip)]
    pub array: &'static str,
    /// its name for people
    pub name: &'static str,
    /// its unit
    pub unit: &'static str,
    /// what has a value
    pub on: Place,
}

/// What has a value of a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Place {
    /// every cell
    Cells,
    /// every triangle
    Triangles,
    /// every node, of a vector whose size is shown
    Nodes,
}

/// All that colours can show, in the order of the menu.
pub(super) const FIELDS: [Field; 5] = [
    Field { array: "stress_1", name: "stress", unit: "Pa", on: Place::Triangles },
    Field { array: "pressure", name: "pressure", unit: "Pa", on: Place::Triangles },
    Field { array: "tension", name: "tension", unit: "N", on: Place::Cells },
    Field { array: "velocity", name: "speed", unit: "m/s", on: Place::Nodes },
    Field { array: "strain", name: "strain", unit: "-", on: Place::Cells },
];

/// A named part of the scene: the cells, or the nodes, whose class is one of these.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct PartGroup {
    /// its name
    pub name: String,
    /// whether it is of nodes
    pub nodes: bool,
    /// numbers of its classes
    pub classes: Vec<i64>,
}

/// The cells of a scene by their nodes, and its groups.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Scene {
    /// [-] number of nodes
    pub nodes: usize,
    /// `[n][3]`
    pub triangles: Vec<u32>,
    /// `[n][2]`
    pub edges: Vec<u32>,
    /// nodes without edges and triangles
    pub dots: Vec<u32>,
    /// of every cell: 1 for an edge that is a side of a triangle
    pub sides: Vec<u8>,
    /// class of every cell, 0 without a group
    pub cell_classes: Vec<u16>,
    /// class of every node
    pub node_classes: Vec<u16>,
    /// named parts
    pub groups: Vec<PartGroup>,
    /// what colours can show
    pub fields: Vec<Field>,
}

impl Scene {
    /// Takes what all frames share from one with the arrays of all [`FIELDS`].
    ///
    /// # Errors
    /// The fault of the frame, as the end of a sentence that begins with its name.
    pub(super) fn new(data: DataSet) -> Result<Self, String> {
        let piece = data.pieces.into_iter().next().ok_or("has no points")?;
        let mut scene = Scene { nodes: piece.points.len(), ..Scene::default() };
        scene.add_cells(&piece)?;
        let classes = |found: Option<Vec<f64>>, count: usize| match found {
            Some(numbers) => numbers.iter().map(|n| *n as u16).collect(),
            None => vec![0; count],
        };
        let named = crate::vtk::read::named_array;
        scene.sides = named(&piece.cell_data, "kind").unwrap_or_default().iter().map(|k| u8::from(*k == 1.0)).collect();
        scene.sides.resize(scene.cells(), 0);
        scene.cell_classes = classes(named(&piece.cell_data, "group"), scene.cells());
        scene.node_classes = classes(named(&piece.point_data, "group"), scene.nodes);
        scene.groups = groups(&data.fields);
        let has = |field: &Field| match field.on {
            Place::Nodes => piece.point_data.iter().any(|column| column.name == field.array),
            _ => piece.cell_data.iter().any(|column| column.name == field.array),
        };
        scene.fields = FIELDS.into_iter().filter(has).collect();
        let sized = scene.cell_classes.len() == scene.cells() && scene.node_classes.len() == scene.nodes;
        if sized { Ok(scene) } else { Err("is damaged: an array has not one number per cell or point".to_owned()) }
    }

    /// Number of triangles, edges and dots.
    pub(super) fn cells(&self) -> usize {
        self.triangles.len() / 3 + self.edges.len() / 2 + self.dots.len()
    }

    /// Number of values of a field.
    pub(super) fn values(&self, field: &Field) -> usize {
        match field.on {
            Place::Cells => self.cells(),
            Place::Triangles => self.triangles.len() / 3,
            Place::Nodes => self.nodes,
        }
    }

    /// [byte] of a packed frame
    pub(super) fn frame_bytes(&self) -> usize {
        (6 * self.nodes + self.fields.iter().map(|field| self.values(field)).sum::<usize>()).next_multiple_of(2)
    }

    /// All of it that is not a name, little-endian: corners of triangles, edges and dots, then sides and classes.
    pub(super) fn bytes(&self) -> Vec<u8> {
        let corners = self.triangles.iter().chain(&self.edges).chain(&self.dots).flat_map(|n| n.to_le_bytes());
        let classes = self.cell_classes.iter().chain(&self.node_classes).flat_map(|n| n.to_le_bytes());
        corners.chain(classes).chain(self.sides.iter().copied()).collect()
    }

    /// Triangles, then edges, then dots, as the frames of a run have them.
    fn add_cells(&mut self, piece: &Piece) -> Result<(), String> {
        let mut last = 0;
        for (kind, corners) in piece.cells.iter() {
            let rank = TYPES.iter().position(|known| *known == (kind, corners.len())).filter(|rank| *rank >= last);
            last = rank.ok_or("is no frame of canopy-fem: its cells are not triangles, then edges")?;
            let list = match last {
                0 => &mut self.triangles,
                1 => &mut self.edges,
                _ => &mut self.dots,
            };
            for &node in corners {
                let there = u32::try_from(node).ok().filter(|node| (*node as usize) < self.nodes);
                let node = there.ok_or("is damaged: a cell has a node that does not exist")?;
                list.push(node);
            }
        }
        Ok(())
    }
}

/// The groups that a frame names, in the order of their names.
fn groups(fields: &[(String, Vec<i64>)]) -> Vec<PartGroup> {
    let mut found = BTreeMap::new();
    for (name, classes) in fields {
        for (prefix, nodes) in PREFIXES {
            if let Some(name) = name.strip_prefix(prefix) {
                found.insert((nodes, name.to_owned()), classes.clone());
            }
        }
    }
    found.into_iter().map(|((nodes, name), classes)| PartGroup { name, nodes, classes }).collect()
}
