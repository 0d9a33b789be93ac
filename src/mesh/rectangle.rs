//! A rectangle of equal cells, each cut into triangles.

use super::source::{FaultSink, MAX_NODES, check_count, check_length};
use super::{Mesh, MeshError, topology};
use serde::{Deserialize, Serialize};

/// How a rectangle's cells are cut.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum RectanglePattern {
    /// One diagonal per cell, lower left to upper right: two triangles.
    #[default]
    Regular,
    /// Both diagonals and a node where they cross: four triangles, the same in both directions.
    Crossed,
}

/// A flat rectangle in the x-y plane, its corners at (0, 0) and (width, height), normal +z.
///
/// Node `row * (columns + 1) + column` is the grid point in that column and row; the centres of crossed cells
/// follow, row by row.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct RectangleParameters {
    /// [m] extent along x, above 0
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0)))]
    pub width: f64,
    /// [m] extent along y, above 0
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0)))]
    pub height: f64,
    /// [-] cells along x, at least 1
    #[cfg_attr(feature = "schema", schemars(range(min = 1)))]
    pub columns: usize,
    /// [-] cells along y, at least 1
    #[cfg_attr(feature = "schema", schemars(range(min = 1)))]
    pub rows: usize,
    /// how the cells are cut; regular if absent
    #[serde(default)]
    pub pattern: RectanglePattern,
}

impl RectangleParameters {
    /// Reports every value out of range; `at` is the JSON pointer of this section.
    pub fn check(&self, at: &str, faults: FaultSink<'_>) {
        check_length(at, "width", self.width, faults);
        check_length(at, "height", self.height, faults);
        check_count(at, "columns", self.columns, [1, MAX_NODES], faults);
        check_count(at, "rows", self.rows, [1, MAX_NODES], faults);
        let nodes = self.columns.saturating_mul(self.rows).saturating_mul(2);
        if nodes > MAX_NODES && self.columns <= MAX_NODES && self.rows <= MAX_NODES {
            let value = format!("{} x {} cells", self.columns, self.rows);
            faults(at, value, format!("at most {} cells", MAX_NODES / 2), "take fewer columns or rows".into());
        }
    }

    /// Makes the mesh; the parameters must have passed [`RectangleParameters::check`].
    ///
    /// # Errors
    /// [`MeshError::Size`] if there are too many cells.
    pub fn build(&self) -> Result<Mesh, MeshError> {
        let cells = self.columns.saturating_mul(self.rows);
        if cells.saturating_mul(2) > MAX_NODES {
            let (nodes, edges, triangles) = (cells, cells.saturating_mul(3), cells.saturating_mul(2));
            return Err(MeshError::Size { nodes, edges, triangles, reason: "too many cells; take fewer" });
        }
        let (columns, rows) = (self.columns as u32, self.rows as u32);
        let x = |column: f64| self.width * (column / self.columns as f64);
        let y = |row: f64| self.height * (row / self.rows as f64);
        let grid = |column: u32, row: u32| row * (columns + 1) + column;
        let centre = |column: u32, row: u32| (columns + 1) * (rows + 1) + row * columns + column;

        let mut nodes = Vec::new();
        for row in 0..=rows {
            nodes.extend((0..=columns).map(|column| [x(f64::from(column)), y(f64::from(row)), 0.0]));
        }
        let mut triangles = Vec::new();
        for row in 0..rows {
            for column in 0..columns {
                let corners =
                    [grid(column, row), grid(column + 1, row), grid(column + 1, row + 1), grid(column, row + 1)];
                let [a, b, c, d] = corners;
                match self.pattern {
                    RectanglePattern::Regular => triangles.extend([[a, b, c], [a, c, d]]),
                    RectanglePattern::Crossed => {
                        nodes.push([x(f64::from(column) + 0.5), y(f64::from(row) + 0.5), 0.0]);
                        let m = centre(column, row);
                        triangles.extend([[a, b, m], [b, c, m], [c, d, m], [d, a, m]]);
                    }
                }
            }
        }
        let edges = topology::unique_edges(&triangles);
        Ok(Mesh { nodes, edges, triangles, ..Mesh::default() })
    }
}
