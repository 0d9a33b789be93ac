//! Wavefront .obj: `v`, `l` and `f` records; everything else (normals, materials, groups) does not matter here.
//!
//! Read by hand because `tobj` renumbers the vertices by use and keeps them apart between objects, which would change
//! the user's node numbers and tear the mesh.

use super::cells::Cells;

pub(super) fn read(bytes: &[u8]) -> Result<Cells, String> {
    let text = std::str::from_utf8(bytes).map_err(|_| "is not text".to_owned())?;
    let mut cells = Cells::default();
    for (number, line) in text.lines().enumerate() {
        read_line(line, &mut cells).map_err(|reason| format!("line {}: {reason}", number + 1))?;
    }
    Ok(cells)
}

fn read_line(line: &str, cells: &mut Cells) -> Result<(), String> {
    let mut words = line.split('#').next().unwrap_or_default().split_ascii_whitespace();
    match words.next() {
        Some("v") => {
            let mut point = [0.0; 3];
            for c in &mut point {
                let word = words.next().ok_or("a vertex needs three coordinates")?;
                *c = word.parse().map_err(|_| format!("\"{word}\" is not a number"))?;
            }
            cells.points.push(point);
        }
        Some("l") => {
            let nodes = indices(words, cells.points.len())?;
            cells.add_line(&nodes, false);
        }
        Some("f") => {
            let nodes = indices(words, cells.points.len())?;
            cells.add_face(&nodes)?;
        }
        _ => {}
    }
    Ok(())
}

/// Vertex numbers of `3`, `3/1`, `3//2` …; they count from 1, or from the latest vertex backwards if negative.
fn indices<'a>(words: impl Iterator<Item = &'a str>, vertices: usize) -> Result<Vec<u64>, String> {
    let index = |word: &str| {
        let first = word.split('/').next().unwrap_or_default();
        let number: i64 = first.parse().map_err(|_| format!("\"{word}\" is not a vertex number"))?;
        let index = if number > 0 { number.checked_sub(1) } else { number.checked_add(vertices as i64) };
        match (number, index.and_then(|i| u64::try_from(i).ok())) {
            (0, _) | (_, None) => Err(format!("there is no vertex {number}")),
            (_, Some(index)) => Ok(index),
        }
    };
    words.map(index).collect()
}
