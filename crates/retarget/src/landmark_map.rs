//! A map with a value for every landmark.

use std::ops::{Index, IndexMut};

use crate::Landmark;

/// A value for every landmark, in the order of [`Landmark::ALL`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LandmarkMap<T>([T; Landmark::ALL.len()]);

impl<T> LandmarkMap<T> {
    /// Creates the map by calling `value` for each landmark in turn.
    pub fn of(value: impl FnMut(Landmark) -> T) -> Self {
        Self(Landmark::ALL.map(value))
    }

    /// Returns all landmarks with their values.
    pub fn iter(&self) -> impl Iterator<Item = (Landmark, &T)> {
        Landmark::ALL.into_iter().zip(&self.0)
    }

    /// Returns all values, in the order of the landmarks.
    pub(crate) fn values_mut(&mut self) -> impl Iterator<Item = &mut T> {
        self.0.iter_mut()
    }
}

impl<T> Index<Landmark> for LandmarkMap<T> {
    type Output = T;

    fn index(&self, landmark: Landmark) -> &T {
        &self.0[place(landmark)]
    }
}

impl<T> IndexMut<Landmark> for LandmarkMap<T> {
    fn index_mut(&mut self, landmark: Landmark) -> &mut T {
        &mut self.0[place(landmark)]
    }
}

fn place(landmark: Landmark) -> usize {
    let index = |side| usize::from(side == crate::Side::Right);
    match landmark {
        Landmark::Pelvis => 0,
        Landmark::Chest => 1,
        Landmark::Neck => 2,
        Landmark::Head => 3,
        Landmark::Shoulder(side) => index(side) * 3 + 4,
        Landmark::Elbow(side) => index(side) * 3 + 5,
        Landmark::Wrist(side) => index(side) * 3 + 6,
        Landmark::Hip(side) => index(side) * 4 + 10,
        Landmark::Knee(side) => index(side) * 4 + 11,
        Landmark::Ankle(side) => index(side) * 4 + 12,
        Landmark::Toe(side) => index(side) * 4 + 13,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_places_are_those_of_the_list() {
        for (index, landmark) in Landmark::ALL.into_iter().enumerate() {
            assert_eq!(place(landmark), index, "{landmark:?}");
        }
    }
}
