//! Connected components of a graph.

/// The component of every one of `n` nodes, named by its smallest node, where pairs of nodes are joined.
pub fn components(n: usize, pairs: impl Iterator<Item = [u32; 2]>) -> Vec<u32> {
    let mut parent: Vec<u32> = (0..n as u32).collect();
    for [a, b] in pairs {
        let (a, b) = (root(&mut parent, a), root(&mut parent, b));
        parent[a.max(b) as usize] = a.min(b);
    }
    (0..n as u32).map(|node| root(&mut parent, node)).collect()
}

/// Root of a node in a forest, halving the path on the way.
fn root(parent: &mut [u32], mut node: u32) -> u32 {
    while parent[node as usize] != node {
        parent[node as usize] = parent[parent[node as usize] as usize];
        node = parent[node as usize];
    }
    node
}
