//! The folder of a run. Earlier results are replaced only on request, and other files never. Locks prevent two runs in
//! one folder; a killed program holds none.

use std::fs::{self, File, Metadata, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::atomic::part_path;
use super::files::{FRAMES, GAUGES, HISTORY, PROBES};
use super::frame_files::frames_in;
use super::sanitize::file_stem;

use crate::vtk::HDF_ENDING;
pub use crate::vtk::SUMMARY;
/// A table of the vibration modes about an equilibrium.
pub const MODES: &str = "modes.csv";
/// The folder of their shapes.
pub const MODES_FOLDER: &str = "modes";
/// The checkpoint of a run.
pub const CHECKPOINT: &str = "checkpoint.bin";

/// The file to open for the frames of a case in a folder: the one that holds them, or else their list.
pub fn frames_of(dir: &Path, name: &str) -> PathBuf {
    let file = |ending: &str| dir.join(format!("{}.{ending}", file_stem(name)));
    Some(file(HDF_ENDING)).filter(|path| path.is_file()).unwrap_or_else(|| file("pvd"))
}

/// Why a folder cannot take results.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FolderError {
    /// The folder has results already.
    #[error(
        "{folder} already holds results ({found}); give --force to replace them,{} or another folder with --out",
        if *.resumable { " --resume to go on from their checkpoint," } else { "" }
    )]
    HoldsResults {
        /// the folder
        folder: String,
        /// the first result found
        found: String,
        /// whether a checkpoint is among them
        resumable: bool,
    },
    /// There is something else at the path of a result.
    #[error("{path} is {what}, where a result belongs; move it away or give another folder with --out")]
    InTheWay {
        /// the path
        path: String,
        /// what it is
        what: &'static str,
    },
    /// The other run has not ended.
    #[error("{path} is being written by another run; wait until it has ended, or give another folder with --out")]
    Busy {
        /// the file
        path: String,
    },
    /// The system's error.
    #[error("{path}: {source}")]
    System {
        /// the path
        path: String,
        /// the reason
        source: io::Error,
    },
}

/// A folder that is ready for the results of one case. No other run may use it as long as this exists.
#[derive(Debug)]
pub struct ResultFolder {
    dir: PathBuf,
    stem: String,
    /// the folder, locked; `None` where folders cannot be opened
    _lock: Option<File>,
}

impl ResultFolder {
    /// Makes `dir` ready for the case `name`: creates it if needed and locks it. Refuses earlier results unless `force`
    /// is given, which removes these files only: `summary.json`, `history.csv`, `probes.csv`, `gauges.csv`,
    /// `modes.csv`, `checkpoint.bin`, `NAME.pvd`, `frames/NAME_<number>.vtu`, `NAME.vtkhdf`, the last three also for
    /// the case of `summary.json`, and `frames` if it is then empty. Other files are kept. A link is removed, never
    /// followed; a linked `frames` is refused.
    ///
    /// # Errors
    /// When there are results and no `force`, when something else has the name of a result, another run uses the
    /// folder, or the system fails.
    pub fn prepare(dir: &Path, name: &str, force: bool) -> Result<Self, FolderError> {
        refuse_file(dir)?;
        fs::create_dir_all(dir).map_err(|e| system(dir, e))?;
        let folder = Self::locked(dir, name)?;
        let earlier = folder.earlier()?;
        if !force {
            folder.refuse(&earlier)?;
        }
        for path in &earlier {
            fs::remove_file(path).map_err(|e| system(path, e))?;
        }
        // Fails, as it should, if there are other files in it.
        let _ = fs::remove_dir(dir.join(FRAMES));
        Ok(folder)
    }

    /// Whether [`ResultFolder::prepare`] would take this folder now without `force`. Changes nothing, so that a program
    /// is told before it does other work.
    ///
    /// # Errors
    /// When there are results, when something else has the name of a result, another run uses the folder, or the system
    /// fails.
    pub fn check(dir: &Path, name: &str) -> Result<(), FolderError> {
        refuse_file(dir)?;
        if !dir.is_dir() {
            return Ok(());
        }
        let folder = Self::locked(dir, name)?;
        folder.refuse(&folder.earlier()?)
    }

    fn refuse(&self, earlier: &[PathBuf]) -> Result<(), FolderError> {
        let Some(found) = earlier.first() else { return Ok(()) };
        let found = found.strip_prefix(&self.dir).unwrap_or(found).display().to_string();
        let resumable = earlier.iter().any(|path| path.ends_with(CHECKPOINT));
        Err(FolderError::HoldsResults { folder: self.dir.display().to_string(), found, resumable })
    }

    /// The folder of an earlier run, to continue it: locked, and nothing is changed.
    ///
    /// # Errors
    /// When something that is not a result has the name of one, or another run is writing there.
    pub fn reopen(dir: &Path, name: &str) -> Result<Self, FolderError> {
        refuse_file(dir)?;
        let folder = Self::locked(dir, name)?;
        folder.earlier()?;
        Ok(folder)
    }

    /// Locks the folder before anything in it is read. The lock of `history.csv` stops earlier versions of the program,
    /// and is the only one where a file system cannot lock folders.
    fn locked(dir: &Path, name: &str) -> Result<Self, FolderError> {
        let held = File::open(dir).ok();
        let history = dir.join(HISTORY);
        let is_file = fs::metadata(&history).is_ok_and(|there| there.is_file());
        let busy = held.as_ref().is_some_and(|dir| lock(dir) == Lock::Elsewhere)
            || is_file && File::open(&history).is_ok_and(|file| lock(&file) == Lock::Elsewhere);
        if busy {
            return Err(FolderError::Busy { path: history.display().to_string() });
        }
        Ok(Self { dir: dir.to_owned(), stem: file_stem(name), _lock: held })
    }

    /// Removes the checkpoint of a completed run that does not keep one.
    ///
    /// # Errors
    /// When it cannot be removed.
    pub fn remove_checkpoint(&self) -> Result<(), FolderError> {
        let path = self.file(CHECKPOINT);
        match fs::remove_file(&path) {
            Err(e) if e.kind() != io::ErrorKind::NotFound => Err(system(&path, e)),
            _ => Ok(()),
        }
    }

    /// The folder.
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    /// The stem of the names of the .pvd and the frames.
    pub fn stem(&self) -> &str {
        &self.stem
    }

    /// Path of a file in the folder, e.g. [`SUMMARY`].
    pub fn file(&self, name: &str) -> PathBuf {
        self.dir.join(name)
    }

    /// Files of an earlier run, in a fixed order.
    fn earlier(&self) -> Result<Vec<PathBuf>, FolderError> {
        let mut found = Vec::new();
        let stems: Vec<String> = [self.stem.clone()].into_iter().chain(self.other_stem()).collect();
        let collections = stems.iter().flat_map(|stem| [format!("{stem}.pvd"), format!("{stem}.{HDF_ENDING}")]);
        for name in
            [SUMMARY, HISTORY, PROBES, GAUGES, MODES, CHECKPOINT].map(str::to_owned).into_iter().chain(collections)
        {
            let path = self.dir.join(name);
            for path in [part_path(&path), path] {
                if let Some(there) = metadata_of(&path)? {
                    if there.is_dir() {
                        return Err(FolderError::InTheWay { path: path.display().to_string(), what: "a folder" });
                    }
                    found.push(path);
                }
            }
        }
        for stem in &stems {
            found.extend(self.earlier_frames(stem)?);
        }
        Ok(found)
    }

    /// The stem of the files of another case, if the summary belongs to one.
    fn other_stem(&self) -> Option<String> {
        let path = self.file(SUMMARY);
        metadata_of(&path).ok()?.filter(Metadata::is_file)?;
        let summary: serde_json::Value = serde_json::from_slice(&fs::read(path).ok()?).ok()?;
        Some(file_stem(summary["case"]["name"].as_str()?)).filter(|stem| *stem != self.stem)
    }

    fn earlier_frames(&self, stem: &str) -> Result<Vec<PathBuf>, FolderError> {
        let folder = self.dir.join(FRAMES);
        match metadata_of(&folder)? {
            None => return Ok(Vec::new()),
            Some(there) if there.is_dir() => {}
            Some(there) => {
                let what = if there.is_symlink() { "a link" } else { "a file" };
                return Err(FolderError::InTheWay { path: folder.display().to_string(), what });
            }
        }
        frames_in(&folder, stem).map_err(|e| system(&folder, e))
    }
}

fn refuse_file(dir: &Path) -> Result<(), FolderError> {
    if fs::metadata(dir).is_ok_and(|there| !there.is_dir()) {
        return Err(FolderError::InTheWay { path: dir.display().to_string(), what: "a file" });
    }
    Ok(())
}

/// The metadata of a path itself, without following links.
fn metadata_of(path: &Path) -> Result<Option<Metadata>, FolderError> {
    match fs::symlink_metadata(path) {
        Ok(there) => Ok(Some(there)),
        Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(e) => Err(system(path, e)),
    }
}

fn system(path: &Path, source: io::Error) -> FolderError {
    FolderError::System { path: path.display().to_string(), source }
}

/// Time to wait for a lock that is held for a short time only: a run is ending, or its process is starting a program,
/// which has a copy of every open file until it begins.
const PATIENCE: Duration = Duration::from_millis(300);

/// The state of the lock of a file or folder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lock {
    /// locked by this handle, or on a system without locks
    Here,
    /// locked by another run
    Elsewhere,
}

/// Locks a file or folder against a second run. There are no locks on Windows, where they would also stop readers, and
/// on file systems without locks (NFS has none for folders).
pub fn lock(file: &File) -> Lock {
    let began = Instant::now();
    loop {
        match cfg!(unix).then(|| file.try_lock()) {
            Some(Err(TryLockError::WouldBlock)) if began.elapsed() < PATIENCE => std::thread::sleep(PATIENCE / 30),
            Some(Err(TryLockError::WouldBlock)) => return Lock::Elsewhere,
            _ => return Lock::Here,
        }
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::fs::OpenOptions;

    /// Between fork and exec, a starting program has copies of all open files of its process, including locked ones.
    #[test]
    fn a_lock_that_is_soon_given_back_is_waited_for() {
        let folder = tempfile::tempdir().expect("a folder");
        let open =
            || OpenOptions::new().create(true).append(true).open(folder.path().join("history.csv")).expect("a file");
        let (held, wanted) = (open(), open());
        assert_eq!(lock(&held), Lock::Here);
        assert_eq!(lock(&wanted), Lock::Elsewhere);
        let gives_back = std::thread::spawn(move || {
            std::thread::sleep(PATIENCE / 6);
            drop(held);
        });
        assert_eq!(lock(&wanted), Lock::Here);
        gives_back.join().expect("no panic");
    }
}
