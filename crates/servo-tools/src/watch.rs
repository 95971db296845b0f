//! Reads the measurements and faults of a servo.

use sinew_servo_bus::dynamixel::table::address as dxl;
use sinew_servo_bus::dynamixel::{StatusError, hardware_error};
use sinew_servo_bus::feetech::table::address as feetech_address;
use sinew_servo_bus::feetech::{Family, status_bit};

use crate::quantity::{Quantity, quantity};
use crate::{Client, Exchange, ServiceError, Servo, Table};

/// Measurements and faults of a servo.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// Position, zero where the encoder counts zero.
    pub position: Quantity,
    /// Speed.
    pub velocity: Quantity,
    /// Current, or load for a servo that does not measure current.
    pub effort: Quantity,
    /// Supply voltage.
    pub voltage: Quantity,
    /// Temperature of the case.
    pub temperature: Quantity,
    /// Faults, in words.
    pub errors: Vec<&'static str>,
}

/// Addresses of position, speed, load, voltage and temperature of a Feetech.
const FEETECH: [u16; 5] = [56, 58, 60, 62, 63];

/// Reads a servo once. A Dynamixel that reports a fault needs a second read.
///
/// # Errors
/// The errors of [`Client::read_bytes`].
pub fn look<E: Exchange>(client: &mut Client<E>, servo: &Servo) -> Result<State, ServiceError> {
    let (addresses, first, end) = match &servo.table {
        Table::Dynamixel(_) => {
            let addresses = [
                dxl::PRESENT_POSITION,
                dxl::PRESENT_VELOCITY,
                dxl::PRESENT_CURRENT,
                dxl::PRESENT_VOLTAGE,
                dxl::PRESENT_TEMPERATURE,
            ];
            (addresses, dxl::PRESENT_CURRENT, dxl::PRESENT_TEMPERATURE + 1)
        }
        Table::Feetech(table) => {
            let current = u16::from(feetech_address::PRESENT_CURRENT);
            let mut addresses = FEETECH;
            // Only STS servos measure current.
            if table.model.family == Family::Sts {
                addresses[2] = current;
                (addresses, FEETECH[0], current + 2)
            } else {
                (addresses, FEETECH[0], u16::from(feetech_address::STATUS) + 1)
            }
        }
    };
    let (bytes, error) = client.read_bytes(servo.id, first, end - first)?;
    let [position, velocity, effort, voltage, temperature] = addresses.map(|address| {
        let bytes = bytes.get(usize::from(address - first)..).unwrap_or_default();
        servo.table.at(address).map(|item| quantity(&item, item.value(bytes, servo.table.order())))
    });
    let (Some(position), Some(velocity), Some(effort), Some(voltage), Some(temperature)) =
        (position, velocity, effort, voltage, temperature)
    else {
        let what = "its table has no registers of what it measures".to_owned();
        return Err(ServiceError::State { id: servo.id, what });
    };
    let errors = match servo.table {
        Table::Dynamixel(_) if StatusError::from_byte(error).alert() => {
            let (bytes, _) = client.read_bytes(servo.id, dxl::HARDWARE_ERROR, 1)?;
            dynamixel_errors(bytes.first().copied().unwrap_or(0))
        }
        Table::Dynamixel(_) => Vec::new(),
        Table::Feetech(_) => feetech_errors(error),
    };
    Ok(State { position, velocity, effort, voltage, temperature, errors })
}

fn words(bits: u8, names: &[(u8, &'static str)]) -> Vec<&'static str> {
    let mut words: Vec<_> =
        names.iter().filter(|(bit, _)| bits & bit != 0).map(|(_, word)| *word).collect();
    let known = names.iter().fold(0, |known, (bit, _)| known | bit);
    if bits & !known != 0 {
        words.push("an error that its manual does not name");
    }
    words
}

fn dynamixel_errors(bits: u8) -> Vec<&'static str> {
    words(
        bits,
        &[
            (hardware_error::INPUT_VOLTAGE, "supply out of its limits"),
            (hardware_error::OVERHEATING, "too hot"),
            (hardware_error::ENCODER, "encoder"),
            (hardware_error::SHOCK, "shock, or too little power"),
            (hardware_error::OVERLOAD, "overload"),
        ],
    )
}

fn feetech_errors(bits: u8) -> Vec<&'static str> {
    words(
        bits,
        &[
            (status_bit::VOLTAGE, "supply out of its limits"),
            (status_bit::ENCODER, "encoder"),
            (status_bit::TEMPERATURE, "too hot"),
            (status_bit::CURRENT, "too much current"),
            (status_bit::OVERLOAD, "overload"),
        ],
    )
}
