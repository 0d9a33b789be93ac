//! Types of elements, and nodes and elements that are made of others.

use crate::read::labels::{KIND, Labelled, set_of};

/// Number of nodes of an element of a type; 1 for those that are no part of a mesh here, `None` if it is not read.
pub(super) fn nodes_of(kind: &str) -> Option<usize> {
    let starts = |words: &[&str]| words.iter().any(|word| kind.starts_with(word));
    if starts(&["MASS", "ROTARYI", "SPRING1", "DASHPOT1", "HEATCAP"]) {
        return Some(1);
    }
    if starts(&[
        "T2D2", "T3D2", "B21", "B31", "B23", "B33", "PIPE21", "PIPE31", "FRAME2D", "FRAME3D", "SPRINGA", "SPRING2",
        "DASHPOTA", "DASHPOT2", "CONN3D2", "CONN2D2", "R2D2", "RB2D2", "RB3D2", "GAPUNI", "ITSUNI", "JOINTC",
    ]) {
        return Some(2);
    }
    let surfaces = ["SFM3D", "STRI", "M3D", "CPS", "CPE", "R3D", "DS", "S"];
    let rest = surfaces.iter().find_map(|word| kind.strip_prefix(word))?;
    let digits = rest.split(|c: char| !c.is_ascii_digit()).next()?;
    match digits {
        "3" => Some(3),
        "4" => Some(4),
        _ => None,
    }
}

/// Nodes between two others, in a straight line at equal distances.
pub(super) fn make_nodes(model: &mut Labelled, [first, last, step]: [u64; 3], set: &str) -> Result<(), String> {
    let missing = |label: u64| format!("*NGEN names node {label}, which is not listed before");
    let a = model.node(first).ok_or_else(|| missing(first))?;
    let b = model.node(last).ok_or_else(|| missing(last))?;
    let count = last.saturating_sub(first) / step;
    if last <= first || !(last - first).is_multiple_of(step) {
        return Err(format!("*NGEN: {step} does not lead from node {first} to node {last}"));
    }
    model.count_made(count)?;
    for i in 0..=count {
        let label = first + i * step;
        if 0 < i && i < count {
            let share = i as f64 / count as f64;
            model.add_node(label, std::array::from_fn(|k| a[k] + share * (b[k] - a[k])))?;
        }
        if !set.is_empty() {
            set_of(&mut model.node_sets, set).push(label);
        }
    }
    Ok(())
}

/// Elements like a given one: its label, then for the row, the rows and the layers how many, and what is added to the
/// labels of nodes and of elements.
pub(super) fn make_elements(model: &mut Labelled, numbers: [u64; 10], set: &str) -> Result<(), String> {
    let [master, counts @ ..] = numbers;
    let nodes =
        model.nodes_of(master).ok_or_else(|| format!("*ELGEN names element {master}, which is not listed before"))?;
    let nodes = nodes.to_vec();
    let [n, by_node, by_element, rows, row_node, row_element, layers, layer_node, layer_element] = counts;
    model.count_made(n.saturating_mul(rows).saturating_mul(layers))?;
    for (layer, row, i) in
        (0..layers).flat_map(|layer| (0..rows).flat_map(move |row| (0..n).map(move |i| (layer, row, i))))
    {
        let shift = |one: [u64; 3]| {
            let parts = [i, row, layer].into_iter().zip(one);
            parts.fold(0_u64, |sum, (count, by)| sum.saturating_add(count.saturating_mul(by)))
        };
        let label = master.saturating_add(shift([by_element, row_element, layer_element])).min(KIND - 1);
        if (i, row, layer) != (0, 0, 0) {
            let by = shift([by_node, row_node, layer_node]);
            let moved = nodes.iter().map(|node| node.saturating_add(by).min(KIND - 1));
            model.add_element(label, moved.collect(), "");
        }
        if !set.is_empty() {
            set_of(&mut model.element_sets, set).push(label);
        }
    }
    Ok(())
}
