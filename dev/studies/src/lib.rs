//! Studies of articles whose ideas Sinew uses: their claims, tested on other data.
//!
//! - `recordings`: data sets by their index, on one skeleton, at 12 Hz.
//! - `spatial`: Hauberg & Pedersen's four experiments, with `mds`, `isomap`, `medoid_shift` and `mann_whitney`; all
//!   distances of a data set for NumPy (`distances`).
//! - `autoencoder`: networks of poses with five losses (`loss`, `weights`), forward kinematics in tensors
//!   (`kinematics`), checkpoints that resume bit by bit.
//! - `pictures`: pictures, made of the parts of the report. `cli`: the command line, a file for each study.

pub mod autoencoder;
pub mod pictures;
pub mod recordings;
pub mod spatial;
mod tables;
