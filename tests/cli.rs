//! The built program as a user meets it: exit statuses, files, messages.

#[path = "cli/adaptive.rs"]
mod adaptive;
#[path = "cli/advice.rs"]
mod advice;
#[path = "cli/bench.rs"]
mod bench;
#[path = "cli/check.rs"]
mod check;
#[path = "cli/doubts.rs"]
mod doubts;
#[path = "cli/failures.rs"]
mod failures;
#[path = "cli/matrices.rs"]
mod matrices;
#[path = "support/read_vtu.rs"]
#[allow(dead_code)] // the arrays' names are of no interest here
mod read_vtu;
#[path = "cli/refusals.rs"]
mod refusals;
#[path = "cli/results.rs"]
mod results;
#[path = "cli/stability.rs"]
mod stability;
#[path = "cli/stiffening.rs"]
mod stiffening;
