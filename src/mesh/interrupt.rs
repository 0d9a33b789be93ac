//! Requests to stop, for long work between two steps and within one: meshes, orderings, factorisations.
//!
//! Such work lies deep below what knows of signals. So a request is found through the thread that works, as times of
//! the start are ([`crate::startup`]). Without [`heeding`] none is ever made.

use std::cell::RefCell;
use std::rc::Rc;

/// Says whether to stop.
type Question = Rc<dyn Fn() -> bool>;

thread_local! {
    static QUESTION: RefCell<Option<Question>> = const { RefCell::new(None) };
}

/// Work that was asked to stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("interrupted")]
pub struct Interrupted;

/// Puts back what was asked before, after a panic too.
struct Before(Option<Question>);

impl Drop for Before {
    fn drop(&mut self) {
        QUESTION.with(|question| *question.borrow_mut() = self.0.take());
    }
}

/// Runs `work`, whose parts on this thread ask `asked` whether to stop. Once it has said so, it should go on to.
pub fn heeding<R>(asked: impl Fn() -> bool + 'static, work: impl FnOnce() -> R) -> R {
    let _before = Before(QUESTION.with(|question| question.borrow_mut().replace(Rc::new(asked))));
    work()
}

/// Whether the work of this thread must end.
pub fn asked() -> bool {
    let question = QUESTION.with(|question| question.borrow().clone());
    question.is_some_and(|asked| asked())
}

/// The same between two pieces of work.
///
/// # Errors
/// When it must.
pub fn check() -> Result<(), Interrupted> {
    if asked() { Err(Interrupted) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::{asked, heeding};

    /// A request counts inside only, and the one outside counts again after that, after a panic too.
    #[test]
    fn a_request_ends_with_its_work() {
        assert!(!asked());
        heeding(
            || true,
            || {
                assert!(asked());
                assert!(!heeding(|| false, asked));
                assert!(std::panic::catch_unwind(|| heeding(|| false, || panic!("within"))).is_err());
                assert!(asked());
            },
        );
        assert!(!asked());
    }
}
