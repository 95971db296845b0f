//! A servo that has answered: what it is, and its registers.

use std::time::Duration;

use sinew_servo_bus::table::Item;
use sinew_servo_bus::{dynamixel, feetech};

use crate::client::{low, packet};
use crate::ping_reply::Miss;
use crate::table::known;
use crate::{Client, Exchange, ServiceError, Table};

/// A servo that has answered.
#[derive(Debug, Clone, PartialEq)]
pub struct Servo {
    /// Its id.
    pub id: u8,
    /// Its registers.
    pub table: Table,
    /// Its firmware, as its maker writes it.
    pub firmware: String,
}

impl<E: Exchange> Client<E> {
    /// The servo of this id, with the registers of its model, or of the model that a person `told`.
    ///
    /// # Errors
    /// Those of [`Self::read_bytes`], [`ServiceError::UnknownModel`] and [`ServiceError::NoModel`].
    pub fn open(&mut self, id: u8, told: Option<&str>) -> Result<Servo, ServiceError> {
        let pong = match self.ping(id, self.tries())? {
            Ok(pong) => pong,
            Err(Miss::Noise) => return Err(ServiceError::Noise { id }),
            Err(Miss::Silence) => return Err(ServiceError::Silent { id, baud: self.baud() }),
        };
        let table = match told {
            Some(name) => Table::told(self.protocol(), name, pong.dynamixel_firmware)?,
            None => pong.table.ok_or_else(|| ServiceError::UnknownModel {
                id,
                number: pong.number,
                known: known(self.protocol()),
            })?,
        };
        Ok(Servo { id, table, firmware: pong.firmware })
    }

    /// The number that a register of a servo holds.
    ///
    /// # Errors
    /// Those of [`Self::read_bytes`].
    pub fn read(&mut self, servo: &Servo, item: &Item) -> Result<i32, ServiceError> {
        let (bytes, _) = self.read_bytes(servo.id, item.address, item.size.into())?;
        Ok(item.value(&bytes, servo.table.order()))
    }

    /// The packet that writes a register.
    pub(crate) fn write_request(
        servo: &Servo,
        item: &Item,
        raw: i32,
    ) -> Result<Vec<u8>, ServiceError> {
        let bytes = item.bytes(raw, servo.table.order());
        let data = bytes.get(..usize::from(item.size)).unwrap_or_default();
        packet(|out| match &servo.table {
            Table::Dynamixel(_) => {
                dynamixel::Instruction::Write { address: item.address, data }.encode(servo.id, out)
            }
            Table::Feetech(table) => {
                feetech::Instruction::Write { address: low(item.address), data }.encode(
                    table.model.family,
                    servo.id,
                    out,
                )
            }
        })
    }

    /// Starts a servo anew: what is kept in RAM is forgotten, torque is off. Waits until it answers again.
    ///
    /// # Errors
    /// [`ServiceError::Silent`] if it does not come back within two seconds.
    pub fn reboot(&mut self, servo: &Servo) -> Result<(), ServiceError> {
        let request = packet(|out| match &servo.table {
            Table::Dynamixel(_) => dynamixel::Instruction::Reboot.encode(servo.id, out),
            Table::Feetech(table) => {
                feetech::Instruction::Reboot.encode(table.model.family, servo.id, out)
            }
        })?;
        self.send(servo.id, &request)?;
        // A Feetech takes about 0.8 s.
        for _ in 0..20 {
            self.pause(Duration::from_millis(100));
            if self.ping(servo.id, 1)?.is_ok() {
                return Ok(());
            }
        }
        Err(ServiceError::Silent { id: servo.id, baud: self.baud() })
    }
}
