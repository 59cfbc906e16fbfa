//! Pages of text, tables and plots, before they become Markdown or HTML.

mod parts;
mod table;

pub use parts::{Document, DocumentPart, Plot, PlotLine};
pub use table::{DocumentTable, TableCell};
