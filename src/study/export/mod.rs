//! A run as an animation for programs of pictures: glTF 2.0 (.glb), or USD as text (.usda).
//!
//! The sides of triangles are left out, as pictures draw the triangles; all other edges are lines.

mod glb;
mod usda;

use crate::mesh::frames::{FrameFault, FrameReader};
use crate::plot::PlotError;
use crate::view::Recording;
use crate::view::recording::fault_of;
use crate::vtk::read::{Piece, named_array};
use clap::ValueEnum;

/// [-] Frames of an animation, if no number is given: a .glb has a shape of the whole scene for each.
pub const FRAMES: usize = 100;

/// The file of an animation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum AnimationFormat {
    /// glTF 2.0 in one binary file, for Blender and browsers
    Glb,
    /// USD as text, for Omniverse, Houdini and Blender
    Usda,
}

impl AnimationFormat {
    /// What the name of its files ends with.
    pub fn ending(self) -> &'static str {
        match self {
            AnimationFormat::Glb => "glb",
            AnimationFormat::Usda => "usda",
        }
    }
}

/// A scene at some times.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Animation {
    /// name of the case
    pub name: String,
    /// [s] one for each frame, ascending
    pub times: Vec<f64>,
    /// [m] positions of the nodes in each frame
    pub frames: Vec<Vec<[f64; 3]>>,
    /// the cloth
    pub triangles: Vec<[u32; 3]>,
    /// edges that are no sides of triangles
    pub lines: Vec<[u32; 2]>,
    /// nodes of a scene without cells
    pub dots: Vec<u32>,
    /// [-] frames that the run has
    pub listed: usize,
}

impl Animation {
    /// Reads at most so many frames of a run, at least two: every second, third, … of all, and the last. Those with
    /// positions that are not finite are left out.
    ///
    /// # Errors
    /// Frames that cannot be read, or of which none is finite.
    pub fn read(run: &Recording, most: usize) -> Result<Self, PlotError> {
        let listed = run.frames.len();
        let stride = listed.saturating_sub(1).div_ceil(most.max(2) - 1).max(1);
        let mut numbers: Vec<usize> = (0..listed).step_by(stride).collect();
        if numbers.last().is_some_and(|last| last + 1 < listed) {
            numbers.push(listed - 1);
        }
        let mut made = Self { name: run.name.clone(), listed, ..Self::default() };
        let mut reader = FrameReader::default();
        for number in numbers {
            let Some((t, place)) = run.frames.get(number) else { continue };
            let bad = |what: &str| fault_of(place, FrameFault::Content(what.to_owned()));
            let data = reader.read(place, &[]).map_err(|fault| fault_of(place, fault))?;
            let piece = data.pieces.into_iter().next().ok_or_else(|| bad("has no points"))?;
            if made.frames.is_empty() {
                made.take_cells(&piece).map_err(bad)?;
            } else if made.frames.first().is_some_and(|first| first.len() != piece.points.len()) {
                return Err(bad("has other points than the first frame of its list"));
            }
            // Times of an animation are in single precision.
            let later = made.times.last().is_none_or(|last| (*t as f32) > (*last as f32));
            if later && piece.points.iter().flatten().all(|x| (*x as f32).is_finite()) {
                made.times.push(*t);
                made.frames.push(piece.points);
            }
        }
        if made.frames.is_empty() {
            return Err(PlotError::NotThere(format!("{} has no frame with finite positions", run.folder.display())));
        }
        Ok(made)
    }

    /// The animation as a file.
    ///
    /// # Errors
    /// What the format does not hold, as the end of a sentence that begins with the name of the run.
    pub fn encode(&self, format: AnimationFormat) -> Result<Vec<u8>, String> {
        match format {
            AnimationFormat::Glb => glb::encode(self),
            AnimationFormat::Usda => Ok(usda::encode(self).into_bytes()),
        }
    }

    fn take_cells(&mut self, piece: &Piece) -> Result<(), &'static str> {
        (self.triangles, self.lines, self.dots) = (Vec::new(), Vec::new(), Vec::new());
        let kinds = named_array(&piece.cell_data, "kind").unwrap_or_default();
        for (cell, (_, corners)) in piece.cells.iter().enumerate() {
            let corner = |node: u64| u32::try_from(node).ok().filter(|node| (*node as usize) < piece.points.len());
            let nodes: Option<Vec<u32>> = corners.iter().map(|node| corner(*node)).collect();
            match nodes.ok_or("is damaged: a cell has a node that does not exist")?[..] {
                [a, b, c] => self.triangles.push([a, b, c]),
                // A side of a triangle.
                [_, _] if kinds.get(cell) == Some(&1.0) => {}
                [a, b] => self.lines.push([a, b]),
                [a] => self.dots.push(a),
                _ => return Err("is no frame of canopy-fem: its cells are not triangles and edges"),
            }
        }
        Ok(())
    }
}
