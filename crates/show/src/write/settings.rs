//! Settings of the writer: error bounds, block length and step.

/// Settings of the writer, which bound the error of a show.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Maximum error of angles and rotations, rad. Default: 0.25°.
    pub angle_rad: f64,
    /// Maximum error of displacements and positions, along each axis, m. Default: 1 mm.
    pub length_m: f64,
    /// Length of a block, s. Default: 4.
    pub block_s: f64,
    /// Step of control values, as a share of the maximum error. Default: 1/2.
    pub step: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { angle_rad: 0.25_f64.to_radians(), length_m: 1e-3, block_s: 4.0, step: 0.5 }
    }
}
