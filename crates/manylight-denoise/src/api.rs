//! The functions of Open Image Denoise 2 that are called, and the library that holds them.
//!
//! Types and constants are those of `oidn.h`, version 2.0; later versions of the same major number
//! are compatible.

#![allow(
    unsafe_code,
    reason = "the library is found at run time, so that its functions have no checked declarations"
)]

use libloading::Library;
use std::ffi::{c_char, c_int, c_void};
use std::path::Path;

/// A device or filter of the library.
pub(crate) type Handle = *mut c_void;

/// `OIDN_DEVICE_TYPE_CPU`
pub(crate) const CPU: c_int = 1;
/// `OIDN_FORMAT_FLOAT3`
pub(crate) const FLOAT3: c_int = 3;
/// `OIDN_QUALITY_HIGH`
pub(crate) const QUALITY_HIGH: c_int = 6;
/// `OIDN_ERROR_NONE`
pub(crate) const NO_ERROR: c_int = 0;
/// `OIDN_ERROR_CANCELLED`
pub(crate) const CANCELLED: c_int = 6;

/// Is called with the finished fraction; `false` cancels.
pub(crate) type ProgressMonitor = unsafe extern "C" fn(*mut c_void, f64) -> bool;

/// The functions, by their names without the prefix `oidn`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Api {
    pub(crate) new_device: unsafe extern "C" fn(c_int) -> Handle,
    pub(crate) release_device: unsafe extern "C" fn(Handle),
    pub(crate) commit_device: unsafe extern "C" fn(Handle),
    pub(crate) get_device_error: unsafe extern "C" fn(Handle, *mut *const c_char) -> c_int,
    pub(crate) get_device_int: unsafe extern "C" fn(Handle, *const c_char) -> c_int,
    pub(crate) set_device_int: unsafe extern "C" fn(Handle, *const c_char, c_int),
    pub(crate) new_filter: unsafe extern "C" fn(Handle, *const c_char) -> Handle,
    pub(crate) release_filter: unsafe extern "C" fn(Handle),
    pub(crate) commit_filter: unsafe extern "C" fn(Handle),
    pub(crate) execute_filter: unsafe extern "C" fn(Handle),
    /// Filter, name, pixels, format, width, height, byte offset, bytes per pixel, bytes per row.
    pub(crate) set_shared_filter_image: unsafe extern "C" fn(
        Handle,
        *const c_char,
        *mut c_void,
        c_int,
        usize,
        usize,
        usize,
        usize,
        usize,
    ),
    pub(crate) set_filter_bool: unsafe extern "C" fn(Handle, *const c_char, bool),
    pub(crate) set_filter_int: unsafe extern "C" fn(Handle, *const c_char, c_int),
    pub(crate) set_filter_progress_monitor_function:
        unsafe extern "C" fn(Handle, ProgressMonitor, *mut c_void),
}

/// Loads the library `file` and finds its functions. The library stays loaded until the process
/// ends, because its worker threads may outlive its devices.
///
/// # Errors
/// A text: the file is missing or is no library, a library that it needs is missing, or it is older
/// than version 2.0.
pub(crate) fn load(file: &Path) -> Result<Api, String> {
    // SAFETY: loading runs the initializers of the library and of those that it needs. The library
    // is one that the user has installed or named for this purpose; like every plug-in it is
    // trusted to have initializers without preconditions.
    let library = unsafe { open(file) }.map_err(|error| whole_message(&error))?;
    // Never closed: the function pointers below are valid for the rest of the process.
    let library: &'static Library = Box::leak(Box::new(library));
    /// A function by its name; the type is that of the field of [`Api`] that it is assigned to.
    macro_rules! function {
        ($name:literal) => {{
            let symbol = concat!($name, "\0").as_bytes();
            // SAFETY: the types of the fields of `Api` are those that `oidn.h` declares for these
            // names in version 2.0, and versions with the same major number keep them. Version 1
            // lacks some of the names and is refused here.
            let function = unsafe { library.get(symbol) };
            *function.map_err(|_| {
                format!("it has no function {}: it is older than version 2.0", $name)
            })?
        }};
    }
    Ok(Api {
        get_device_int: function!("oidnGetDeviceInt"),
        set_device_int: function!("oidnSetDeviceInt"),
        set_filter_bool: function!("oidnSetFilterBool"),
        set_filter_int: function!("oidnSetFilterInt"),
        new_device: function!("oidnNewDevice"),
        release_device: function!("oidnReleaseDevice"),
        commit_device: function!("oidnCommitDevice"),
        get_device_error: function!("oidnGetDeviceError"),
        new_filter: function!("oidnNewFilter"),
        release_filter: function!("oidnReleaseFilter"),
        commit_filter: function!("oidnCommitFilter"),
        execute_filter: function!("oidnExecuteFilter"),
        set_shared_filter_image: function!("oidnSetSharedFilterImage"),
        set_filter_progress_monitor_function: function!("oidnSetFilterProgressMonitorFunction"),
    })
}

/// # Safety
/// As for [`Library::new`].
#[cfg(not(windows))]
unsafe fn open(file: &Path) -> Result<Library, libloading::Error> {
    // SAFETY: the caller's.
    unsafe { Library::new(file) }
}

/// Searches the libraries that `file` needs in its own folder too.
///
/// # Safety
/// As for [`Library::new`].
#[cfg(windows)]
unsafe fn open(file: &Path) -> Result<Library, libloading::Error> {
    use libloading::os::windows::{LOAD_WITH_ALTERED_SEARCH_PATH, Library as WindowsLibrary};
    if !file.is_absolute() {
        // SAFETY: the caller's.
        return unsafe { Library::new(file) };
    }
    // SAFETY: the caller's.
    unsafe { WindowsLibrary::load_with_flags(file, LOAD_WITH_ALTERED_SEARCH_PATH) }.map(Into::into)
}

/// The message of an error with that of its source, which names the missing file.
fn whole_message(error: &libloading::Error) -> String {
    use std::error::Error;
    match error.source() {
        Some(source) => format!("{error}: {source}"),
        None => error.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_library_is_refused() {
        let folder = tempfile::TempDir::new().unwrap();
        let file = folder.path().join("library.so");
        assert!(load(&file).unwrap_err().contains("library.so"));
        std::fs::write(&file, "no library").unwrap();
        assert!(!load(&file).unwrap_err().is_empty());
    }

    /// The C library of the system is a library, but lacks the functions.
    #[cfg(target_os = "linux")]
    #[test]
    fn a_library_without_the_functions_is_refused() {
        let message = load(Path::new("libc.so.6")).unwrap_err();
        assert!(message.contains("older than version 2.0"), "{message}");
    }
}
