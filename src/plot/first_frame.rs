//! Where nodes lie before any displacement, from the first frame of a run: its points less its displacements.
//!
//! `probes.csv` gives positions, and a run may begin displaced, so the first row does not tell. The case does, but making its mesh
//! again takes long and needs the mesh's file where it was. Source of the format: as in [`crate::output::encode`]; read is what
//! [`crate::output::vtu`] writes for `canopy-fem solve`: raw appended, not compressed.

/// Reference positions [m] of all nodes.
///
/// # Errors
/// What is wrong with the file.
pub(super) fn reference_positions(file: &[u8]) -> Result<Vec<[f64; 3]>, String> {
    let mark = b"<AppendedData encoding=\"raw\">\n_";
    let split = file.windows(mark.len()).position(|w| w == mark);
    let split = split.ok_or("is no frame with raw appended data, as canopy-fem solve writes it")?;
    let (head, body) = file.split_at(split);
    let body = body.get(mark.len()..).unwrap_or_default();
    let head = std::str::from_utf8(head).map_err(|_| "has a header that is no text")?;
    if !head.contains("byte_order=\"LittleEndian\" header_type=\"UInt64\">") {
        return Err("is no uncompressed frame, as canopy-fem solve writes it".to_owned());
    }
    let points = vectors(head, body, "Points")?;
    let displacement = vectors(head, body, "displacement")?;
    if points.len() != displacement.len() {
        return Err(format!("has {} points but {} displacements", points.len(), displacement.len()));
    }
    let reference = |(x, u): (&[f64; 3], &[f64; 3])| std::array::from_fn(|c| x[c] - u[c]);
    Ok(points.iter().zip(&displacement).map(reference).collect())
}

/// An array of vectors: its length in bytes as eight bytes, then the numbers.
fn vectors(head: &str, body: &[u8], name: &str) -> Result<Vec<[f64; 3]>, String> {
    let damaged = || format!("is damaged: its array \"{name}\" cannot be read");
    let tag =
        format!("<DataArray type=\"Float64\" Name=\"{name}\" NumberOfComponents=\"3\" format=\"appended\" offset=\"");
    let (_, rest) = head.split_once(&tag).ok_or_else(|| format!("has no array of vectors \"{name}\""))?;
    let offset: usize = rest.split_once('"').and_then(|(offset, _)| offset.parse().ok()).ok_or_else(damaged)?;
    let (length, data) = body.get(offset..).and_then(<[u8]>::split_first_chunk).ok_or_else(damaged)?;
    let length = usize::try_from(u64::from_le_bytes(*length)).map_err(|_| damaged())?;
    let data = data.get(..length).filter(|_| length.is_multiple_of(24)).ok_or_else(damaged)?;
    let (numbers, _) = data.as_chunks::<8>();
    let (triples, _) = numbers.as_chunks::<3>();
    Ok(triples.iter().map(|t| t.map(f64::from_le_bytes)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::encode::VtuFormat;
    use crate::output::vtu::{Array, Cells, Snapshot, Values, VtuWriter};

    fn frame() -> Vec<u8> {
        let (points, displacement) = ([[12.0, 0.5, 0.0], [1.0, 2.0, 3.0]], [[2.0, 0.0, 0.0], [0.0, -1.0, 4.0]]);
        let cells = Cells { points: 2, triangles: &[], edges: &[[0, 1]] };
        let mut writer = VtuWriter::new(&cells, VtuFormat::default()).expect("good cells");
        let data = [Array { name: "displacement", values: Values::Vectors(&displacement) }];
        let picture = Snapshot { time: Some(0.0), points: &points, point_data: &data, cell_data: &[] };
        let mut file = Vec::new();
        writer.write(&picture, &mut file).expect("memory");
        file
    }

    /// What the writer wrote is read back bit by bit.
    #[test]
    fn positions_less_displacements() {
        assert_eq!(reference_positions(&frame()), Ok(vec![[10.0, 0.5, 0.0], [1.0, 3.0, -1.0]]));
    }

    /// A file cut off anywhere is refused, and never read as something else.
    #[test]
    fn cut_files_are_refused() {
        let whole = frame();
        let good = reference_positions(&whole);
        for length in 0..whole.len() {
            let read = reference_positions(&whole[..length]);
            assert!(read.is_err() || read == good, "{length} bytes");
        }
        assert!(reference_positions(&whole[..whole.len() - 60]).is_err());
    }
}
