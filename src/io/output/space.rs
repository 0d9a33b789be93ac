//! Disk space needed by frames, and free space.

use std::path::Path;

use super::frame::Fields;
use crate::model::observables::Observables;
use crate::vtk::{Precision, Width};

/// [byte] Approximate size of the XML around the arrays of a frame.
const HEAD: u64 = 2000;

/// [byte] Size of a frame as raw arrays without compression, within the few digits of its XML and one byte a cell; with
/// compression it is at most that.
pub fn frame_bytes(picture: &dyn Observables, fields: Fields, precision: Precision) -> u64 {
    let fields = fields.of_scene(picture);
    let count = |n: usize| n as u64;
    let (points, triangles, edges) =
        (count(picture.reference().len()), count(picture.triangles().len()), count(picture.edges().len()));
    // A scene without triangles and edges has vertex cells.
    let vertices = if triangles + edges == 0 { points } else { 0 };
    let cells = triangles + edges + vertices;
    let corners = 3 * triangles + 2 * edges + vertices;
    // Displacements, velocities and positions are always written, the last with eight bytes per number.
    let vectors = 2 + u64::from(fields.force) + u64::from(fields.reaction);
    let scalars =
        [fields.tension, fields.strain, fields.rest_length, fields.pressure].map(u64::from).iter().sum::<u64>();
    let scalars = scalars + if fields.membrane { 8 } else { 0 };
    // Places on the mesh, and Int32 numbers on cells and points.
    let named = if picture.groups().is_empty() { 0 } else { (24 + 4) * points + 4 * cells };
    // With triangles: UInt8 kinds, and the flags of cells that are not drawn, which frames with all drawn do without.
    let flags = if triangles > 0 { 2 } else { 0 } + u64::from(fields.crossing);
    // Corners and offsets, UInt8 types.
    let width = count(Width::of(points as usize, corners as usize).bytes());
    let number = match precision {
        Precision::F64 => 8,
        Precision::F32 => 4,
    };
    HEAD + named
        + 3 * (8 + number * vectors) * points
        + (number * scalars + width + 1 + flags) * cells
        + width * corners
}

/// [byte] Free space for an ordinary user on the disk of `path`, which need not exist; `None` if the system does not
/// report it.
pub fn free_bytes(path: &Path) -> Option<u64> {
    #[cfg(unix)]
    {
        let there = path.ancestors().find(|p| p.as_os_str().is_empty() || p.exists())?;
        let there = if there.as_os_str().is_empty() { Path::new(".") } else { there };
        let system = rustix::fs::statvfs(there).ok()?;
        system.f_bavail.checked_mul(system.f_frsize)
    }
    #[cfg(not(unix))]
    {
        let _ = path;
        None
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    /// A folder that does not exist yet has the free space of its parent, for relative and absolute paths.
    #[test]
    fn room_of_a_folder_to_be() {
        let folder = tempfile::tempdir().expect("a folder");
        let there = free_bytes(folder.path()).expect("Unix tells");
        let to_be = free_bytes(&folder.path().join("a/b")).expect("Unix tells");
        // Other programs may write meanwhile.
        assert!(there > 0 && to_be.abs_diff(there) < there / 2, "{there} and {to_be}");
        assert!(free_bytes(Path::new("no/such/folder")).is_some_and(|bytes| bytes > 0));
    }
}
