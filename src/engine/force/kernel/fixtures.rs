//! Elements and vectors for tests of kernels.

use super::local_buffer::{LocalBuffer, RECORD, rows};

/// Nodes of the tests.
pub const NODES: usize = 50;

/// Numbers between -1 and 1, always the same.
pub fn random(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 33) as f64 / f64::from(1u32 << 30) - 1.0
    }
}

/// A local buffer with vectors of [`NODES`] nodes; the last two are the same.
pub fn vectors(seed: u64) -> LocalBuffer {
    let (mut buffer, mut random) = (LocalBuffer::new(0), random(seed));
    let rows = rows(buffer.records(), NODES);
    for row in rows.iter_mut() {
        *row = [0; RECORD].map(|_| random());
    }
    rows[NODES - 1] = rows[NODES - 2];
    buffer
}

/// `n` elements between these nodes, some with a node twice; the first is between the two nodes at the same place.
pub fn elements<const N: usize>(n: usize, seed: u64) -> Vec<[u16; N]> {
    let mut random = random(seed);
    let place = |node: usize| (RECORD * node) as u16;
    let mut all: Vec<[u16; N]> =
        (0..n).map(|_| [0; N].map(|_| place((random().abs() * (NODES - 1) as f64) as usize))).collect();
    if let Some(first) = all.first_mut() {
        *first = std::array::from_fn(|i| place(NODES - 1 - i % 2));
    }
    all
}
