//! One half-duplex line with simulated devices on it.

/// A simulated device on a line.
pub trait BusDevice {
    /// Hears bytes on the line, from the controller or from another device.
    fn hear(&mut self, bytes: &[u8]);

    /// After how many microseconds of silence it wants to speak; none if it does not.
    fn due_us(&self) -> Option<u32>;

    /// Says what it wanted to, into `out`, and how many bytes it was; cut short where `out` is too small.
    fn speak(&mut self, out: &mut [u8]) -> usize;

    /// The line has been silent for longer than anyone takes to answer.
    fn silence(&mut self);
}

/// A half-duplex line: all devices hear all others, and those that are due first speak first.
#[derive(Debug)]
pub struct Line<'d, D> {
    devices: &'d mut [D],
}

impl<'d, D: BusDevice> Line<'d, D> {
    /// A line with these devices.
    pub fn new(devices: &'d mut [D]) -> Self {
        Self { devices }
    }

    /// The controller sends `bytes`, and `answer` gets what each device says, in order, and how long the line was
    /// silent before it, in microseconds. `scratch` must hold the longest reply.
    ///
    /// Cost: each reply is heard by every device.
    pub fn exchange(&mut self, bytes: &[u8], scratch: &mut [u8], answer: impl FnMut(&[u8], u32)) {
        self.hear(bytes, None);
        self.speak(scratch, answer);
    }

    /// The line has been silent: what was begun is over, and who waited for a silent device may speak.
    pub fn silence(&mut self, scratch: &mut [u8], answer: impl FnMut(&[u8], u32)) {
        for device in self.devices.iter_mut() {
            device.silence();
        }
        self.speak(scratch, answer);
    }

    fn speak(&mut self, scratch: &mut [u8], mut answer: impl FnMut(&[u8], u32)) {
        // A device that speaks is no longer due, and hearing others makes it due at most once more.
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
