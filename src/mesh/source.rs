//! The mesh section of a case: where the mesh comes from.

use super::annulus::{AnnulusParameters, DiscParameters};
use super::chain::ChainParameters;
use super::explicit::ExplicitMesh;
use super::parachute::ParachuteParameters;
use super::read::Imported;
use super::rectangle::RectangleParameters;
use super::{Mesh, MeshError, MeshFile};
use serde::de::value::MapAccessDeserializer;
use serde::de::{DeserializeSeed, Error as _, IntoDeserializer, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use std::path::Path;

/// [-] largest number of nodes of any source; a larger number counts as a mistake.
pub const MAX_NODES: usize = 50_000_000;

/// Where the mesh of a network comes from.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "schema", schemars(transform = one_of))]
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
    /// Nodes, springs and triangles listed in the case.
    Explicit(ExplicitMesh),
    /// A mesh file, `"file"`, and how its mesh is placed and repaired.
    #[serde(untagged)]
    File(MeshFile),
}

/// An object with the key of exactly one source; the keys of a file are all there may be beside it.
impl<'de> Deserialize<'de> for MeshSource {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        from.deserialize_map(SourceVisitor)
    }
}

struct SourceVisitor;

impl<'de> Visitor<'de> for SourceVisitor {
    type Value = MeshSource;

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("an object with the source of a mesh as its key")
    }

    fn visit_map<M: MapAccess<'de>>(self, mut map: M) -> Result<MeshSource, M::Error> {
        let key: String = map.next_key()?.ok_or_else(|| M::Error::custom("a mesh needs a source"))?;
        let source = match key.as_str() {
            "annulus" => MeshSource::Annulus(map.next_value()?),
            "disc" => MeshSource::Disc(map.next_value()?),
            "rectangle" => MeshSource::Rectangle(map.next_value()?),
            "chain" => MeshSource::Chain(map.next_value()?),
            "parachute" => MeshSource::Parachute(map.next_value()?),
            "explicit" => MeshSource::Explicit(map.next_value()?),
            known if MeshFile::KEYS.contains(&known) => {
                return MeshFile::deserialize(MapAccessDeserializer::new(Again { key: Some(key), map }))
                    .map(MeshSource::File);
            }
            other => return Err(M::Error::unknown_variant(other, &SOURCES)),
        };
        match map.next_key::<String>()? {
            None => Ok(source),
            Some(second) => Err(M::Error::custom(format!("a mesh has one source, not \"{key}\" and \"{second}\""))),
        }
    }
}

/// Names of the sources.
const SOURCES: [&str; 7] = ["annulus", "disc", "rectangle", "chain", "parachute", "explicit", "file"];

/// A map whose first key was read already.
struct Again<M> {
    key: Option<String>,
    map: M,
}

impl<'de, M: MapAccess<'de>> MapAccess<'de> for Again<M> {
    type Error = M::Error;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, M::Error> {
        match self.key.take() {
            Some(key) => seed.deserialize(key.into_deserializer()).map(Some),
            None => self.map.next_key_seed(seed),
        }
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, M::Error> {
        self.map.next_value_seed(seed)
    }
}

/// The choices exclude each other, which schemars does not say of one without a key of its own.
#[cfg(feature = "schema")]
fn one_of(schema: &mut schemars::Schema) {
    if let Some(choices) = schema.remove("anyOf") {
        schema.insert("oneOf".to_owned(), choices);
    }
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
            Self::File(file) => file.check(faults),
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
        first_fault(|faults| self.check(faults))?;
        let mesh = match self {
            Self::Annulus(p) => p.build()?,
            Self::Disc(p) => p.build()?,
            Self::Rectangle(p) => p.build()?,
            Self::Chain(p) => p.build(),
            Self::Parachute(p) => p.build()?,
            Self::Explicit(p) => p.build()?,
            // The reader of the file has checked it.
            Self::File(file) => return file.read(base),
        };
        mesh.check()?;
        Ok(Imported { mesh, notes: Vec::new(), repairs: Vec::new() })
    }
}

/// The first fault that a check reports.
pub(super) fn first_fault(check: impl FnOnce(FaultSink<'_>)) -> Result<(), MeshError> {
    let mut first = None;
    check(&mut |pointer, value, allowed, hint| {
        first.get_or_insert_with(|| MeshError::Parameter { pointer: pointer.to_owned(), value, allowed, hint });
    });
    first.map_or(Ok(()), Err)
}

/// [m] Lengths whose squares and products are numbers with all their digits.
const LENGTHS: [f64; 2] = [1e-100, 1e100];

/// Reports a length that is not above zero, or so small or large that areas cannot be computed.
pub(super) fn check_length(at: &str, key: &str, value: f64, faults: FaultSink<'_>) {
    let [least, most] = LENGTHS;
    if !(value >= least && value <= most) {
        let hint = "give a length in metres".to_owned();
        let allowed = if value > 0.0 { format!("{least:e} to {most:e}") } else { "above 0".to_owned() };
        faults(&format!("{at}/{key}"), format!("{value}"), allowed, hint);
    }
}

/// Reports a count outside `least..=most`.
pub(super) fn check_count(at: &str, key: &str, value: usize, [least, most]: [usize; 2], faults: FaultSink<'_>) {
    if value < least || value > most {
        let hint = if value < least { "take more" } else { "take fewer" };
        faults(&format!("{at}/{key}"), value.to_string(), format!("{least} to {most}"), hint.into());
    }
}
