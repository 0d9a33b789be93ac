//! .vtu, .vtp and legacy .vtk, also the frames that a run writes.

use super::cells::{Cells, IGNORED};
use super::marks::Marks;
use super::{SEAM, START_DISPLACEMENT};
use crate::group::{CELL_GROUP, GROUP, KIND, NODE_GROUP};
use crate::vtk::read::{named_array, piece_content, read_with_fields, whole_numbers};
use std::collections::BTreeMap;
use std::ops::Range;
use vtkio::model::{Attribute, CellType, DataSet, IOBuffer, PolyDataPiece, UnstructuredGridPiece, VertexNumbers};

pub(super) fn read(bytes: &[u8]) -> Result<Cells, String> {
    let mut cells = Cells::default();
    let (data, fields) = read_with_fields(bytes)?;
    for (name, numbers) in fields {
        if let Some(group) = name.strip_prefix(CELL_GROUP) {
            add_names(&mut cells.cell_groups, group, numbers);
        } else if let Some(group) = name.strip_prefix(NODE_GROUP) {
            add_names(&mut cells.point_groups, group, numbers);
        }
    }
    match data {
        DataSet::UnstructuredGrid { pieces, .. } => {
            for piece in pieces {
                add_grid(piece_content(piece)?, &mut cells)?;
            }
        }
        DataSet::PolyData { pieces, .. } => {
            for piece in pieces {
                add_poly(piece_content(piece)?, &mut cells)?;
            }
        }
        _ => return Err("holds neither an unstructured grid nor polygons".into()),
    }
    Ok(cells)
}

/// Notes that members with one of these numbers belong to a group.
fn add_names(names: &mut BTreeMap<i64, Vec<String>>, group: &str, numbers: Vec<i64>) {
    for number in numbers {
        names.entry(number).or_default().push(group.to_owned());
    }
}

/// The groups of members: by the numbers of [`GROUP`], whose names the file tells, or by all arrays of whole numbers.
enum Parts {
    Numbers(Vec<i64>),
    Marks(Marks),
}

impl Parts {
    /// `named` says that the file tells names, as ours do.
    fn of(data: &[Attribute], named: bool) -> Self {
        if named {
            let numbers = named_array(data, GROUP).unwrap_or_default();
            return Parts::Numbers(numbers.into_iter().map(|number| number as i64).collect());
        }
        let mut arrays = whole_numbers(data);
        arrays.retain(|(name, _)| name != SEAM && name != KIND);
        Parts::Marks(Marks::new(arrays))
    }

    /// Puts the lines and faces that were added since the last call into the groups of a cell.
    fn name_cell(&self, cell: usize, cells: &mut Cells) {
        match self {
            Parts::Numbers(numbers) => cells.number_cells(numbers.get(cell).copied().unwrap_or(0)),
            Parts::Marks(marks) => cells.name_cells(&marks.names(cell)),
        }
    }
}

/// Adds what the points of a piece have: their groups and the displacement at the start.
fn add_point_data(data: &[Attribute], first: u64, cells: &mut Cells) -> Result<(), String> {
    match Parts::of(data, !cells.point_groups.is_empty()) {
        Parts::Numbers(numbers) => cells.number_points(numbers),
        Parts::Marks(marks) => {
            for point in first..cells.points.len() as u64 {
                cells.name_point(&marks.names((point - first) as usize), point);
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

/// Adds points; returns the number the first of them got.
fn add_points(points: IOBuffer, cells: &mut Cells) -> Result<u64, String> {
    let first = cells.points.len() as u64;
    let values: Vec<f64> = points.cast_into().ok_or("has points that are no numbers")?;
    if !values.len().is_multiple_of(3) {
        return Err("has points without three coordinates".into());
    }
    cells.points.extend(values.chunks_exact(3).map(|p| [p[0], p[1], p[2]]));
    Ok(first)
}

/// The nodes of cells, one after the other.
#[derive(Default)]
struct Lists {
    nodes: Vec<u64>,
    /// where the nodes of each cell are
    ranges: Vec<Range<usize>>,
}

impl Lists {
    fn iter(&self) -> impl ExactSizeIterator<Item = &[u64]> {
        self.ranges.iter().map(|range| &self.nodes[range.clone()])
    }
}

/// The cells' nodes; `first` is added to each.
fn lists(numbers: VertexNumbers, first: u64) -> Result<Lists, String> {
    let damaged = || "is damaged: its cells and their nodes do not fit together".to_owned();
    let mut lists = Lists::default();
    match numbers {
        VertexNumbers::Legacy { vertices, .. } => {
            lists.nodes = vertices.into_iter().map(u64::from).collect();
            let mut from = 0;
            while let Some(&count) = lists.nodes.get(from) {
                let end = usize::try_from(count).ok().and_then(|count| count.checked_add(from)?.checked_add(1));
                let end = end.filter(|end| *end <= lists.nodes.len()).ok_or_else(damaged)?;
                lists.ranges.push(from + 1..end);
                from = end;
            }
        }
        VertexNumbers::XML { connectivity, offsets } => {
            lists.nodes = connectivity;
            let mut from = 0;
            // Newer files begin with the offset 0, which would be a cell without nodes, so it is left out.
            for to in offsets.into_iter().filter(|&to| to != 0) {
                let to = usize::try_from(to).map_err(|_| damaged())?;
                lists.nodes.get(from..to).ok_or_else(damaged)?;
                lists.ranges.push(from..to);
                from = to;
            }
        }
    }
    // Counts among them are not used any more.
    for node in &mut lists.nodes {
        *node = node.checked_add(first).ok_or_else(damaged)?;
    }
    Ok(lists)
}

fn add_grid(piece: UnstructuredGridPiece, cells: &mut Cells) -> Result<(), String> {
    let first = add_points(piece.points, cells)?;
    add_point_data(&piece.data.point, first, cells)?;
    let parts = Parts::of(&piece.data.cell, !cells.cell_groups.is_empty());
    let seam = named_array(&piece.data.cell, SEAM).unwrap_or_default();
    let lists = lists(piece.cells.cell_verts, first)?;
    if lists.ranges.len() != piece.cells.types.len() {
        return Err(format!("has {} cells but {} cell types", lists.ranges.len(), piece.cells.types.len()));
    }
    for (i, (nodes, kind)) in lists.iter().zip(piece.cells.types).enumerate() {
        let on_seam = seam.get(i).is_some_and(|&s| s != 0.0);
        match (kind, nodes) {
            (CellType::Vertex | CellType::PolyVertex, _) => cells.remark(IGNORED),
            (CellType::Line | CellType::PolyLine, _) => cells.add_line(nodes, on_seam),
            (CellType::Triangle | CellType::Quad | CellType::Polygon, _) => cells.add_face(nodes),
            (CellType::TriangleStrip, _) => cells.add_strip(nodes),
            // A pixel lists its corners row by row, not around.
            (CellType::Pixel, &[a, b, c, d]) => cells.add_face(&[a, b, d, c]),
            _ => {
                return Err(format!("cell {i} is a {kind:?}; only lines, triangles and quads of first order are read"));
            }
        }
        parts.name_cell(i, cells);
    }
    Ok(())
}

fn add_poly(piece: PolyDataPiece, cells: &mut Cells) -> Result<(), String> {
    let first = add_points(piece.points, cells)?;
    add_point_data(&piece.data.point, first, cells)?;
    let parts = Parts::of(&piece.data.cell, !cells.cell_groups.is_empty());
    let seam = named_array(&piece.data.cell, SEAM).unwrap_or_default();
    // Cells are counted through all four lists.
    let mut cell = 0;
    for (list, kind) in [piece.verts, piece.lines, piece.polys, piece.strips].into_iter().zip(0..) {
        for nodes in list.map_or(Ok(Lists::default()), |numbers| lists(numbers, first))?.iter() {
            match kind {
                0 => cells.remark(IGNORED),
                1 => cells.add_line(nodes, seam.get(cell).is_some_and(|&s| s != 0.0)),
                2 => cells.add_face(nodes),
                _ => cells.add_strip(nodes),
            }
            parts.name_cell(cell, cells);
            cell += 1;
        }
    }
    Ok(())
}
