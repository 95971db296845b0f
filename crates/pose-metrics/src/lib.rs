//! How poses, clips and joints compare: distances of poses, geodesics, search, blends, and the importance of joints.

pub mod blend;
pub mod character;
pub mod find;
pub mod geodesic;
pub mod spatial;
pub mod weights;
