//! A servo of a description; values that the file leaves out are those of its kind.

use crate::description::{Description, DescriptionError, Path, ServoModel, Step};
use crate::nearest::nearest;
use crate::number::single;
use crate::servo::{Servo, ServoSettings};

/// Returns the servo at an index of the description.
pub(super) fn of(rig: &Description, index: usize) -> Result<Servo, DescriptionError> {
    let described = &rig.servos[index];
    let refused = |key, expected: String, found: String| DescriptionError {
        path: Path(vec![Step::Key("servo"), Step::Index(index), Step::Key(key)]),
        item: format!("servo {:?}", described.name),
        expected,
        found,
    };
    let model = rig.servo_model(&described.model).ok_or_else(|| {
        refused("model", known_models(rig, &described.model), format!("{:?}", described.model))
    })?;
    // A servo's own position is zero in the middle of its range.
    let half = 0.5 * model.range_rad.value;
    let range = described.range_rad.first().copied();
    let range = range
        .or_else(|| rig.pulses(described).map(|pulses| pulses.range_rad()))
        .unwrap_or([-half, half]);
    Servo::new(ServoSettings {
        gear: single(f64::from(described.direction) * described.gear),
        offset_rad: single(described.offset_rad.unwrap_or(0.0)),
        range_rad: range.map(single),
        torque_nm: single(described.torque_nm.unwrap_or(model.stall_torque_nm.value)),
        speed_rad_s: single(described.speed_rad_s.unwrap_or(model.no_load_speed_rad_s.value)),
        acceleration_rad_s2: described.acceleration_rad_s2.map_or(f32::INFINITY, single),
        torque_constant_nm_a: single(model.torque_constant_nm_a.value),
        position_gain_nm_rad: single(model.position_gain_nm_rad.value),
        friction_nm: single(model.friction_nm.value),
        damping_nm_s: single(model.damping_nm_s.value),
        rotor_inertia_kg_m2: single(model.rotor_inertia_kg_m2.value),
        on_signal_loss: described.on_signal_loss,
    })
    .map_err(|error| {
        refused("model", "numbers that a servo can have".to_owned(), error.to_string())
    })
}

impl Description {
    /// Returns a kind of servo by name: the rig's own if there is one, otherwise a built-in kind.
    pub fn servo_model(&self, name: &str) -> Option<ServoModel> {
        let own = self.servo_models.iter().find(|model| model.name == name);
        own.cloned().or_else(|| ServoModel::built_in(name))
    }
}

fn known_models(rig: &Description, wrong: &str) -> String {
    let mut names: Vec<&str> = rig.servo_models.iter().map(|model| model.name.as_str()).collect();
    for name in ServoModel::built_in_names() {
        names.push(name);
    }
    let begins = |name: &&str| name.to_lowercase().starts_with(&wrong.to_lowercase());
    let longer = names.iter().copied().find(|name| !wrong.is_empty() && begins(name));
    match longer.or_else(|| nearest(wrong, names.iter().copied())) {
        Some(near) => format!("a known kind of servo, such as {near:?}"),
        None => format!("a known kind of servo: {}", names.join(", ")),
    }
}
