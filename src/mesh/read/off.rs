//! Geomview .off: counts, vertices, faces. Colours, normals and texture are not used.

use super::cells::{Cells, IGNORED};
use super::text::{number, point, text};

pub(super) fn read(bytes: &[u8]) -> Result<Cells, String> {
    let text = text(bytes);
    let bare = text.lines().map(|line| line.split('#').next().unwrap_or_default().trim());
    let mut lines = bare.filter(|line| !line.is_empty()).peekable();
    let head = lines.peek().copied().unwrap_or_default();
    let (title, counts) = head.split_at(head.find(|c: char| c.is_ascii_digit()).unwrap_or(head.len()));
    if !title.trim().ends_with("OFF") || title.contains('4') || title.contains('n') {
        return Err(
            "is not an OFF file of three dimensions in text: its first line is not OFF, COFF or NOFF".to_owned()
        );
    }
    lines.next();
    let counts = if counts.is_empty() { lines.next().unwrap_or_default() } else { counts };
    let mut words = counts.split_ascii_whitespace();
    let (vertices, faces): (usize, usize) = (number(words.next())?, number(words.next())?);
    let mut cells = Cells::default();
    for vertex in 0..vertices {
        let line = lines.next().ok_or_else(|| format!("ends after {vertex} of {vertices} vertices"))?;
        let at = point(&mut line.split_ascii_whitespace()).map_err(|why| format!("vertex {vertex}: {why}"))?;
        cells.points.push(at);
    }
    for face in 0..faces {
        let line = lines.next().ok_or_else(|| format!("ends after {face} of {faces} faces"))?;
        let mut words = line.split_ascii_whitespace();
        let fault = |why: String| format!("face {face}: {why}");
        let count: usize = number(words.next()).map_err(fault)?;
        let corners = words.map(Some).chain(std::iter::repeat(None)).take(count.min(line.len())).map(number);
        let corners: Vec<u64> = corners.collect::<Result<_, String>>().map_err(fault)?;
        match corners.len() {
            0 | 1 => cells.remark(IGNORED),
            2 => cells.add_line(&corners, false),
            _ => cells.add_face(&corners),
        }
    }
    Ok(cells)
}
