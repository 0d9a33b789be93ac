//! The examples run and show what they say.

#[path = "../../examples/cloth_by_hand.rs"]
mod cloth_by_hand;
#[path = "../../examples/compare_methods.rs"]
mod compare_methods;

#[path = "../../examples/own_bar_law.rs"]
mod own_bar_law;
#[path = "../../examples/own_force.rs"]
mod own_force;
#[path = "../../examples/own_observer.rs"]
mod own_observer;
#[path = "../../examples/own_scheme.rs"]
mod own_scheme;
#[path = "../../examples/reefing.rs"]
mod reefing;

/// The derivatives of the example are those of its force.
#[test]
fn the_derivatives_of_an_example_are_right() {
    let force = own_force::Tether { stiffness: 8.0, nodes: 3 };
    let x = [[0.1, 0.7, -0.4], [0.0, -1.2, 0.3], [2.0, 0.0, 0.0]];
    let found = canopy_fem::simulation::derivative_error(&force, 0.0, &x, &[[0.0; 3]; 3]);
    assert!(found.relative < 1e-8, "{found:?}");
}

/// A force, a law, a scheme and an observer from outside the crate give closed forms.
#[test]
fn what_a_program_adds_gives_closed_forms() {
    for (what, error, allowed) in [
        ("force", own_force::tethered("velocity-verlet").expect("it runs"), 2e-6),
        ("force with derivatives", own_force::tethered("newmark").expect("it runs"), 4e-6),
        ("reefing", reefing::reef().expect("it runs"), 1e-9),
        ("bar law", own_bar_law::cubic().expect("it runs"), 1e-4),
        ("scheme", own_scheme::drift_kick().expect("it runs"), 1e-4),
        ("observer", own_observer::compare_states().expect("it runs"), 1e-5),
    ] {
        assert!(error < allowed, "{what}: {error:e}");
    }
}

#[test]
fn the_methods_come_out_in_the_order_of_their_accuracy() {
    let errors: std::collections::BTreeMap<_, _> = compare_methods::compare().expect("it runs").into_iter().collect();
    // Orders 4, 2 and 1 at h = 0.01 s; Kang's filter is coarser still.
    assert!(errors["rk4"] < 1e-8, "{errors:?}");
    for second in ["velocity-verlet", "newmark", "hht", "generalized-alpha", "improved-euler"] {
        assert!(errors[second] > 1e-7 && errors[second] < 2e-3, "{second}: {errors:?}");
    }
    for first in ["explicit-euler", "euler-cromer", "backward-euler"] {
        assert!(errors[first] > 2e-3 && errors[first] < 0.1, "{first}: {errors:?}");
    }
}

#[test]
fn the_cloth_falls_and_the_ledger_closes() {
    let row = cloth_by_hand::swing().expect("it runs");
    let sum = row.kinetic + row.elastic + row.gravity + row.numerical;
    assert!(row.gravity < -0.05, "{row:?}");
    assert!(sum.abs() < 1e-12, "{row:?}");
}
