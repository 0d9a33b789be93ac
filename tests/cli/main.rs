//! The built program as a user meets it: exit statuses, files, messages, runs that are interrupted and go on, studies,
//! pictures. What belongs where: `tests/README.md`.

mod adaptive;
mod advice;
mod bench;
mod check;
#[path = "../common/mod.rs"]
mod common;
mod contact;
mod doubts;
mod events;
mod export;
mod failures;
mod gauges;
mod gradient;
mod group_frames;
mod initial_from;
mod landing;
mod mass_scaling;
mod materials;
mod matrices;
mod membrane_gauges;
mod mesh;
mod mesh_look;
mod nets;
mod parachutes;
mod plot;
mod point;
mod record;
mod refusals;
mod report;
mod results;
mod resume;
mod roofs;
mod sewn;
mod shell;
mod stability;
mod stages;
mod statics;
mod stiffening;
mod study;
mod until_rest;
mod view;
mod vtkhdf;
mod worth;
