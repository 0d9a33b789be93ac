//! The springs of a network as Newton's mixed iteration (`solve/mixed`) takes them.

use super::network::{Network, node_state};
use crate::assembly::{Assembler, MixedForm, MixedSystem};
use crate::force::{SpringTerm, TangentForm};
use crate::model::spring_state::SpringState;
use crate::model::state::StateRef;
use crate::model::system::Weights;

impl Network {
    fn spring_terms(&self) -> impl Iterator<Item = &dyn SpringTerm> {
        self.force_terms().filter_map(|term| term.springs())
    }
}

impl MixedSystem for Network {
    fn springs(&self) -> usize {
        self.spring_terms().map(SpringTerm::count).sum()
    }

    fn measure(&self, at: StateRef<'_>, cv: f64, out: &mut [SpringState]) {
        let mut rest = out;
        for term in self.spring_terms() {
            let Some((own, others)) = rest.split_at_mut_checked(term.count()) else { return };
            term.measure(node_state(at), cv, own);
            rest = others;
        }
    }

    fn assemble_mixed(&self, at: StateRef<'_>, w: Weights, form: MixedForm<'_>, assembler: &mut Assembler) {
        let MixedForm { springs, convex, symmetric } = form;
        let form = TangentForm { convex, symmetric };
        let mut sink = assembler.sink(|dof| w.m * self.built.mass[dof / 3]);
        let mut rest = springs;
        for term in self.force_terms() {
            match term.springs().and_then(|springs| Some((springs, rest.split_at_checked(springs.count())?))) {
                Some((springs, (own, others))) => {
                    springs.mixed_tangent(node_state(at), w, own, &mut sink);
                    rest = others;
                }
                None => term.tangent(node_state(at), w, form, &mut sink),
            }
        }
        self.emit_law_tangents(at, w, form, &mut sink);
    }
}
