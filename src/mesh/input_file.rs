//! Opening of input files. A named pipe is refused: opening it would wait for a writer, perhaps for ever.

use std::fs::{self, File, FileType};
use std::io::{self, ErrorKind, Read};
use std::path::Path;

/// Opens a regular file, also through a link.
///
/// # Errors
/// [`ErrorKind::InvalidInput`] for anything but a regular file and [`ErrorKind::IsADirectory`] for a folder, both
/// without opening it; else the error of the system.
pub fn open(path: &Path) -> io::Result<File> {
    let kind = fs::metadata(path)?.file_type();
    if kind.is_file() { File::open(path) } else { Err(refusal(kind)) }
}

/// Reads a regular file.
///
/// # Errors
/// As [`open`].
pub fn read(path: &Path) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    open(path)?.read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Opens a regular file, a character device, or a pipe that the shell has opened already (`/dev/stdin`, `<(command)`).
///
/// # Errors
/// As [`open`].
pub fn open_stream(path: &Path) -> io::Result<File> {
    let kind = fs::metadata(path)?.file_type();
    let opened_by_shell = || is_pipe(kind) && fs::canonicalize(path).map_or(true, |real| real.starts_with("/dev"));
    if kind.is_file() || is_character_device(kind) || opened_by_shell() { File::open(path) } else { Err(refusal(kind)) }
}

fn refusal(kind: FileType) -> io::Error {
    if kind.is_dir() {
        return io::Error::from(ErrorKind::IsADirectory);
    }
    let what = if is_pipe(kind) { "this is a named pipe" } else { "this is no regular file" };
    io::Error::new(ErrorKind::InvalidInput, format!("{what}; write its contents to a file and give that"))
}

#[cfg(unix)]
fn is_pipe(kind: FileType) -> bool {
    std::os::unix::fs::FileTypeExt::is_fifo(&kind)
}

#[cfg(unix)]
fn is_character_device(kind: FileType) -> bool {
    std::os::unix::fs::FileTypeExt::is_char_device(&kind)
}

#[cfg(not(unix))]
fn is_pipe(_: FileType) -> bool {
    false
}

#[cfg(not(unix))]
fn is_character_device(_: FileType) -> bool {
    false
}
