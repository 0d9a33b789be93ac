//! Claim, measured, tolerance: what the program promises of its schemes, forces and systems, each against a closed form
//! or an independent computation, printed as one table.
//!
//! ```text
//! cargo test --release --test claims                 # all groups
//! cargo test --release --test claims -- pendulum     # groups whose name contains a word
//! ```
//!
//! A group is a file with `pub fn claims() -> Vec<Claim>` and a line in [`GROUPS`]. Tolerances stand beside the claims
//! with what explains them: the order of the scheme, the size of the elements, rounding.

mod bars;
mod catenary;
mod cavity;
mod chain;
mod claim;
#[path = "../common/mod.rs"]
mod common;
mod contact;
mod descents;
mod dissipation;
mod elastic_pendulum;
mod elastica;
mod energy_ledger;
mod energy_momentum;
mod energy_numerical;
mod energy_oscillator;
mod equilibrium;
mod events;
mod forces;
mod free_fall;
mod glide;
mod hanging_chain;
mod hencky;
mod inflated;
mod kang;
mod lattice;
mod linear_theory;
mod linearised;
mod membrane;
mod motion;
mod net;
mod newton_cases;
mod newton_rate;
mod one_mass;
mod order;
mod oscillator;
mod parachute;
mod pendulum;
mod recurrence;
mod reeling;
mod rich_net;
mod rich_power;
mod rich_sheet;
mod rigid_payload;
mod sheets;
mod signal;
mod spectra;
mod spring_pendulum;
mod tables;
mod thesis;
mod tolerance;
mod waves;
mod wrinkles;

use claim::{Claim, table};
use rayon::prelude::*;
use std::panic::catch_unwind;
use std::process::ExitCode;

type Group = (&'static str, fn() -> Vec<Claim>);

/// All groups in the order they are printed.
const GROUPS: &[Group] = &[
    ("order", order::claims),
    ("loads over time", tables::claims),
    ("recurrence", recurrence::claims),
    ("spectra", spectra::claims),
    ("energy of an oscillator", energy_oscillator::claims),
    ("energy lost by a scheme", energy_numerical::claims),
    ("energy ledger", energy_ledger::claims),
    ("energy-momentum", energy_momentum::claims),
    ("dissipation of an oscillator", dissipation::claims),
    ("tolerance of the pendulum", tolerance::pendulum),
    ("tolerance of a cloth", tolerance::cloth),
    ("newton", newton_rate::claims),
    ("oscillator", oscillator::claims),
    ("pendulum", pendulum::claims),
    ("spring pendulum", spring_pendulum::claims),
    ("double pendulum", hanging_chain::double_pendulum),
    ("hanging chain", hanging_chain::claims),
    ("catenary", catenary::claims),
    ("equilibrium", equilibrium::claims),
    ("dispersion of a chain", waves::dispersion),
    ("wave speed of a chain", waves::speed),
    ("dispersion of a triangular net", net::claims),
    ("prestressed membrane", membrane::claims),
    ("hencky membrane", hencky::claims),
    ("membranes of constant strain", sheets::claims),
    ("wrinkled membranes", wrinkles::claims),
    ("membranes, bars and bending in motion", rich_sheet::claims),
    ("bars that are not linear", bars::claims),
    ("elastica", elastica::claims),
    ("elastic pendulum", elastic_pendulum::claims),
    ("force laws", forces::claims),
    ("free fall through air", free_fall::claims),
    ("glide", glide::claims),
    ("Taylor's parachute", inflated::taylor),
    ("Taylor's parachute by static", inflated::taylor_static),
    ("reefed parachute", inflated::reefed),
    ("Mylar balloon", inflated::balloon),
    ("rigid payload, free", rigid_payload::claims),
    ("parachute, steady", parachute::claims),
    ("parachutes of the field, steady", descents::claims),
    ("C-9 in a free stream", descents::free_stream),
    ("parachute, falls", parachute::falls),
    ("parachute, opening", parachute::opening),
    ("parachute, apparent mass", parachute::apparent_mass),
    ("parachute, balance of a cavity", cavity::balance),
    ("parachute, cavity that fills", cavity::filling),
    ("parachute, line in a cross wind", parachute::line),
    ("events", events::claims),
    ("moving supports and bases", motion::claims),
    ("winches and reefing", reeling::claims),
    ("contact of a mass, slopes", contact::mass::slopes),
    ("contact of a mass, bounces", contact::mass::bounces),
    ("contact of a mass, orders", contact::order::smooth),
    ("contact of a mass, orders with friction", contact::order::with_friction),
    ("contact, loads on what is touched", contact::load::claims),
    ("contact, explicit steps", contact::limit::claims),
    ("contact of a line, capstan", contact::capstan::claims),
    ("contact of a line, edge of a table", contact::chain::edges),
    ("contact of a line, scale", contact::chain::scale),
    ("contact of a tube with plates", contact::tube::claims),
    ("contact of sheets that meet", contact::sheets::meetings),
    ("contact that nothing reaches", contact::sheets::bits),
    ("contact on threads", contact::sheets::threads),
    ("kang", kang::claims),
    ("table 4 of the thesis", thesis::table_4),
    ("remarks of the thesis", thesis::remarks),
];

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    let chosen: Vec<&Group> = GROUPS.iter().filter(|g| words.iter().all(|w| g.0.contains(w.as_str()))).collect();
    // Long groups must not wait behind each other, whatever their order in the table.
    let results: Vec<_> =
        chosen.par_iter().with_max_len(1).map(|(name, claims)| (*name, catch_unwind(claims))).collect();
    if chosen.is_empty() {
        println!("no group of claims is named by all of {words:?}");
        return ExitCode::FAILURE;
    }
    let (mut held, mut missed) = (0, Vec::new());
    for (name, result) in &results {
        match result {
            Ok(claims) => {
                print!("{}", table(name, claims));
                held += claims.iter().filter(|c| c.holds()).count();
                missed.extend(claims.iter().filter(|c| !c.holds()).map(|c| format!("{name}: {}", c.what)));
            }
            Err(_) => missed.push(format!("{name}: ended in a panic, printed above")),
        }
    }
    println!("\n{held} claims hold, {} missed", missed.len());
    missed.iter().for_each(|m| println!("  missed: {m}"));
    if missed.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
