//! The control table of a simulated servo, with the rules of the protocol for reads and writes.

use crate::dynamixel::instruction::ResetScope;
use crate::dynamixel::status::ErrorCode;
use crate::dynamixel::table::{Table, address, drive_mode};
use crate::table::{Access, Area, ByteOrder, Item, Range, Restriction};

/// Maximum goal position in the modes of several turns, counts: 256 turns either way. Source: e-manual, Goal Position.
const TURNS: i32 = 1_048_575;
/// Addresses from Velocity I Gain to Feedforward 1st Gain. A change of mode resets them. Source: e-manual, Operating
/// Mode.
const GAINS: core::ops::RangeInclusive<u16> = 76..=90;
/// Addresses from Goal PWM to Profile Velocity. A change of mode resets them too.
const GOALS: core::ops::RangeInclusive<u16> = address::GOAL_PWM..=112;
const POSITION_MODE: i32 = 3;

/// A control table in memory that the caller owns.
#[derive(Debug)]
pub struct Memory<'m> {
    table: Table,
    bytes: &'m mut [u8],
    restrictions: &'static [Restriction],
}

impl<'m> Memory<'m> {
    pub(super) fn new(table: Table, bytes: &'m mut [u8]) -> Self {
        Self { table, bytes, restrictions: &[] }
    }

    /// Sets which values a controller cannot write: the servo answers with an error.
    pub fn restrict(&mut self, restrictions: &'static [Restriction]) {
        self.restrictions = restrictions;
    }

    /// Returns the layout of the control table.
    pub fn table(&self) -> &Table {
        &self.table
    }

    /// Returns the value of a register, or 0 if the servo has no register at `address`.
    pub fn get(&self, address: u16) -> i32 {
        self.table.at(address).map_or(0, |item| self.value(&item))
    }

    /// Sets a register, even if a controller could not write it. Bits that do not fit are cut off.
    pub fn set(&mut self, address: u16, value: i32) {
        if let Some(item) = self.table.at(address) {
            let bytes = item.bytes(value, ByteOrder::Little);
            self.put(item.address, bytes.get(..usize::from(item.size)).unwrap_or_default());
        }
    }

    /// Returns whether torque is on.
    pub fn torque_is_on(&self) -> bool {
        self.byte(address::TORQUE_ENABLE) != 0
    }

    /// Reads bytes with the rules for a controller. Bytes between registers are 0.
    pub(super) fn read(&self, address: u16, out: &mut [u8]) -> Result<(), ErrorCode> {
        let end = usize::from(address).saturating_add(out.len());
        if out.is_empty() || end > self.table.size() || self.table.at(address).is_none() {
            return Err(ErrorCode::Access);
        }
        self.copy(address, out);
        Ok(())
    }

    pub(super) fn copy(&self, address: u16, out: &mut [u8]) {
        for (byte, from) in out.iter_mut().zip(address..) {
            *byte = self.byte(self.place(from));
        }
    }

    /// Writes bytes with the rules for a controller: all of them, or none and an error. A write to Operating Mode
    /// resets gains and goals.
    pub(super) fn write(&mut self, address: u16, data: &[u8]) -> Result<(), ErrorCode> {
        self.check(address, data)?;
        for (byte, to) in data.iter().zip(address..) {
            self.put(self.place(to), core::slice::from_ref(byte));
        }
        if (address..).zip(data).any(|(to, _)| self.place(to) == address::OPERATING_MODE) {
            self.reset(|item| GAINS.contains(&item.address) || GOALS.contains(&item.address));
        }
        Ok(())
    }

    /// Checks whether a controller may write these bytes.
    pub(super) fn check(&self, address: u16, data: &[u8]) -> Result<(), ErrorCode> {
        if data.is_empty() {
            return Err(ErrorCode::DataLength);
        }
        let mut rest = data;
        let mut at = address;
        while !rest.is_empty() {
            let target = self.place(at);
            let item = self.table.at(target).filter(|item| item.access == Access::ReadWrite);
            let item = item.ok_or(ErrorCode::Access)?;
            let whole = (0..u16::from(item.size)).all(|byte| {
                self.place(at.saturating_add(byte)) == item.address.saturating_add(byte)
            });
            let Some((value, behind)) = rest.split_at_checked(item.size.into()).filter(|_| whole)
            else {
                return Err(ErrorCode::DataLength);
            };
            self.check_item(&item, value)?;
            rest = behind;
            at = at.saturating_add(item.size.into());
        }
        Ok(())
    }

    fn check_item(&self, item: &Item, value: &[u8]) -> Result<(), ErrorCode> {
        if item.area == Area::Eeprom && self.torque_is_on() {
            return Err(ErrorCode::Access);
        }
        let value = item.value(value, ByteOrder::Little);
        if Restriction::refuse(self.restrictions, item.address, value) {
            return Err(ErrorCode::DataRange);
        }
        let is_goal = (address::GOAL_PWM..=address::GOAL_POSITION).contains(&item.address);
        let watchdog_ran_out = self.get(address::BUS_WATCHDOG) < 0;
        if watchdog_ran_out && (is_goal || (item.address == address::BUS_WATCHDOG && value != 0)) {
            return Err(ErrorCode::DataRange);
        }
        if item.address == address::DRIVE_MODE && value & drive_mode::SLAVE != 0 {
            // The slave of a dual joint obeys a cable to its master, which no line of simulated servos has.
            return Err(ErrorCode::DataRange);
        }
        let within = |least: i32, most: i32, code| {
            if (least..=most).contains(&value) { Ok(()) } else { Err(code) }
        };
        match item.range {
            Range::Any => Ok(()),
            Range::Between(least, most) => within(least, most, ErrorCode::DataRange),
            Range::PlusMinus(limit) => {
                let most = self.get(limit);
                within(most.saturating_neg(), most, ErrorCode::DataLimit)
            }
            Range::Within(..) if self.get(address::OPERATING_MODE) != POSITION_MODE => {
                within(-TURNS, TURNS, ErrorCode::DataRange)
            }
            Range::Within(least, most) => {
                within(self.get(least), self.get(most), ErrorCode::DataLimit)
            }
        }
    }

    /// Resets RAM to its power-up values.
    pub(super) fn reset_ram(&mut self) {
        self.reset(|item| item.area == Area::Ram);
        for run in self.table.indirect().into_iter().flatten() {
            for index in 0..run.count {
                self.set(
                    run.addresses.saturating_add(index.saturating_mul(2)),
                    run.data.saturating_add(index).into(),
                );
                self.put(run.data.saturating_add(index), &[0]);
            }
        }
    }

    pub(super) fn reset_all(&mut self) {
        self.reset(|_| true);
        self.reset_ram();
    }

    pub(super) fn factory_reset(&mut self, scope: ResetScope, own: u8) {
        let baud = self.get(address::BAUD);
        self.reset_all();
        if scope != ResetScope::All {
            self.set(address::ID, own.into());
        }
        if scope == ResetScope::ButIdAndBaud {
            self.set(address::BAUD, baud);
        }
    }

    fn reset(&mut self, which: impl Fn(&Item) -> bool) {
        let table = self.table;
        for item in table.items().filter(|item| which(item)) {
            self.set(item.address, item.initial);
        }
    }

    fn value(&self, item: &Item) -> i32 {
        let bytes = self.bytes.get(item.address.into()..).unwrap_or_default();
        item.value(bytes, ByteOrder::Little)
    }

    /// Returns the address at which a byte is stored. For indirect data, this is another address than `address`.
    fn place(&self, address: u16) -> u16 {
        for run in self.table.indirect().into_iter().flatten() {
            let index = address.checked_sub(run.data).filter(|index| *index < run.count);
            if let Some(index) = index {
                let pointer = run.addresses.saturating_add(index.saturating_mul(2));
                return u16::from_le_bytes([
                    self.byte(pointer),
                    self.byte(pointer.saturating_add(1)),
                ]);
            }
        }
        address
    }

    fn byte(&self, address: u16) -> u8 {
        self.bytes.get(usize::from(address)).copied().unwrap_or(0)
    }

    fn put(&mut self, address: u16, bytes: &[u8]) {
        for (byte, to) in bytes.iter().zip(usize::from(address)..) {
            if let Some(slot) = self.bytes.get_mut(to) {
                *slot = *byte;
            }
        }
    }
}
