//! Kratos .mdpa: nodes, elements and conditions of two to four nodes; sub model parts are groups.

use super::cells::{Cells, IGNORED};
use super::labels::{Labelled, not_read};
use super::text::{number, point, text};

/// Added to the labels of conditions, which count for themselves.
const CONDITIONS: u64 = 1 << 40;

pub(super) fn read(bytes: &[u8]) -> Result<Cells, String> {
    let text = text(bytes);
    let mut file = File::default();
    // A condition on an element is the same face in another group.
    file.all.cells.repeats_faces = true;
    for (at, line) in (1..).zip(text.lines()) {
        let line = line.split("//").next().unwrap_or_default().trim();
        file.read_line(line).map_err(|why| format!("line {at}: {why}"))?;
    }
    if file.all.cells.points.is_empty() {
        return Err("has no \"Begin Nodes\" block".to_owned());
    }
    // A sub model part also lists the nodes of its elements; further ones are a group of nodes.
    file.all.drop_nodes_of_elements();
    file.all.finish()
}

#[derive(Default)]
struct File {
    all: Labelled,
    /// the blocks that are open: their words
    open: Vec<[String; 2]>,
}

impl File {
    fn read_line(&mut self, line: &str) -> Result<(), String> {
        let mut words = line.split_ascii_whitespace();
        match words.next() {
            None => return Ok(()),
            Some("Begin") => {
                let mut word = || words.next().unwrap_or_default().to_owned();
                self.open.push([word(), word()]);
                return self.known();
            }
            Some("End") => {
                self.open.pop();
                return Ok(());
            }
            Some(_) => {}
        }
        let Some([block, name]) = self.open.last() else { return Ok(()) };
        let mut words = line.split_ascii_whitespace();
        match block.as_str() {
            "Nodes" => {
                let label = number(words.next())?;
                self.all.add_node(label, point(&mut words)?)
            }
            "Elements" | "Conditions" | "Geometries" => {
                let label: u64 = number(words.next())?;
                // The property; geometries have none.
                if block != "Geometries" {
                    words.next();
                }
                let nodes = words.map(|word| number(Some(word))).collect::<Result<Vec<u64>, String>>()?;
                if nodes.len() < 2 {
                    self.all.cells.remark(IGNORED);
                    return Ok(());
                }
                if nodes.len() > 4 {
                    return Err(not_read(name));
                }
                let own = if block == "Elements" { 0 } else { CONDITIONS };
                self.all.add_element(label.saturating_add(own), nodes, "");
                Ok(())
            }
            "SubModelPartNodes" | "SubModelPartElements" | "SubModelPartConditions" => {
                let label: u64 = number(words.next())?;
                let parts = self.open.iter().filter(|[block, _]| block == "SubModelPart");
                let group = parts.map(|[_, name]| name.as_str()).collect::<Vec<_>>().join(".");
                let (sets, own) = match block.as_str() {
                    "SubModelPartNodes" => (&mut self.all.node_sets, 0),
                    "SubModelPartElements" => (&mut self.all.element_sets, 0),
                    _ => (&mut self.all.element_sets, CONDITIONS),
                };
                sets.entry(group).or_default().push(label.saturating_add(own));
                Ok(())
            }
            _ => Ok(()),
        }
    }

    /// Refuses solids by the name of their kind; one of four nodes is a tetrahedron unless it is called a surface.
    fn known(&self) -> Result<(), String> {
        let Some([block, name]) = self.open.last().filter(|[block, _]| block == "Elements") else { return Ok(()) };
        let surface = ["Shell", "Membrane", "Plate", "Surface"].iter().any(|word| name.contains(word));
        let solid = ["3D6N", "3D8N", "3D10N"].iter().any(|ending| name.ends_with(ending));
        if solid || name.ends_with("3D4N") && !surface { Err(not_read(&format!("{name} ({block})"))) } else { Ok(()) }
    }
}
