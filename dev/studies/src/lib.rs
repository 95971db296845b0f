//! Studies of articles that Sinew takes ideas from: what they claim, tried again on other data.
//!
//! - `recordings`: data sets by their index, on one skeleton, at 12 Hz.
//! - `spatial`: Hauberg & Pedersen's four experiments, over `mds`, `isomap`, `medoid_shift` and `mann_whitney`; all
//!   distances of a data set for NumPy (`distances`).
//! - `autoencoder`: networks of poses with five losses (`loss`, `weights`), forward kinematics in tensors
//!   (`kinematics`), checkpoints that go on bit by bit.
//! - `pictures`, `cli`: pictures, of the blocks of the report; a file for each study.

pub mod autoencoder;
pub mod pictures;
pub mod recordings;
pub mod spatial;
mod tables;
