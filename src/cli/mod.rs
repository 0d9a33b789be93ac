//! (see the files of this folder)

pub mod mesh;
