//! An entity of a drawing: its values by group codes, and the coordinates that it is given in.

use crate::read::text::number;
use nalgebra::{Matrix3, Matrix4, Rotation3, Scale3, Translation3, Vector3};

/// An entity of a drawing.
#[derive(Clone, Default)]
pub(super) struct Entity<'a> {
    pub kind: &'a str,
    /// where it begins
    pub line: usize,
    /// group codes and their values, in file order
    pub values: Vec<(i32, &'a str)>,
}

impl<'a> Entity<'a> {
    fn first(&self, code: i32) -> Option<&'a str> {
        self.values.iter().find(|(known, _)| *known == code).map(|(_, value)| *value)
    }

    pub(super) fn has(&self, code: i32) -> bool {
        self.first(code).is_some()
    }

    pub(super) fn text(&self, code: i32) -> &'a str {
        self.first(code).unwrap_or_default()
    }

    pub(super) fn real(&self, code: i32) -> Result<f64, String> {
        self.first(code).map_or(Ok(0.0), |value| number(Some(value)))
    }

    fn real_or(&self, code: i32, absent: f64) -> Result<f64, String> {
        self.first(code).map_or(Ok(absent), |value| number(Some(value)))
    }

    pub(super) fn whole(&self, code: i32) -> Result<i64, String> {
        self.first(code).map_or(Ok(0), |value| number(Some(value)))
    }

    /// The point whose x has this code.
    pub(super) fn point(&self, code: i32) -> Result<[f64; 3], String> {
        Ok([self.real(code)?, self.real(code + 10)?, self.real(code + 20)?])
    }

    /// All points whose x have this code.
    pub(super) fn points(&self, code: i32) -> Result<Vec<[f64; 3]>, String> {
        let mut points = Vec::new();
        for (known, value) in &self.values {
            let axis = [code, code + 10, code + 20].iter().position(|code| code == known);
            match (axis, points.last_mut()) {
                (Some(0), _) => points.push([number(Some(value))?, 0.0, 0.0]),
                (Some(axis), Some(point)) => point[axis] = number(Some(value))?,
                _ => {}
            }
        }
        Ok(points)
    }

    /// All numbers with this code.
    pub(super) fn numbers<T: std::str::FromStr>(&self, code: i32) -> Result<Vec<T>, String> {
        self.values.iter().filter(|(known, _)| *known == code).map(|(_, value)| number(Some(value))).collect()
    }

    /// The direction that the plane of the entity faces.
    pub(super) fn normal(&self) -> Result<Vector3<f64>, String> {
        let [x, y, z] = [self.real(210)?, self.real(220)?, self.real_or(230, 1.0)?];
        Vector3::new(x, y, z).try_normalize(0.0).ok_or_else(|| "an extrusion without direction".to_owned())
    }

    /// Axes of the coordinates of a flat entity ("arbitrary axis algorithm"); `None` for those of the drawing.
    pub(super) fn axes(&self) -> Result<Option<Matrix3<f64>>, String> {
        let z = self.normal()?;
        if z == Vector3::z() {
            return Ok(None);
        }
        let near = z.x.abs() < 1.0 / 64.0 && z.y.abs() < 1.0 / 64.0;
        let x = if near { Vector3::y() } else { Vector3::z() }.cross(&z).normalize();
        Ok(Some(Matrix3::from_columns(&[x, z.cross(&x), z])))
    }

    /// Where an INSERT puts a block, at a column and a row.
    pub(super) fn insertion(&self, block: &Entity<'a>, [column, row]: [i64; 2]) -> Result<Matrix4<f64>, String> {
        let vector = Vector3::from;
        let scale = [self.real_or(41, 1.0)?, self.real_or(42, 1.0)?, self.real_or(43, 1.0)?];
        let step = [column as f64 * self.real(44)?, row as f64 * self.real(45)?, 0.0];
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), self.real(50)?.to_radians());
        let own = Translation3::from(vector(self.point(10)?)).to_homogeneous()
            * turn.to_homogeneous()
            * Translation3::from(vector(step)).to_homogeneous()
            * Scale3::from(vector(scale)).to_homogeneous()
            * Translation3::from(-vector(block.point(10)?)).to_homogeneous();
        Ok(self.axes()?.map_or(own, |axes| axes.to_homogeneous() * own))
    }
}
