//! Doubtful values of a rig file: those of the description, and servos whose address their kind cannot have.

use sinew_rig::Description;
use sinew_rig::description::{Address, Doubt, ServoModel};
use sinew_servo_sim::registers::RegisterTable;

/// Returns doubtful values of a rig's file: first those of the description, then those of the servos.
pub(super) fn doubts(rig: &Description) -> Vec<Doubt> {
    let mut doubts = rig.doubts();
    for servo in &rig.servos {
        let kind = ServoModel::with_article(&servo.model);
        let has_bus = RegisterTable::of(&servo.model).is_some();
        let text = match servo.address {
            Address::Id(id) if !has_bus && ServoModel::built_in(&servo.model).is_some() => format!(
                "{kind} is a hobby servo, which takes pulses and has no id: write `channel = N`, its place on a \
                 PCA9685, for `id = {id}`"
            ),
            Address::Id(id) if !has_bus => format!(
                "{kind} is on no bus that Sinew speaks, so `id = {id}` reaches nobody: `channel` is for servos that \
                 take pulses"
            ),
            Address::Channel(channel) if has_bus => format!(
                "{kind} is a bus servo: write `id = N` for `channel = {channel}`, which is a place on a PCA9685"
            ),
            _ => continue,
        };
        doubts.push(Doubt { about: format!("servo {}", servo.name), text });
    }
    doubts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_servo_whose_kind_has_no_such_address_is_named() {
        let mut rig = sinew_rig::new::arm(4).unwrap();
        assert_eq!(doubts(&rig), []);
        "MG90S".clone_into(&mut rig.servos[0].model);
        "XYZ".clone_into(&mut rig.servos[1].model);
        rig.servos[2].address = Address::Channel(3);
        "MG996R".clone_into(&mut rig.servos[3].model);
        rig.servos[3].address = Address::Channel(4);
        let told: Vec<_> = doubts(&rig).iter().map(ToString::to_string).collect();
        let [hobby, unknown, bus] = &told[..] else { panic!("{told:?}") };
        assert!(hobby.starts_with("servo turn1: an MG90S is a hobby servo"), "{hobby}");
        assert!(hobby.contains("`channel = N`") && hobby.contains("`id = 1`"), "{hobby}");
        assert!(unknown.contains("reaches nobody"), "{unknown}");
        assert!(bus.contains("is a bus servo: write `id = N`"), "{bus}");
    }
}
