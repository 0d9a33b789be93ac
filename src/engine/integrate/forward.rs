//! What a scheme leaves to the implicit engine that solves its stages.

/// The methods of [`Integrator`](super::Integrator) that do in a scheme what they do in its field `engine`.
macro_rules! left_to_engine {
    () => {
        fn accept(&mut self) {
            self.engine.accept();
        }

        fn restart(&mut self, system: &(dyn TangentSystem + 'static), at: &Point) {
            self.engine.restart(system, at);
        }

        fn keep_over_change(&mut self, system: &(dyn TangentSystem + 'static), at: &Point) -> bool {
            self.engine.keep_over_change(system, at)
        }

        fn set_end(&mut self, end: f64) {
            self.engine.set_end(end);
        }

        fn drop_unsaved(&mut self) {
            self.engine.drop_unsaved();
        }

        fn save(&self) -> CarriedState {
            self.engine.save()
        }

        fn restore(&mut self, carried: &CarriedState) -> Result<(), StepError> {
            self.engine.restore(carried)
        }

        fn filter_error(
            &mut self,
            e: &mut [f64],
            system: &(dyn TangentSystem + 'static),
            counters: &mut Counters,
        ) -> Result<(), StepError> {
            self.engine.filter_error(e, system, counters)
        }

        fn dof_of_unknown(&self, unknown: usize) -> usize {
            self.engine.dof_of_unknown(unknown)
        }

        fn linear_stats(&self) -> Option<LinearStats> {
            self.engine.linear_stats()
        }
    };
}
pub(super) use left_to_engine;
