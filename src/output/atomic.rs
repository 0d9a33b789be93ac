//! Replacing a file so that a reader sees the old or the new content, never a part.

use std::ffi::OsString;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// How hard a replacement tries to survive a power cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Durability {
    /// Atomic for readers; the system writes to the disk when it likes.
    Visible,
    /// Also flushed to the disk before the new name counts.
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

/// Writes `content` to `path` by way of [`part_path`] and a rename in the same folder.
///
/// # Errors
/// Whatever the system answers; `path` then still holds what it held.
pub fn replace(path: &Path, content: &[u8], durability: Durability) -> io::Result<()> {
    let part = part_path(path);
    // A leftover, possibly a link: removed rather than written through.
    match fs::remove_file(&part) {
        Err(e) if e.kind() != io::ErrorKind::NotFound => return Err(e),
        _ => {}
    }
    let written = write_new(&part, content, durability).and_then(|()| fs::rename(&part, path));
    if written.is_err() {
        // The first error is the one to tell; the part is removed if that is still possible.
        let _ = fs::remove_file(&part);
        return written;
    }
    if durability == Durability::Synced {
        sync_folder(path);
    }
    Ok(())
}

fn write_new(part: &Path, content: &[u8], durability: Durability) -> io::Result<()> {
    let mut file = OpenOptions::new().write(true).create_new(true).open(part)?;
    file.write_all(content)?;
    if durability == Durability::Synced {
        file.sync_all()?;
    }
    Ok(())
}

/// Makes the rename itself durable where folders can be synced; elsewhere the file is complete all the same.
fn sync_folder(path: &Path) {
    let parent = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if let Ok(folder) = File::open(parent) {
        let _ = folder.sync_all();
    }
}
