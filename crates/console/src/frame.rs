//! A frame: the state of the rig as numbers, in a binary message, little-endian, for each snapshot of the board.

use sinew_link::message::{Dof, SUPPLY_UNIT, Servo};

/// Version of the layout; the first byte of a frame.
const LAYOUT: u8 = 2;
/// Value of a byte if there is no fault, or no limiter.
const NONE: u8 = 255;
/// Value of a temperature that is not known.
const NO_TEMPERATURE: i8 = -128;

/// Flag: the rig follows a slider.
pub(crate) const JOGS: u8 = 1;
/// Flag: a show plays.
pub(crate) const PLAYS: u8 = 2;
/// Flag: the board does not answer.
pub(crate) const LOST: u8 = 4;
/// Flag: the frame contains the pose of the ghost.
pub(crate) const GHOST: u8 = 8;

/// Content of a frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Frame<'a> {
    pub(crate) state: u8,
    pub(crate) fault: Option<u8>,
    pub(crate) flags: u8,
    pub(crate) t_s: f32,
    /// Time in the show, s; negative before the show starts.
    pub(crate) place_s: Option<f32>,
    pub(crate) supply_v: f32,
    pub(crate) tick_us: u16,
    /// Numbers of coordinates, dofs and servos of the rig.
    pub(crate) counts: [usize; 3],
    pub(crate) measured: &'a [f32],
    pub(crate) wanted: &'a [f32],
    pub(crate) ghost: Option<&'a [f32]>,
    pub(crate) dofs: &'a [Dof],
    pub(crate) servos: &'a [Servo],
    /// Supply voltages of servos, V; 0 or missing if not known.
    pub(crate) supplies: &'a [f32],
}

impl Frame<'_> {
    /// Returns the bytes of the frame. Numbers that the board has not sent are NaN; of a servo, the temperature is -128
    /// and the other numbers are 0. Supplies of servos are in 0.1 V. A byte without a fault or a limiter is 255.
    pub(crate) fn bytes(&self) -> Vec<u8> {
        let [n, d, s] = self.counts;
        let ghost = self.ghost.filter(|ghost| ghost.len() == n);
        let flags = self.flags | if ghost.is_some() { GHOST } else { 0 };
        let mut out = Vec::with_capacity(24 + 4 * (3 * n + d) + d + 6 * s);
        out.extend([LAYOUT, self.state, self.fault.unwrap_or(NONE), flags]);
        for number in [self.t_s, self.place_s.unwrap_or(f32::NAN), self.supply_v] {
            out.extend(number.to_le_bytes());
        }
        out.extend(self.tick_us.to_le_bytes());
        for count in [n, d, s] {
            out.extend(u16::try_from(count).unwrap_or(u16::MAX).to_le_bytes());
        }
        let mut pose = |q: &[f32]| {
            for index in 0..n {
                out.extend(q.get(index).copied().unwrap_or(f32::NAN).to_le_bytes());
            }
        };
        pose(self.measured);
        pose(self.wanted);
        if let Some(ghost) = ghost {
            pose(ghost);
        }
        for index in 0..d {
            let effort = self.dofs.get(index).map_or(f32::NAN, |dof| dof.effort);
            out.extend(effort.to_le_bytes());
        }
        out.extend((0..d).map(|index| {
            self.dofs.get(index).and_then(|dof| dof.limiter).map_or(NONE, |limit| limit as u8)
        }));
        let servo = |index: usize| self.servos.get(index);
        out.extend((0..s).flat_map(|index| {
            servo(index)
                .and_then(|servo| servo.temperature_c)
                .unwrap_or(NO_TEMPERATURE)
                .to_le_bytes()
        }));
        out.extend((0..s).map(|index| servo(index).map_or(0, |servo| servo.heat_percent)));
        out.extend(
            (0..s).flat_map(|index| servo(index).map_or(0, |servo| servo.bus_errors).to_le_bytes()),
        );
        out.extend((0..s).map(|index| servo(index).map_or(0, |servo| servo.hardware_error)));
        out.extend((0..s).map(|index| {
            let volts = self.supplies.get(index).copied().unwrap_or(0.0);
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "it saturates"
            )]
            let supply = (volts / SUPPLY_UNIT).round() as u8;
            supply
        }));
        out
    }
}

#[cfg(test)]
mod tests {
    use sinew_link::message::Limit;

    use super::*;

    #[test]
    fn a_frame_has_its_numbers_in_their_places() {
        let dofs = [
            Dof { effort: 1.5, limiter: Some(Limit::Heat), target: 0 },
            Dof { effort: 0.0, limiter: None, target: 0 },
        ];
        let servo = Servo {
            temperature_c: Some(-3),
            heat_percent: 40,
            bus_errors: 513,
            hardware_error: 8,
            supply: 0,
        };
        let frame = Frame {
            state: 5,
            fault: None,
            flags: JOGS,
            t_s: 1.0,
            place_s: None,
            supply_v: 12.0,
            tick_us: 2000,
            counts: [2, 2, 1],
            measured: &[0.25, 0.5],
            wanted: &[],
            ghost: Some(&[0.0, 1.0]),
            dofs: &dofs,
            servos: &[servo],
            supplies: &[12.1],
        };
        let bytes = frame.bytes();
        let f32_at = |at: usize| f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
        assert_eq!(bytes[..4], [2, 5, 255, JOGS | GHOST]);
        assert!(f32_at(8).is_nan());
        assert_eq!(bytes[16..24], [0xD0, 0x07, 2, 0, 2, 0, 1, 0]);
        assert_eq!([f32_at(24), f32_at(28)].map(f32::to_bits), [0.25_f32, 0.5].map(f32::to_bits));
        assert!(f32_at(32).is_nan() && f32_at(36).is_nan());
        assert_eq!([f32_at(44), f32_at(48)].map(f32::to_bits), [1.0_f32, 1.5].map(f32::to_bits));
        assert_eq!(bytes[56..], [7, 255, 253, 40, 1, 2, 8, 121]);
    }
}
