//! A straight chain of edges.

use super::Mesh;
use super::source::{FaultSink, MAX_NODES, check_count};
use serde::{Deserialize, Serialize};

/// A straight line of equal edges without triangles; node 0 is at `from`, node `segments` at `to`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ChainParameters {
    /// [m] position of the first node
    pub from: [f64; 3],
    /// [m] position of the last node, not the same as `from`
    pub to: [f64; 3],
    /// [-] number of edges, at least 1
    #[cfg_attr(feature = "schema", schemars(range(min = 1)))]
    pub segments: usize,
}

impl ChainParameters {
    /// Reports every value out of range; `at` is the JSON pointer of this section.
    pub fn check(&self, at: &str, faults: FaultSink<'_>) {
        for (key, point) in [("from", self.from), ("to", self.to)] {
            if !point.iter().all(|c| c.is_finite()) {
                faults(&format!("{at}/{key}"), format!("{point:?}"), "finite numbers".into(), "give metres".into());
            }
        }
        if self.from == self.to {
            let hint = "move one end, a chain needs a length".to_owned();
            faults(&format!("{at}/to"), format!("{:?}", self.to), "another place than `from`".into(), hint);
        }
        check_count(at, "segments", self.segments, [1, MAX_NODES], faults);
    }

    /// Makes the mesh; the parameters must have passed [`ChainParameters::check`].
    pub fn build(&self) -> Mesh {
        let segments = self.segments.min(MAX_NODES) as u32;
        let point = |i: u32| {
            let s = f64::from(i) / f64::from(segments);
            // Weighted so that both ends are exact to the last bit.
            std::array::from_fn(|c| (1.0 - s) * self.from[c] + s * self.to[c])
        };
        let nodes = (0..=segments).map(point).collect();
        Mesh { nodes, edges: (0..segments).map(|i| [i, i + 1]).collect(), ..Mesh::default() }
    }
}
