//! Where nodes lie before any displacement, from the first frame of a run: its points less its displacements.
//!
//! `probes.csv` gives positions, and a run may begin displaced, so the first row is not enough. The case is, but
//! making its mesh again takes long and needs the mesh's file where it was. Source of the format: as in
//! [`crate::output::encode`]; read is what [`crate::output::vtu`] writes for `canopy-fem solve`: raw appended,
//! compressed or not, fields of either precision.

use std::io::Read;

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
    let packed = head.contains("header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\">");
    if !packed && !head.contains("byte_order=\"LittleEndian\" header_type=\"UInt64\">") {
        return Err("is no frame as canopy-fem solve writes it".to_owned());
    }
    let vectors = |name| vectors(&File { head, body, packed }, name);
    let points = vectors("Points")?;
    let displacement = vectors("displacement")?;
    if points.len() != displacement.len() {
        return Err(format!("has {} points but {} displacements", points.len(), displacement.len()));
    }
    let reference = |(x, u): (&[f64; 3], &[f64; 3])| std::array::from_fn(|c| x[c] - u[c]);
    Ok(points.iter().zip(&displacement).map(reference).collect())
}

/// A frame in its parts.
struct File<'a> {
    head: &'a str,
    body: &'a [u8],
    packed: bool,
}

fn vectors(file: &File<'_>, name: &str) -> Result<Vec<[f64; 3]>, String> {
    let damaged = || format!("is damaged: its array \"{name}\" cannot be read");
    let tag = format!("\" Name=\"{name}\" NumberOfComponents=\"3\" format=\"appended\" offset=\"");
    let (before, rest) = file.head.split_once(&tag).ok_or_else(|| format!("has no array of vectors \"{name}\""))?;
    let offset: usize = rest.split_once('"').and_then(|(offset, _)| offset.parse().ok()).ok_or_else(damaged)?;
    let data = file.body.get(offset..).ok_or_else(damaged)?;
    let bytes = if file.packed { unpacked(data) } else { plain(data).map(<[u8]>::to_vec) }.ok_or_else(damaged)?;
    let numbers: Vec<f64> = if before.ends_with("Float32") {
        bytes.as_chunks::<4>().0.iter().map(|b| f64::from(f32::from_le_bytes(*b))).collect()
    } else {
        bytes.as_chunks::<8>().0.iter().map(|b| f64::from_le_bytes(*b)).collect()
    };
    let (triples, rest) = numbers.as_chunks::<3>();
    if rest.is_empty() { Ok(triples.to_vec()) } else { Err(damaged()) }
}

/// A number of eight bytes, and what follows it.
fn number(data: &[u8]) -> Option<(usize, &[u8])> {
    let (head, rest) = data.split_first_chunk()?;
    Some((usize::try_from(u64::from_le_bytes(*head)).ok()?, rest))
}

/// The length in bytes, then the bytes.
fn plain(data: &[u8]) -> Option<&[u8]> {
    let (length, data) = number(data)?;
    data.get(..length).filter(|_| length.is_multiple_of(12))
}

/// The number of blocks, their size, the size of a last partial one, the packed size of each; then the blocks.
fn unpacked(data: &[u8]) -> Option<Vec<u8>> {
    let (blocks, data) = number(data)?;
    let (_, data) = number(data)?;
    let (_, data) = number(data)?;
    let sizes = data.get(..blocks.checked_mul(8)?)?;
    let mut packed = data.get(sizes.len()..)?;
    let mut out = Vec::new();
    for size in sizes.as_chunks::<8>().0 {
        let (block, rest) = packed.split_at_checked(usize::try_from(u64::from_le_bytes(*size)).ok()?)?;
        flate2::read::ZlibDecoder::new(block).read_to_end(&mut out).ok()?;
        packed = rest;
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::vtu::{Array, Cells, Snapshot, Values, VtuWriter};
    use crate::output::vtu::{Compression, Precision, VtuFormat};

    fn frame() -> Vec<u8> {
        frame_as(VtuFormat::default())
    }

    fn frame_as(format: VtuFormat) -> Vec<u8> {
        let (points, displacement) = ([[12.0, 0.5, 0.0], [1.0, 2.0, 3.0]], [[2.0, 0.0, 0.0], [0.0, -1.0, 4.0]]);
        let cells = Cells { points: 2, triangles: &[], edges: &[[0, 1]] };
        let mut writer = VtuWriter::new(&cells, format).expect("good cells");
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

    /// These numbers are exact in seven digits too.
    #[test]
    fn every_format_is_read() {
        for compression in [Compression::None, Compression::Zlib] {
            for precision in [Precision::F64, Precision::F32] {
                let file = frame_as(VtuFormat { compression, precision, ..VtuFormat::default() });
                assert_eq!(reference_positions(&file), Ok(vec![[10.0, 0.5, 0.0], [1.0, 3.0, -1.0]]), "{precision:?}");
            }
        }
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
