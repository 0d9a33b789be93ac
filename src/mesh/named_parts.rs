//! Where in a scene something is, by the names of its groups.

use super::Groups;

/// Names that are given for one place.
const NAMES: usize = 2;

/// The parts of a scene that groups name.
#[derive(Clone, Copy, Debug)]
pub struct NamedParts<'a> {
    /// named parts
    pub groups: &'a Groups,
    /// ends of the edges
    pub edges: &'a [[u32; 2]],
    /// corners of the triangles
    pub triangles: &'a [[u32; 3]],
}

impl<'a> NamedParts<'a> {
    /// The groups that a node belongs to, at most two, the smallest first: those that list it; else those with an edge
    /// that ends at it; else those with a triangle that has it.
    pub fn of_node(&self, node: u32) -> Vec<&'a str> {
        let lists = smallest(self.groups.iter().map(|(name, group)| (name, &group.nodes)), |member| member == node);
        let ends = |edge: u32| self.edges.get(edge as usize).is_some_and(|ends| ends.contains(&node));
        let corner = |triangle: u32| self.triangles.get(triangle as usize).is_some_and(|t| t.contains(&node));
        let or = |found: Vec<&'a str>, other: &dyn Fn() -> Vec<&'a str>| if found.is_empty() { other() } else { found };
        let found = or(lists, &|| smallest(self.groups.iter().map(|(name, group)| (name, &group.edges)), ends));
        or(found, &|| smallest(self.groups.iter().map(|(name, group)| (name, &group.triangles)), corner))
    }

    /// The groups that list an edge, at most two, the smallest first.
    pub fn of_edge(&self, edge: u32) -> Vec<&'a str> {
        smallest(self.groups.iter().map(|(name, group)| (name, &group.edges)), |member| member == edge)
    }

    /// The groups that list a triangle, at most two, the smallest first.
    pub fn of_triangle(&self, triangle: u32) -> Vec<&'a str> {
        smallest(self.groups.iter().map(|(name, group)| (name, &group.triangles)), |member| member == triangle)
    }
}

/// The names of the smallest lists with such a member.
fn smallest<'a>(lists: impl Iterator<Item = (&'a String, &'a Vec<u32>)>, fits: impl Fn(u32) -> bool) -> Vec<&'a str> {
    let mut found: Vec<(usize, &str)> = lists
        .filter(|(_, list)| list.iter().any(|&m| fits(m)))
        .map(|(name, list)| (list.len(), name.as_str()))
        .collect();
    found.sort();
    found.into_iter().take(NAMES).map(|(_, name)| name).collect()
}

/// What is numbered with the groups it belongs to: "node 136 (skirt)", or "node 136" without any.
pub fn with_groups(what: &str, number: impl std::fmt::Display, groups: &[impl AsRef<str>]) -> String {
    let names: Vec<&str> = groups.iter().map(AsRef::as_ref).collect();
    if names.is_empty() { format!("{what} {number}") } else { format!("{what} {number} ({})", names.join(", ")) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Group;

    #[test]
    fn places_have_the_names_of_their_smallest_groups() {
        let list = |nodes: &[u32], edges: &[u32], triangles: &[u32]| Group {
            nodes: nodes.to_vec(),
            edges: edges.to_vec(),
            triangles: triangles.to_vec(),
        };
        let groups: Groups = [
            ("all", list(&[0, 1, 2, 3], &[], &[])),
            ("corner", list(&[1], &[], &[])),
            ("skirt", list(&[1, 2], &[], &[])),
            ("lines", list(&[], &[0, 1], &[])),
            ("cloth", list(&[], &[], &[0])),
        ]
        .map(|(name, group)| (name.to_owned(), group))
        .into();
        let parts = NamedParts { groups: &groups, edges: &[[0, 4], [4, 5]], triangles: &[[5, 6, 7]] };
        assert_eq!(parts.of_node(1), ["corner", "skirt"]);
        assert_eq!(parts.of_node(0), ["all"], "groups of nodes before those of edges");
        assert_eq!(parts.of_node(5), ["lines"], "those of edges before those of triangles");
        assert_eq!(parts.of_node(7), ["cloth"]);
        assert!(parts.of_node(8).is_empty() && parts.of_edge(2).is_empty());
        assert_eq!((parts.of_edge(1), parts.of_triangle(0)), (vec!["lines"], vec!["cloth"]));
        assert_eq!(with_groups("node", 1, &parts.of_node(1)), "node 1 (corner, skirt)");
        assert_eq!(with_groups("node", 8, &parts.of_node(8)), "node 8");
    }
}
