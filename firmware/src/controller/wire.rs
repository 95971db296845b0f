//! Interface to a board's bus line in a tick.

use sinew_servo_bus::{EncodeError, ServoBus};

/// A bus line with servos.
///
/// **Duty**: whatever servos do, every call returns within the time that its arguments give.
pub trait Wire {
    /// Empties the input, sends `bytes`, and passes received bytes to `reply` as they arrive, until that returns true
    /// or `wait_us` have passed since the first byte was sent.
    fn exchange(&mut self, bytes: &[u8], wait_us: u32, reply: impl FnMut(&[u8]) -> bool);

    /// Returns the remaining time of the tick, µs.
    fn left_us(&self) -> u32;

    /// Returns the bit rate of a line of servos, bit/s, if the line accepts [bytes of a host](Self::pass).
    fn rate(&self, _line: u8) -> Option<u32> {
        None
    }

    /// Sends bytes of a host to the servos of a line, while torque is off: empties the input, uses `baud` bit/s (0:
    /// the line's own rate), and passes received bytes to `reply` until `wait_us` have passed since the first byte
    /// was sent. Afterwards the line is as before. Returns the time from the first byte sent to the last byte
    /// received, µs, or 0 if none was received. Returns `None` if there is no such line or rate; then nothing was
    /// sent.
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

/// Makes the exchange of a tick: sends packets and reads replies, as long as the bus has packets and there is time.
/// `out` is room for the longest packets.
///
/// # Errors
/// [`EncodeError`] if a packet has no room in `out`: this packet was not sent, and no later one either.
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
