//! Arrays of whole numbers that mark parts of a mesh.

use crate::group::LONGEST_NAME;
use std::collections::{BTreeSet, HashMap};

/// More different numbers than these are no parts.
const MOST: usize = 256;

/// Arrays by name, with a number a member.
pub(super) struct Marks(Vec<(String, Vec<i64>, Naming)>);

/// How the groups of an array are called.
enum Naming {
    /// as the array: all its members are 0 or 1
    Plain,
    /// as the array and the number
    Numbered,
}

impl Marks {
    /// Arrays with too many different numbers, or names of what programs count through, mark nothing.
    pub(super) fn new(arrays: Vec<(String, Vec<i64>)>) -> Self {
        let parts = arrays.into_iter().filter_map(|(name, numbers)| {
            let name: String = name.chars().take(LONGEST_NAME).collect();
            let different: BTreeSet<i64> = numbers.chunk_by(|a, b| a == b).map(|alike| alike[0]).collect();
            let counts = name.starts_with("vtk") || name.starts_with("Global") || name.starts_with("Original");
            let naming = if different.iter().all(|n| [0, 1].contains(n)) { Naming::Plain } else { Naming::Numbered };
            (different.len() <= MOST && !counts).then_some((name, numbers, naming))
        });
        Marks(parts.collect())
    }

    /// Whether no array marks anything.
    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// For each of so many members the first one with the same numbers: all those are in the same groups.
    pub(super) fn first_alike(&self, count: usize) -> Vec<u32> {
        let mut alike = vec![0; count];
        for (_, numbers, _) in &self.0 {
            let mut first: HashMap<(u32, Option<i64>), u32> = HashMap::new();
            // Neighbours in a file mostly have the same number.
            let mut latest = None;
            for (alike, member) in alike.iter_mut().zip(0..) {
                let key = (*alike, numbers.get(member as usize).copied());
                *alike = match latest {
                    Some((same, known)) if same == key => known,
                    _ => *first.entry(key).or_insert(member),
                };
                latest = Some((key, *alike));
            }
        }
        alike
    }

    /// The groups of a member: none for the number 0 of an array of 0 and 1.
    pub(super) fn names(&self, member: usize) -> Vec<String> {
        let named = self.0.iter().filter_map(|(name, numbers, naming)| match (numbers.get(member)?, naming) {
            (0, Naming::Plain) => None,
            (_, Naming::Plain) => Some(name.clone()),
            (number, Naming::Numbered) => Some(format!("{name} {number}")),
        });
        named.collect()
    }
}
