//! Native part of the Python package `sinew_motion`. It converts arrays for the crates that the command `sinew` uses.
//!
//! The Python code in `python/sinew_motion` checks shapes, and documents each function. This crate converts numbers and
//! errors, and calls the other crates.
//!
//! - `arrays`, `error`, `work`: arrays of NumPy, exceptions, and long work without Python's global lock.
//! - `rig`, `dynamics`, `jacobian`, `tracker`: rigs, their dynamics in f32, and the tick of the controller.
//! - `clip`, `show`: recorded clips, their retargeting to a rig, and shows.
//! - `errors`, `heading`, `metrics`: state errors, distances between poses, importance of joints.
//! - `board/`: boards at ports, simulated boards, consoles.
//! - `evaluate`, `motions`: the evaluation and its sweeps, and the motions that they track.

#![forbid(unsafe_code)]
#![expect(clippy::needless_pass_by_value, reason = "PyO3 passes arrays and objects by value")]

mod arrays;
#[cfg(unix)]
mod board;
mod clip;
mod dynamics;
mod error;
mod errors;
mod evaluate;
mod heading;
mod jacobian;
mod metrics;
mod motions;
mod rig;
mod show;
mod tracker;
mod work;

use pyo3::prelude::*;

#[pymodule]
mod _sinew_motion {
    #[cfg(unix)]
    #[pymodule_export]
    use crate::board::{BoardError, NativeBoard, NativeConsole, open_board, open_console};
    #[pymodule_export]
    use crate::clip::{NativeClip, read_clip};
    #[pymodule_export]
    use crate::errors::errors;
    #[pymodule_export]
    use crate::evaluate::{evaluate, methods, sweep};
    #[pymodule_export]
    use crate::metrics::{geodesic, importance, pose_distance};
    #[pymodule_export]
    use crate::rig::{NativeRig, load_rig, new_arm, new_face};
    #[pymodule_export]
    use crate::show::{NativeShow, bake, map, open_show, retarget};
    #[pymodule_export]
    use crate::tracker::NativeTracker;
}
