//! Distances, derivatives and free ways of pairs of elements: what `.ci/check_contact.py` compares with `ipctk`.
//!
//! ```text
//! cargo run --release --example contact_pairs < PAIRS > RESULTS
//! ```
//!
//! Everything is little-endian `f64`. A pair is 29 of them: its kind (0 node-node, 1 node-edge, 2 node-triangle, 3
//! edge-edge), 12 coordinates of the nodes, 12 displacements, the thickness, the share of the gap that is to be left
//! and two lengths of edges at rest. A result is 29 as well: the distance, the places of the closest points on both
//! elements (a node's number; 100 + 10 a + b between nodes a and b; 200 inside the triangle), 12 derivatives, the free
//! share (2 where the whole way is free) and, of two edges, the mollifier and 12 derivatives of it, else 13 times 0.

use canopy_fem_engine::contact::distance::{PairKind, Place, nearest};
use canopy_fem_engine::contact::impact::{Approach, free_share};
use canopy_fem_engine::contact::parallel::Mollifier;
use nalgebra::Vector3;
use std::error::Error;
use std::io::{Read, Write};

/// Numbers of a pair.
const GIVEN: usize = 29;

fn kind(number: f64) -> Result<PairKind, Box<dyn Error>> {
    Ok(match number {
        0.0 => PairKind::NodeNode,
        1.0 => PairKind::NodeEdge,
        2.0 => PairKind::NodeTriangle,
        3.0 => PairKind::EdgeEdge,
        _ => return Err(format!("no kind of pair: {number}").into()),
    })
}

fn number_of(place: Place) -> f64 {
    match place {
        Place::Corner(node) => node as f64,
        Place::Side(from, to) => (100 + 10 * from + to) as f64,
        Place::Inside => 200.0,
    }
}

fn nodes(of: &[f64]) -> [Vector3<f64>; 4] {
    std::array::from_fn(|j| Vector3::from_column_slice(&of[3 * j..3 * j + 3]))
}

fn result(given: &[f64]) -> Result<Vec<f64>, Box<dyn Error>> {
    let (kind, x, d) = (kind(given[0])?, nodes(&given[1..13]), nodes(&given[13..25]));
    let found = nearest(kind, &x);
    let mut numbers = vec![found.distance, number_of(found.feature.first), number_of(found.feature.second)];
    numbers.extend(found.gradient().iter().flatten());
    let approach = Approach { kind, x, d, thickness: given[25] };
    numbers.push(free_share(&approach, given[26]).unwrap_or(2.0));
    if kind == PairKind::EdgeEdge {
        let mollifier = Mollifier::new(&x, [given[27], given[28]]);
        numbers.push(mollifier.value());
        numbers.extend(mollifier.gradient().iter().flatten());
    } else {
        numbers.extend([0.0; 13]);
    }
    Ok(numbers)
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut bytes = Vec::new();
    std::io::stdin().read_to_end(&mut bytes)?;
    let (words, rest) = bytes.as_chunks::<8>();
    let given: Vec<f64> = words.iter().map(|word| f64::from_le_bytes(*word)).collect();
    if !(rest.is_empty() && given.len().is_multiple_of(GIVEN)) {
        return Err(format!("{} bytes are no whole number of pairs of {} bytes", bytes.len(), 8 * GIVEN).into());
    }
    let mut out = Vec::with_capacity(bytes.len());
    for pair in given.chunks_exact(GIVEN) {
        for number in result(pair)? {
            out.extend_from_slice(&number.to_le_bytes());
        }
    }
    std::io::stdout().write_all(&out)?;
    Ok(())
}
