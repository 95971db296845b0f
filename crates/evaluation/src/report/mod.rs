//! The result as text, JSON and CSV.

mod csv;
mod json;
mod likeness;
mod table;

pub use csv::{clips_csv, result_csv};
pub use json::json;
pub use table::tables;
