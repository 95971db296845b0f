//! What a board's line has to do in a tick.

use sinew_servo_bus::{EncodeError, ServoBus};

/// A line with servos on it.
///
/// **Duty**: whatever servos do or do not, every call comes back within its time.
pub trait Wire {
    /// Empties its input, sends `bytes`, and gives what comes to `reply`, as it comes, until that says that it has all
    /// or `wait_us` are over since the first byte out.
    fn exchange(&mut self, bytes: &[u8], wait_us: u32, reply: impl FnMut(&[u8]) -> bool);

    /// What is left of the tick, µs.
    fn left_us(&self) -> u32;

    /// At what rate a line of servos talks, bit/s, if there is one that takes [bytes of a host](Self::pass).
    fn rate(&self, _line: u8) -> Option<u32> {
        None
    }

    /// Bytes of a host to the servos of a line, while torque is off: empties its input, talks at `baud` bit/s (0: as
    /// always), and gives what comes to `reply` until `wait_us` are over since the first byte out. Then the line is as
    /// before. Says when the last byte came, µs behind the first one out, 0 if none did; nothing if there is no such
    /// line or rate, and then nothing was sent.
    fn pass(
        &mut self,
        _line: u8,
        _baud: u32,
        _bytes: &[u8],
        _wait_us: u32,
        _reply: impl FnMut(&[u8]),
    ) -> Option<u32> {
        None
    }
}

/// The exchange of a tick: packets out and replies in, as long as the bus wants more and there is time. `out`: room for
/// the longest packets.
///
/// # Errors
/// [`EncodeError`] if there is no room in `out`: that packet did not go out, and none behind it.
pub fn exchange(
    bus: &mut impl ServoBus,
    wire: &mut impl Wire,
    out: &mut [u8],
) -> Result<(), EncodeError> {
    let mut request = Some(bus.plan(out)?);
    while let Some(asked) = request {
        let bytes = out.get(..asked.len).unwrap_or_default();
        wire.exchange(bytes, asked.time_us, |said| bus.reply(said));
        request = bus.plan_more(wire.left_us(), out)?;
    }
    Ok(())
}
