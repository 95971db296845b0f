//! Writes the result as text, JSON and CSV.

mod csv;
mod json;
mod latency;
mod likeness;
mod robustness;
mod table;

pub use csv::{clips_csv, result_csv};
pub use json::json;
pub use latency::latency_table;
pub use robustness::robustness_tables;
pub use table::tables;
