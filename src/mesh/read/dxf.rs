//! Drawing exchange .dxf in text: 3DFACE, LINE, POLYLINE (open, closed, meshes of faces, grids) and LWPOLYLINE. Layers
//! are groups. Corners at one place become one node.
//!
//! Read by hand: the crate `dxf` brings decoders of pictures and a calendar along.

use super::cells::Cells;
use super::text::{number, text};
use std::collections::BTreeMap;

pub(super) fn read(bytes: &[u8]) -> Result<Cells, String> {
    if bytes.starts_with(b"AutoCAD Binary DXF") {
        return Err("is a binary DXF file; save it as text".to_owned());
    }
    let text = text(bytes);
    let mut file = File { cells: Cells::of_corners(), ..File::default() };
    let mut lines = text.lines();
    let (mut at, mut inside) = (0, false);
    let mut entity = Entity::default();
    let mut section = String::new();
    while let (Some(code), Some(value)) = (lines.next(), lines.next()) {
        at += 2;
        let code: i32 = number(Some(code.trim())).map_err(|why| format!("line {}: {why}", at - 1))?;
        let value = value.trim();
        if code == 0 {
            if inside {
                file.add(std::mem::take(&mut entity)).map_err(|why| format!("line {at}: {why}"))?;
            }
            entity = Entity { kind: value.to_owned(), ..Entity::default() };
        } else if code == 2 && entity.kind == "SECTION" {
            value.clone_into(&mut section);
            inside = section == "ENTITIES";
        } else if inside {
            entity.values.entry(code).or_default().push(value.to_owned());
        }
    }
    file.end_polyline()?;
    Ok(file.cells)
}

/// An entity of a drawing: its values by group code.
#[derive(Default)]
struct Entity {
    kind: String,
    values: BTreeMap<i32, Vec<String>>,
}

impl Entity {
    fn real(&self, code: i32) -> Result<f64, String> {
        self.values.get(&code).map_or(Ok(0.0), |list| number(list.first().map(String::as_str)))
    }

    fn whole(&self, code: i32) -> Result<i64, String> {
        self.values.get(&code).map_or(Ok(0), |list| number(list.first().map(String::as_str)))
    }

    /// The point whose x has this code.
    fn point(&self, code: i32) -> Result<[f64; 3], String> {
        Ok([self.real(code)?, self.real(code + 10)?, self.real(code + 20)?])
    }

    fn layer(&self) -> Vec<String> {
        self.values.get(&8).and_then(|list| list.first()).filter(|name| *name != "0").cloned().into_iter().collect()
    }
}

#[derive(Default)]
struct File {
    cells: Cells,
    /// the polyline whose vertices follow
    polyline: Option<Polyline>,
}

struct Polyline {
    flags: i64,
    /// rows and columns of a grid
    size: [usize; 2],
    layer: Vec<String>,
    points: Vec<u64>,
    /// faces of a mesh by their corners, counted from 1; negative where a side is not drawn
    faces: Vec<Vec<i64>>,
}

/// Flags of polylines and their vertices.
const CLOSED: i64 = 1;
const GRID: i64 = 16;
const CLOSED_ACROSS: i64 = 32;
const MESH: i64 = 64;
const FACE: i64 = 128;

impl File {
    fn point(&mut self, place: [f64; 3]) -> u64 {
        self.cells.points.push(place);
        self.cells.points.len() as u64 - 1
    }

    fn add(&mut self, entity: Entity) -> Result<(), String> {
        let layer = entity.layer();
        match entity.kind.as_str() {
            "3DFACE" => {
                // A triangle repeats its third corner.
                let mut corners = Vec::with_capacity(4);
                for code in [10, 11, 12, 13] {
                    let place = entity.point(code)?;
                    corners.push(self.point(place));
                }
                self.cells.add_face(&corners);
                self.cells.name_cells(&layer);
            }
            "LINE" => {
                let ends = [entity.point(10)?, entity.point(11)?].map(|place| self.point(place));
                self.cells.add_line(&ends, false);
                self.cells.name_cells(&layer);
            }
            "LWPOLYLINE" => {
                let height = entity.real(38)?;
                let [xs, ys] = [10, 20].map(|code| entity.values.get(&code).cloned().unwrap_or_default());
                let mut points = Vec::new();
                for (x, y) in xs.iter().zip(&ys) {
                    points.push(self.point([number(Some(x))?, number(Some(y))?, height]));
                }
                self.outline(&points, entity.whole(70)? & CLOSED != 0, &layer);
            }
            "POLYLINE" => {
                self.end_polyline()?;
                let size = [entity.whole(71)?, entity.whole(72)?].map(|n| usize::try_from(n).unwrap_or(0));
                let flags = entity.whole(70)?;
                self.polyline = Some(Polyline { flags, size, layer, points: Vec::new(), faces: Vec::new() });
            }
            "VERTEX" => {
                let flags = entity.whole(70)?;
                if flags & FACE != 0 && flags & MESH == 0 {
                    let corners = [71, 72, 73, 74].map(|code| entity.whole(code));
                    let corners: Vec<i64> = corners.into_iter().collect::<Result<_, String>>()?;
                    let corners = corners.into_iter().filter(|corner| *corner != 0).collect();
                    self.polyline.iter_mut().for_each(|line| line.faces.push(Vec::clone(&corners)));
                } else {
                    let place = entity.point(10)?;
                    let point = self.point(place);
                    self.polyline.iter_mut().for_each(|line| line.points.push(point));
                }
            }
            "SEQEND" => self.end_polyline()?,
            "" | "SECTION" | "ENDSEC" | "EOF" | "POINT" | "TEXT" | "MTEXT" | "DIMENSION" | "VIEWPORT" => {}
            _ => self.cells.remark("entities other than faces, lines and polylines were left out: explode them first"),
        }
        Ok(())
    }

    /// The lines along a polyline.
    fn outline(&mut self, points: &[u64], closed: bool, layer: &[String]) {
        self.cells.add_line(points, false);
        if let (true, [first, _, .., last]) = (closed, points) {
            self.cells.add_line(&[*last, *first], false);
        }
        self.cells.name_cells(layer);
    }

    fn end_polyline(&mut self) -> Result<(), String> {
        let Some(line) = self.polyline.take() else { return Ok(()) };
        if line.flags & MESH != 0 {
            for face in &line.faces {
                let corner = |n: &i64| {
                    let at = usize::try_from(n.unsigned_abs()).ok().and_then(|n| line.points.get(n.checked_sub(1)?));
                    at.copied().ok_or_else(|| format!("a face names vertex {n} of a mesh of {}", line.points.len()))
                };
                let corners = face.iter().map(corner).collect::<Result<Vec<u64>, String>>()?;
                if corners.len() == 2 { self.cells.add_line(&corners, false) } else { self.cells.add_face(&corners) }
            }
        } else if line.flags & GRID != 0 {
            let [rows, columns] = line.size;
            if rows.checked_mul(columns) != Some(line.points.len()) {
                return Err(format!("a grid of {rows} by {columns} has {} vertices", line.points.len()));
            }
            let at = |row: usize, column: usize| line.points[row % rows * columns + column % columns];
            let closed = |flag: i64| usize::from(line.flags & flag == 0);
            for row in 0..rows.saturating_sub(closed(CLOSED)) {
                for column in 0..columns.saturating_sub(closed(CLOSED_ACROSS)) {
                    let corners = [(0, 0), (0, 1), (1, 1), (1, 0)].map(|(r, c)| at(row + r, column + c));
                    self.cells.add_face(&corners);
                }
            }
        } else {
            self.outline(&line.points, line.flags & CLOSED != 0, &line.layer);
        }
        self.cells.name_cells(&line.layer);
        Ok(())
    }
}
