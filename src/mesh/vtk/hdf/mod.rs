//! VTKHDF files: all frames of a run in one file, with the mesh once. Written and read without the HDF5 library.
//!
//! A frame is added as a chunk of every array at the end of the file; then the few bytes that lead to the chunks are
//! changed in place, and last, in one write, the numbers of frames and of times. So the file can be read whenever the
//! program is killed, and what a frame adds does not depend on how often the run was interrupted: a file that is cut
//! back to fewer frames and goes on has the bytes of one that was written without a break. The crates for HDF5 that
//! were tried either append to lists of single numbers only, or can leave a file that VTK cannot read when they are
//! killed while they write a frame: `docs/performance/tried.md`.
//!
//! The subset of HDF5: superblock 1, object headers 1 with links as messages, B-trees 1, filters shuffle and deflate.
//!
//! Source: "VTKHDF format specification" 2.2, <https://docs.vtk.org/en/latest/vtk_file_formats/vtkhdf_file_format/>.

mod filters;
mod head;
mod header;
mod read;
mod region;
#[cfg(test)]
mod tests;
mod tree;
mod write;

pub use head::HdfScene;
pub use read::HdfFrames;
pub use write::HdfWriter;

/// What stands for `/` in the name of a link, which cannot hold one: division slash.
const SLASH: char = '\u{2215}';

/// The name of an array as that of a link.
fn link_name(name: &str) -> String {
    name.replace('/', SLASH.encode_utf8(&mut [0; 4]))
}

/// The name of an array, from that of a link.
fn array_name(name: &str) -> String {
    name.replace(SLASH, "/")
}
