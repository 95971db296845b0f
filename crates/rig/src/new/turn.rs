//! A revolute joint of the starting rigs.

use crate::description::Joint;

/// A revolute joint with the name of the body that it moves.
pub(super) struct Turn<'a> {
    pub(super) name: &'a str,
    pub(super) parent: &'a str,
    pub(super) position_m: [f64; 3],
    pub(super) axis: [f64; 3],
    pub(super) range_deg: [f64; 2],
    pub(super) home_deg: f64,
    pub(super) speed_deg_s: f64,
    pub(super) acceleration_deg_s2: f64,
}

impl Turn<'_> {
    pub(super) fn joint(&self) -> Joint {
        Joint {
            name: self.name.to_owned(),
            parent: self.parent.to_owned(),
            child: self.name.to_owned(),
            position_m: self.position_m,
            axis: Some(self.axis),
            range_rad: vec![self.range_deg.map(f64::to_radians)],
            // Zero is the default, and is left out.
            home_rad: (self.home_deg.abs() > 0.0).then_some(self.home_deg.to_radians()),
            speed_rad_s: Some(self.speed_deg_s.to_radians()),
            acceleration_rad_s2: Some(self.acceleration_deg_s2.to_radians()),
            ..Joint::default()
        }
    }
}
