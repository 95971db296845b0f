//! Properties and golden numbers that hold across the crates. One program: the core's kernels are compiled for it once.

mod limits;
mod motion;
mod parity;
mod play_in_qemu;
mod stillness;
mod tables;
