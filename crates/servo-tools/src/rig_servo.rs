//! Servos of a rig file, and how to find them on a line.

use sinew_rig::Description;
use sinew_rig::actuation::JointFriction;
use sinew_rig::description::{Address, ServoModel};

use crate::position_gain::{PositionGain, position_gains};
use crate::{Client, Exchange, Protocol, ServiceError, Servo, Table};

/// A servo of a rig file that has an id.
#[derive(Debug, Clone, PartialEq)]
pub struct RigServo {
    /// Name of the servo in the rig.
    pub name: String,
    /// Id of the servo.
    pub id: u8,
    /// Data of the servo's kind.
    pub model: ServoModel,
    /// Range, rad from the middle of the encoder; `None` for the whole range of the kind.
    pub range_rad: Option<[f64; 2]>,
    /// Value of the servo's register Homing Offset, rad; `None` if the rig file does not state it.
    pub homing_offset_rad: Option<f64>,
    /// Maximum torque that the rig needs, N m; `None` for the stall torque of the kind.
    pub torque_nm: Option<f64>,
    /// Friction torque of the joint, in addition to the servo's own, N m.
    pub joint_friction_nm: f32,
    /// P gain in a position mode; `None` for a kind without this register.
    pub position_gain: Option<PositionGain>,
}

impl RigServo {
    /// Returns the registers of the servo's kind, or `None` for a kind without a known table.
    pub fn table(&self) -> Option<Table> {
        Table::named_model(&self.model.name, u8::MAX)
    }

    /// Returns the servo's protocol, or `None` for a kind without a known table.
    pub fn protocol(&self) -> Option<Protocol> {
        self.table().map(|table| table.protocol())
    }

    /// Opens the servo on a line.
    ///
    /// # Errors
    /// [`ServiceError::WrongModel`] if a servo of another model answers, and the errors of [`Client::open`].
    pub fn open<E: Exchange>(&self, client: &mut Client<E>) -> Result<Servo, ServiceError> {
        let table = self.table();
        let servo = match client.open(self.id, None) {
            // The model numbers of some models are unknown.
            Err(ServiceError::UnknownModel { .. }) if table.is_some() => {
                client.open(self.id, Some(&self.model.name))?
            }
            other => other?,
        };
        match table {
            Some(table) if table.model() != servo.table.model() => Err(ServiceError::WrongModel {
                name: self.name.clone(),
                id: self.id,
                has: servo.table.model().to_owned(),
                should: self.model.name.clone(),
            }),
            _ => Ok(servo),
        }
    }
}

/// Returns the servos of a rig with an id on a bus. If the rig has only one bus, `bus` may be `None`.
///
/// # Errors
/// [`ServiceError::Rig`] if no servo has an id, the bus is unknown, `bus` is `None` although there are several buses,
/// or the kind or P gain of a servo is invalid.
pub fn of_bus(rig: &Description, bus: Option<&str>) -> Result<Vec<RigServo>, ServiceError> {
    let on_bus = || rig.servos.iter().filter(|servo| matches!(servo.address, Address::Id(_)));
    let mut buses: Vec<&str> = on_bus().map(|servo| servo.bus.as_str()).collect();
    buses.sort_unstable();
    buses.dedup();
    let refused = |what: String| ServiceError::Rig { name: rig.name.clone(), what };
    let bus = match (bus, buses.as_slice()) {
        (_, []) => {
            return Err(refused("none of its servos has an id; bus servos have one".to_owned()));
        }
        (Some(bus), known) if known.contains(&bus) => bus,
        (None, [bus]) => bus,
        (Some(bus), known) => {
            return Err(refused(format!("it has no bus {bus:?}; there are: {}", known.join(", "))));
        }
        (None, known) => {
            let known = known.join(", ");
            return Err(refused(format!(
                "its servos are on several buses, {known}: name one with --rig-bus"
            )));
        }
    };
    // A rig whose drives are not described yet has no known joint friction.
    let frictions = rig.actuation().map(|actuation| actuation.joint_friction(rig));
    let frictions = frictions.unwrap_or_else(|_| vec![JointFriction::default(); rig.servos.len()]);
    let gains = position_gains(rig, rig.mechanism().ok().as_ref())?;
    (rig.servos.iter().zip(frictions).zip(gains))
        .filter(|((servo, _), _)| matches!(servo.address, Address::Id(_)) && servo.bus == bus)
        .map(|((servo, friction), position_gain)| {
            let model = rig.servo_model(&servo.model);
            let model = model
                .ok_or_else(|| refused(format!("there is no kind of servo {:?}", servo.model)))?;
            let Address::Id(id) = servo.address else { return Err(refused("no id".to_owned())) };
            Ok(RigServo {
                name: servo.name.clone(),
                id,
                model,
                range_rad: servo.range_rad.first().copied(),
                homing_offset_rad: servo.homing_offset_rad,
                torque_nm: servo.torque_nm,
                joint_friction_nm: friction.coulomb_nm,
                position_gain,
            })
        })
        .collect()
}

/// Converts counts to a rig's own position of a servo, rad from the middle of the encoder.
pub fn own_rad(table: &Table, counts: i32) -> f64 {
    f64::from(counts - table.counts() / 2) * table.rad_per_count()
}
