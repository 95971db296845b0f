//! The similarity of a rig to its performer: angles between their limbs.

/// Mean and maximum of angles.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Angles {
    sum_deg: f64,
    count: u64,
    /// Largest angle, deg.
    pub largest_deg: f64,
}

impl Angles {
    /// Adds an angle, deg.
    pub fn add(&mut self, angle_deg: f64) {
        self.sum_deg += angle_deg;
        self.count += 1;
        self.largest_deg = self.largest_deg.max(angle_deg);
    }

    /// Adds all angles of another sum.
    pub fn merge(&mut self, other: &Self) {
        self.sum_deg += other.sum_deg;
        self.count += other.count;
        self.largest_deg = self.largest_deg.max(other.largest_deg);
    }

    /// Returns whether no angle was added.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Returns the mean angle, deg.
    pub fn mean_deg(&self) -> f64 {
        self.sum_deg / self.count.max(1) as f64
    }
}

/// The angles between a rig's limbs and those of the performer whose motion it performs. Empty for other motions.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Likeness {
    /// Angles of the rig's target pose. They do not depend on the method.
    pub retargeting: Angles,
    /// Angles of the simulated rig.
    pub total: Angles,
}

impl Likeness {
    /// Adds the angles of another comparison.
    pub fn merge(&mut self, other: &Self) {
        self.retargeting.merge(&other.retargeting);
        self.total.merge(&other.total);
    }
}
