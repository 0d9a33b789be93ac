//! The files of a run, as the writing thread sees them.

use std::fs::{self, File};
use std::path::{Path, PathBuf};

use super::csv::write_fault;
use super::encode::VtuFormat;
use super::frame::{CellMap, Fields, Frame};
use super::history::{History, HistoryRow};
use super::probes::{Probe, Probes};
use super::pvd::Collection;
use super::vtu::{Array, Cells, Snapshot, Values, VtuError, VtuWriter};
use crate::drive::observer::ObserveError;

/// Folder of the frames, beside the .pvd.
pub const FRAMES: &str = "frames";
/// A row a step, or every n.
pub const HISTORY: &str = "history.csv";
/// Chosen nodes at each frame time.
pub const PROBES: &str = "probes.csv";

/// What the writing thread must know of the run; everything in the user's numbering.
#[derive(Clone, Debug)]
pub struct FilesSpec<'a> {
    /// folder of the results
    pub folder: PathBuf,
    /// stem of the .pvd and the frames, see [`super::names::file_stem`]
    pub stem: String,
    /// [m] positions displacements count from
    pub reference: &'a [[f64; 3]],
    /// triangles of the picture
    pub triangles: &'a [[u32; 3]],
    /// edges of the picture
    pub edges: &'a [[u32; 2]],
    /// fields that are shown
    pub fields: Fields,
    /// nodes to follow; `probes.csv` is written only if there are any
    pub probes: &'a [Probe],
    /// spelling of the frames' arrays
    pub format: VtuFormat,
}

/// The open files of a run.
#[derive(Debug)]
pub struct ResultFiles {
    frames: FrameFiles,
    collection: Collection,
    history: History,
    probes: Option<Probes>,
}

impl ResultFiles {
    /// Creates `history.csv`, `probes.csv` if there are probes, and the frames' folder.
    ///
    /// # Errors
    /// When something cannot be created, or a cell names a node that is not there.
    pub fn create(spec: &FilesSpec<'_>) -> Result<Self, ObserveError> {
        let path = |name: &str| spec.folder.join(name);
        let frames = FrameFiles::create(spec)?;
        let probes = (!spec.probes.is_empty()).then(|| Probes::create(&path(PROBES), spec.probes)).transpose()?;
        Ok(Self {
            frames,
            collection: Collection::new(&path(&format!("{}.pvd", spec.stem))),
            history: History::create(&path(HISTORY))?,
            probes,
        })
    }

    /// Writes a frame, its probes, and then shows it in the collection.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn frame(&mut self, frame: &Frame) -> Result<(), ObserveError> {
        let file = self.frames.write(frame, self.collection.frames())?;
        if let Some(probes) = &mut self.probes {
            probes.push(frame)?;
        }
        self.collection.push(frame.time, &file);
        self.collection.write_if_due()
    }

    /// Appends a row to the history.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn row(&mut self, row: &HistoryRow) -> Result<(), ObserveError> {
        self.history.push(row)
    }

    /// Hands over lines and frames that have waited long enough.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn flush_if_due(&mut self) -> Result<(), ObserveError> {
        self.history.file().flush_if_due()?;
        if let Some(probes) = &mut self.probes {
            probes.file().flush_if_due()?;
        }
        self.collection.write_if_due()
    }

    /// Hands over everything.
    ///
    /// # Errors
    /// When the system refuses; all files are tried, the first fault is told.
    pub fn finish(&mut self) -> Result<(), ObserveError> {
        let history = self.history.file().flush();
        let probes = self.probes.as_mut().map_or(Ok(()), |probes| probes.file().flush());
        let collection = if self.collection.frames() > 0 { self.collection.write() } else { Ok(()) };
        history.and(probes).and(collection)
    }
}

/// The .vtu files.
#[derive(Debug)]
struct FrameFiles {
    folder: PathBuf,
    stem: String,
    vtu: VtuWriter,
    map: CellMap,
    fields: Fields,
    reference: Vec<[f64; 3]>,
    displacement: Vec<[f64; 3]>,
    tension: Vec<f64>,
    strain: Vec<f64>,
}

impl FrameFiles {
    fn create(spec: &FilesSpec<'_>) -> Result<Self, ObserveError> {
        let folder = spec.folder.join(FRAMES);
        fs::create_dir_all(&folder).map_err(|e| write_fault(&folder, e))?;
        let cells = Cells { points: spec.reference.len(), triangles: spec.triangles, edges: spec.edges };
        let vtu = VtuWriter::new(&cells, spec.format).map_err(|e| vtu_fault(&folder, e))?;
        Ok(Self {
            map: CellMap::new(spec.triangles, spec.edges, vtu.cells()),
            folder,
            stem: spec.stem.clone(),
            vtu,
            fields: spec.fields,
            reference: spec.reference.to_vec(),
            displacement: Vec::with_capacity(spec.reference.len()),
            tension: Vec::new(),
            strain: Vec::new(),
        })
    }

    /// Writes frame `number`; returns its path from the folder of the results.
    fn write(&mut self, frame: &Frame, number: usize) -> Result<String, ObserveError> {
        let name = format!("{}_{number:06}.vtu", self.stem);
        let path = self.folder.join(&name);
        self.prepare(frame);
        let mut file = File::create(&path).map_err(|e| write_fault(&path, e))?;
        let vectors = |name, values| Array { name, values: Values::Vectors(values) };
        let scalars = |name, values| Array { name, values: Values::Scalars(values) };
        let Fields { force, reaction, tension, strain } = self.fields;
        let points = [
            (true, vectors("displacement", &self.displacement)),
            (true, vectors("velocity", &frame.velocities)),
            (force, vectors("force", &frame.force)),
            (reaction, vectors("reaction", &frame.reaction)),
        ];
        let cells = [(tension, scalars("tension", &self.tension)), (strain, scalars("strain", &self.strain))];
        let picture = Snapshot {
            time: Some(frame.time),
            points: &frame.positions,
            point_data: &asked_for(&points),
            cell_data: &asked_for(&cells),
        };
        self.vtu.write(&picture, &mut file).map_err(|e| vtu_fault(&path, e))?;
        Ok(format!("{FRAMES}/{name}"))
    }

    fn prepare(&mut self, frame: &Frame) {
        self.displacement.clear();
        let moved = frame.positions.iter().zip(&self.reference);
        self.displacement.extend(moved.map(|(x, x0)| [x[0] - x0[0], x[1] - x0[1], x[2] - x0[2]]));
        if self.fields.tension {
            self.map.spread(&frame.tension, &mut self.tension);
        }
        if self.fields.strain {
            self.map.spread(&frame.strain, &mut self.strain);
        }
    }
}

fn asked_for<'a>(arrays: &[(bool, Array<'a>)]) -> Vec<Array<'a>> {
    arrays.iter().filter(|(on, _)| *on).map(|(_, array)| *array).collect()
}

fn vtu_fault(path: &Path, fault: VtuError) -> ObserveError {
    let source = match fault {
        VtuError::Write(source) => source,
        other => std::io::Error::new(std::io::ErrorKind::InvalidInput, other),
    };
    write_fault(path, source)
}
