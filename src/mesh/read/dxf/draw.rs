//! Entities as points, lines, faces and outlines.

use super::curves::{arc, ellipse, spline};
use super::entity::Entity;
use super::{File, MOST_CURVED, Open};
use nalgebra::{Matrix3, Vector3};

pub(super) struct Polyline {
    flags: i64,
    /// rows and columns of a grid, and those of its smooth form
    sizes: [[usize; 2]; 2],
    layer: Vec<String>,
    /// of a flat one
    axes: Option<Matrix3<f64>>,
    points: Vec<u64>,
    /// in the plane of a flat one
    places: Vec<[f64; 3]>,
    /// for each point, the tangent of a quarter of the angle of the arc to the next; 0 for a straight side
    bulges: Vec<f64>,
    /// faces of a mesh by their corners, counted from 1; negative where a side is not drawn
    faces: Vec<Vec<i64>>,
}

/// Flags of polylines and their vertices.
const CLOSED: i64 = 1;
const SMOOTH: i64 = 4;
const IN_SPACE: i64 = 8;
const GRID: i64 = 16;
const CONTROL: i64 = 16;
const CLOSED_ACROSS: i64 = 32;
const MESH: i64 = 64;
const FACE: i64 = 128;

/// Code of the bulge of a vertex.
const BULGE: i32 = 42;

/// A place in a flat entity, in space.
fn in_space(axes: Option<&Matrix3<f64>>, place: [f64; 3]) -> [f64; 3] {
    axes.map_or(place, |axes| (axes * Vector3::from(place)).into())
}

impl<'a> File<'a> {
    pub(super) fn draw(&mut self, entity: &Entity<'a>) -> Result<(), String> {
        let layer = self.layer(entity);
        match entity.kind {
            "3DFACE" => {
                // A triangle repeats its third corner.
                let places = [entity.point(10)?, entity.point(11)?, entity.point(12)?, entity.point(13)?];
                self.face(places, &layer);
            }
            "SOLID" | "TRACE" => {
                // The corners stand row by row, and a triangle may lack its fourth.
                let fourth = if entity.has(13) { 13 } else { 12 };
                let axes = entity.axes()?;
                let places = [entity.point(10)?, entity.point(11)?, entity.point(fourth)?, entity.point(12)?];
                self.face(places.map(|place| in_space(axes.as_ref(), place)), &layer);
            }
            "LINE" => {
                let points = [entity.point(10)?, entity.point(11)?].map(|place| self.point(place)).to_vec();
                self.open.push(Open { points, layer });
            }
            "LWPOLYLINE" => {
                let height = entity.real(38)?;
                let mut places = entity.points(10)?;
                places.iter_mut().for_each(|place| place[2] = height);
                let axes = entity.axes()?;
                let points: Vec<u64> = places.iter().map(|place| self.point(in_space(axes.as_ref(), *place))).collect();
                let bulges = lwpolyline_bulges(entity)?;
                self.outline(&points, &places, axes.as_ref(), &bulges, (entity.whole(70)? & CLOSED != 0, layer))?;
            }
            "CIRCLE" | "ARC" => {
                let ([x, y, z], radius) = (entity.point(10)?, entity.real(40)?);
                let arc = entity.kind == "ARC";
                let [from, to] = if arc { [entity.real(50)?, entity.real(51)?] } else { [0.0, 180.0] };
                let ends = [from, to].map(|angle| angle.to_radians());
                let places = ends.map(|angle| [x + radius * angle.cos(), y + radius * angle.sin(), z]);
                let axes = entity.axes()?;
                let points = places.map(|place| self.point(in_space(axes.as_ref(), place)));
                // An arc turns to the left; a circle is two half ones.
                let bulge = ((to - from).rem_euclid(360.0).to_radians() / 4.0).tan();
                self.outline(&points, &places, axes.as_ref(), &[bulge; 2], (!arc, layer))?;
            }
            "ELLIPSE" | "SPLINE" => {
                let of_ellipse = entity.kind == "ELLIPSE";
                let (places, closed) =
                    if of_ellipse { ellipse(entity, self.chord)? } else { spline(entity, self.chord)? };
                self.count_curved(places.len())?;
                let points: Vec<u64> = places.iter().map(|place| self.point(*place)).collect();
                self.cells.remark(if of_ellipse { ELLIPSES } else { SPLINES });
                self.outline(&points, &places, None, &[], (closed, layer))?;
            }
            "MESH" => self.mesh(entity, &layer)?,
            "POLYLINE" => {
                self.end_polyline()?;
                let size = |rows, columns| {
                    Ok::<_, String>(
                        [entity.whole(rows)?, entity.whole(columns)?].map(|n| usize::try_from(n).unwrap_or(0)),
                    )
                };
                let flags = entity.whole(70)?;
                let axes = if flags & (IN_SPACE | GRID | MESH) == 0 { entity.axes()? } else { None };
                let (points, places, bulges, faces) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
                let sizes = [size(71, 72)?, size(73, 74)?];
                self.polyline = Some(Polyline { flags, sizes, layer, axes, points, places, bulges, faces });
            }
            "VERTEX" => self.vertex(entity)?,
            "SEQEND" => self.end_polyline()?,
            _ => {}
        }
        Ok(())
    }

    fn face(&mut self, places: [[f64; 3]; 4], layer: &[String]) {
        let corners = places.map(|place| self.point(place));
        self.cells.add_face(&corners);
        self.cells.name_cells(layer);
    }

    /// A MESH: its vertices, then for each face a count and that many vertices.
    fn mesh(&mut self, entity: &Entity<'a>, layer: &[String]) -> Result<(), String> {
        let points: Vec<u64> = entity.points(10)?.into_iter().map(|place| self.point(place)).collect();
        let after = entity.values.iter().skip_while(|(code, _)| *code != 93);
        let list = after.skip(1).take_while(|(code, _)| *code == 90);
        let mut list = list.map(|(_, value)| crate::read::text::number::<usize>(Some(value)));
        let mut corners = Vec::new();
        while let Some(count) = list.next().transpose()? {
            corners.clear();
            for _ in 0..count {
                let at = list.next().ok_or("a face of a mesh is cut off")??;
                corners.push(*points.get(at).ok_or_else(|| format!("a face names vertex {at} of {}", points.len()))?);
            }
            self.cells.add_face(&corners);
        }
        self.cells.name_cells(layer);
        Ok(())
    }

    fn vertex(&mut self, entity: &Entity<'a>) -> Result<(), String> {
        let flags = entity.whole(70)?;
        let Some(line) = &mut self.polyline else { return Ok(()) };
        if flags & FACE != 0 && flags & MESH == 0 {
            let corners = [71, 72, 73, 74].map(|code| entity.whole(code));
            let corners: Vec<i64> = corners.into_iter().collect::<Result<_, String>>()?;
            line.faces.push(corners.into_iter().filter(|corner| *corner != 0).collect());
            return Ok(());
        }
        // Control points of a curve are not on it; the points of the curve follow.
        if flags & CONTROL != 0 && line.flags & SMOOTH != 0 {
            return Ok(());
        }
        let (place, bulge) = (entity.point(10)?, entity.real(BULGE)?);
        line.places.push(place);
        line.bulges.push(bulge);
        let placed = in_space(line.axes.as_ref(), place);
        let point = self.point(placed);
        self.polyline.iter_mut().for_each(|line| line.points.push(point));
        Ok(())
    }

    /// A polyline with its arcs. One that ends where it began is closed, whatever it says.
    fn outline(
        &mut self,
        points: &[u64],
        places: &[[f64; 3]],
        axes: Option<&Matrix3<f64>>,
        bulges: &[f64],
        (closed, layer): (bool, Vec<String>),
    ) -> Result<(), String> {
        let mut all = Vec::with_capacity(points.len());
        for (at, &point) in points.iter().enumerate() {
            all.push(point);
            let next = places.get(at + 1).or(places.first().filter(|_| closed));
            if let (Some(next), Some(&bulge)) = (next, bulges.get(at).filter(|bulge| **bulge != 0.0)) {
                let between = arc([places[at], *next], bulge, self.chord);
                self.count_curved(between.len())?;
                for place in between {
                    all.push(self.point(in_space(axes, place)));
                }
                self.cells.remark("arcs were divided into chords of at most 5 degrees");
            }
        }
        let place = |point: &u64| self.cells.points[*point as usize];
        let ends_meet = all.len() > 3 && all.first().map(place) == all.last().map(place);
        if (closed && all.len() > 2) || ends_meet {
            if ends_meet {
                all.pop();
            }
            self.cells.add_outline(all, &layer);
        } else {
            self.open.push(Open { points: all, layer });
        }
        Ok(())
    }

    /// Counts points on curves.
    fn count_curved(&mut self, count: usize) -> Result<(), String> {
        self.curved += count;
        if self.curved > MOST_CURVED {
            return Err(format!(
                "its curves have more than {MOST_CURVED} points; take a longer \"edge\", or fewer of them"
            ));
        }
        Ok(())
    }

    pub(super) fn end_polyline(&mut self) -> Result<(), String> {
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
            let [rows, columns] = line.sizes[usize::from(line.flags & SMOOTH != 0)];
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
            let closed = line.flags & CLOSED != 0;
            self.outline(&line.points, &line.places, line.axes.as_ref(), &line.bulges, (closed, line.layer))?;
            return Ok(());
        }
        self.cells.name_cells(&line.layer);
        Ok(())
    }
}

const ELLIPSES: &str = "ellipses were divided into chords of at most 5 degrees";
const SPLINES: &str = "splines were divided into chords, or are lines through the points that they fit";

/// The bulge of each vertex; only vertices before an arc have one.
fn lwpolyline_bulges(entity: &Entity<'_>) -> Result<Vec<f64>, String> {
    let mut bulges = Vec::new();
    for (code, value) in &entity.values {
        match (*code, bulges.last_mut()) {
            (10, _) => bulges.push(0.0),
            (BULGE, Some(bulge)) => *bulge = crate::read::text::number(Some(value))?,
            _ => {}
        }
    }
    Ok(bulges)
}
