//! Meshes as VTK XML text: .vtu (unstructured grid) and .vtp (lines and polygons).

use super::encode::{Appender, CellTable, Width, little_endian};
use super::tags::{field_arrays, field_data};
use super::write::{Cells, FixedArrays, VtuError, bytes, head, right};
use super::{Encoding, VtuFormat, xml_attribute};

/// What a mesh is written as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// .vtu: triangles before edges
    Grid,
    /// .vtp: the format has lines before polygons
    Polygons,
}

/// A mesh as text: its arrays are inline in base64, which every VTK reads; those of the file as a whole are plain text.
///
/// # Errors
/// When a cell names a point that does not exist, or an array has the wrong length.
pub fn mesh_text(
    form: Form,
    points: &[[f64; 3]],
    cells: &Cells<'_>,
    arrays: &FixedArrays<'_>,
) -> Result<String, VtuError> {
    let table = CellTable::new(cells, Width::Long)?;
    let n_cells = table.types.len();
    let (kind, counts) = match form {
        Form::Grid => ("UnstructuredGrid", format!("NumberOfCells=\"{n_cells}\"")),
        Form::Polygons => {
            let (lines, polygons) = (cells.edges.len(), cells.triangles.len());
            let none = "NumberOfVerts=\"0\" NumberOfStrips=\"0\"";
            ("PolyData", format!("{none} NumberOfLines=\"{lines}\" NumberOfPolys=\"{polygons}\""))
        }
    };
    let topology = match form {
        Form::Grid => {
            let (kind, types) = (table.width.kind(), array("UInt8", "types", 1, &table.types)?);
            let connectivity = array(kind, "connectivity", 1, &table.connectivity)?;
            let offsets = array(kind, "offsets", 1, &table.ends)?;
            format!("<Cells>\n{connectivity}{offsets}{types}</Cells>\n")
        }
        Form::Polygons => cell_list("Lines", cells.edges)? + &cell_list("Polys", cells.triangles)?,
    };
    let cell_data = cell_data(form, cells, arrays, n_cells)?;
    Ok([
        &head(kind, ""),
        &field_data(&field_arrays(arrays.field)),
        &format!("<Piece NumberOfPoints=\"{}\" {counts}>\n<Points>\n", points.len()),
        &array("Float64", "points", 3, &little_endian(points.as_flattened()))?,
        "</Points>\n",
        &topology,
        &point_data(points, arrays)?,
        &format!("<CellData>\n{cell_data}</CellData>\n</Piece>\n</{kind}>\n</VTKFile>\n"),
    ]
    .concat())
}

fn array(kind: &str, name: &str, components: usize, data: &[u8]) -> Result<String, VtuError> {
    let mut appender = Appender::new(VtuFormat { encoding: Encoding::Base64, ..VtuFormat::default() });
    let (mut text, name) = (Vec::new(), xml_attribute(name));
    appender.append(data, &mut text)?;
    let text = String::from_utf8_lossy(&text);
    Ok(format!(
        "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"binary\">{text}\
         </DataArray>\n"
    ))
}

/// Cells with so many corners each.
fn cell_list<const N: usize>(tag: &str, cells: &[[u32; N]]) -> Result<String, VtuError> {
    let connectivity: Vec<u8> = cells.as_flattened().iter().flat_map(|&n| i64::from(n).to_le_bytes()).collect();
    let ends: Vec<u8> = (1..=cells.len()).flat_map(|cell| ((N * cell) as i64).to_le_bytes()).collect();
    let connectivity = array("Int64", "connectivity", 1, &connectivity)?;
    Ok(format!("<{tag}>\n{connectivity}{}</{tag}>\n", array("Int64", "offsets", 1, &ends)?))
}

/// The arrays on cells, in the order of the form.
fn cell_data(form: Form, cells: &Cells<'_>, arrays: &FixedArrays<'_>, n_cells: usize) -> Result<String, VtuError> {
    let first = match form {
        Form::Grid => 0,
        Form::Polygons => cells.triangles.len(),
    };
    let mut text = String::new();
    for (name, flags) in arrays.cell_flags {
        right(name, flags.len(), n_cells)?;
        text += &array("UInt8", name, 1, &[&flags[first..], &flags[..first]].concat())?;
    }
    if let Some((name, numbers)) = arrays.cell_numbers {
        right(name, numbers.len(), n_cells)?;
        text += &array("Int32", name, 1, &bytes(&[&numbers[first..], &numbers[..first]].concat()))?;
    }
    Ok(text)
}

/// The section of arrays on points; nothing without any.
fn point_data(points: &[[f64; 3]], arrays: &FixedArrays<'_>) -> Result<String, VtuError> {
    let mut text = String::new();
    if let Some((name, numbers)) = arrays.point_numbers {
        right(name, numbers.len(), points.len())?;
        text += &array("Int32", name, 1, &bytes(numbers))?;
    }
    if let Some((name, vectors)) = arrays.point_vectors {
        right(name, vectors.len(), points.len())?;
        text += &array("Float64", name, 3, &little_endian(vectors.as_flattened()))?;
    }
    Ok(if text.is_empty() { text } else { format!("<PointData>\n{text}</PointData>\n") })
}
