//! Servos of a rig file, and the same on a line.

use sinew_rig::Description;
use sinew_rig::actuation::JointFriction;
use sinew_rig::description::{Address, ServoModel};

use crate::position_gain::{PositionGain, position_gains};
use crate::{Client, Exchange, Protocol, ServiceError, Servo, Table};

/// A servo of a rig file that has an id.
#[derive(Debug, Clone, PartialEq)]
pub struct RigServo {
    /// What people call it.
    pub name: String,
    /// Its id.
    pub id: u8,
    /// What its kind can do.
    pub model: ServoModel,
    /// How far it may go, from the middle of its encoder; none for as far as its kind.
    pub range_rad: Option<[f64; 2]>,
    /// The most torque that it is asked for; none for as much as its kind has.
    pub torque_nm: Option<f64>,
    /// What friction of its joint takes beside its own, N m.
    pub joint_friction_nm: f32,
    /// Its P gain where it is driven by position; none of a kind without that register.
    pub position_gain: Option<PositionGain>,
}

impl RigServo {
    /// The registers of its kind; none for a kind that a rig file describes by itself under a name of its own.
    pub fn table(&self) -> Option<Table> {
        Table::named_model(&self.model.name, u8::MAX)
    }

    /// Its protocol, if its kind is known.
    pub fn protocol(&self) -> Option<Protocol> {
        self.table().map(|table| table.protocol())
    }

    /// The servo on a line.
    ///
    /// # Errors
    /// [`ServiceError::WrongModel`] if another one answers, and those of [`Client::open`].
    pub fn open<E: Exchange>(&self, client: &mut Client<E>) -> Result<Servo, ServiceError> {
        let table = self.table();
        let servo = match client.open(self.id, None) {
            // Of some models nobody knows the number.
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

/// The servos of a rig that have an id on one of its buses; the bus may be left out where there is one.
///
/// # Errors
/// [`ServiceError::Rig`] if there is none, or several buses and none is named.
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
                "its servos hang on several buses, {known}: name one with --rig-bus"
            )));
        }
    };
    // Of a rig whose drives are not described yet there is none.
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
                torque_nm: servo.torque_nm,
                joint_friction_nm: friction.coulomb_nm,
                position_gain,
            })
        })
        .collect()
}

/// A rig's own position of a servo, rad, that counts from the middle of its encoder.
pub fn own_rad(table: &Table, counts: i32) -> f64 {
    f64::from(counts - table.counts() / 2) * table.rad_per_count()
}
