//! Reads numbers with serde, and refuses those that are not finite or not unit. Types that derive `Deserialize` name
//! these functions on their fields.

use core::fmt;

use glam::{Quat, Vec3};
use serde::de::{Deserialize, Deserializer, Error};

use crate::math::{self, UNIT_TOLERANCE};

/// A value that consists of one or several numbers.
pub(crate) trait Numbers: fmt::Debug {
    fn are_finite(&self) -> bool;
}

impl Numbers for f32 {
    fn are_finite(&self) -> bool {
        self.is_finite()
    }
}

impl Numbers for Vec3 {
    fn are_finite(&self) -> bool {
        self.is_finite()
    }
}

impl Numbers for Quat {
    fn are_finite(&self) -> bool {
        self.is_finite()
    }
}

impl<T: Numbers, const K: usize> Numbers for [T; K] {
    fn are_finite(&self) -> bool {
        self.iter().all(Numbers::are_finite)
    }
}

/// Reads a value that must be finite.
pub(crate) fn finite<'de, T, D>(from: D) -> Result<T, D::Error>
where
    T: Numbers + Deserialize<'de>,
    D: Deserializer<'de>,
{
    let value = T::deserialize(from)?;
    if value.are_finite() {
        Ok(value)
    } else {
        Err(D::Error::custom(format_args!("{value:?} is not finite; only finite numbers will do")))
    }
}

/// Reads a unit quaternion.
pub(crate) fn unit_rotation<'de, D: Deserializer<'de>>(from: D) -> Result<Quat, D::Error> {
    let rotation: Quat = finite(from)?;
    if math::is_unit(rotation) {
        Ok(rotation)
    } else {
        let squared = rotation.dot(rotation);
        Err(D::Error::custom(format_args!(
            "{rotation:?} has squared length {squared}; a rotation must be a unit quaternion [x, y, z, w]"
        )))
    }
}

/// Reads a unit vector.
pub(crate) fn unit_axis<'de, D: Deserializer<'de>>(from: D) -> Result<Vec3, D::Error> {
    let axis: Vec3 = finite(from)?;
    let length = math::length(axis);
    if (length - 1.0).abs() <= UNIT_TOLERANCE {
        Ok(axis)
    } else {
        Err(D::Error::custom(format_args!(
            "{axis:?} has length {length}; an axis must be a unit vector"
        )))
    }
}
