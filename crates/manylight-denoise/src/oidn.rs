//! A device of Open Image Denoise, and images filtered by it.

#![allow(
    unsafe_code,
    reason = "calls of the library, which takes pointers to images"
)]

use crate::api::{self, Api, Handle};
use crate::search::SearchPlaces;
use manylight::image::Image;
use std::ffi::{CStr, c_char, c_int, c_void};
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use thiserror::Error;

/// Oldest version that is used.
const MIN_MAJOR: u32 = 2;

/// A version of the library.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Version {
    /// Major number.
    pub major: u32,
    /// Minor number.
    pub minor: u32,
    /// Patch number.
    pub patch: u32,
}

impl Version {
    /// The version from the number that the library reports, such as 20501 for 2.5.1.
    fn from_number(number: u32) -> Self {
        Version {
            major: number / 10_000,
            minor: number / 100 % 100,
            patch: number % 100,
        }
    }
}

impl fmt::Display for Version {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}.{}", self.major, self.minor, self.patch)
    }
}

/// The library was not found, or what was found cannot be used.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("Open Image Denoise 2 was not found; looked in\n{}", .tried.join("\n"))]
pub struct Unavailable {
    /// One line for each place, with what was found there.
    pub tried: Vec<String>,
}

/// Why an image was not filtered.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum FilterError {
    /// `cancel` became true.
    #[error("denoising was cancelled")]
    Cancelled,
    /// The library reports an error.
    #[error("Open Image Denoise: {0}")]
    Library(String),
}

/// What a pixel shows at its first surface, to keep edges and textures.
#[derive(Clone, Copy, Debug)]
pub struct Features<'i> {
    /// Albedo in [0, 1], three channels.
    pub albedo: &'i Image,
    /// Shading normal, three channels in [-1, 1].
    pub normal: &'i Image,
}

/// A device of the library on the processor. The results do not depend on the number of threads.
#[derive(Debug)]
pub struct Oidn {
    api: Api,
    device: Handle,
    version: Version,
    file: PathBuf,
}

impl Oidn {
    /// Searches the library, loads it, and makes a device with this number of threads (`None`: one
    /// per core).
    ///
    /// # Errors
    /// No place has a library of version 2.0 or later that makes a device.
    pub fn open(places: &SearchPlaces, threads: Option<usize>) -> Result<Self, Unavailable> {
        let mut tried = Vec::new();
        for place in places.places() {
            if place.files.is_empty() {
                tried.push(format!("  {}: no library", place.name));
            }
            for file in place.files {
                match Oidn::from_file(&file, threads) {
                    Ok(oidn) => return Ok(oidn),
                    Err(reason) => tried.push(format!("  {}: {reason}", place.name)),
                }
            }
        }
        Err(Unavailable { tried })
    }

    /// A device of the library `file`.
    fn from_file(file: &Path, threads: Option<usize>) -> Result<Self, String> {
        let api = api::load(file)?;
        // SAFETY: the call has no preconditions; it returns null on failure.
        let device = unsafe { (api.new_device)(api::CPU) };
        if device.is_null() {
            let reason = error_of(&api, std::ptr::null_mut()).map(|e| e.to_string());
            return Err(reason.unwrap_or_else(|| "it makes no device on this processor".into()));
        }
        let mut oidn = Oidn {
            api,
            device,
            version: Version::from_number(0),
            file: file.to_owned(),
        };
        let threads = threads.and_then(|n| c_int::try_from(n).ok()).unwrap_or(0);
        // SAFETY: `device` is a device that is not released before `oidn` is dropped; the names are
        // strings that end with 0. `numThreads` may be set before the first commit, and 0 selects
        // the default.
        let version = unsafe {
            (api.set_device_int)(device, c"numThreads".as_ptr(), threads);
            (api.commit_device)(device);
            (api.get_device_int)(device, c"version".as_ptr())
        };
        oidn.check().map_err(|error| error.to_string())?;
        oidn.version = Version::from_number(u32::try_from(version).unwrap_or(0));
        if oidn.version.major < MIN_MAJOR {
            return Err(format!("its version {} is older than 2.0", oidn.version));
        }
        Ok(oidn)
    }

    /// The version of the library.
    pub fn version(&self) -> Version {
        self.version
    }

    /// The library file.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// Filters radiance: any values from 0 on, three channels. Negative values become 0. `features`
    /// must be free of noise.
    ///
    /// # Errors
    /// `cancel` becomes true while it works, or the library reports an error.
    ///
    /// # Panics
    /// If an image does not have three channels, or sizes differ.
    pub fn filter(
        &self,
        radiance: &Image,
        features: Option<Features>,
        cancel: &AtomicBool,
    ) -> Result<Image, FilterError> {
        let mut images = vec![(c"color", radiance)];
        if let Some(Features { albedo, normal }) = features {
            images.extend([(c"albedo", albedo), (c"normal", normal)]);
        }
        self.run(&images, cancel)
    }

    /// Runs a filter with these input images, by name.
    fn run(&self, images: &[(&CStr, &Image)], cancel: &AtomicBool) -> Result<Image, FilterError> {
        let (width, height) = (images[0].1.width, images[0].1.height);
        for (_, image) in images {
            assert_eq!(
                (image.width, image.height, image.channels, image.data.len()),
                (width, height, 3, width * height * 3),
                "images of one size with three channels are filtered"
            );
        }
        let mut output = Image::new(width, height, 3);
        let filter = Filter::new(self)?;
        for (name, image) in images {
            // The library reads input images only; the pointer type is that of the C declaration.
            filter.set_image(name, image.data.as_ptr().cast_mut(), image);
        }
        let pixels = output.data.as_mut_ptr();
        filter.set_image(c"output", pixels, &output);
        filter.execute(cancel)?;
        drop(filter);
        Ok(output)
    }

    /// The error of the calls since the last check.
    fn check(&self) -> Result<(), FilterError> {
        error_of(&self.api, self.device).map_or(Ok(()), Err)
    }
}

// SAFETY: the functions of the library may be called by several threads at once; it serializes
// those of one device. The fields do not change after `Oidn::open`.
unsafe impl Sync for Oidn {}

impl Drop for Oidn {
    fn drop(&mut self) {
        // SAFETY: `device` was made by this library, is released once, and every filter has been
        // released before, because a `Filter` borrows the device.
        unsafe { (self.api.release_device)(self.device) }
    }
}

/// Takes the pending error of `device`; with null, that of the last call that failed to make a
/// device.
fn error_of(api: &Api, device: Handle) -> Option<FilterError> {
    let mut message: *const c_char = std::ptr::null();
    // SAFETY: `device` is a device or null, both of which the function accepts; it stores a pointer
    // to a string that ends with 0 and lives until the next call, or leaves null.
    let (code, text) = unsafe {
        let code = (api.get_device_error)(device, &raw mut message);
        let text = (!message.is_null()).then(|| CStr::from_ptr(message).to_string_lossy());
        (code, text.unwrap_or_default().into_owned())
    };
    match code {
        api::NO_ERROR => None,
        api::CANCELLED => Some(FilterError::Cancelled),
        code => Some(FilterError::Library(format!("{text} (error {code})"))),
    }
}

/// A filter of the type `RT`.
struct Filter<'d> {
    oidn: &'d Oidn,
    handle: Handle,
}

impl<'d> Filter<'d> {
    fn new(oidn: &'d Oidn) -> Result<Self, FilterError> {
        // SAFETY: the device is committed and lives as long as the borrow; the name is a string
        // that ends with 0.
        let handle = unsafe { (oidn.api.new_filter)(oidn.device, c"RT".as_ptr()) };
        if handle.is_null() {
            oidn.check()?;
            return Err(FilterError::Library("it makes no filter".into()));
        }
        Ok(Filter { oidn, handle })
    }

    /// Sets the image `name` to `pixels`, which have the size of `image` and must live until the
    /// filter has run.
    fn set_image(&self, name: &CStr, pixels: *mut f32, image: &Image) {
        // SAFETY: the filter lives; `pixels` has `width * height` pixels of three floats without
        // gaps, which is what offset 0 and strides 0 mean. Callers keep the images until the filter
        // is dropped.
        unsafe {
            (self.oidn.api.set_shared_filter_image)(
                self.handle,
                name.as_ptr(),
                pixels.cast::<c_void>(),
                api::FLOAT3,
                image.width,
                image.height,
                0,
                0,
                0,
            );
        }
    }

    fn execute(&self, cancel: &AtomicBool) -> Result<(), FilterError> {
        let Api {
            set_filter_bool,
            set_filter_int,
            set_filter_progress_monitor_function,
            commit_filter,
            execute_filter,
            ..
        } = self.oidn.api;
        let user = std::ptr::from_ref(cancel).cast_mut().cast::<c_void>();
        // SAFETY: the filter lives; the names end with 0; the images that were set are alive and
        // have the declared sizes. The monitor is called only during `execute_filter`, which
        // blocks, while `cancel` is borrowed.
        unsafe {
            set_filter_bool(self.handle, c"hdr".as_ptr(), true);
            set_filter_bool(self.handle, c"cleanAux".as_ptr(), true);
            set_filter_int(self.handle, c"quality".as_ptr(), api::QUALITY_HIGH);
            set_filter_progress_monitor_function(self.handle, goes_on, user);
            commit_filter(self.handle);
            execute_filter(self.handle);
        }
        self.oidn.check()
    }
}

impl Drop for Filter<'_> {
    fn drop(&mut self) {
        // SAFETY: `handle` was made by this library and is released once.
        unsafe { (self.oidn.api.release_filter)(self.handle) }
    }
}

/// The progress monitor: whether the filter goes on.
///
/// # Safety
/// `cancel` points to an `AtomicBool` that lives during the call.
unsafe extern "C" fn goes_on(cancel: *mut c_void, _fraction: f64) -> bool {
    // SAFETY: the caller's.
    let cancel = unsafe { &*cancel.cast::<AtomicBool>() };
    !cancel.load(Ordering::Relaxed)
}
