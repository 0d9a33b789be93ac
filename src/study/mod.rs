//! What accuracy costs on a scene: predictions from short trials.

pub mod trial;
