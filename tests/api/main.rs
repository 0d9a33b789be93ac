//! The library as a program that embeds it meets it, and what the house keeps of itself: its rules, its cases, its
//! README. What belongs where: `tests/README.md`.

mod adaptive;
mod architecture;
mod assets;
mod canopy;
mod case;
mod cavity;
#[path = "../common/mod.rs"]
mod common;
mod conjugate;
mod counters;
mod critical;
mod divergence;
mod door;
mod events;
mod examples;
mod filling;
mod globalised;
mod inflow;
mod linear;
mod materials;
mod mesh;
mod mesh_files;
mod mesh_groups;
mod mesh_statements;
mod mesh_table;
mod mesh_written;
mod modes;
mod multirate;
mod newton;
mod output;
mod overlap;
mod parachute;
mod readme;
mod roofs;
mod samples;
mod sew;
mod simulation;
mod stability;
mod step_block;
mod strategy;
mod study_report;
mod tangent;
mod threads;
mod values;
