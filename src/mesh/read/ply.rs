//! Stanford .ply, text and binary, by `ply-rs-bw`. Whole numbers of faces, edges and vertices, except colours, are
//! groups.

use super::PLY_NO_MARKS;
use super::cells::{Cells, IGNORED};
use super::marks::Marks;
use ply_rs_bw::parser::Parser;
use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult, PropertyType, ScalarType};

pub(super) fn read(bytes: &[u8]) -> Result<Cells, String> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let ply = Parser::<Record>::new().read_ply(&mut &*bytes).map_err(|error| format!("is not a PLY file: {error}"))?;
    let mut cells = Cells::default();
    let marks_of = |element: &str, at: usize| {
        let properties = ply.header.elements.get(element).map(|definition| &definition.properties);
        let mut whole =
            properties.into_iter().flatten().filter(|(name, definition)| is_mark(name, &definition.data_type));
        whole.nth(at).map(|(name, _)| name.clone()).unwrap_or_default()
    };
    let marks = |element: &str, records: &[Record]| {
        let count = records.first().map_or(0, |record| record.marks.len());
        let column = |at| (marks_of(element, at), records.iter().filter_map(|r| r.marks.get(at).copied()).collect());
        Marks::new((0..count).map(column).collect())
    };
    for (element, records) in &ply.payload {
        let marks = marks(element, records);
        match element.as_str() {
            "vertex" => {
                for (at, record) in records.iter().enumerate() {
                    let [Some(x), Some(y), Some(z)] = record.point else {
                        return Err(format!("vertex {at} lacks one of x, y and z"));
                    };
                    cells.points.push([x, y, z]);
                    cells.name_point(&marks.names(at), at as u64);
                }
            }
            "face" | "tristrips" | "edge" => {
                for (at, record) in records.iter().enumerate() {
                    let corners: Option<Vec<u64>> = record.corners.iter().map(|c| u64::try_from(*c).ok()).collect();
                    match (element.as_str(), corners) {
                        ("tristrips", _) => return Err("holds strips of triangles; write it with faces".to_owned()),
                        (_, None) => return Err(format!("{element} {at} has a negative number of a vertex")),
                        (_, Some(corners)) if corners.len() < 2 => cells.remark(IGNORED),
                        (_, Some(corners)) if corners.len() == 2 => cells.add_line(&corners, false),
                        (_, Some(corners)) => cells.add_face(&corners),
                    }
                    cells.name_cells(&marks.names(at));
                }
            }
            _ => {}
        }
    }
    Ok(cells)
}

/// Whether a property of a record marks a part.
fn is_mark(name: &str, kind: &PropertyType) -> bool {
    let whole = |kind: &ScalarType| !matches!(kind, ScalarType::Float | ScalarType::Double);
    matches!(kind, PropertyType::Scalar(kind) if whole(kind)) && !PLY_NO_MARKS.contains(&name)
}

/// A vertex, a face or an edge.
#[derive(Default)]
struct Record {
    point: [Option<f64>; 3],
    corners: Vec<i64>,
    /// whole numbers in the order of the header
    marks: Vec<i64>,
}

impl PropertyAccess for Record {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        let list = match &value {
            Property::ListChar(list) => Some(list.iter().map(|n| i64::from(*n)).collect()),
            Property::ListUChar(list) => Some(list.iter().map(|n| i64::from(*n)).collect()),
            Property::ListShort(list) => Some(list.iter().map(|n| i64::from(*n)).collect()),
            Property::ListUShort(list) => Some(list.iter().map(|n| i64::from(*n)).collect()),
            Property::ListInt(list) => Some(list.iter().map(|n| i64::from(*n)).collect()),
            Property::ListUInt(list) => Some(list.iter().map(|n| i64::from(*n)).collect()),
            _ => None,
        };
        let (number, whole) = match value {
            Property::Char(n) => (f64::from(n), true),
            Property::UChar(n) => (f64::from(n), true),
            Property::Short(n) => (f64::from(n), true),
            Property::UShort(n) => (f64::from(n), true),
            Property::Int(n) => (f64::from(n), true),
            Property::UInt(n) => (f64::from(n), true),
            Property::Float(n) => (f64::from(n), false),
            Property::Double(n) => (n, false),
            _ => (0.0, false),
        };
        match (name, list) {
            ("vertex_indices" | "vertex_index", Some(list)) => self.corners = list,
            ("vertex1" | "vertex2", None) => self.corners.push(number as i64),
            ("x" | "y" | "z", None) => self.point[usize::from(name.as_bytes()[0] - b'x')] = Some(number),
            (name, None) if whole && !PLY_NO_MARKS.contains(&name) => self.marks.push(number as i64),
            _ => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}
