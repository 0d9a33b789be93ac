//! Tuples of nodes in ascending order, and those that are listed again.

/// Calls `visit` with all tuples and their numbers: in ascending order of the tuples, the smaller number first among
/// equal ones.
///
/// Tuples are put together by their first node, then sorted within. Nodes are mostly numbered along the mesh, so this
/// stays in the caches where a hash table or one large sort does not.
pub fn in_order<const N: usize>(tuples: impl Iterator<Item = [u32; N]> + Clone, mut visit: impl FnMut([u32; N], u32)) {
    let (mut count, mut nodes) = (0_usize, 0_usize);
    for tuple in tuples.clone() {
        (count, nodes) = (count + 1, nodes.max(tuple[0] as usize + 1));
    }
    // Few tuples with large numbers of nodes need no list of all nodes.
    if nodes > 8 * count + 64 {
        let mut all: Vec<([u32; N], u32)> = tuples.zip(0..).collect();
        all.sort_unstable();
        all.into_iter().for_each(|(tuple, number)| visit(tuple, number));
        return;
    }
    // Where the tuples of each node begin, one place further: filling the places moves them to where they end.
    let mut next = vec![0_u32; nodes + 1];
    tuples.clone().for_each(|tuple| next[tuple[0] as usize + 1] += 1);
    for node in 0..nodes {
        next[node + 1] += next[node];
    }
    // The other nodes of each tuple, and its number.
    let mut rest = vec![[0; N]; count];
    for (tuple, number) in tuples.zip(0..) {
        let slot = &mut next[tuple[0] as usize];
        let entry = &mut rest[*slot as usize];
        entry[..N - 1].copy_from_slice(&tuple[1..]);
        entry[N - 1] = number;
        *slot += 1;
    }
    let mut begin = 0;
    for (node, end) in (0..).zip(&next[..nodes]) {
        let entries = &mut rest[begin..*end as usize];
        begin = *end as usize;
        sort(entries);
        for entry in entries {
            let mut tuple = [node; N];
            tuple[1..].copy_from_slice(&entry[..N - 1]);
            visit(tuple, entry[N - 1]);
        }
    }
}

/// Sorts entries, which are mostly few: a call for each node takes longer than the sorting.
fn sort<const N: usize>(entries: &mut [[u32; N]]) {
    const FEW: usize = 16;
    let key = |entry: &[u32; N]| entry.iter().fold(0_u128, |key, word| key << 32 | u128::from(*word));
    if entries.len() > FEW {
        entries.sort_unstable_by_key(key);
        return;
    }
    for i in 1..entries.len() {
        let (entry, mut at) = (entries[i], i);
        while at > 0 && key(&entries[at - 1]) > key(&entry) {
            entries[at] = entries[at - 1];
            at -= 1;
        }
        entries[at] = entry;
    }
}

/// For each tuple that equals an earlier one its number, and that of the earliest one; in no order of theirs.
pub(super) fn repeated<const N: usize>(tuples: impl Iterator<Item = [u32; N]> + Clone) -> Vec<[u32; 2]> {
    let mut again = Vec::new();
    let mut current: Option<([u32; N], u32)> = None;
    in_order(tuples, |tuple, number| match current {
        Some((same, first)) if same == tuple => again.push([number, first]),
        _ => current = Some((tuple, number)),
    });
    again
}

/// For each tuple the number of the earliest one that equals it.
pub(super) fn earliest<const N: usize>(tuples: &[[u32; N]]) -> Vec<u32> {
    let mut earliest: Vec<u32> = (0..tuples.len() as u32).collect();
    for [number, first] in repeated(tuples.iter().copied()) {
        earliest[number as usize] = first;
    }
    earliest
}

/// The same nodes in ascending order.
pub(super) fn sorted<const N: usize>(mut tuple: [u32; N]) -> [u32; N] {
    tuple.sort_unstable();
    tuple
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against a stable sort, for few and for large numbers of nodes.
    #[test]
    fn tuples_are_put_in_order() {
        let mut seed = 7_u32;
        for (count, most) in [(0, 1), (500, 20), (500, 100_000), (3, 4_000_000_000)] {
            let mut random = || {
                seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                (seed >> 4) % most
            };
            let tuples: Vec<[u32; 2]> = (0..count).map(|_| [random(), random()]).collect();
            let mut order: Vec<u32> = (0..count).collect();
            order.sort_by_key(|number| tuples[*number as usize]);
            let mut found = Vec::new();
            in_order(tuples.iter().copied(), |tuple, number| {
                assert_eq!(tuple, tuples[number as usize]);
                found.push(number);
            });
            assert_eq!(found, order);
            let first = |tuple| tuples.iter().position(|other| other == tuple).map(|at| at as u32);
            let expected: Option<Vec<u32>> = tuples.iter().map(first).collect();
            assert_eq!(Some(earliest(&tuples)), expected);
        }
    }
}
