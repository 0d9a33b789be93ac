//! Kratos .mdpa: nodes, elements, conditions and geometries of two to four nodes; sub model parts are groups.

use super::cells::{Cells, IGNORED};
use super::labels::{KIND, Labelled, not_read, set_of};
use super::statements::Meaning::{LeftOut, Nothing, Read, Refused};
use super::statements::{JOINS, LeftOut as Left, Statements};
use super::text::{number, point, text};

/// What is done with the blocks.
///
/// Source: Kratos Multiphysics wiki, "Input data".
const BLOCKS: Statements = Statements {
    mark: "Begin ",
    list: &[
        (
            Read,
            &[
                "Nodes",
                "Elements",
                "Conditions",
                "Geometries",
                "SubModelPart",
                "SubModelPartNodes",
                "SubModelPartElements",
                "SubModelPartConditions",
                "SubModelPartGeometries",
            ],
        ),
        (Refused(JOINS), &["MasterSlaveConstraints", "Constraints"]),
        (LeftOut, &["Mesh", "SubModelPartConstraints"]),
        (
            Nothing,
            &[
                "ModelPartData",
                "Properties",
                "Table",
                "NodalData",
                "ElementalData",
                "ConditionalData",
                "SubModelPartData",
                "SubModelPartTables",
                "SubModelPartProperties",
                "MeshNodes",
                "MeshElements",
                "MeshConditions",
                "MeshData",
            ],
        ),
    ],
};

/// Most parts within parts.
const DEEPEST: usize = 100;

pub(super) fn read(bytes: &[u8]) -> Result<Cells, String> {
    let text = text(bytes);
    let mut file = File::default();
    // A condition on an element is the same face in another group.
    file.all.cells.repeats_faces = true;
    for (at, line) in (1..).zip(text.lines()) {
        let line = line.split("//").next().unwrap_or_default().trim();
        file.read_line(line, at).map_err(|why| format!("line {at}: {why}"))?;
    }
    if file.all.cells.points.is_empty() {
        return Err("has no \"Begin Nodes\" block".to_owned());
    }
    // A sub model part also lists the nodes of its elements; further ones are a group of nodes.
    file.all.nodes_repeat_elements = true;
    file.all.finish(&file.left)
}

#[derive(Default)]
struct File {
    all: Labelled,
    /// the blocks that are open: their words
    open: Vec<[String; 2]>,
    /// name of the sub model part that is open, with those around it
    group: String,
    left: Left,
}

impl File {
    fn read_line(&mut self, line: &str, at: usize) -> Result<(), String> {
        let mut words = line.split_ascii_whitespace();
        match words.next() {
            None => return Ok(()),
            Some("Begin") => {
                let mut word = || words.next().unwrap_or_default().to_owned();
                self.open.push([word(), word()]);
                if self.open.len() > DEEPEST {
                    return Err(format!("blocks lie more than {DEEPEST} deep"));
                }
                self.rename();
                return self.known(at);
            }
            Some("End") => {
                self.open.pop();
                self.rename();
                return Ok(());
            }
            Some(_) => {}
        }
        let Some([block, name]) = self.open.last() else { return Ok(()) };
        let mut words = line.split_ascii_whitespace();
        let whole = |word| {
            let number: u64 = number(word)?;
            if number < KIND { Ok(number) } else { Err(format!("{number} is too large for a label")) }
        };
        let own = kind(block);
        match block.as_str() {
            "Nodes" => {
                let label = whole(words.next())?;
                self.all.add_node(label, point(&mut words)?)
            }
            "Elements" | "Conditions" | "Geometries" => {
                let label: u64 = whole(words.next())?;
                // The property; geometries have none.
                if block != "Geometries" {
                    words.next();
                }
                let nodes = words.map(|word| whole(Some(word))).collect::<Result<Vec<u64>, String>>()?;
                if nodes.len() < 2 {
                    self.all.cells.remark(IGNORED);
                    return Ok(());
                }
                if nodes.len() > 4 {
                    return Err(not_read(name));
                }
                self.all.add_element(label + own, nodes, "");
                Ok(())
            }
            "SubModelPartNodes" | "SubModelPartElements" | "SubModelPartConditions" | "SubModelPartGeometries" => {
                let sets =
                    if block == "SubModelPartNodes" { &mut self.all.node_sets } else { &mut self.all.element_sets };
                set_of(sets, &self.group).push(whole(words.next())? + own);
                Ok(())
            }
            _ => Ok(()),
        }
    }

    fn rename(&mut self) {
        let parts = self.open.iter().filter(|[block, _]| block == "SubModelPart");
        self.group = parts.map(|[_, name]| name.as_str()).collect::<Vec<_>>().join(".");
    }

    /// Refuses what is not carried out, and solids by the name of their kind; one of four nodes is a tetrahedron unless
    /// it is called a surface.
    fn known(&mut self, at: usize) -> Result<(), String> {
        let Some([block, name]) = self.open.last() else { return Ok(()) };
        BLOCKS.admit(block, at, &mut self.left)?;
        if !["Elements", "Conditions", "Geometries"].contains(&block.as_str()) {
            return Ok(());
        }
        let surface =
            ["Shell", "Membrane", "Plate", "Surface", "Quadrilateral", "Face"].iter().any(|word| name.contains(word));
        let solid = ["3D6N", "3D8N", "3D10N"].iter().any(|ending| name.ends_with(ending))
            || ["Tetrahedra", "Hexahedra", "Prism", "Pyramid"].iter().any(|word| name.starts_with(word));
        let four = block == "Elements" && name.ends_with("3D4N") && !surface;
        if solid || four { Err(not_read(&format!("{name} ({block})"))) } else { Ok(()) }
    }
}

/// Conditions and geometries count for themselves.
fn kind(block: &str) -> u64 {
    match block {
        "Conditions" | "SubModelPartConditions" => KIND,
        "Geometries" | "SubModelPartGeometries" => 2 * KIND,
        _ => 0,
    }
}
