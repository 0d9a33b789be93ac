//! The materials that a case can name: those of the program, in `materials.json` beside this file, and its own.

use std::f64::consts::PI;
use std::path::Path;
use std::sync::LazyLock;

use serde_json::Value;

use super::diagnostics::{Fault, Faults, nearest};
use super::jsonc;
use super::pointer::Pointer;
use super::schema::{ClothMaterial, LineMaterial, Material, MaterialMap, Materials};

/// The materials of the program as JSON.
pub const SHIPPED: &str = include_str!("materials.json");

/// The same; a test reads the text, so that it is never empty.
static MATERIALS: LazyLock<MaterialMap> = LazyLock::new(|| serde_json::from_str(SHIPPED).unwrap_or_default());

/// The materials of the program, by name.
pub fn shipped() -> &'static MaterialMap {
    &MATERIALS
}

/// Puts the materials of a file into a case that names it; `base` is the folder of the case.
///
/// # Errors
/// A file that cannot be read or is no JSON.
pub(crate) fn read_file(json: &mut Value, base: &Path) -> Result<(), Box<Fault>> {
    let Some(Value::String(name)) = json.get("materials") else { return Ok(()) };
    let refuse = |hint: String| {
        let allowed = "a file with materials by name".to_owned();
        Box::new(Fault {
            pointer: "/materials".to_owned(),
            value: format!("\"{name}\""),
            allowed,
            hint: Some(hint),
            ..Fault::default()
        })
    };
    let text = jsonc::read(&base.join(name)).map_err(|error| refuse(error.to_string()))?;
    let clean = jsonc::blank(&text).unwrap_or_else(|_| text.clone());
    let found: Value = serde_json::from_str(&clean).map_err(|error| refuse(format!("it is no JSON: {error}")))?;
    if !found.is_object() {
        return Err(refuse("write an object whose keys are the names of materials".to_owned()));
    }
    if let Some(place) = json.get_mut("materials") {
        *place = found;
    }
    Ok(())
}

/// The materials of a case.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MaterialTable<'a> {
    own: Option<&'a MaterialMap>,
}

impl<'a> MaterialTable<'a> {
    pub(crate) fn of(materials: Option<&'a Materials>) -> Self {
        let own = match materials {
            Some(Materials::Here(own)) => Some(own),
            // A file has been put in place of its name.
            Some(Materials::File(_)) | None => None,
        };
        Self { own }
    }

    /// The material that the case names at `at`; a fault with the nearest name if there is none.
    pub(crate) fn find(&self, at: &Pointer, name: &str, faults: &mut Faults<'_>) -> Option<&'a Material> {
        let found = self.own.and_then(|own| own.get(name)).or_else(|| shipped().get(name));
        if found.is_none() {
            let names = shipped().keys().chain(self.own.into_iter().flat_map(MaterialMap::keys));
            // A size or a type that is another one is no spelling mistake.
            let last = |name: &str| name.rsplit('-').next().unwrap_or_default().to_owned();
            let alike = names.clone().filter(|known| last(known) == last(name)).map(String::as_str);
            let near = nearest(name, alike).or_else(|| nearest(name, names.map(String::as_str)));
            let hint = near.map(|near| format!("did you mean \"{near}\"?"));
            let hint = hint.unwrap_or_else(|| "`canopy-fem materials` prints those of the program".to_owned());
            let allowed = "the name of a material, of the program or in `materials`".to_owned();
            faults.add_value(at, format!("\"{name}\""), allowed, Some(hint));
        }
        found
    }

    /// The same where a cloth is needed.
    pub(crate) fn cloth(&self, at: &Pointer, name: &str, faults: &mut Faults<'_>) -> Option<&'a ClothMaterial> {
        match self.find(at, name, faults)? {
            Material::Cloth(cloth) => Some(cloth),
            Material::Line(_) => {
                let hint = "its numbers are those of a line".to_owned();
                faults.add_value(at, format!("\"{name}\""), "the name of a cloth", Some(hint));
                None
            }
        }
    }

    /// The same where a line is needed.
    pub(crate) fn line(&self, at: &Pointer, name: &str, faults: &mut Faults<'_>) -> Option<&'a LineMaterial> {
        match self.find(at, name, faults)? {
            Material::Line(line) => Some(line),
            Material::Cloth(_) => {
                let hint = "its numbers are those of a cloth".to_owned();
                faults.add_value(at, format!("\"{name}\""), "the name of a line, tape or cable", Some(hint));
                None
            }
        }
    }
}

/// Adds the faults of the case's own materials that no range shows.
pub(crate) fn check(materials: Option<&Materials>, faults: &mut Faults<'_>) {
    let Some(Materials::Here(own)) = materials else { return };
    for (name, material) in own {
        if let Material::Line(line) = material
            && rigidity(line).is_none()
        {
            let at = Pointer::root().key("materials").key(name).key("line");
            let allowed = "either axial_rigidity, or modulus and diameter";
            faults.add_value(&at, "a line without a stiffness, or with two", allowed, None);
        }
    }
}

/// [N] EA of a line, by itself or by E pi d^2/4; `None` if it has neither or both.
pub(crate) fn rigidity(line: &LineMaterial) -> Option<f64> {
    match (line.axial_rigidity, line.modulus, line.diameter) {
        (Some(ea), None, _) => Some(ea),
        (None, Some(modulus), Some(diameter)) => Some(0.25 * PI * modulus * diameter * diameter),
        _ => None,
    }
}
