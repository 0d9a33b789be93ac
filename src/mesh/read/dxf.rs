//! Drawing exchange .dxf in text: 3DFACE, LINE, POLYLINE (open, closed, meshes of faces, grids), LWPOLYLINE, CIRCLE and
//! ARC. Closed ones are outlines. Layers are groups. Corners at one place become one node.
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
            if code == BULGE {
                // Only vertices before an arc have one.
                let vertices = entity.values.get(&10).map_or(0, Vec::len);
                let bulges = entity.values.entry(code).or_default();
                bulges.resize(bulges.len().max(vertices.saturating_sub(1)), "0".to_owned());
            }
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
    /// for each point, the tangent of a quarter of the angle of the arc to the next; 0 for a straight side
    bulges: Vec<f64>,
    /// faces of a mesh by their corners, counted from 1; negative where a side is not drawn
    faces: Vec<Vec<i64>>,
}

/// Flags of polylines and their vertices.
const CLOSED: i64 = 1;
const GRID: i64 = 16;
const CLOSED_ACROSS: i64 = 32;
const MESH: i64 = 64;
const FACE: i64 = 128;

/// Code of the bulge of a vertex.
const BULGE: i32 = 42;
/// [rad] Largest angle of a chord of an arc.
const CHORD: f64 = std::f64::consts::PI / 36.0;

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
                let bulges = entity.values.get(&BULGE).into_iter().flatten().map(|text| number(Some(text)));
                let bulges = bulges.collect::<Result<Vec<f64>, String>>()?;
                self.outline(&points, &bulges, entity.whole(70)? & CLOSED != 0, &layer);
            }
            "CIRCLE" | "ARC" => {
                let ([x, y, z], radius) = (entity.point(10)?, entity.real(40)?);
                let arc = entity.kind == "ARC";
                let [from, to] = if arc { [entity.real(50)?, entity.real(51)?] } else { [0.0, 180.0] };
                let ends = [from, to].map(|angle| angle.to_radians());
                let ends = ends.map(|angle| self.point([x + radius * angle.cos(), y + radius * angle.sin(), z]));
                // An arc turns to the left; a circle is two half ones.
                let bulge = ((to - from).rem_euclid(360.0).to_radians() / 4.0).tan();
                self.outline(&ends, &[bulge; 2], !arc, &layer);
            }
            "POLYLINE" => {
                self.end_polyline()?;
                let size = [entity.whole(71)?, entity.whole(72)?].map(|n| usize::try_from(n).unwrap_or(0));
                let flags = entity.whole(70)?;
                let (points, bulges, faces) = (Vec::new(), Vec::new(), Vec::new());
                self.polyline = Some(Polyline { flags, size, layer, points, bulges, faces });
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
                    let (point, bulge) = (self.point(place), entity.real(BULGE)?);
                    if let Some(line) = &mut self.polyline {
                        line.points.push(point);
                        line.bulges.push(bulge);
                    }
                }
            }
            "SEQEND" => self.end_polyline()?,
            "" | "SECTION" | "ENDSEC" | "EOF" | "POINT" | "TEXT" | "MTEXT" | "DIMENSION" | "VIEWPORT" => {}
            _ => self.cells.remark("entities other than faces, lines and polylines were left out: explode them first"),
        }
        Ok(())
    }

    /// A polyline with its arcs. One that ends where it began is closed, whatever it says.
    fn outline(&mut self, points: &[u64], bulges: &[f64], closed: bool, layer: &[String]) {
        let mut all = Vec::with_capacity(points.len());
        for (at, &point) in points.iter().enumerate() {
            all.push(point);
            let next = points.get(at + 1).or(points.first().filter(|_| closed));
            if let (Some(&next), Some(&bulge)) = (next, bulges.get(at).filter(|bulge| **bulge != 0.0)) {
                self.arc([point, next], bulge, &mut all);
            }
        }
        let place = |point: &u64| self.cells.points[*point as usize];
        let ends_meet = all.len() > 3 && all.first().map(place) == all.last().map(place);
        if (closed && all.len() > 2) || ends_meet {
            if ends_meet {
                all.pop();
            }
            self.cells.add_outline(all, layer);
        } else {
            self.cells.add_line(&all, false);
            self.cells.name_cells(layer);
        }
    }

    /// Points on an arc between two points, in the x-y plane; `bulge` is the tangent of a quarter of its angle, above 0
    /// if it turns to the left.
    fn arc(&mut self, ends: [u64; 2], bulge: f64, to: &mut Vec<u64>) {
        let [[ax, ay, z], [bx, by, _]] = ends.map(|point| self.cells.points[point as usize]);
        let quarter = bulge.atan();
        let chords = (4.0 * quarter.abs() / CHORD).ceil() as usize;
        for i in 1..chords {
            // A point that sees the chord under the angle pi - 2 quarter, at this share of the arc.
            let turn = 4.0 * quarter * i as f64 / chords as f64;
            let share = (0.5 * turn).sin() / (2.0 * quarter).sin();
            let (sin, cos) = (0.5 * turn - 2.0 * quarter).sin_cos();
            let [dx, dy] = [bx - ax, by - ay];
            let place = [ax + share * (cos * dx - sin * dy), ay + share * (sin * dx + cos * dy), z];
            to.push(self.point(place));
        }
        self.cells.remark("arcs were divided into chords of at most 5 degrees");
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
            self.outline(&line.points, &line.bulges, line.flags & CLOSED != 0, &line.layer);
        }
        self.cells.name_cells(&line.layer);
        Ok(())
    }
}
