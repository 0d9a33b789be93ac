//! Newton's iteration: what one costs, and which scenes it solves.
//!
//! ```text
//! cargo bench -p canopy-fem-benches --bench newton                  # the cost of an iteration and of a step
//! cargo bench -p canopy-fem-benches --bench newton -- sheets        # flat sheets that swing down
//! cargo bench -p canopy-fem-benches --bench newton -- flags         # flags in a wind
//! cargo bench -p canopy-fem-benches --bench newton -- statics       # equilibria of sheets and ropes
//! cargo bench -p canopy-fem-benches --bench newton -- random 200    # so many random networks, 2,000 if not given
//! cargo bench -p canopy-fem-benches --bench newton -- seed 17       # one of them: its case, and how it ends
//! cargo bench -p canopy-fem-benches --bench newton -- sheets --limit 20
//! ```
//!
//! A run is stopped after `--limit` seconds of processor time (60).

#[path = "../fixture/mod.rs"]
mod fixture;
mod iteration;
mod random;
mod row;
mod statics;
mod swings;

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    let number = || words.get(1).and_then(|word| word.parse().ok());
    match words.first().map(String::as_str) {
        Some("sheets") => swings::sheets(),
        Some("flags") => swings::flags(),
        Some("statics") => statics::table(),
        Some("random") => random::table(number().unwrap_or(2000)),
        Some("seed") => random::one(number().expect("seed wants a number")),
        _ => {
            iteration::benches();
            criterion::Criterion::default().configure_from_args().final_summary();
        }
    }
}
