//! Tuples of nodes in ascending order, and those that are listed again.

/// The numbers of tuples in ascending order of the tuples, the smaller number first among equal ones.
///
/// Tuples are put together by their first node, then sorted within. Nodes are mostly numbered along the mesh, so this
/// stays in the caches where a hash table or one large sort does not.
pub(super) fn ascending<const N: usize>(tuples: &[[u32; N]]) -> Vec<u32> {
    let first = |tuple: &[u32; N]| tuple.first().map_or(0, |node| *node as usize);
    let mut order: Vec<u32> = (0..tuples.len() as u32).collect();
    let by_tuple = |number: &u32| (tuples[*number as usize], *number);
    let nodes = tuples.iter().map(first).max().map_or(0, |most| most + 1);
    // Few tuples with large numbers of nodes need no list of all nodes.
    if nodes > 8 * tuples.len() + 64 {
        order.sort_unstable_by_key(by_tuple);
        return order;
    }
    let mut start = vec![0_u32; nodes + 1];
    tuples.iter().for_each(|tuple| start[first(tuple) + 1] += 1);
    for node in 0..nodes {
        start[node + 1] += start[node];
    }
    let mut next = start.clone();
    for (number, tuple) in (0..).zip(tuples) {
        let slot = &mut next[first(tuple)];
        order[*slot as usize] = number;
        *slot += 1;
    }
    for range in start.windows(2) {
        order[range[0] as usize..range[1] as usize].sort_unstable_by_key(by_tuple);
    }
    order
}

/// For each tuple the number of the earliest one that equals it.
pub(super) fn earliest<const N: usize>(tuples: &[[u32; N]]) -> Vec<u32> {
    let mut earliest = vec![0; tuples.len()];
    let mut current: Option<u32> = None;
    for number in ascending(tuples) {
        let same = current.filter(|first| tuples[*first as usize] == tuples[number as usize]);
        let first = same.unwrap_or(number);
        earliest[number as usize] = first;
        current = Some(first);
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
            assert_eq!(ascending(&tuples), order);
            let first = |tuple| tuples.iter().position(|other| other == tuple).map(|at| at as u32);
            let expected: Option<Vec<u32>> = tuples.iter().map(first).collect();
            assert_eq!(Some(earliest(&tuples)), expected);
        }
    }
}
