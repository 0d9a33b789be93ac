//! The .vtu files of a run.

use std::fs::{self, OpenOptions};
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};

use super::atomic::{Durability, replace_by, sync_folder};
use super::csv::write_fault;
use super::files::{FRAMES, FilesSpec};
use super::frame::{CellMap, Fields, Frame, SIDE};
use super::resume::ResumeError;
use crate::drive::observer::ObserveError;
use crate::mesh::group::{GroupNumbers, KIND};
use crate::model::observables::MembranePicture;
use crate::vtk::write::{Array, Cells, FixedArrays, Snapshot, Values, VtuError, VtuWriter};

/// The cell array by which VTK leaves cells out of pictures; they are cells as before to all that reads the file.
/// Source: `vtkDataSetAttributes::GhostArrayName` and its `HIDDENCELL`.
const VTK_GHOSTS: &str = "vtkGhostType";
const HIDDEN_CELL: u8 = 32;

/// Writes frames one by one; each is complete before it gets its final name.
#[derive(Debug)]
pub(crate) struct FrameFiles {
    folder: PathBuf,
    stem: String,
    vtu: VtuWriter,
    map: CellMap,
    fields: Fields,
    reference: Vec<[f64; 3]>,
    displacement: Vec<[f64; 3]>,
    tension: Vec<f64>,
    strain: Vec<f64>,
    rest_length: Vec<f64>,
    pressure: Vec<f64>,
    crossing: Vec<u8>,
    membranes: MembraneArrays,
    /// number of the first frame that may not be on the disk yet
    unsynced: u64,
}

/// The name of a frame.
fn name_of(stem: &str, number: u64) -> String {
    format!("{stem}_{number:06}.vtu")
}

/// The number in the name of a frame; `None` for any other name.
pub(crate) fn number_of(stem: &str, name: &str) -> Option<u64> {
    let digits = name.strip_prefix(stem)?.strip_prefix('_')?.strip_suffix(".vtu")?;
    let number = digits.bytes().all(|b| b.is_ascii_digit()).then(|| digits.parse().ok())??;
    (name_of(stem, number) == name).then_some(number)
}

impl FrameFiles {
    /// Creates the folder.
    ///
    /// # Errors
    /// When it cannot be created, or a cell names a node that does not exist.
    pub(crate) fn create(spec: &FilesSpec<'_>) -> Result<Self, ObserveError> {
        let folder = spec.folder.join(FRAMES);
        fs::create_dir_all(&folder).map_err(|e| write_fault(&folder, e))?;
        let cells = Cells { points: spec.reference.len(), triangles: spec.triangles, edges: spec.edges };
        let fault = |e| write_fault(&folder, vtu_error(e));
        let vtu = VtuWriter::new(&cells, spec.format).map_err(fault)?;
        let map = CellMap::new(spec.triangles, spec.edges, vtu.cells());
        let vtu = name_parts(vtu, spec, &map).map_err(fault)?;
        Ok(Self {
            map,
            folder,
            stem: spec.stem.clone(),
            vtu,
            fields: spec.fields,
            reference: spec.reference.to_vec(),
            displacement: vec![[0.0; 3]; spec.reference.len()],
            tension: Vec::new(),
            strain: Vec::new(),
            rest_length: Vec::new(),
            pressure: Vec::new(),
            crossing: Vec::new(),
            membranes: MembraneArrays::default(),
            unsynced: 0,
        })
    }

    /// Continues after `frames` frames of an earlier run; later ones are removed.
    ///
    /// # Errors
    /// As [`FrameFiles::create`], and when a frame cannot be removed.
    pub(crate) fn reopen(spec: &FilesSpec<'_>, frames: u64) -> Result<Self, ObserveError> {
        let mut made = Self::create(spec)?;
        made.unsynced = frames;
        let folder = &made.folder;
        for path in frames_in(folder, &spec.stem).map_err(|e| write_fault(folder, e))? {
            let number = path.file_name().and_then(|name| number_of(&spec.stem, name.to_str()?));
            // Without a number it is the temporary file of a frame that was being written when the run was killed.
            if number.is_none_or(|number| number >= frames) {
                fs::remove_file(&path).map_err(|e| write_fault(&path, e))?;
            }
        }
        Ok(made)
    }

    /// Checks that the first `frames` frames exist.
    ///
    /// # Errors
    /// The first missing frame.
    pub(crate) fn check(spec: &FilesSpec<'_>, frames: u64) -> Result<(), ResumeError> {
        let folder = spec.folder.join(FRAMES);
        for number in 0..frames {
            let path = folder.join(name_of(&spec.stem, number));
            match fs::symlink_metadata(&path) {
                Ok(there) if there.is_file() => {}
                Ok(_) => return Err(ResumeError::NoFile { path: path.display().to_string() }),
                Err(e) if e.kind() == io::ErrorKind::NotFound => {
                    return Err(ResumeError::Missing { path: path.display().to_string() });
                }
                Err(e) => return Err(ResumeError::system(&path, e)),
            }
        }
        Ok(())
    }

    /// Writes frame `number`; returns its path from the folder of the results.
    ///
    /// # Errors
    /// Errors of the system; the frame then does not exist.
    pub(crate) fn write(&mut self, frame: &Frame, number: u64) -> Result<String, ObserveError> {
        let name = name_of(&self.stem, number);
        let path = self.folder.join(&name);
        self.prepare(frame);
        let vectors = |name, values| Array { name, values: Values::Vectors(values) };
        let scalars = |name, values| Array { name, values: Values::Scalars(values) };
        let Fields { force, reaction, tension, strain, rest_length, pressure, membrane, crossing } = self.fields;
        let points = [
            (true, vectors("displacement", &self.displacement)),
            (true, vectors("velocity", &frame.velocities)),
            (force, vectors("force", &frame.force)),
            (reaction, vectors("reaction", &frame.reaction)),
        ];
        let cells = [
            (tension, scalars("tension", &self.tension)),
            (strain, scalars("strain", &self.strain)),
            (rest_length, scalars("rest_length", &self.rest_length)),
            (pressure, scalars("pressure", &self.pressure)),
            (membrane, scalars("stress_1", &self.membranes.scalars[0])),
            (membrane, scalars("stress_2", &self.membranes.scalars[1])),
            (membrane, scalars("strain_1", &self.membranes.scalars[2])),
            (membrane, scalars("strain_2", &self.membranes.scalars[3])),
            (membrane, scalars("wrinkling", &self.membranes.scalars[4])),
            (membrane, vectors("warp", &self.membranes.warp)),
            (crossing, Array { name: "crossing", values: Values::Flags(&self.crossing) }),
        ];
        let picture = Snapshot {
            time: Some(frame.time),
            points: &frame.positions,
            point_data: &asked_for(&points),
            cell_data: &asked_for(&cells),
        };
        let vtu = &mut self.vtu;
        replace_by(&path, Durability::Visible, |file| vtu.write(&picture, file).map_err(vtu_error))
            .map_err(|e| write_fault(&path, e))?;
        Ok(format!("{FRAMES}/{name}"))
    }

    /// Removes frames by their numbers.
    pub(crate) fn remove(&mut self, frames: Range<u64>) -> Result<(), ObserveError> {
        self.unsynced = self.unsynced.min(frames.start);
        for number in frames {
            let path = self.folder.join(name_of(&self.stem, number));
            match fs::remove_file(&path) {
                Err(e) if e.kind() != io::ErrorKind::NotFound => return Err(write_fault(&path, e)),
                _ => {}
            }
        }
        Ok(())
    }

    /// Makes the frames before number `frames` durable.
    pub(crate) fn sync(&mut self, frames: u64) -> Result<(), ObserveError> {
        for number in self.unsynced..frames {
            let path = self.folder.join(name_of(&self.stem, number));
            match OpenOptions::new().write(true).open(&path).and_then(|file| file.sync_all()) {
                // The user has removed it; a resumed run will report that.
                Err(e) if e.kind() == io::ErrorKind::NotFound => {}
                done => done.map_err(|e| write_fault(&path, e))?,
            }
        }
        if self.unsynced < frames {
            sync_folder(&self.folder);
            self.unsynced = frames;
        }
        Ok(())
    }

    fn prepare(&mut self, frame: &Frame) {
        let moved = frame.positions.as_flattened().iter().zip(self.reference.as_flattened());
        for (d, (x, x0)) in self.displacement.as_flattened_mut().iter_mut().zip(moved) {
            *d = x - x0;
        }
        if self.fields.tension {
            self.map.spread(&frame.tension, &mut self.tension);
        }
        if self.fields.strain {
            self.map.spread(&frame.strain, &mut self.strain);
        }
        if self.fields.rest_length {
            self.map.of_edges(&frame.rest_length, &mut self.rest_length);
        }
        if self.fields.pressure {
            self.map.of_triangles(&frame.pressure, &mut self.pressure);
        }
        if self.fields.crossing {
            self.map.of_triangles(&frame.crossing, &mut self.crossing);
        }
        if self.fields.membrane {
            self.membranes.fill(&frame.membrane, self.vtu.cells());
        }
    }
}

/// Cell arrays of membranes.
#[derive(Debug, Default)]
struct MembraneArrays {
    /// principal stresses, principal strains, wrinkling
    scalars: [Vec<f64>; 5],
    warp: Vec<[f64; 3]>,
}

impl MembraneArrays {
    /// Of the triangles, which come first among so many cells; all others have no membrane.
    fn fill(&mut self, triangles: &[MembranePicture], cells: usize) {
        let all = || triangles.iter().copied().chain(std::iter::repeat(MembranePicture::default())).take(cells);
        for (i, scalars) in self.scalars.iter_mut().enumerate() {
            scalars.clear();
            scalars.extend(all().map(|MembranePicture { stress: [s1, s2], strain: [e1, e2], wrinkling, .. }| {
                [s1, s2, e1, e2, wrinkling][i]
            }));
        }
        self.warp.clear();
        self.warp.extend(all().map(|of| of.warp));
    }
}

/// Adds what tells the parts of a scene apart: kinds of cells, and in a scene with groups their numbers and where the
/// nodes are on the mesh.
fn name_parts(vtu: VtuWriter, spec: &FilesSpec<'_>, map: &CellMap) -> Result<VtuWriter, VtuError> {
    let kinds = map.kinds();
    let hide = |kind: &u8| if *kind == SIDE { HIDDEN_CELL } else { 0 };
    let hidden: Option<Vec<u8>> = kinds.as_ref().filter(|_| !spec.draw_sides).map(|k| k.iter().map(hide).collect());
    let flags = [(KIND, kinds.as_deref()), (VTK_GHOSTS, hidden.as_deref())];
    let flags: Vec<(&str, &[u8])> = flags.into_iter().filter_map(|(name, of)| Some((name, of?))).collect();
    let groups = GroupNumbers::new(spec.groups, [spec.reference.len(), spec.triangles.len(), spec.edges.len()]);
    let named = FixedArrays { cell_flags: &flags, ..FixedArrays::default() };
    if spec.groups.is_empty() {
        return vtu.with_fixed(&named);
    }
    vtu.with_fixed(&FixedArrays {
        point_vectors: Some(("reference_position", spec.reference)),
        point_numbers: groups.point_array(),
        cell_numbers: groups.cell_array(),
        field: &groups.field_arrays(),
        ..named
    })
}

/// The frames of one run in a folder, also the part of one that was never finished.
pub(crate) fn frames_in(folder: &Path, stem: &str) -> Result<Vec<PathBuf>, io::Error> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = entry.file_name();
        let Some(name) = name.to_str() else { continue };
        let whole = name.strip_prefix('.').and_then(|rest| rest.strip_suffix(".part")).unwrap_or(name);
        let is_folder = entry.file_type().is_ok_and(|kind| kind.is_dir());
        if !is_folder && number_of(stem, whole).is_some() {
            found.push(entry.path());
        }
    }
    found.sort();
    Ok(found)
}

fn asked_for<'a>(arrays: &[(bool, Array<'a>)]) -> Vec<Array<'a>> {
    arrays.iter().filter(|(on, _)| *on).map(|(_, array)| *array).collect()
}

fn vtu_error(fault: VtuError) -> io::Error {
    match fault {
        VtuError::Write(source) => source,
        other => io::Error::new(io::ErrorKind::InvalidInput, other),
    }
}
