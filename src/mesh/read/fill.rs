//! Fills closed outlines with triangles. An outline inside another is a hole in it, and one inside a hole is filled
//! again.

use super::cells::{Cells, Outline};
use crate::delaunay::{Unfilled, fill};
use nalgebra::{Vector2, Vector3};

/// [-] Most nodes that an edge length may ask for.
const MOST_NODES: f64 = 2e6;
/// [-] Most tests of points against sides.
const MOST_TESTS: usize = 2_000_000_000;
/// [-] Largest area of a triangle by the square of the edge length. An equilateral one has 0.43; most become smaller
/// than the largest.
const LARGEST: f64 = 0.6;
/// [-] Share of its size by which an outline may leave its plane.
const FLAT: f64 = 1e-3;

impl Cells {
    /// Fills the outlines with triangles whose edges are about this long [m]. Sides are divided into pieces no longer
    /// than that, alike for neighbours. Without an edge length outlines become lines.
    /// Points at most `distance` [m] apart are one. Returns sentences about what was not filled, and what was.
    ///
    /// # Errors
    /// Why outlines cannot be filled, as the end of a sentence that begins with the file's name.
    pub(super) fn fill_outlines(&mut self, edge: Option<f64>, distance: f64) -> Result<[Option<String>; 2], String> {
        self.number_cells(0);
        let outlines = std::mem::take(&mut self.outlines);
        let count = outlines.len();
        let Some(edge) = edge else {
            outlines.iter().for_each(|outline| self.add_loop(outline));
            let advice = "to fill them with triangles: --edge LENGTH, or \"edge\" in a case";
            return Ok([(count > 0).then(|| format!("{count} closed polylines stay lines; {advice}")), None]);
        };
        let mut sheets = Vec::new();
        for outline in outlines {
            match Sheet::of(&outline, &self.points, distance) {
                Some(sheet) => sheets.push(sheet),
                None => self.add_loop(&outline),
            }
        }
        let unfilled = count - sheets.len();
        let around = containers(&sheets, distance)?;
        let nodes: f64 = sheets.iter().map(|sheet| sheet.nodes(edge)).sum();
        if nodes > MOST_NODES {
            let area: f64 = sheets.iter().map(|sheet| sheet.area).sum();
            return Err(format!(
                "has outlines of {area:.3e} m^2, of which an edge length of {edge} m makes about {nodes:.1e} nodes; at \
                 most {MOST_NODES:.0e} are made"
            ));
        }
        let mut filled = [0; 3];
        for (number, sheet) in sheets.iter().enumerate() {
            let depth = around[number].as_ref().map(Vec::len);
            filled[depth.map_or(2, |depth| depth % 2)] += 1;
            if let Some(depth) = depth.filter(|depth| depth % 2 == 0) {
                let inside = |other: &usize| {
                    around[*other].as_ref().is_some_and(|list| list.len() == depth + 1 && list.contains(&number))
                };
                let holes: Vec<&Sheet> = (0..sheets.len()).filter(inside).map(|hole| &sheets[hole]).collect();
                self.fill_sheet(sheet, &holes, edge)?;
            }
        }
        if !self.displacement.is_empty() {
            self.displacement.resize(self.points.len(), [0.0; 3]);
        }
        let [sheets, holes, again] = filled;
        let note = match (count, unfilled, again) {
            (0, ..) => Some("there are no closed polylines that an edge length could fill".to_owned()),
            (_, 0, 0) => None,
            _ => Some(format!(
                "of {count} closed polylines {unfilled} are not flat or without area and stay lines, and {again} repeat \
                 another"
            )),
        };
        let done = format!("{sheets} closed polylines with {holes} holes were filled with triangles");
        Ok([note, (sheets > 0).then_some(done)])
    }

    fn add_loop(&mut self, outline: &Outline) {
        self.add_line(&outline.points, false);
        if let [first, _, .., last] = outline.points[..] {
            self.add_line(&[last, first], false);
        }
        self.number_cells(outline.number);
    }

    fn fill_sheet(&mut self, sheet: &Sheet, holes: &[&Sheet], edge: f64) -> Result<(), String> {
        let (mut points, mut sides) = (Vec::new(), Vec::new());
        for outline in [&sheet].into_iter().chain(holes) {
            let first = points.len();
            for (i, a) in outline.points.iter().enumerate() {
                points.push(*a);
                self.divide(*a, outline.points[(i + 1) % outline.points.len()], edge, &mut points);
            }
            let end = points.len();
            sides.extend((first..end).map(|i| [i, if i + 1 < end { i + 1 } else { first }]));
        }
        let place = |point: u64| Vector3::from(self.points[point as usize]);
        let flat: Vec<Vector2<f64>> = points.iter().map(|point| sheet.plane.flat(place(*point))).collect();
        let most = 100 + 20 * points.len() + 8 * sheet.nodes(edge) as usize;
        let filled = fill(&flat, &sides, LARGEST * edge * edge, most);
        let filled = filled.map_err(|why| {
            let [x, y, z]: [f64; 3] = place(sheet.points[0]).into();
            let reason = match why {
                Unfilled::Crossed => "crosses or touches itself or one of its holes".to_owned(),
                Unfilled::Unending => format!("was not filled with {most} points; take another edge length"),
            };
            format!("has an outline from ({x}, {y}, {z}) m, which {reason}")
        })?;
        for point in filled.inner {
            points.push(self.points.len() as u64);
            self.points.push(sheet.plane.space(point).into());
        }
        for corners in filled.triangles {
            self.add_face(&corners.map(|corner| points[corner as usize]));
        }
        self.number_cells(sheet.number);
        Ok(())
    }

    /// Adds points between `a` and `b`, at the same places whichever of them is first.
    fn divide(&mut self, a: u64, b: u64, edge: f64, to: &mut Vec<u64>) {
        let ends = [a, b].map(|point| Vector3::from(self.points[point as usize]));
        let turned = ends[0].iter().zip(&ends[1]).find_map(|(x, y)| (x != y).then_some(x > y)) == Some(true);
        let [low, high] = if turned { [ends[1], ends[0]] } else { ends };
        // A side that is as long as the edge but for rounding is one piece.
        let pieces = ((high - low).norm() / edge - 1e-6).ceil().max(1.0) as usize;
        for i in 1..pieces {
            let share = if turned { pieces - i } else { i } as f64 / pieces as f64;
            to.push(self.points.len() as u64);
            self.points.push((low + share * (high - low)).into());
        }
    }
}

/// An outline in its plane.
pub(super) struct Sheet {
    pub points: Vec<u64>,
    pub number: i64,
    pub plane: Plane,
    /// [m] its corners
    places: Vec<Vector3<f64>>,
    /// [m^2]
    area: f64,
    /// [m] its smallest and largest coordinates
    span: [Vector3<f64>; 2],
}

#[derive(Clone, Copy)]
pub(super) struct Plane {
    pub origin: Vector3<f64>,
    pub axes: [Vector3<f64>; 2],
    normal: Vector3<f64>,
}

impl Plane {
    pub(super) fn flat(&self, place: Vector3<f64>) -> Vector2<f64> {
        Vector2::from(self.axes.map(|axis| axis.dot(&(place - self.origin))))
    }

    pub(super) fn space(&self, place: Vector2<f64>) -> Vector3<f64> {
        self.origin + place.x * self.axes[0] + place.y * self.axes[1]
    }
}

impl Sheet {
    /// `None` for an outline without area, or one that is not flat. The normal points up, so that all sheets of a
    /// drawing have the same side up.
    pub(super) fn of(outline: &Outline, points: &[[f64; 3]], distance: f64) -> Option<Sheet> {
        let place = |point: u64| Vector3::from(points[point as usize]);
        let mut kept = outline.points.clone();
        kept.dedup_by(|a, b| (place(*a) - place(*b)).norm() <= distance);
        while kept.len() > 1 && (place(kept[0]) - place(kept[kept.len() - 1])).norm() <= distance {
            kept.pop();
        }
        let places: Vec<Vector3<f64>> = kept.iter().map(|point| place(*point)).collect();
        let origin = *places.first()?;
        let twice = |pair: &[Vector3<f64>]| (pair[0] - origin).cross(&(pair[1] - origin));
        let sum: Vector3<f64> = places.windows(2).map(twice).sum();
        let span = [f64::min, f64::max].map(|pick: fn(f64, f64) -> f64| {
            places.iter().copied().reduce(|a, b| a.zip_map(&b, pick)).unwrap_or_default()
        });
        let size = (span[1] - span[0]).norm();
        let normal = sum.try_normalize(1e-9 * size * size)?;
        let least = 1e-9;
        let up = [normal.z, normal.y, normal.x].into_iter().find(|x| x.abs() > least).is_none_or(|x| x > 0.0);
        let normal = if up { normal } else { -normal };
        let along = if normal.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
        let first = (along - normal * normal.dot(&along)).normalize();
        let flat = places.iter().all(|p| normal.dot(&(p - origin)).abs() <= FLAT * size);
        let plane = Plane { origin, axes: [first, normal.cross(&first)], normal };
        let (points, number, area) = (kept, outline.number, 0.5 * sum.norm());
        (flat && area.is_finite()).then_some(Sheet { points, number, plane, places, area, span })
    }

    /// [-] About as many nodes as it gets.
    fn nodes(&self, edge: f64) -> f64 {
        let next = self.places.iter().cycle().skip(1);
        let around: f64 = self.places.iter().zip(next).map(|(a, b)| 1.0 + (b - a).norm() / edge).sum();
        around + 2.0 * self.area / (edge * edge)
    }

    /// Corners and middles of the sides.
    fn marks(&self) -> impl Iterator<Item = Vector3<f64>> {
        let next = self.places.iter().cycle().skip(1);
        self.places.iter().zip(next).flat_map(|(a, b)| [*a, 0.5 * (a + b)])
    }

    /// Whether a place is inside, or `None` on a side, in the plane of the sheet.
    fn holds(&self, place: Vector3<f64>, distance: f64) -> Option<bool> {
        let p = self.plane.flat(place);
        let corners = self.places.iter().map(|corner| self.plane.flat(*corner));
        let next = corners.clone().cycle().skip(1);
        let mut inside = false;
        for (a, b) in corners.zip(next) {
            let along = ((p - a).dot(&(b - a)) / (b - a).norm_squared()).clamp(0.0, 1.0);
            if (a + along * (b - a) - p).norm() <= distance {
                return None;
            }
            if (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x) {
                inside = !inside;
            }
        }
        Some(inside)
    }
}

/// For each sheet those that it lies in; `None` if it repeats another.
fn containers(sheets: &[Sheet], distance: f64) -> Result<Vec<Option<Vec<usize>>>, String> {
    let mut around = vec![Some(Vec::new()); sheets.len()];
    let mut tests = sheets.len().saturating_mul(sheets.len());
    // The larger one comes first, and of equal ones the earlier.
    let mut order: Vec<usize> = (0..sheets.len()).collect();
    order.sort_by(|a, b| sheets[*b].area.total_cmp(&sheets[*a].area).then(a.cmp(b)));
    for (rank, &inner) in order.iter().enumerate() {
        let [low, high] = sheets[inner].span;
        for &outer in &order[..rank] {
            let (sheet, [least, most]) = (&sheets[outer], sheets[outer].span);
            let within = (0..3).all(|k| least[k] <= low[k] + distance && high[k] <= most[k] + distance);
            if !within || around[outer].is_none() || tests > MOST_TESTS {
                continue;
            }
            let reach = sheet.plane.normal.dot(&(sheets[inner].places[0] - sheet.plane.origin)).abs();
            if reach > FLAT * (most - least).norm() {
                continue;
            }
            tests = tests.saturating_add(2 * sheet.places.len() * sheets[inner].places.len());
            let found: Vec<bool> = sheets[inner].marks().filter_map(|place| sheet.holds(place, distance)).collect();
            match (found.contains(&true), found.contains(&false)) {
                (true, false) => around[inner].iter_mut().for_each(|list| list.push(outer)),
                (false, false) => around[inner] = None,
                (false, true) => {}
                (true, true) => {
                    let [x, y, z]: [f64; 3] = sheets[inner].places[0].into();
                    return Err(format!("has an outline from ({x}, {y}, {z}) m, which crosses another one"));
                }
            }
        }
    }
    if tests > MOST_TESTS {
        return Err(format!("has {} closed polylines, too many to tell which lie inside others", sheets.len()));
    }
    Ok(around)
}
