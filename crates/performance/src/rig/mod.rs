//! The user's rigs: files of any format that `sinew-rig` reads, and the work of the commands on them.

mod doubts;
mod dynamics;
mod file;
mod review;
mod size;

pub use dynamics::{DynamicsError, dof_names, inverse_dynamics};
pub use file::{LoadedRig, RigFileError, has_feet, load};
pub use review::review;
pub use size::at_home;
