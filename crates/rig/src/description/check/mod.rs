//! Checks a description, and refuses invalid values.

mod bodies;
mod drives;
mod face_shapes;
mod joints;
mod limits;
mod names;
mod part;
mod servos;
#[cfg(test)]
mod tests;
mod tree;

use super::Description;
use super::error::{DescriptionError, Step};
pub(super) use tree::Shape;

pub(crate) use bodies::is_possible;
use names::Names;
use part::{Part, Sign};

impl Description {
    /// Refuses an invalid description. O(bodies + joints + servos).
    ///
    /// In an accepted description, names are unique and every used name exists; bodies are a tree; numbers fit f32,
    /// axes and rotations have unit length, inertias are physically possible; the home pose is within all limits,
    /// kinds of servo are known, and no drive is singular.
    ///
    /// # Errors
    /// The first [`DescriptionError`] in the order of the file's sections.
    pub fn check(&self) -> Result<(), DescriptionError> {
        self.checked()?;
        self.actuation()?;
        Ok(())
    }

    /// Performs [`Self::check`] up to the actuation, and returns the tree of bodies.
    pub(super) fn checked(&self) -> Result<Shape, DescriptionError> {
        self.check_standing()?;
        let bodies = Names::new("body", self.bodies.iter().map(|body| &body.name))?;
        for (index, body) in self.bodies.iter().enumerate() {
            bodies::check(Part::of("body", index, &body.name), body)?;
        }
        let joints = Names::new("joint", self.joints.iter().map(|joint| &joint.name))?;
        for (index, joint) in self.joints.iter().enumerate() {
            joints::check(Part::of("joint", index, &joint.name), joint)?;
        }
        let shape = tree::shape(self, &bodies)?;
        for (index, limit) in self.limits.iter().enumerate() {
            limits::check(self, &joints, index, limit)?;
        }
        Names::new("shape", self.face_shapes.iter().map(|shape| &shape.name))?;
        for (index, shape) in self.face_shapes.iter().enumerate() {
            face_shapes::check(self, &joints, index, shape)?;
        }
        let servos = Names::new("servo", self.servos.iter().map(|servo| &servo.name))?;
        let mut owners = drives::Owners::new(self);
        for (index, drive) in self.drives.iter().enumerate() {
            drives::check(self, (&joints, &servos), &mut owners, index, drive)?;
        }
        let mut addresses = servos::Addresses::new();
        for (index, servo) in self.servos.iter().enumerate() {
            servos::check(&mut addresses, index, servo)?;
        }
        Names::new("servo_model", self.servo_models.iter().map(|model| &model.name))?;
        for (index, model) in self.servo_models.iter().enumerate() {
            servos::check_model(index, model)?;
        }
        Ok(shape)
    }

    /// Checks the rig's name, its mount and its power supply.
    fn check_standing(&self) -> Result<(), DescriptionError> {
        if self.name.trim().is_empty() {
            let found = format!("{:?}", self.name);
            return Err(tree::of_rig("name", "a name".to_owned(), found));
        }
        let mount = Part::single("mount");
        mount.numbers(&[Step::Key("position_m")], &self.mount.position_m, Sign::Any)?;
        mount.unit_length("rotation_xyzw", &self.mount.rotation_xyzw)?;
        if let Some(supply) = &self.supply {
            let part = Part::single("supply");
            part.number(&[Step::Key("voltage_v")], supply.voltage_v, Sign::Positive)?;
            part.number(&[Step::Key("current_a")], supply.current_a, Sign::Positive)?;
        }
        Ok(())
    }
}
