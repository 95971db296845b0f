//! The item that a board stores for a rig: its compact form, followed by the wiring of its servos.

use sinew_wiring::{BusLine, LINES, Servo, Wiring};

use super::node::RIG_ROOM;
use crate::play::line_setup::LineSetup;
use crate::play::{RigParts, SERVOS};

impl RigParts {
    /// Returns the rig in its compact form. It ends with the CRC by which boards and shows identify it.
    ///
    /// # Errors
    /// The reason why the rig has no compact form.
    pub fn compact_rig(&self) -> Result<Vec<u8>, String> {
        let mut bytes = vec![0; RIG_ROOM];
        let len = self.board.encode(&mut bytes).map_err(|error| error.to_string())?;
        bytes.truncate(len);
        Ok(bytes)
    }

    /// Returns the item that a board accepts as its rig.
    ///
    /// # Errors
    /// The reason why there is none.
    pub fn board_rig(&self) -> Result<Vec<u8>, String> {
        let mut item = self.compact_rig()?;
        let len = item.len();
        item.resize(RIG_ROOM, 0);
        let wiring = self.wiring()?;
        let len = wiring.append(&mut item, len).ok_or("it has too many servos")?;
        item.truncate(len);
        Ok(item)
    }

    /// Returns how the servos are connected to a board, and how they are driven.
    ///
    /// # Errors
    /// The rig has more lines than a board.
    pub fn wiring(&self) -> Result<Wiring<LINES, SERVOS>, String> {
        self.wired().ok_or_else(|| format!("it has more than {LINES} buses"))
    }

    fn wired(&self) -> Option<Wiring<LINES, SERVOS>> {
        let setups: Vec<LineSetup> = self.lines.iter().map(|line| self.line_setup(line)).collect();
        let mut wiring = Wiring {
            rate_hz: self.rate_hz,
            latest: self.schedules.iter().position(|of| *of == self.schedule).unwrap_or_default(),
            tracker: self.settings.tracker,
            lines: heapless::Vec::new(),
            servos: heapless::Vec::new(),
        };
        for (line, setup) in self.lines.iter().zip(&setups) {
            let load = line.load(&self.servos);
            let (protocol, timing, traffic) = (setup.protocol(), load.timing, load.traffic);
            wiring.lines.push(BusLine { protocol, timing, traffic }).ok()?;
        }
        for (part, setup) in self.servos.iter().zip(&self.setups) {
            let (line, place) = part.place;
            let on_line = setups.get(line)?.servo(place)?;
            wiring.servos.push(Servo { line, on_line, setup: *setup }).ok()?;
        }
        Some(wiring)
    }
}
