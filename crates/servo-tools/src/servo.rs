//! A servo that has answered: its id, registers and firmware.

use std::time::Duration;

use sinew_servo_bus::feetech::table::address;
use sinew_servo_bus::table::Item;
use sinew_servo_bus::{dynamixel, feetech};

use crate::client::{low, packet};
use crate::ping_reply::Miss;
use crate::table::known;
use crate::{Client, Exchange, ServiceError, Table};

/// A servo that has answered.
#[derive(Debug, Clone, PartialEq)]
pub struct Servo {
    /// Id of the servo.
    pub id: u8,
    /// Registers of the servo's model.
    pub table: Table,
    /// Firmware version, as the maker writes it.
    pub firmware: String,
}

impl<E: Exchange> Client<E> {
    /// Opens the servo with this id, with the registers of its own model, or of the model `told` that a person names.
    ///
    /// # Errors
    /// The errors of [`Self::read_bytes`], [`ServiceError::UnknownModel`] and [`ServiceError::NoModel`].
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
        let table = self.with_phase(id, table)?;
        Ok(Servo { id, table, firmware: pong.firmware })
    }

    /// Returns the table with the unit of speed that an STS has by its Phase.
    fn with_phase(&mut self, id: u8, table: Table) -> Result<Table, ServiceError> {
        match table {
            Table::Feetech(table) if table.model.family == feetech::Family::Sts => {
                let (phase, _) = self.read_bytes(id, address::PHASE.into(), 1)?;
                let phase = phase.first().copied().unwrap_or_default();
                Ok(Table::Feetech(table.with_phase(phase.into())))
            }
            other => Ok(other),
        }
    }

    /// Reads the value of a servo's register.
    ///
    /// # Errors
    /// The errors of [`Self::read_bytes`].
    pub fn read(&mut self, servo: &Servo, item: &Item) -> Result<i32, ServiceError> {
        let (bytes, _) = self.read_bytes(servo.id, item.address, item.size.into())?;
        Ok(item.value(&bytes, servo.table.order()))
    }

    /// Returns the packet that writes a register.
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

    /// Restarts a servo, and waits until it answers again. RAM gets its power-up values, and torque is off.
    ///
    /// # Errors
    /// [`ServiceError::Silent`] if it does not answer again within two seconds; others as in [`Self::read_bytes`].
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
