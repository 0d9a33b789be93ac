//! Replacing a file so that a reader sees the old or the new content, never a part.

use std::ffi::OsString;
use std::fs::{self, File, OpenOptions};
use std::hash::{BuildHasher, RandomState};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Whether a replacement survives a power cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Durability {
    /// Atomic for readers; the system decides when to write to the disk.
    Visible,
    /// Also flushed to the disk before the rename.
    Synced,
}

/// The temporary file beside `path`: `.NAME.part`. It is always the same one, so a killed run leaves at most one
/// behind and the next run replaces it. (A randomly named file of the `tempfile` crate would be readable
/// by its owner only, which the result would inherit.)
pub fn part_path(path: &Path) -> PathBuf {
    let mut name = OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(".part");
    path.with_file_name(name)
}

/// A temporary file beside `path` that no other process has: `.NAME.RANDOM.part`, for files that several processes may
/// write at the same time, on several machines too.
fn own_part_path(path: &Path) -> PathBuf {
    // Seeded by the system for each process, and different in every call.
    let random = RandomState::new().hash_one(std::process::id());
    let mut name = OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(format!(".{random:016x}.part"));
    path.with_file_name(name)
}

/// As [`replace`], for a file that several processes may write at the same time: the last one wins.
///
/// # Errors
/// Errors of the system; `path` then has its old content.
pub fn replace_shared(path: &Path, content: &[u8], durability: Durability) -> io::Result<()> {
    replace_via(&own_part_path(path), path, durability, |file| file.write_all(content))
}

/// Writes `content` to `path` by way of [`part_path`] and a rename in the same folder.
///
/// # Errors
/// Errors of the system; `path` then has its old content.
pub fn replace(path: &Path, content: &[u8], durability: Durability) -> io::Result<()> {
    replace_by(path, durability, |file| file.write_all(content))
}

/// The same with content that `fill` writes piece by piece.
///
/// # Errors
/// Errors of the system or of `fill`; `path` then has its old content.
pub fn replace_by(
    path: &Path,
    durability: Durability,
    fill: impl FnOnce(&mut File) -> io::Result<()>,
) -> io::Result<()> {
    replace_via(&part_path(path), path, durability, fill)
}

fn replace_via(
    part: &Path,
    path: &Path,
    durability: Durability,
    fill: impl FnOnce(&mut File) -> io::Result<()>,
) -> io::Result<()> {
    let file = create_new(part)?;
    let written = write_new(file, durability, fill).and_then(|()| fs::rename(part, path));
    if written.is_err() {
        // The first error is reported; the temporary file is removed if possible.
        let _ = fs::remove_file(part);
        return written;
    }
    if durability == Durability::Synced {
        sync_folder(path.parent().unwrap_or(Path::new("")));
    }
    Ok(())
}

fn create_new(part: &Path) -> io::Result<File> {
    let create = || OpenOptions::new().write(true).create_new(true).open(part);
    match create() {
        // A leftover, possibly a link, is removed instead of being written through.
        Err(e) if e.kind() == io::ErrorKind::AlreadyExists => fs::remove_file(part).and_then(|()| create()),
        created => created,
    }
}

fn write_new(mut file: File, durability: Durability, fill: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<()> {
    fill(&mut file)?;
    if durability == Durability::Synced {
        file.sync_all()?;
    }
    Ok(())
}

/// Makes new names in a folder durable where folders can be synced; elsewhere the files are complete, but their names
/// may be lost in a power cut.
pub fn sync_folder(folder: &Path) {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    if let Ok(folder) = File::open(folder) {
        let _ = folder.sync_all();
    }
}
