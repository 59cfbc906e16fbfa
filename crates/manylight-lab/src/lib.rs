//! The measuring side of the manylight renderer.
//!
//! The crate compares images with a reference, shows them in self-contained HTML pages, and carries
//! out studies: plans of renders that are measured one by one and summarized in tables. It renders
//! nothing itself. A study starts the program `manylight` as a child process per render, and learns
//! about its options through [`study::RenderInterface`].
//!
//! # Promises
//!
//! * Error measures follow published definitions. SSIM and HDR-FLIP are tested against values of
//!   scikit-image and of the authors' program.
//! * Equal inputs give equal results, for any number of threads.
//! * Nothing is printed. Functions that touch files return a [`LabError`], which names the file,
//!   and the place in a plan.
//! * HTML pages load nothing from the network.
//!
//! # Layers
//!
//! A module imports only from layers with smaller numbers.
//!
//! ```text
//!  3 study
//!  2 viewer
//!  1 compare
//!  0 error text document noise false_color
//! ```
//!
//! # Modules, in reading order
//!
//! * [`compare`]: error measures, SSIM, HDR-FLIP, z-scores of blocks, expected errors from noise.
//! * [`noise`]: variances of means over an image, in the metadata of image files.
//! * [`document`]: pages of text, tables and plots; written as Markdown, or as part of an HTML
//!   page.
//! * [`viewer`]: HTML pages to inspect images beside their reference.
//! * [`study`]: plans, runs, results and their page.
//! * [`false_color`]: maps of numbers in false colors.
//! * [`text`] and [`error`]: text helpers and errors.
//!
//! # Example
//!
//! Compare two images of 2 x 1 pixels in memory:
//!
//! ```
//! use manylight_lab::compare::{ComparisonImage, compare};
//!
//! let reference = ComparisonImage::from_rgb(2, 1, vec![[1.0; 3], [3.0; 3]]);
//! let image = ComparisonImage::from_rgb(2, 1, vec![[1.5; 3], [3.0; 3]]);
//! let comparison = compare("image", &image, &reference);
//! // (0.5² + 0²) / 2 in each channel.
//! assert_eq!(comparison.errors.mse, 0.125);
//! // Means 2.25 and 2.
//! assert_eq!(comparison.means.ratio_of_means, [Some(1.125); 3]);
//! assert!(comparison.flip > 0.0);
//! ```

pub mod compare;
pub mod document;
pub mod error;
pub mod false_color;
pub mod noise;
pub mod study;
pub mod text;
pub mod viewer;

pub use error::{LabError, PlanError};
