//! A network's springs one by one, for schemes that go from spring to spring or from node to node.

use super::acting::SpringBatch;
use super::network::Network;
use crate::force::law::curve::CurveKind;
use crate::force::law::slack::Clamp;
use crate::model::forces::Role;
use crate::model::links::{Link, NoLinks, SpringLinks};
use crate::model::system::SpringGraph;

impl Network {
    /// Its springs, if a tension that grows with a constant stiffness describes each, and nothing joins all nodes.
    pub(super) fn find_links(&self) -> Result<&dyn SpringLinks, NoLinks> {
        let curved = |batch: &SpringBatch| batch.data.curve != CurveKind::Linear;
        match (self.acting.springs.iter().any(curved), self.acting.apparent.is_empty()) {
            (true, _) => Err(NoLinks::Curve),
            (_, false) => Err(NoLinks::ApparentMass),
            (false, true) => Ok(self),
        }
    }
}

/// Spring `i` of a batch whose rest lengths are `s` times those given.
fn link(batch: &SpringBatch, i: usize, s: f64) -> Link {
    let (data, nodes) = (&batch.data, batch.data.nodes[i]);
    if batch.cut.is_cut(i) {
        return Link { nodes, ..Link::NONE };
    }
    let (k, clamp, c) = (data.stiffness.at(i), Clamp::or_none(data.slack), batch.dashpot.at(i));
    let bound = |limit: f64| if limit.is_finite() { k * (limit - clamp.offset) } else { limit };
    Link {
        nodes,
        stiffness: k,
        rest: data.rest_length[i] * s + clamp.offset,
        least: bound(clamp.lower),
        most: bound(clamp.upper),
        axial: if batch.axial { c } else { 0.0 },
        relative: if batch.axial { 0.0 } else { c },
    }
}

impl SpringLinks for Network {
    fn count(&self) -> usize {
        self.acting.springs.iter().map(|batch| batch.data.nodes.len()).sum()
    }

    fn at(&self, t: f64, out: &mut [Link]) {
        let mut rest = out.iter_mut();
        for batch in &self.acting.springs {
            let s = batch.data.rest_scale_at(t);
            (0..batch.data.nodes.len()).zip(rest.by_ref()).for_each(|(i, out)| *out = link(batch, i, s));
        }
    }

    fn reeled(&self) -> bool {
        self.acting.springs.iter().any(|batch| batch.data.rest_scale.is_some())
    }

    fn rest_forces(&self) -> Option<Vec<f64>> {
        // Springs are the first terms, one a batch, and weight is a potential.
        let others = self.acting.terms.iter().skip(self.acting.springs.len());
        let weight = |role: Role| role == Role::Gravity;
        let only_weight = others.flat_map(|term| term.parts()).all(|part| weight(part.role));
        (only_weight && self.external.is_none()).then(|| self.weight())
    }
}
