//! .vtu, .vtp and legacy .vtk, by `vtkio`.

use super::cells::Cells;
use base64::Engine as _;
use vtkio::model::{
    Attribute, CellType, DataSet, IOBuffer, Piece, PolyDataPiece, UnstructuredGridPiece, VertexNumbers,
};

/// Name of the cell array that marks seams.
const SEAM: &str = "seam";
/// [-] deflate cannot expand data by more than this (zlib's own technical notes give 1032)
const DEFLATE_RATIO: u64 = 1100;

pub(super) fn read(bytes: &[u8]) -> Result<Cells, String> {
    let xml = bytes.trim_ascii_start().starts_with(b"<");
    let vtk = if xml {
        check_xml(bytes)?;
        vtkio::Vtk::parse_xml(bytes)
    } else {
        // Binary legacy files are big-endian; text ones do not care.
        vtkio::Vtk::parse_legacy_be(bytes)
    };
    let mut cells = Cells::default();
    match vtk.map_err(|error| format!("is not a VTK file that can be read: {error}"))?.data {
        DataSet::UnstructuredGrid { pieces, .. } => {
            for piece in pieces {
                add_grid(inline(piece)?, &mut cells)?;
            }
        }
        DataSet::PolyData { pieces, .. } => {
            for piece in pieces {
                add_poly(inline(piece)?, &mut cells)?;
            }
        }
        _ => return Err("holds neither an unstructured grid nor polygons".into()),
    }
    Ok(cells)
}

/// Refuses what `vtkio` cannot read, and sizes it would allocate without looking at how much data there is.
fn check_xml(bytes: &[u8]) -> Result<(), String> {
    let has = |what: &str| bytes.windows(what.len()).any(|w| w == what.as_bytes());
    if has("encoding=\"raw\"") {
        return Err("has raw appended data, which is not read; save it as ASCII or binary (inline) instead".into());
    }
    if !has("compressor=") {
        return Ok(());
    }
    if !has("vtkZLibDataCompressor") {
        return Err("is compressed with another method than zlib; save it uncompressed or with zlib".into());
    }
    if has("<AppendedData") {
        return Err("has compressed appended data, which is not read; save it uncompressed or inline".into());
    }
    let word = if has("header_type=\"UInt64\"") { 8 } else { 4 };
    let text = std::str::from_utf8(bytes).map_err(|_| "is not text".to_owned())?;
    for array in text.split("<DataArray").skip(1) {
        let content = array.split('>').nth(1).and_then(|c| c.split('<').next()).unwrap_or_default().trim();
        if array.contains("format=\"binary\"") && !content.is_empty() {
            check_compressed(content, word)?;
        }
    }
    Ok(())
}

/// The header of a compressed array (number of blocks, size of a block, size of the last) must suit the data's length.
fn check_compressed(content: &str, word: usize) -> Result<(), String> {
    let damaged = || "is damaged: a compressed array has an impossible header".to_owned();
    // Three words in base64, padded up to whole groups of four characters.
    let head = content.get(..(3 * word).div_ceil(3) * 4).ok_or_else(damaged)?;
    let head = base64::engine::general_purpose::STANDARD.decode(head).map_err(|_| damaged())?;
    let mut sizes = head.chunks_exact(word).map(|chunk| {
        let mut wide = [0; 8];
        wide[..word].copy_from_slice(chunk);
        u64::from_le_bytes(wide)
    });
    let [blocks, size, last] = [0; 3].map(|_: u8| sizes.next().unwrap_or(u64::MAX));
    let data = content.len() as u64;
    let Some(full) = blocks.checked_sub(1) else {
        // vtkio takes one from the number of blocks and then asks for all memory there is.
        return Err("holds an empty compressed array, which is not read; save it uncompressed".to_owned());
    };
    let total = full.checked_mul(size).and_then(|t| t.checked_add(last));
    let possible = blocks <= data && total.is_some_and(|t| t <= data * DEFLATE_RATIO);
    if possible { Ok(()) } else { Err(damaged()) }
}

fn inline<P>(piece: Piece<P>) -> Result<P, String> {
    match piece {
        Piece::Inline(piece) => Ok(*piece),
        _ => Err("refers to other files; read those one by one".into()),
    }
}

/// Adds points; returns the number the first of them got.
fn add_points(points: IOBuffer, cells: &mut Cells) -> Result<u64, String> {
    let first = cells.points.len() as u64;
    let values: Vec<f64> = points.cast_into().ok_or("has points that are no numbers")?;
    if !values.len().is_multiple_of(3) {
        return Err("has points without three coordinates".into());
    }
    cells.points.extend(values.chunks_exact(3).map(|p| [p[0], p[1], p[2]]));
    Ok(first)
}

/// Values of the seam array, if there is one.
fn seams(attributes: Vec<Attribute>) -> Vec<f64> {
    let seam = attributes.into_iter().find_map(|attribute| match attribute {
        Attribute::DataArray(array) if array.name == SEAM => array.data.cast_into(),
        _ => None,
    });
    seam.unwrap_or_default()
}

/// The cells' nodes; `first` is added to each.
fn lists(numbers: VertexNumbers, first: u64) -> Result<Vec<Vec<u64>>, String> {
    let damaged = || "is damaged: its cells and their nodes do not fit together".to_owned();
    let shift =
        |nodes: &[u64]| nodes.iter().map(|n| n.checked_add(first)).collect::<Option<Vec<_>>>().ok_or_else(damaged);
    let mut lists = Vec::new();
    match numbers {
        VertexNumbers::Legacy { vertices, .. } => {
            let wide: Vec<u64> = vertices.into_iter().map(u64::from).collect();
            let mut rest = wide.as_slice();
            while let Some((&count, tail)) = rest.split_first() {
                let count = usize::try_from(count).map_err(|_| damaged())?;
                let (nodes, tail) = tail.split_at_checked(count).ok_or_else(damaged)?;
                lists.push(shift(nodes)?);
                rest = tail;
            }
        }
        VertexNumbers::XML { connectivity, offsets } => {
            let mut from = 0;
            // Newer files begin with the offset 0; a cell of no nodes has no meaning, so it can be left out.
            for to in offsets.into_iter().filter(|&to| to != 0) {
                let to = usize::try_from(to).map_err(|_| damaged())?;
                lists.push(shift(connectivity.get(from..to).ok_or_else(damaged)?)?);
                from = to;
            }
        }
    }
    Ok(lists)
}

fn add_grid(piece: UnstructuredGridPiece, cells: &mut Cells) -> Result<(), String> {
    let first = add_points(piece.points, cells)?;
    let seam = seams(piece.data.cell);
    let lists = lists(piece.cells.cell_verts, first)?;
    if lists.len() != piece.cells.types.len() {
        return Err(format!("has {} cells but {} cell types", lists.len(), piece.cells.types.len()));
    }
    for (i, (nodes, kind)) in lists.iter().zip(piece.cells.types).enumerate() {
        let on_seam = seam.get(i).is_some_and(|&s| s != 0.0);
        match (kind, nodes.as_slice()) {
            (CellType::Vertex | CellType::PolyVertex, _) => cells.ignored += 1,
            (CellType::Line | CellType::PolyLine, _) => cells.add_line(nodes, on_seam),
            (CellType::Triangle | CellType::Quad | CellType::Polygon, _) => cells.add_face(nodes)?,
            (CellType::TriangleStrip, _) => add_strip(nodes, cells)?,
            // A pixel lists its corners row by row, not around.
            (CellType::Pixel, &[a, b, c, d]) => cells.add_face(&[a, b, d, c])?,
            _ => {
                return Err(format!("cell {i} is a {kind:?}; only lines, triangles and quads of first order are read"));
            }
        }
    }
    Ok(())
}

fn add_poly(piece: PolyDataPiece, cells: &mut Cells) -> Result<(), String> {
    let first = add_points(piece.points, cells)?;
    let seam = seams(piece.data.cell);
    let of = |numbers: Option<VertexNumbers>| numbers.map_or(Ok(Vec::new()), |n| lists(n, first));
    let vertices = of(piece.verts)?.len();
    cells.ignored += vertices;
    for (i, nodes) in of(piece.lines)?.iter().enumerate() {
        cells.add_line(nodes, seam.get(vertices + i).is_some_and(|&s| s != 0.0));
    }
    for nodes in of(piece.polys)? {
        cells.add_face(&nodes)?;
    }
    for nodes in of(piece.strips)? {
        add_strip(&nodes, cells)?;
    }
    Ok(())
}

/// Every second triangle of a strip turns the other way.
fn add_strip(nodes: &[u64], cells: &mut Cells) -> Result<(), String> {
    for (i, t) in nodes.windows(3).enumerate() {
        cells.add_face(&if i % 2 == 0 { [t[0], t[1], t[2]] } else { [t[1], t[0], t[2]] })?;
    }
    Ok(())
}
