//! .vtu, .vtp and legacy .vtk, also the frames that a run writes.

use super::cells::{Cells, IGNORED};
use super::marks::Marks;
use super::{SEAM, START_DISPLACEMENT};
use crate::group::{CELL_GROUP, GROUP, KIND, LONGEST_NAME, NODE_GROUP};
use crate::vtk::read::{Column, Numbers, Piece, files_of, named_array};
use std::collections::{BTreeMap, HashMap};

/// Refuses a file that lists others, with their names.
pub(super) fn read_list(bytes: &[u8]) -> Result<Cells, String> {
    let files = files_of(bytes);
    let shown = files.iter().take(5).map(String::as_str).collect::<Vec<_>>().join(", ");
    Err(match files.len() {
        0 => "lists other files, but none by its name".to_owned(),
        n => format!("lists {n} files and holds no mesh itself; name one of its files: {shown}"),
    })
}

pub(super) fn read(bytes: &[u8]) -> Result<Cells, String> {
    let mut cells = Cells::default();
    let data = crate::vtk::read::read(bytes, &[SEAM, START_DISPLACEMENT])?;
    for (name, numbers) in data.fields {
        if let Some(group) = name.strip_prefix(CELL_GROUP) {
            add_names(&mut cells.cell_groups, group, numbers);
        } else if let Some(group) = name.strip_prefix(NODE_GROUP) {
            add_names(&mut cells.point_groups, group, numbers);
        }
    }
    for piece in data.pieces {
        add_piece(piece, &mut cells)?;
    }
    Ok(cells)
}

/// Notes that members with one of these numbers belong to a group.
fn add_names(names: &mut BTreeMap<i64, Vec<String>>, group: &str, numbers: Vec<i64>) {
    let group: String = group.chars().take(LONGEST_NAME).collect();
    for number in numbers {
        let listed = names.entry(number).or_default();
        if listed.last() != Some(&group) {
            listed.push(group.clone());
        }
    }
}

/// The groups of members: by the numbers of [`GROUP`], whose names the file tells, or by all arrays of whole numbers.
enum Parts {
    Numbers(Vec<i64>),
    Marks(Marks),
}

impl Parts {
    /// `named` says that the file tells names, as ours do.
    fn of(data: &[Column], named: bool) -> Self {
        if named {
            let numbers = named_array(data, GROUP).unwrap_or_default();
            return Parts::Numbers(numbers.into_iter().map(|number| number as i64).collect());
        }
        let marks = data.iter().filter_map(|column| match &column.numbers {
            Numbers::Whole(numbers)
                if column.components == 1 && ![SEAM, KIND, GHOSTS].contains(&column.name.as_str()) =>
            {
                Some((column.name.clone(), numbers.clone()))
            }
            _ => None,
        });
        Parts::Marks(Marks::new(marks.collect()))
    }

    /// The number of the groups of each cell; missing ones are 0. Names are made for those that `is_wanted` only.
    fn numbers(self, count: usize, is_wanted: impl Fn(usize) -> bool, cells: &mut Cells) -> Vec<i64> {
        let marks = match self {
            Parts::Numbers(numbers) => return numbers,
            Parts::Marks(marks) if marks.is_empty() => return Vec::new(),
            Parts::Marks(marks) => marks,
        };
        let mut known = HashMap::new();
        let mut number = |cell: usize, alike: u32| match is_wanted(cell) {
            true => *known.entry(alike).or_insert_with(|| cells.number_of(&marks.names(cell))),
            false => 0,
        };
        marks.first_alike(count).into_iter().enumerate().map(|(cell, alike)| number(cell, alike)).collect()
    }
}

/// Adds what the points of a piece have: their groups and the displacement at the start.
fn add_point_data(data: &[Column], first: u64, cells: &mut Cells) -> Result<(), String> {
    match Parts::of(data, !cells.point_groups.is_empty()) {
        Parts::Numbers(numbers) => cells.number_points(numbers),
        Parts::Marks(marks) if marks.is_empty() => {}
        Parts::Marks(marks) => {
            let (mut names, mut latest) = (Vec::new(), None);
            for (point, alike) in (first..).zip(marks.first_alike(cells.points.len() - first as usize)) {
                if latest != Some(alike) {
                    (names, latest) = (marks.names(alike as usize), Some(alike));
                }
                cells.name_point(&names, point);
            }
        }
    }
    if let Some(numbers) = named_array(data, START_DISPLACEMENT) {
        cells.displacement.extend(numbers.as_chunks().0);
    }
    match cells.displacement.len() {
        0 => Ok(()),
        n if n == cells.points.len() => Ok(()),
        n => Err(format!("has {n} vectors in \"{START_DISPLACEMENT}\" for {} points", cells.points.len())),
    }
}

/// Name of the array that marks cells which other files or pieces hold, and cells that are hidden.
const GHOSTS: &str = "vtkGhostType";
/// Bits of such a cell: it is a double, or hidden.
const DOUBLE: i64 = 1;
const HIDDEN: i64 = 32;

fn add_piece(piece: Piece, cells: &mut Cells) -> Result<(), String> {
    let first = cells.points.len() as u64;
    if first == 0 {
        cells.points = piece.points
    } else {
        cells.points.extend(&piece.points)
    }
    add_point_data(&piece.point_data, first, cells)?;
    let seam = named_array(&piece.cell_data, SEAM).unwrap_or_default();
    let whole =
        |name| piece.cell_data.iter().find(|column| column.name == name).map(|column| column.numbers.clone().whole());
    let ghosts = whole(GHOSTS).unwrap_or_default();
    // Older files tell how far a cell lies outside of the piece.
    let levels = whole("vtkGhostLevels").unwrap_or_default();
    let types = &piece.cells.types;
    let is_left_out = |cell: usize| {
        // Frames hide the lines on the sides of triangles, which are edges none the less.
        let bits = if matches!(types[cell], 3 | 4) { DOUBLE } else { DOUBLE | HIDDEN };
        ghosts.get(cell).is_some_and(|ghost| ghost & bits != 0) || levels.get(cell).is_some_and(|level| *level > 0)
    };
    let parts = Parts::of(&piece.cell_data, !cells.cell_groups.is_empty());
    let numbers = parts.numbers(types.len(), |cell| !is_left_out(cell), cells);
    let only_faces = types.iter().all(|kind| matches!(kind, 5 | 7 | 9));
    if first == 0 && only_faces && ghosts.is_empty() && levels.is_empty() {
        cells.add_faces(piece.cells.points, piece.cells.ends);
        cells.number_faces(numbers);
        return Ok(());
    }
    let mut nodes = Vec::new();
    for (i, (kind, points)) in piece.cells.iter().enumerate() {
        let on_seam = seam.get(i).is_some_and(|&s| s != 0.0);
        nodes.clear();
        nodes.extend(points.iter().map(|point| point.saturating_add(first)));
        if is_left_out(i) {
            cells.remark("ghost or hidden cells were left out");
            continue;
        }
        match (kind, &nodes[..]) {
            (0..=2, _) => cells.remark(IGNORED),
            (3 | 4, nodes) => cells.add_line(nodes, on_seam),
            (5 | 7 | 9, nodes) => cells.add_face(nodes),
            (6, nodes) => cells.add_strip(nodes),
            // A pixel lists its corners row by row, not around.
            (8, &[a, b, c, d]) => cells.add_face(&[a, b, d, c]),
            _ => {
                let kind = type_name(kind);
                return Err(format!("cell {i} is a {kind}; only lines, triangles and quads of first order are read"));
            }
        }
        cells.number_cells(numbers.get(i).copied().unwrap_or(0));
    }
    Ok(())
}

/// VTK's name of a type of cells that is not read.
fn type_name(kind: u8) -> String {
    let known = match kind {
        8 => "Pixel with other than four points",
        10 => "Tetra",
        11 => "Voxel",
        12 => "Hexahedron",
        13 => "Wedge",
        14 => "Pyramid",
        21 => "QuadraticEdge",
        22 => "QuadraticTriangle",
        23 => "QuadraticQuad",
        24 => "QuadraticTetra",
        25 => "QuadraticHexahedron",
        42 => "Polyhedron",
        69 => "LagrangeTriangle",
        70 => "LagrangeQuadrilateral",
        76 => "BezierTriangle",
        77 => "BezierQuadrilateral",
        other => return format!("cell of the type {other}"),
    };
    known.to_owned()
}
