//! Comparison of poses, clips and joints: distances of poses, geodesics, search, blends, and the importance of
//! joints.
//!
//! - [`spatial`] compares poses of one skeleton with the measures of `core`: `rigid` finds the joints that move,
//!   `rig` makes any joint the root, `measure` selects the distance, `matrix` stores all pairs.
//! - [`geodesic`] finds the shortest paths between poses that keep bone lengths, by Newton's method in f64.
//!   `limit` and `curve` keep ranges by an interior-point method. The matrix is eliminated pose by pose
//!   (`by_pose`), or joint by joint (`by_joint`) if a rig has many joints. The module shares no code with `core`.
//! - [`find`] searches a library of clips and skips moments only by lower bounds; [`blend`] blends one clip into
//!   another.
//! - [`character`] reads skinned characters, rigs and skeletons into one representation: joints at rest.
//! - [`weights`] computes the importance of a character's joints.

pub mod blend;
pub mod character;
pub mod find;
pub mod geodesic;
pub mod spatial;
pub mod weights;
