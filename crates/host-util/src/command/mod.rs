//! Functions that commands share: common options, and output to the terminal.

mod exit;
mod output;
mod table;
mod threads;

pub use exit::exit_code;
pub use output::{note, print, print_raw, with_progress};
pub use table::table;
pub use threads::ThreadArgs;
