//! Checks servos and their kinds.

use std::collections::HashMap;

use super::joints::check_range;
use super::part::{Part, Sign, shown};
use crate::description::error::{DescriptionError, Step};
use crate::description::{Address, Pulses, Servo, ServoModel, SourcedValue};
use crate::number;

/// Values of a kind that may be zero; all others must be positive.
pub(super) const MAY_BE_ZERO: [&str; 6] = [
    "continuous_torque_nm",
    "position_gain_nm_rad",
    "friction_nm",
    "damping_nm_s",
    "backlash_rad",
    "thermal_resistance_k_w",
];

/// Largest accepted step and play of a servo, rad: six times the play of hobby servos.
const COARSEST_RAD: f64 = 0.1;

/// Shortest and longest permitted pulse of a hobby servo, us.
const PULSES_US: [f64; 2] = [200.0, 4000.0];

/// Fastest vibration of a rotor on its gear, rad/s (190 Hz): its phase changes by 0.3 rad in a step of the
/// simulated servos, 0.25 ms. The step does not resolve faster vibrations: light bodies would be thrown when teeth
/// meet.
const FASTEST_RING_RAD_S: f64 = 1200.0;

/// Name of the servo at each address of each bus.
pub(super) type Addresses<'a> = HashMap<(&'a str, Address), &'a str>;

pub(super) fn check<'a>(
    addresses: &mut Addresses<'a>,
    index: usize,
    servo: &'a Servo,
) -> Result<(), DescriptionError> {
    let part = Part::of("servo", index, &servo.name);
    for (key, name) in [("model", &servo.model), ("bus", &servo.bus)] {
        if name.trim().is_empty() {
            return Err(part.refuse(&[Step::Key(key)], "a name", format!("{name:?}")));
        }
    }
    check_address(part, addresses, servo)?;
    if ![1, -1].contains(&servo.direction) {
        return Err(part.refuse(&[Step::Key("direction")], "1 or -1", servo.direction));
    }
    part.number_if_any("offset_deg", servo.offset_rad, Sign::Any)?;
    part.number_if_any("homing_offset_deg", servo.homing_offset_rad, Sign::Any)?;
    part.number(&[Step::Key("gear")], servo.gear, Sign::Positive)?;
    check_pulses(part, servo)?;
    let at = [Step::Key("range_deg")];
    for pair in &servo.range_rad {
        check_range(part, &at, *pair)?;
    }
    if servo.range_rad.len() > 1 {
        let found = servo.range_rad.len();
        return Err(part.refuse(&at, "one pair [least, most]", found));
    }
    part.number_if_any("torque_nm", servo.torque_nm, Sign::Positive)?;
    for (key, limit) in
        [("speed_deg_s", servo.speed_rad_s), ("acceleration_deg_s2", servo.acceleration_rad_s2)]
    {
        part.number_if_any(key, limit, Sign::Motion)?;
    }
    if servo.p_gain == Some(0) {
        return Err(part.refuse(&[Step::Key("p_gain")], "a whole number above 0", 0));
    }
    Ok(())
}

/// Refuses pulses and travel of a servo that is not driven by pulses, and invalid pulses.
fn check_pulses(part: Part<'_>, servo: &Servo) -> Result<(), DescriptionError> {
    let given =
        [("pulse_us", servo.pulse_us.is_some()), ("travel_deg", servo.travel_rad.is_some())];
    if let (Address::Id(id), Some((key, _))) =
        (servo.address, given.into_iter().find(|(_, is_given)| *is_given))
    {
        let expected =
            "no such key of a servo with an id: only hobby servos (`channel`) take pulses";
        return Err(part.refuse(&[Step::Key(key)], expected, format!("it with id = {id}")));
    }
    part.number_if_any("travel_deg", servo.travel_rad, Sign::Positive)?;
    let Some([least, middle, most]) = servo.pulse_us else { return Ok(()) };
    let [shortest, longest] = PULSES_US;
    // The comparisons also refuse NaN.
    if shortest <= least && least < middle && middle < most && most <= longest {
        return Ok(());
    }
    let expected = format!(
        "[least, middle, most] in us, rising, from {shortest} to {longest}; `direction = -1` turns a servo around"
    );
    let found = [least, middle, most].map(number::text).join(", ");
    Err(part.refuse(&[Step::Key("pulse_us")], expected, format!("[{found}]")))
}

fn check_address<'a>(
    part: Part<'_>,
    addresses: &mut Addresses<'a>,
    servo: &'a Servo,
) -> Result<(), DescriptionError> {
    let (key, number, most) = match servo.address {
        // 253 and 254 are reserved by the bus, 255 begins a packet.
        Address::Id(id) => ("id", id, 252),
        Address::Channel(channel) => ("channel", channel, 15),
    };
    let at = [Step::Key(key)];
    if number > most {
        return Err(part.refuse(&at, format!("a whole number from 0 to {most}"), number));
    }
    if let Some(first) = addresses.insert((&servo.bus, servo.address), &servo.name) {
        let expected = format!("an {key} that no other servo of bus {:?} has", servo.bus);
        return Err(part.refuse(&at, expected, format!("{number}, as servo {first:?} has")));
    }
    Ok(())
}

pub(super) fn check_model(index: usize, model: &ServoModel) -> Result<(), DescriptionError> {
    let part = Part::of("servo_model", index, &model.name);
    let fine = [
        ("resolution_rad", model.resolution_rad.value, "above 0", model.resolution_rad.value > 0.0),
        ("backlash_rad", model.backlash_rad.value, "from 0", model.backlash_rad.value >= 0.0),
    ];
    for (key, value, least, is_right) in fine {
        // The comparison also refuses NaN.
        if !is_right || value > COARSEST_RAD {
            let at = [Step::Key(key), Step::Key("value")];
            let expected = format!("a number {least}, at most {COARSEST_RAD} rad (5.7 deg)");
            return Err(part.refuse(&at, expected, shown(&at, value)));
        }
    }
    for (key, sourced) in model.clone().values_mut() {
        let sign = if MAY_BE_ZERO.contains(&key) { Sign::NotNegative } else { Sign::Positive };
        check_sourced(part, key, sourced, sign)?;
    }
    let stall_nm = model.stall_torque_nm.value;
    if model.friction_nm.value >= stall_nm {
        let at = [Step::Key("friction_nm"), Step::Key("value")];
        let expected = format!("less than stall_torque_nm ({stall_nm} N m), or it never turns");
        return Err(part.refuse(&at, expected, shown(&at, model.friction_nm.value)));
    }
    for (key, sourced) in model.clone().optional_values_mut() {
        let Some(sourced) = sourced else { continue };
        if key == "output_friction_share" && !(0.0..=1.0).contains(&sourced.value) {
            let at = [Step::Key(key), Step::Key("value")];
            return Err(part.refuse(&at, "a part from 0 to 1", sourced.value));
        }
        let sign = if key == "gear_stiffness_nm_rad" { Sign::Positive } else { Sign::NotNegative };
        check_sourced(part, key, sourced, sign)?;
    }
    let [least, middle, most] = Pulses::of_model(model).us;
    if !(PULSES_US[0] <= least && least < middle && middle < most && most <= PULSES_US[1]) {
        let at = [Step::Key("pulse_middle_us"), Step::Key("value")];
        let [shortest, longest] = PULSES_US;
        let expected = format!(
            "rising pulses from {shortest} to {longest} us: pulse_least_us (default 500), pulse_middle_us (1500), \
             pulse_most_us (2500)"
        );
        return Err(part.refuse(&at, expected, format!("{least}, {middle} and {most}")));
    }
    check_ring(part, model)
}

/// Refuses a gear whose rotor vibrates faster against a held shaft than simulations resolve.
fn check_ring(part: Part<'_>, model: &ServoModel) -> Result<(), DescriptionError> {
    let rotor_kg_m2 = model.rotor_inertia_kg_m2.value;
    let stiffness_nm_rad = model.gear_stiffness();
    let most_nm_rad = rotor_kg_m2 * FASTEST_RING_RAD_S * FASTEST_RING_RAD_S;
    if stiffness_nm_rad <= most_nm_rad {
        return Ok(());
    }
    let at = [Step::Key("gear_stiffness_nm_rad"), Step::Key("value")];
    let expected = format!(
        "at most {} N m/rad with rotor_inertia_kg_m2 = {rotor_kg_m2}: a gear whose rotor rings at 190 Hz or less",
        number::text(number::rounded(most_nm_rad)),
    );
    Err(part.refuse(&at, expected, shown(&at, stiffness_nm_rad)))
}

fn check_sourced(
    part: Part<'_>,
    key: &'static str,
    sourced: &SourcedValue,
    sign: Sign,
) -> Result<(), DescriptionError> {
    part.number(&[Step::Key(key), Step::Key("value")], sourced.value, sign)?;
    if sourced.source.trim().is_empty() {
        let expected = "where the value is from, or \"guess: ...\"";
        let at = [Step::Key(key), Step::Key("source")];
        return Err(part.refuse(&at, expected, "an empty text"));
    }
    Ok(())
}
