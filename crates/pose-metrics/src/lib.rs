//! How poses, clips and joints compare: distances of poses, geodesics, search, blends, and the importance of joints.
//!
//! - [`spatial`] compares poses of one skeleton as `core` does: `rigid` finds the joints that move, `rig` sees them
//!   from any joint, `measure` chooses the distance, `matrix` keeps all pairs.
//! - [`geodesic`] finds the shortest ways between poses that keep bone lengths, by Newton's method in f64. `limit` and
//!   `curve` keep ranges by an interior-point method. Its matrix is eliminated pose by pose (`by_pose`), or joint by
//!   joint (`by_joint`) where a rig has many joints. It shares nothing with `core`.
//! - [`find`] searches a library of clips, leaving moments out only by lower bounds; [`blend`] leads one clip into
//!   another.
//! - [`character`] reads skinned characters, rigs and skeletons, each to the same joints at rest.
//! - [`weights`] computes the importance of a character's joints.

pub mod blend;
pub mod character;
pub mod find;
pub mod geodesic;
pub mod spatial;
pub mod weights;
