//! Reading of input files: regular files alone, within their length.
//!
//! Other files may have no end (`/dev/zero`), or let the program wait (a pipe without a writer).

use std::fs::{self, File, FileType};
use std::io::{self, Read};
use std::path::Path;
use sysinfo::System;

/// Most bytes that a file may have more than its length says. Those of `/proc` say 0, and a small
/// file may grow while it is read.
const MAX_BEYOND: u64 = 64 << 10;

/// The start of the files that Git LFS leaves in the place of those that it did not fetch.
const LFS_POINTER: &[u8] = b"version https://git-lfs.github.com/spec/";

/// Bytes of a file above which the memory of the machine is asked for.
const LARGE: u64 = 1 << 30;

/// Opens a regular file, and says how many bytes it has.
///
/// # Errors
/// The file cannot be opened, or is of another kind.
pub(crate) fn open_regular(path: &Path) -> io::Result<(File, u64)> {
    // Before the file is opened, which waits for the writer of a pipe and may start a device.
    check_kind(fs::metadata(path)?.file_type())?;
    let file = File::open(path)?;
    let metadata = file.metadata()?;
    check_kind(metadata.file_type())?;
    Ok((file, metadata.len()))
}

/// The content of a regular file.
///
/// # Errors
/// The file cannot be read, is of another kind, is larger than the memory, or grows while it is
/// read.
pub(crate) fn read_regular(path: &Path) -> io::Result<Vec<u8>> {
    let (file, length) = open_regular(path)?;
    let too_large = || io::Error::other(format!("found {length} bytes, more than the memory has"));
    if length > LARGE && length > memory_of_machine() {
        return Err(too_large());
    }
    let mut bytes = Vec::new();
    let capacity = usize::try_from(length).map_err(|_| too_large())?;
    bytes.try_reserve_exact(capacity).map_err(|_| too_large())?;
    let most = length.saturating_add(MAX_BEYOND);
    file.take(most + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        return Err(io::Error::other("it grew while it was read"));
    }
    if bytes.starts_with(LFS_POINTER) {
        return Err(io::Error::other(
            "it is a pointer of Git LFS, whose content was not fetched; run `git lfs pull` in its repository",
        ));
    }
    Ok(bytes)
}

/// Bytes of the memory of the machine; the largest number if the system does not tell.
fn memory_of_machine() -> u64 {
    let mut system = System::new();
    system.refresh_memory();
    match system.total_memory() {
        0 => u64::MAX,
        bytes => bytes,
    }
}

fn check_kind(kind: FileType) -> io::Result<()> {
    if kind.is_file() {
        return Ok(());
    }
    let found = match kind {
        kind if kind.is_dir() => "a folder",
        kind => special_kind(kind),
    };
    Err(io::Error::other(format!(
        "found {found}, expected a regular file"
    )))
}

#[cfg(unix)]
fn special_kind(kind: FileType) -> &'static str {
    use std::os::unix::fs::FileTypeExt;
    if kind.is_fifo() {
        "a pipe"
    } else if kind.is_socket() {
        "a socket"
    } else {
        "a device"
    }
}

#[cfg(not(unix))]
fn special_kind(_: FileType) -> &'static str {
    "a special file"
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn devices_sockets_and_folders_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let socket = folder.path().join("socket");
        let _listener = std::os::unix::net::UnixListener::bind(&socket).unwrap();
        for (path, found) in [
            (Path::new("/dev/zero"), "a device"),
            (&socket, "a socket"),
            (folder.path(), "a folder"),
        ] {
            let error = read_regular(path).unwrap_err().to_string();
            assert_eq!(error, format!("found {found}, expected a regular file"));
        }
    }

    #[test]
    fn huge_files_take_no_memory() {
        let file = tempfile::NamedTempFile::new().unwrap();
        // A file of zeros that takes no room; file systems allow at least this.
        file.as_file().set_len(15 << 40).unwrap();
        let error = read_regular(file.path()).unwrap_err().to_string();
        assert_eq!(
            error,
            format!("found {} bytes, more than the memory has", 15_u64 << 40)
        );
    }

    #[test]
    fn pointers_of_git_lfs_are_named() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 7\n";
        fs::write(file.path(), pointer).unwrap();
        let error = read_regular(file.path()).unwrap_err().to_string();
        assert!(error.contains("pointer of Git LFS"), "{error}");
    }

    #[test]
    fn the_length_of_a_file_bounds_what_is_read() {
        let file = tempfile::NamedTempFile::new().unwrap();
        fs::write(file.path(), "abc").unwrap();
        assert_eq!(read_regular(file.path()).unwrap(), b"abc");
        // Files of `/proc` have content, but no length.
        let status = read_regular(Path::new("/proc/self/status")).unwrap_or_default();
        assert_eq!(status.is_empty(), !Path::new("/proc").exists());
    }
}
