//! Properties and golden numbers across the crates. They are one program so that the core's kernels are compiled for
//! it once.

mod in_time;
mod limits;
mod motion;
mod parity;
mod play_in_qemu;
mod stillness;
mod tables;
