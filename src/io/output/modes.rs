//! Vibration modes: `modes.csv`, and a collection of shapes in the folder `modes`.

use super::atomic::{Durability, replace};
use super::csv::write_fault;
use super::files::FilesSpec;
use super::folder::{FolderError, MODES, MODES_FOLDER, ResultFolder};
use super::frame::{Fields, Frame, FrameSize};
use super::frame_files::FrameFiles;
use super::pvd::Collection;
use super::recorder::RecorderSpec;
use crate::analysis::lowest::LowMode;
use crate::drive::observer::ObserveError;
use crate::model::point::Point;
use crate::model::state::State;
use crate::scene::Scene;
use std::fmt::Write as _;

/// Why modes cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum ModesWriteError {
    /// Their folder cannot be used.
    #[error(transparent)]
    Folder(#[from] FolderError),
    /// They cannot be written.
    #[error(transparent)]
    Observe(#[from] ObserveError),
}

/// [-] Largest displacement of a drawn shape, as a share of the scene's size.
const DRAWN: f64 = 0.2;

/// Writes the modes about a state. `mass_x`, `mass_y`, `mass_z` [kg] is what moves in a mode if a support shakes along
/// an axis (effective modal mass); `frequency` is in Hz, `omega_squared` and its `error` in 1/s^2, `growth` in 1/s. The
/// collection has a frame for each mode, whose time is its number; `displacement` is its shape. Without modes those of
/// an earlier search are removed.
///
/// # Errors
/// When they cannot be written, or earlier ones are in the way.
pub fn write_modes(
    scene: &dyn Scene,
    spec: &RecorderSpec,
    at: &Point,
    modes: &[LowMode],
    replaces: bool,
) -> Result<(), ModesWriteError> {
    let dir = spec.out_dir.join(MODES_FOLDER);
    if modes.is_empty() && !dir.exists() {
        return Ok(());
    }
    let folder = ResultFolder::prepare(&dir, &spec.name, replaces)?;
    if modes.is_empty() {
        // Fails, as it should, if there are other files in it.
        let _ = std::fs::remove_dir(dir);
        return Ok(());
    }
    let table = spec.out_dir.join(MODES);
    replace(&table, rows(scene, modes).as_bytes(), Durability::Synced).map_err(|e| write_fault(&table, e))?;
    let n = scene.reference().len();
    let mut frame = Frame::new(FrameSize { nodes: n, ..FrameSize::default() });
    scene.trace(at.state.as_ref(), &mut frame.positions, &mut frame.velocities);
    let reference = frame.positions.clone();
    let mut files = FrameFiles::create(&FilesSpec {
        folder: dir,
        stem: folder.stem().to_owned(),
        reference: &reference,
        triangles: scene.triangles(),
        edges: scene.edges(),
        groups: scene.groups(),
        fields: Fields::default(),
        draw_sides: spec.edges,
        probes: &[],
        gauges: Vec::new(),
        format: spec.format,
    })?;
    let mut collection = Collection::new(&folder.file(&format!("{}.pvd", folder.stem())));
    let size = if scene.size() > 0.0 { scene.size() } else { 1.0 };
    let mut state = State::clone(&at.state);
    for (number, mode) in (0_u32..).zip(modes) {
        let largest = mode.shape.get(mode.dof).map_or(1.0, |x| x.abs()).max(f64::MIN_POSITIVE);
        for ((to, x), shape) in state.x.iter_mut().zip(&at.state.x).zip(&mode.shape) {
            *to = x + DRAWN * size / largest * shape;
        }
        frame.time = f64::from(number + 1);
        scene.trace(state.as_ref(), &mut frame.positions, &mut frame.velocities);
        collection.push(frame.time, &files.write(&frame, u64::from(number))?);
    }
    Ok(collection.write(Durability::Synced)?)
}

fn rows(scene: &dyn Scene, modes: &[LowMode]) -> String {
    let mut text = "mode,frequency,omega_squared,node,axis,mass_x,mass_y,mass_z,growth,error\n".to_owned();
    let mut momentum = vec![0.0; scene.n_dof()];
    for (number, mode) in modes.iter().enumerate() {
        scene.mass_times(&mode.shape, &mut momentum);
        let mut sums = [0.0; 3];
        for (dof, p) in momentum.iter().enumerate() {
            let axis = ["x", "y", "z"].iter().position(|axis| *axis == scene.name_of(dof).1);
            sums.iter_mut().enumerate().filter(|(i, _)| Some(*i) == axis).for_each(|(_, sum)| *sum += p);
        }
        let [x, y, z] = sums.map(|sum| sum * sum);
        let (node, axis) = scene.name_of(mode.dof);
        let (frequency, square) = (mode.frequency(), mode.omega_squared);
        let (growth, error) = (mode.growth(), mode.error);
        let _ = writeln!(
            text,
            "{},{frequency:?},{square:?},{node},{axis},{x:?},{y:?},{z:?},{growth:?},{error:?}",
            number + 1
        );
    }
    text
}
