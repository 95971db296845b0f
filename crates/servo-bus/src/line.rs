//! Connects simulated devices to one half-duplex line.

/// A simulated device on a line.
pub trait BusDevice {
    /// Receives bytes that the controller or another device sent.
    fn hear(&mut self, bytes: &[u8]);

    /// Returns the silence after which the device wants to send, in microseconds, or `None` if it does not want to
    /// send.
    fn due_us(&self) -> Option<u32>;

    /// Writes the device's answer to `out` and returns its length. The answer is cut if `out` is too small.
    fn speak(&mut self, out: &mut [u8]) -> usize;

    /// Informs the device that the line was silent for longer than any device takes to answer.
    fn silence(&mut self);
}

/// A half-duplex line. All devices receive all bytes; the device that is due first sends first.
#[derive(Debug)]
pub struct Line<'d, D> {
    devices: &'d mut [D],
}

impl<'d, D: BusDevice> Line<'d, D> {
    /// Creates a line with these devices.
    pub fn new(devices: &'d mut [D]) -> Self {
        Self { devices }
    }

    /// Sends `bytes` from the controller. `answer` receives each device's reply, in order, and the silence before the
    /// reply in microseconds. `scratch` must hold the longest reply.
    ///
    /// Cost: every device processes each reply.
    pub fn exchange(&mut self, bytes: &[u8], scratch: &mut [u8], answer: impl FnMut(&[u8], u32)) {
        self.hear(bytes, None);
        self.speak(scratch, answer);
    }

    /// Reports a silence to all devices: unfinished packets end, and devices that waited for a silent device may
    /// answer.
    pub fn silence(&mut self, scratch: &mut [u8], answer: impl FnMut(&[u8], u32)) {
        for device in self.devices.iter_mut() {
            device.silence();
        }
        self.speak(scratch, answer);
    }

    fn speak(&mut self, scratch: &mut [u8], mut answer: impl FnMut(&[u8], u32)) {
        // A device that sends is no longer due, and other replies make it due at most once more.
        for _ in 0..self.devices.len().saturating_mul(2) {
            let Some((speaker, delay_us)) = self.next_speaker() else { return };
            let Some(device) = self.devices.get_mut(speaker) else { return };
            let len = device.speak(scratch);
            let said = scratch.get(..len).unwrap_or_default();
            answer(said, delay_us);
            self.hear(said, Some(speaker));
        }
    }

    fn next_speaker(&self) -> Option<(usize, u32)> {
        let due = self.devices.iter().enumerate();
        due.filter_map(|(index, device)| Some((index, device.due_us()?)))
            .min_by_key(|(_, delay_us)| *delay_us)
    }

    fn hear(&mut self, bytes: &[u8], speaker: Option<usize>) {
        for (index, device) in self.devices.iter_mut().enumerate() {
            if Some(index) != speaker {
                device.hear(bytes);
            }
        }
    }
}
