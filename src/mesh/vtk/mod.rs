//! VTK's files: the writers and the one reader of .vtu and .vtp, for meshes and for the frames of a run.
//!
//! Source: "VTK XML file formats", <https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html>.

mod cells;
mod encode;
pub mod hdf;
pub mod read;
mod tags;
mod vectored_write;
pub mod write;
pub mod write_mesh;

pub use encode::Width;
use serde::{Deserialize, Serialize};

/// Folder of the frames of a run, beside its .pvd.
pub const FRAMES: &str = "frames";
/// What the name of the one file of a run ends with, whose frames are in it.
pub const HDF_ENDING: &str = "vtkhdf";
/// How a run ended, for programs; in its folder.
pub const SUMMARY: &str = "summary.json";

/// How the bytes of appended arrays are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Encoding {
    /// As raw bytes: the smallest and fastest form, but not valid text, which some builds of ParaView 9.1-9.2 refuse.
    #[default]
    Raw,
    /// As base64 text: 4/3 of the size, read by every program.
    Base64,
}

/// Whether appended bytes are compressed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Compression {
    /// As they are.
    #[default]
    None,
    /// zlib level 1 in blocks of 1 MiB.
    Zlib,
}

/// How many digits numbers keep.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Precision {
    /// All sixteen digits.
    #[default]
    F64,
    /// Seven, at half the size: enough for pictures. Positions keep sixteen.
    F32,
}

/// The files of frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum FrameFormat {
    /// A .vtu file for each frame, in a folder, and a .pvd file that lists them.
    #[default]
    Vtu,
    /// One .vtkhdf file for all frames of a run, with the mesh once.
    Vtkhdf,
}

/// How the arrays of a frame are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct VtuFormat {
    /// a file for each frame, or one for all
    pub file: FrameFormat,
    /// raw or base64
    pub encoding: Encoding,
    /// none or zlib
    pub compression: Compression,
    /// of fields; positions, times and ledgers keep all digits
    pub precision: Precision,
}

/// Text for an XML attribute. Control characters, which XML 1.0 cannot hold, become spaces.
pub fn xml_attribute(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&apos;"),
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    /// Characters with a meaning in XML are escaped.
    #[test]
    fn specials_are_escaped() {
        let (text, escaped) = ("a<b> & \"c\" 'd'\u{1}", "a&lt;b&gt; &amp; &quot;c&quot; &apos;d&apos; ");
        assert_eq!(super::xml_attribute(text), escaped);
    }
}
