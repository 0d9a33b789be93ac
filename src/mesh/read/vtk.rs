//! .vtu, .vtp and legacy .vtk, also the frames that a run writes.

use super::cells::Cells;
use super::{SEAM, START_DISPLACEMENT};
use crate::mesh::group::{CELL_GROUP, GROUP, NODE_GROUP};
use crate::vtk::read::{field_numbers, named_array, piece_content, read as read_vtk};
use std::collections::BTreeMap;
use vtkio::model::{Attribute, CellType, DataSet, IOBuffer, PolyDataPiece, UnstructuredGridPiece, VertexNumbers};

pub(super) fn read(bytes: &[u8]) -> Result<Cells, String> {
    let mut cells = Cells::default();
    match read_vtk(bytes)? {
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
    for (name, numbers) in field_numbers(bytes)? {
        if let Some(group) = name.strip_prefix(CELL_GROUP) {
            add_names(&mut cells.cell_groups, group, numbers);
        } else if let Some(group) = name.strip_prefix(NODE_GROUP) {
            add_names(&mut cells.point_groups, group, numbers);
        }
    }
    if cells.cell_groups.is_empty() {
        cells.name_cell_groups();
    }
    Ok(cells)
}

/// Notes that members with one of these numbers belong to a group.
fn add_names(names: &mut BTreeMap<i64, Vec<String>>, group: &str, numbers: Vec<i64>) {
    for number in numbers {
        names.entry(number).or_default().push(group.to_owned());
    }
}

/// Adds what the points of a piece have: numbers of groups and the displacement at the start.
fn add_point_data(data: Vec<Attribute>, cells: &mut Cells) -> Result<(), String> {
    let numbers = named_array(data.clone(), GROUP).unwrap_or_default();
    cells.number_points(numbers.into_iter().map(|number| number as i64));
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

/// The cells' nodes; `first` is added to each.
fn lists(numbers: VertexNumbers, first: u64) -> Result<Vec<Vec<u64>>, String> {
    let damaged = || "is damaged: its cells and their nodes do not fit together".to_owned();
    let shift =
        |nodes: &[u64]| nodes.iter().map(|n| n.checked_add(first)).collect::<Option<Vec<_>>>().ok_or_else(damaged);
    let mut lists = Vec::new();
    match numbers {
        VertexNumbers::Legacy { vertices, .. } => {
            let wide: Vec<u64> = vertices.into_iter().map(u64::from).collect();
            let mut rest = wide.as_slice();
            while let Some((&count, tail)) = rest.split_first() {
                let count = usize::try_from(count).map_err(|_| damaged())?;
                let (nodes, tail) = tail.split_at_checked(count).ok_or_else(damaged)?;
                lists.push(shift(nodes)?);
                rest = tail;
            }
        }
        VertexNumbers::XML { connectivity, offsets } => {
            let mut from = 0;
            // Newer files begin with the offset 0, which would be a cell without nodes, so it is left out.
            for to in offsets.into_iter().filter(|&to| to != 0) {
                let to = usize::try_from(to).map_err(|_| damaged())?;
                lists.push(shift(connectivity.get(from..to).ok_or_else(damaged)?)?);
                from = to;
            }
        }
    }
    Ok(lists)
}

fn add_grid(piece: UnstructuredGridPiece, cells: &mut Cells) -> Result<(), String> {
    let first = add_points(piece.points, cells)?;
    add_point_data(piece.data.point, cells)?;
    let group = named_array(piece.data.cell.clone(), GROUP).unwrap_or_default();
    let seam = named_array(piece.data.cell, SEAM).unwrap_or_default();
    let lists = lists(piece.cells.cell_verts, first)?;
    if lists.len() != piece.cells.types.len() {
        return Err(format!("has {} cells but {} cell types", lists.len(), piece.cells.types.len()));
    }
    for (i, (nodes, kind)) in lists.iter().zip(piece.cells.types).enumerate() {
        let on_seam = seam.get(i).is_some_and(|&s| s != 0.0);
        match (kind, nodes.as_slice()) {
            (CellType::Vertex | CellType::PolyVertex, _) => cells.ignored += 1,
            (CellType::Line | CellType::PolyLine, _) => cells.add_line(nodes, on_seam),
            (CellType::Triangle | CellType::Quad | CellType::Polygon, _) => cells.add_face(nodes)?,
            (CellType::TriangleStrip, _) => add_strip(nodes, cells)?,
            // A pixel lists its corners row by row, not around.
            (CellType::Pixel, &[a, b, c, d]) => cells.add_face(&[a, b, d, c])?,
            _ => {
                return Err(format!("cell {i} is a {kind:?}; only lines, triangles and quads of first order are read"));
            }
        }
        cells.number_cells(group.get(i).map_or(0, |number| *number as i64));
    }
    Ok(())
}

fn add_poly(piece: PolyDataPiece, cells: &mut Cells) -> Result<(), String> {
    let first = add_points(piece.points, cells)?;
    let seam = named_array(piece.data.cell, SEAM).unwrap_or_default();
    let of = |numbers: Option<VertexNumbers>| numbers.map_or(Ok(Vec::new()), |n| lists(n, first));
    let vertices = of(piece.verts)?.len();
    cells.ignored += vertices;
    for (i, nodes) in of(piece.lines)?.iter().enumerate() {
        cells.add_line(nodes, seam.get(vertices + i).is_some_and(|&s| s != 0.0));
    }
    for nodes in of(piece.polys)? {
        cells.add_face(&nodes)?;
    }
    for nodes in of(piece.strips)? {
        add_strip(&nodes, cells)?;
    }
    Ok(())
}

/// Every second triangle of a strip has the opposite orientation.
fn add_strip(nodes: &[u64], cells: &mut Cells) -> Result<(), String> {
    for (i, t) in nodes.windows(3).enumerate() {
        cells.add_face(&if i % 2 == 0 { [t[0], t[1], t[2]] } else { [t[1], t[0], t[2]] })?;
    }
    Ok(())
}
