//! .stl, text or binary, by `stl_io`; corners at exactly the same place become one node.

use super::cells::Cells;
use std::collections::HashMap;
use std::io::Cursor;

pub(super) fn read(bytes: &[u8]) -> Result<Cells, String> {
    let mut cursor = Cursor::new(bytes);
    let triangles = stl_io::create_stl_reader(&mut cursor).map_err(|error| format!("is not an STL file: {error}"))?;
    let mut cells = Cells::default();
    let mut known: HashMap<[u64; 3], u64> = HashMap::new();
    for triangle in triangles {
        let triangle = triangle.map_err(|error| format!("is damaged: {error}"))?;
        let mut corners = [0; 3];
        for (corner, vertex) in corners.iter_mut().zip(triangle.vertices) {
            // Adding zero turns -0 into 0, which is the same place.
            let point = vertex.0.map(|c| f64::from(c) + 0.0);
            *corner = *known.entry(point.map(f64::to_bits)).or_insert_with(|| {
                cells.points.push(point);
                cells.points.len() as u64 - 1
            });
        }
        cells.add_face(&corners)?;
    }
    Ok(cells)
}
