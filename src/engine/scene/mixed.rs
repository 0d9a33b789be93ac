//! The springs and membranes of a network as Newton's mixed iteration (`solve/mixed`) takes them.

use super::network::{Network, node_state};
use crate::assembly::{Assembler, MixedForm, MixedSystem, TangentSystem};
use crate::force::{SheetTerm, SpringTerm, TangentForm};
use crate::model::spring_state::{SheetState, SpringState};
use crate::model::state::StateRef;
use crate::model::system::Weights;

impl Network {
    fn spring_terms(&self) -> impl Iterator<Item = &dyn SpringTerm> {
        self.force_terms().filter_map(|term| term.springs())
    }

    /// Only where the tangent is symmetric: pressures that turn with the cloth are most of its change there, and the
    /// matrix of the iteration has their symmetric part alone.
    fn sheet_terms(&self) -> impl Iterator<Item = &dyn SheetTerm> {
        let symmetric = self.symmetric();
        self.force_terms().filter(move |_| symmetric).filter_map(|term| term.sheets())
    }
}

impl MixedSystem for Network {
    fn springs(&self) -> usize {
        self.spring_terms().map(SpringTerm::count).sum()
    }

    fn sheets(&self) -> usize {
        self.sheet_terms().map(SheetTerm::count).sum()
    }

    fn measure(&self, at: StateRef<'_>, cv: f64, out: &mut [SpringState]) {
        let mut rest = out;
        for term in self.spring_terms() {
            let Some((own, others)) = rest.split_at_mut_checked(term.count()) else { return };
            term.measure(node_state(at), cv, own);
            rest = others;
        }
    }

    fn measure_sheets(&self, at: StateRef<'_>, cv: f64, out: &mut [SheetState]) {
        let mut rest = out;
        for term in self.sheet_terms() {
            let Some((own, others)) = rest.split_at_mut_checked(term.count()) else { return };
            term.measure(node_state(at), cv, own);
            rest = others;
        }
    }

    fn assemble_mixed(&self, at: StateRef<'_>, w: Weights, form: MixedForm<'_>, assembler: &mut Assembler) {
        let MixedForm { springs, sheets, convex, symmetric, .. } = form;
        let form = TangentForm { convex, symmetric };
        let near = assembler.near.clone();
        let mut sink = assembler.sink(|dof| w.m * self.built.mass[dof / 3]);
        let (mut springs, mut sheets) = (springs, sheets);
        for term in self.force_terms() {
            let own_springs = term.springs().and_then(|own| Some((own, springs.split_off(..own.count())?)));
            let own_sheets = term.sheets().and_then(|own| Some((own, sheets.split_off(..own.count())?)));
            match (own_springs, own_sheets) {
                (Some((own, tangents)), _) => own.mixed_tangent(node_state(at), w, tangents, &mut sink),
                (_, Some((own, stresses))) => own.mixed_tangent(node_state(at), w, stresses, &mut sink),
                (None, None) => term.tangent(node_state(at), w, form, &mut sink),
            }
        }
        self.emit_law_tangents(at, w, form, &mut sink);
        self.emit_near(&near, (at, None), w, form, &mut sink);
    }
}
