//! How like a performer a rig is: angles between their limbs.

/// Mean and largest of angles.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Angles {
    sum_deg: f64,
    count: u64,
    /// The largest, deg.
    pub largest_deg: f64,
}

impl Angles {
    /// Adds one more, deg.
    pub fn add(&mut self, angle_deg: f64) {
        self.sum_deg += angle_deg;
        self.count += 1;
        self.largest_deg = self.largest_deg.max(angle_deg);
    }

    /// Adds those of another.
    pub fn merge(&mut self, other: &Self) {
        self.sum_deg += other.sum_deg;
        self.count += other.count;
        self.largest_deg = self.largest_deg.max(other.largest_deg);
    }

    /// Whether there were none.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Their mean, deg.
    pub fn mean_deg(&self) -> f64 {
        self.sum_deg / self.count.max(1) as f64
    }
}

/// The limbs of a rig against those of the performer whose motion it has taken over. Empty of other motions.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Likeness {
    /// Of the rig's own target: the same for all methods.
    pub retargeting: Angles,
    /// Of the simulated rig.
    pub total: Angles,
}

impl Likeness {
    /// Adds those of another.
    pub fn merge(&mut self, other: &Self) {
        self.retargeting.merge(&other.retargeting);
        self.total.merge(&other.total);
    }
}
