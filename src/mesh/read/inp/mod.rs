//! Abaqus and CalculiX .inp: nodes and elements, also made by `*NGEN` and `*ELGEN`, parts and their instances; node and
//! element sets are groups. With several instances a set is called by its instance too: `left-1.hem`.

mod make;
mod place;
mod statements;

use super::cells::{Cells, IGNORED};
use super::labels::{KIND, Labelled, Labels, not_read, set_of};
use super::statements::LeftOut;
use super::text::{label, real, text};
use make::{make_elements, make_nodes, nodes_of};
use place::{Coordinates, System, moved};
use statements::KEYWORDS;
use std::collections::{BTreeMap, HashMap, HashSet};

pub(super) fn read(bytes: &[u8]) -> Result<Cells, String> {
    let text = text(bytes);
    let mut file = File::default();
    let mut keyword = String::new();
    for (at, line) in (1..).zip(text.lines()) {
        let line = line.trim();
        if line.is_empty() || line.starts_with("**") {
            continue;
        }
        // A keyword line that ends in a comma goes on in the next one.
        let begun = !keyword.is_empty();
        let done = if begun || line.starts_with('*') {
            keyword.push_str(line);
            if line.ends_with(',') {
                continue;
            }
            file.keyword(std::mem::take(&mut keyword).trim_start_matches('*'), at)
        } else {
            file.data(line)
        };
        done.map_err(|why| format!("line {at}: {why}"))?;
    }
    file.finish()
}

#[derive(Default)]
struct File {
    /// nodes and elements outside of parts, and those of instances
    all: Labelled,
    parts: BTreeMap<String, Labelled>,
    /// the part whose statements follow
    part: Option<String>,
    instances: Vec<Instance>,
    /// whether the statements of the last instance follow
    in_instance: bool,
    section: Section,
    system: System,
    system_numbers: Vec<f64>,
    /// names of sets, parts and instances as they are first written, by their capitals
    names: HashMap<String, String>,
    /// ranges of sets that other sets brought
    copied: usize,
    left: LeftOut,
}

/// A part that stands at a place.
#[derive(Default)]
struct Instance {
    name: String,
    part: String,
    /// of its data lines
    numbers: Vec<f64>,
    /// what is listed in the instance itself
    own: Labelled,
}

/// Most ranges of labels that sets of sets may bring.
const MOST_COPIED: usize = 2_000_000;

/// What the data lines belong to.
#[derive(Default)]
enum Section {
    #[default]
    Other,
    Nodes {
        set: String,
        coordinates: Coordinates,
    },
    /// lines or faces of so many nodes, and the words of an element that goes on in the next line
    Elements {
        count: usize,
        set: String,
        begun: Vec<u64>,
    },
    /// elements such as point masses
    Ignored,
    Set {
        nodes: bool,
        name: String,
        generate: bool,
        /// added to its labels
        offset: u64,
    },
    MadeNodes {
        set: String,
    },
    MadeElements {
        set: String,
    },
    Instance,
    System,
}

impl File {
    /// The model that statements add to.
    fn open(&mut self) -> &mut Labelled {
        match (&self.part, self.in_instance, self.instances.last_mut()) {
            (_, true, Some(instance)) => &mut instance.own,
            (Some(part), ..) => self.parts.entry(part.clone()).or_default(),
            _ => &mut self.all,
        }
    }

    fn set_mut(&mut self, nodes: bool, name: &str) -> &mut Labels {
        let model = self.open();
        set_of(if nodes { &mut model.node_sets } else { &mut model.element_sets }, name)
    }

    /// A name as it was first written: names do not mind case.
    fn name(&mut self, name: &str) -> String {
        self.names.entry(name.to_ascii_uppercase()).or_insert_with(|| name.to_owned()).clone()
    }

    /// The instance of a name, by its number.
    fn instance(&self, name: &str) -> Result<usize, String> {
        let found = self.instances.iter().position(|instance| instance.name.eq_ignore_ascii_case(name));
        found.ok_or_else(|| format!("there is no *INSTANCE of the name \"{name}\" before"))
    }

    fn keyword(&mut self, line: &str, at: usize) -> Result<(), String> {
        let mut parts = line.split(',').map(str::trim);
        let word = parts.next().unwrap_or_default().to_ascii_uppercase();
        let word = word.split_ascii_whitespace().collect::<Vec<_>>().join(" ");
        let options: Vec<(String, String)> = parts
            .map(|option| option.split_once('=').unwrap_or((option, "")))
            .map(|(key, value)| (key.trim().to_ascii_uppercase(), value.trim().trim_matches('"').to_owned()))
            .collect();
        let option = |key: &str| options.iter().find(|(name, _)| name == key).map(|(_, value)| value.clone());
        let named = |key: &str| option(key).unwrap_or_default();
        self.section = Section::Other;
        if (4..9).contains(&self.system_numbers.len()) {
            return Err("*SYSTEM: needs three points, or one".to_owned());
        }
        if !KEYWORDS.admit(&word, at, &mut self.left)? {
            return Ok(());
        }
        if option("INPUT").or_else(|| option("FILE")).is_some() {
            return Err(format!("*{word}: its data are in another file; {}", super::statements::ONE_FILE));
        }
        self.section = match word.as_str() {
            "NODE" => {
                let coordinates = Coordinates::of(&named("SYSTEM"))?;
                Section::Nodes { set: self.name(&named("NSET")), coordinates }
            }
            "ELEMENT" => {
                let kind = named("TYPE").to_ascii_uppercase();
                match nodes_of(&kind).ok_or_else(|| not_read(&format!("of type {kind}")))? {
                    1 => Section::Ignored,
                    count => Section::Elements { count, set: self.name(&named("ELSET")), begun: Vec::new() },
                }
            }
            "NSET" | "ELSET" => self.set(&word, &option)?,
            "NGEN" if option("LINE").is_none() => Section::MadeNodes { set: self.name(&named("NSET")) },
            "NGEN" => return Err(format!("*NGEN along a curve: {}", super::statements::WRITE_OUT)),
            "ELGEN" => Section::MadeElements { set: self.name(&named("ELSET")) },
            "SYSTEM" => {
                (self.system, self.system_numbers) = (System::default(), Vec::new());
                Section::System
            }
            "PART" => {
                self.system = System::default();
                let name = self.name(&named("NAME"));
                self.parts.entry(name.clone()).or_default();
                self.part = Some(name);
                Section::Other
            }
            "END PART" => {
                (self.part, self.system) = (None, System::default());
                Section::Other
            }
            "INSTANCE" => {
                if option("INSTANCE").or_else(|| option("LIBRARY")).is_some() {
                    return Err(format!("*INSTANCE of another analysis: {}", super::statements::ONE_FILE));
                }
                let (name, part) = (self.name(&named("NAME")), self.name(&named("PART")));
                self.instances.push(Instance { name, part, ..Instance::default() });
                self.in_instance = true;
                Section::Instance
            }
            "END INSTANCE" => {
                self.in_instance = false;
                Section::Other
            }
            _ => Section::Other,
        };
        Ok(())
    }

    fn set(&mut self, word: &str, option: &impl Fn(&str) -> Option<String>) -> Result<Section, String> {
        let name = option(word).ok_or_else(|| format!("a set without {word}="))?;
        let name = self.name(&name);
        let offset = match option("INSTANCE") {
            Some(instance) => (self.instance(&instance)? as u64 + 1) * KIND,
            None => 0,
        };
        let nodes = word == "NSET";
        if let Some(elements) = option("ELSET").filter(|_| nodes) {
            let labels = self.labels_of(false, &elements, offset)?;
            self.open().nodes_of_elements.push((name.clone(), labels));
        }
        Ok(Section::Set { nodes, name, generate: option("GENERATE").is_some(), offset })
    }

    /// The labels of a set that is known by now; in an assembly also of one of an instance.
    fn labels_of(&mut self, nodes: bool, name: &str, offset: u64) -> Result<Labels, String> {
        let of_instance = |(instance, set)| Some(((self.instance(instance).ok()? as u64 + 1) * KIND, set));
        let (offset, set) = name.split_once('.').and_then(of_instance).unwrap_or((offset, name));
        let set = self.name(set);
        let sets = |model: &Labelled| {
            let sets = if nodes { &model.node_sets } else { &model.element_sets };
            sets.get(&set).cloned()
        };
        let found = match (offset / KIND).checked_sub(1).and_then(|at| self.instances.get(at as usize)) {
            Some(instance) => sets(&instance.own).or_else(|| sets(self.parts.get(&instance.part)?)),
            None => sets(self.open()),
        };
        let mut labels = Labels::default();
        let found = found.ok_or_else(|| format!("there is no set \"{name}\" before"))?;
        self.copied += found.len();
        if self.copied > MOST_COPIED {
            return Err(format!("the sets of sets have more than {MOST_COPIED} ranges of labels; list their members"));
        }
        labels.extend(&found, offset);
        Ok(labels)
    }

    /// The label of a node or an element; in an assembly `name.7` is one of an instance.
    fn label(&self, word: &str) -> Result<u64, String> {
        let own = match word.split_once('.').filter(|(_, rest)| !rest.is_empty()) {
            Some((instance, word)) => return Ok((self.instance(instance)? as u64 + 1) * KIND + label(word)?),
            None => label(word)?,
        };
        if own < KIND { Ok(own) } else { Err(format!("{own} is too large for a label")) }
    }

    fn data(&mut self, line: &str) -> Result<(), String> {
        let mut words: Vec<&str> = line.split(',').map(str::trim).collect();
        // A line that goes on, or an unused field, ends in a comma.
        while words.last().is_some_and(|word| word.is_empty()) {
            words.pop();
        }
        let mut section = std::mem::take(&mut self.section);
        let done = self.data_of(&mut section, &words);
        self.section = section;
        done
    }

    fn data_of(&mut self, section: &mut Section, words: &[&str]) -> Result<(), String> {
        let whole = |at: usize, absent: u64| match words.get(at).filter(|word| !word.is_empty()) {
            Some(word) => label(word),
            None => Ok(absent),
        };
        match section {
            Section::Other => {}
            Section::Ignored => self.all.cells.remark(IGNORED),
            Section::Nodes { set, coordinates } => {
                let label = self.label(words.first().copied().unwrap_or_default())?;
                // Coordinates that are left out are 0.
                let coordinate = |at: usize| words.get(at).map_or(Ok(0.0), |word| real_or_0(word));
                let given = [coordinate(1)?, coordinate(2)?, coordinate(3)?];
                let point = self.system.place(coordinates.place(given));
                let model = self.open();
                model.add_node(label, point)?;
                if !set.is_empty() {
                    set_of(&mut model.node_sets, set).push(label);
                }
            }
            Section::Elements { count, set, begun } => {
                for word in words.iter().filter(|word| !word.is_empty()) {
                    begun.push(self.label(word)?);
                    // A beam may name a further node for its direction.
                    if begun.len() == *count + 1 {
                        self.open().add_element(begun[0], begun[1..].to_vec(), set);
                        begun.clear();
                        break;
                    }
                }
            }
            Section::Set { nodes, name, generate: false, offset } => {
                for word in words.iter().filter(|word| !word.is_empty()) {
                    match self.label(word) {
                        Ok(label) => self.set_mut(*nodes, name).push(label + *offset),
                        Err(_) => {
                            let labels = self.labels_of(*nodes, word.trim_matches('"'), *offset)?;
                            self.set_mut(*nodes, name).extend(&labels, 0);
                        }
                    }
                }
            }
            Section::Set { nodes, name, generate: true, offset } => {
                let &[first, last] = words.first_chunk().ok_or("GENERATE needs a first and a last number")?;
                let range = [self.label(first)? + *offset, self.label(last)? + *offset, whole(2, 1)?];
                self.set_mut(*nodes, name).push_range(range);
            }
            Section::MadeNodes { set } => {
                let &[first, last] = words.first_chunk().ok_or("*NGEN needs a first and a last node")?;
                let step = whole(2, 1)?.max(1);
                make_nodes(self.open(), [label(first)?, label(last)?, step], set)?;
            }
            Section::MadeElements { set } => {
                let mut numbers = [1; 10];
                for (at, number) in numbers.iter_mut().enumerate() {
                    *number = whole(at, 1)?;
                }
                make_elements(self.open(), numbers, set)?;
            }
            Section::Instance => {
                let numbers = reals(words)?;
                if let Some(instance) = self.instances.last_mut() {
                    instance.numbers.extend(numbers);
                    // The first line is the translation, whose missing components are 0.
                    let whole = if instance.numbers.len() > 3 { instance.numbers.len() } else { 3 };
                    instance.numbers.resize(whole, 0.0);
                }
            }
            Section::System => {
                self.system_numbers.extend(reals(words)?);
                // The second line holds a third point.
                if !(4..9).contains(&self.system_numbers.len()) {
                    self.system = System::of(&self.system_numbers)?;
                }
            }
        }
        Ok(())
    }

    fn finish(mut self) -> Result<Cells, String> {
        let several = self.instances.len() > 1;
        if self.instances.is_empty() {
            match self.parts.len() {
                0 => {}
                1 => self
                    .instances
                    .extend(self.parts.keys().map(|part| Instance { part: part.clone(), ..Instance::default() })),
                n => return Err(format!("has {n} parts and no *INSTANCE of them; write the assembly too")),
            }
        }
        let mut placed = HashSet::new();
        for (number, instance) in (1..).zip(std::mem::take(&mut self.instances)) {
            let place = moved(&instance.numbers)?;
            let name = |set: &str| if several { format!("{}.{set}", instance.name) } else { set.to_owned() };
            let part = self.parts.get(&instance.part);
            let again = !placed.insert(instance.part);
            for model in part.into_iter().chain([&instance.own]) {
                if again {
                    self.all.count_made(model.size())?;
                }
                self.all.add_copy(model, number * KIND, &place, name)?;
            }
        }
        if self.all.cells.points.is_empty() {
            return Err("has no *NODE section".to_owned());
        }
        self.all.finish(&self.left)
    }
}

/// The numbers of a line; empty fields are 0.
fn reals(words: &[&str]) -> Result<Vec<f64>, String> {
    words.iter().map(|word| real_or_0(word)).collect()
}

fn real_or_0(word: &str) -> Result<f64, String> {
    if word.is_empty() { Ok(0.0) } else { real(word) }
}
