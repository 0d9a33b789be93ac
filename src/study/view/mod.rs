//! A run as one page that needs nothing else: the scene in 3D over its frames, and its gauges.
//!
//! `recording` finds the frames of a folder, `scene` takes what they share from the first of them, `packed` makes
//! a few bytes of each, `curves` reads the gauges, and `page` puts all of it into one file, or into the answers of
//! a server while a run goes on. The page itself is `templates/view`: plain WebGL2, no library. A library for 3D would
//! bring 700 kB to each page for cameras, materials and loaders, and still need every shader here: positions and values
//! are read from textures, so that a frame costs two uploads and no loop over nodes.

mod curves;
mod packed;
pub mod page;
pub mod recording;
mod scene;

pub use page::{page, part};
pub use recording::Recording;
