//! The mesh section of a case: where the mesh comes from.

use super::annulus::{AnnulusParameters, DiscParameters};
use super::chain::ChainParameters;
use super::explicit::ExplicitMesh;
use super::parachute::ParachuteParameters;
use super::read::Imported;
use super::rectangle::RectangleParameters;
use super::{Mesh, MeshError, read};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// [-] largest number of nodes of any source; a larger number counts as a mistake.
pub const MAX_NODES: usize = 50_000_000;

/// Where the mesh of a network comes from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum MeshSource {
    /// A flat ring in the x-y plane around the origin, normal +z.
    Annulus(AnnulusParameters),
    /// A flat disc in the x-y plane around the origin, normal +z.
    Disc(DiscParameters),
    /// A flat rectangle in the x-y plane from the origin, normal +z.
    Rectangle(RectangleParameters),
    /// A straight line of edges without triangles.
    Chain(ChainParameters),
    /// A rigged parachute with its axis along z and the payload below; its parts are groups.
    Parachute(Box<ParachuteParameters>),
    /// A mesh file (.vtu, .vtk, .msh, .obj, .stl); a relative path counts from the case file's folder.
    File(String),
    /// Nodes, springs and triangles listed in the case.
    Explicit(ExplicitMesh),
}

/// Receives faults: JSON pointer below the mesh section, value, what is allowed, hint.
pub type FaultSink<'a> = &'a mut dyn FnMut(&str, String, String, String);

impl MeshSource {
    /// Reports every parameter out of range, without building anything or opening files.
    pub fn check(&self, faults: FaultSink<'_>) {
        match self {
            Self::Annulus(p) => p.check("/annulus", faults),
            Self::Disc(p) => p.check("/disc", faults),
            Self::Rectangle(p) => p.check("/rectangle", faults),
            Self::Chain(p) => p.check("/chain", faults),
            Self::Parachute(p) => p.check("/parachute", faults),
            Self::Explicit(p) => p.check("/explicit", faults),
            Self::File(name) => {
                if name.is_empty() {
                    faults("/file", "\"\"".into(), "a file name".into(), "name a mesh file".into());
                }
            }
        }
    }

    /// Makes or reads the mesh; `base` is the folder of the case file.
    ///
    /// The result has passed [`Mesh::check`].
    ///
    /// # Errors
    /// The first parameter out of range, a mesh that cannot be made as requested, or an unreadable file.
    pub fn build(&self, base: &Path) -> Result<Mesh, MeshError> {
        Ok(self.build_with_notes(base)?.mesh)
    }

    /// The same, with one sentence for each change or omission of the file's reader.
    ///
    /// # Errors
    /// As [`MeshSource::build`].
    pub fn build_with_notes(&self, base: &Path) -> Result<Imported, MeshError> {
        let mut first = None;
        self.check(&mut |pointer, value, allowed, hint| {
            first.get_or_insert_with(|| MeshError::Parameter { pointer: pointer.to_owned(), value, allowed, hint });
        });
        if let Some(fault) = first {
            return Err(fault);
        }
        let mesh = match self {
            Self::Annulus(p) => p.build()?,
            Self::Disc(p) => p.build()?,
            Self::Rectangle(p) => p.build()?,
            Self::Chain(p) => p.build(),
            Self::Parachute(p) => p.build()?,
            Self::Explicit(p) => p.build()?,
            // The reader of the file has checked it.
            Self::File(name) => return read::read_mesh(&base.join(name)),
        };
        mesh.check()?;
        Ok(Imported { mesh, notes: Vec::new() })
    }
}

/// Reports a length that is not finite and above zero.
pub(super) fn check_length(at: &str, key: &str, value: f64, faults: FaultSink<'_>) {
    if !(value.is_finite() && value > 0.0) {
        let hint = "give a length in metres".to_owned();
        faults(&format!("{at}/{key}"), value.to_string(), "finite and above 0".into(), hint);
    }
}

/// Reports a count outside `least..=most`.
pub(super) fn check_count(at: &str, key: &str, value: usize, [least, most]: [usize; 2], faults: FaultSink<'_>) {
    if value < least || value > most {
        let hint = if value < least { "take more" } else { "take fewer" };
        faults(&format!("{at}/{key}"), value.to_string(), format!("{least} to {most}"), hint.into());
    }
}
