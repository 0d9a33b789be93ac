//! Where Abaqus puts nodes: coordinate systems of nodes, and the places of instances.

use nalgebra::{Matrix3, Point3, Rotation3, Translation3, Unit, Vector3};

/// Coordinates of `*NODE, SYSTEM=`.
#[derive(Clone, Copy, Debug, Default)]
pub(super) enum Coordinates {
    #[default]
    Rectangular,
    /// radius, angle [deg] from x in the x-y plane, z
    Cylindrical,
    /// radius, angle [deg] from x in the x-y plane, angle [deg] above that plane
    Spherical,
}

impl Coordinates {
    pub(super) fn of(word: &str) -> Result<Self, String> {
        match word.to_ascii_uppercase().as_str() {
            "" | "R" => Ok(Coordinates::Rectangular),
            "C" => Ok(Coordinates::Cylindrical),
            "S" => Ok(Coordinates::Spherical),
            other => Err(format!("*NODE: SYSTEM={other} is not known; known are R, C and S")),
        }
    }

    pub(super) fn place(self, [a, b, c]: [f64; 3]) -> [f64; 3] {
        let (sin, cos) = b.to_radians().sin_cos();
        match self {
            Coordinates::Rectangular => [a, b, c],
            Coordinates::Cylindrical => [a * cos, a * sin, c],
            Coordinates::Spherical => {
                let (up, out) = c.to_radians().sin_cos();
                [a * cos * out, a * sin * out, a * up]
            }
        }
    }
}

/// The system of `*SYSTEM`, in which nodes are given.
#[derive(Clone, Debug)]
pub(super) struct System {
    origin: Vector3<f64>,
    axes: Matrix3<f64>,
}

impl Default for System {
    fn default() -> Self {
        System { origin: Vector3::zeros(), axes: Matrix3::identity() }
    }
}

impl System {
    /// From the numbers of its data lines: the origin, a point on the first axis, one in the plane of the first two.
    pub(super) fn of(numbers: &[f64]) -> Result<Self, String> {
        let point = |from: usize| numbers.get(from..from + 3).map(Vector3::from_column_slice);
        let Some(origin) = point(0) else { return Ok(System::default()) };
        let axes = match (point(3), point(6)) {
            (None, _) => Some(Matrix3::identity()),
            (Some(_), None) => None,
            (Some(on), Some(plane)) => axes(on - origin, plane - origin),
        };
        let axes = axes.ok_or("*SYSTEM: needs an origin, a point on x and one in the x-y plane, not in one line")?;
        Ok(System { origin, axes })
    }

    pub(super) fn place(&self, point: [f64; 3]) -> [f64; 3] {
        (self.origin + self.axes * Vector3::from(point)).into()
    }
}

fn axes(first: Vector3<f64>, in_plane: Vector3<f64>) -> Option<Matrix3<f64>> {
    let x = first.try_normalize(0.0)?;
    let z = x.cross(&in_plane).try_normalize(0.0)?;
    Some(Matrix3::from_columns(&[x, z.cross(&x), z]))
}

/// Moves a point as the data lines of `*INSTANCE` say: first along a vector, then about an axis through two points by
/// an angle [deg].
pub(super) fn moved(numbers: &[f64]) -> Result<impl Fn([f64; 3]) -> [f64; 3] + use<>, String> {
    let vector = |from: usize| numbers.get(from..from + 3).map(Vector3::from_column_slice);
    let shift = Translation3::from(vector(0).unwrap_or_default());
    let turn = match (vector(3), vector(6), numbers.get(9)) {
        (None, ..) => None,
        (Some(a), Some(b), Some(angle)) => {
            let axis = Unit::try_new(b - a, 0.0).ok_or("*INSTANCE: the two points of the axis of rotation are one")?;
            Some((a, Rotation3::from_axis_angle(&axis, angle.to_radians())))
        }
        _ => return Err("*INSTANCE: a rotation needs two points and an angle".to_owned()),
    };
    Ok(move |point: [f64; 3]| {
        let at = shift.transform_point(&Point3::from(point)).coords;
        turn.map_or(at, |(a, turn)| a + turn * (at - a)).into()
    })
}
