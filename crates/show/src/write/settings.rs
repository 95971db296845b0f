//! Error bounds, block length and step of a show that is written.

/// Settings of the writer: how near a show must be to its samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// The largest error of angles and rotations, rad. Default: 0.25°.
    pub angle_rad: f64,
    /// The largest error of displacements and positions, along each axis, m. Default: 1 mm.
    pub length_m: f64,
    /// How long a block is, s. Default: 4.
    pub block_s: f64,
    /// The step of control values, in shares of the largest error. Default: 1/2.
    pub step: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { angle_rad: 0.25_f64.to_radians(), length_m: 1e-3, block_s: 4.0, step: 0.5 }
    }
}
