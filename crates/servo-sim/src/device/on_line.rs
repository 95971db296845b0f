//! A servo as a device on a line. While it has no power or starts, it is silent; otherwise its registers' device
//! answers.

use sinew_servo_bus::BusDevice;

use super::{Program, Servo};
use crate::wire::Listener;

impl Listener for Servo<'_> {
    fn rate(&self) -> u32 {
        self.baud()
    }
}

impl BusDevice for Servo<'_> {
    fn hear(&mut self, bytes: &[u8]) {
        if !self.runs() {
            return;
        }
        let told = self.told();
        let is_published = std::mem::replace(&mut self.is_published, true);
        match &mut self.program {
            Program::Dynamixel(servo) => {
                if !is_published {
                    servo.publish(&told);
                }
                servo.device.hear(bytes);
            }
            Program::Feetech(servo) => {
                if !is_published {
                    servo.publish(&told);
                }
                servo.device.hear(bytes);
            }
            Program::Pulse(_) => {}
        }
        self.keep_torque();
    }

    fn due_us(&self) -> Option<u32> {
        match &self.program {
            Program::Dynamixel(servo) => servo.device.due_us(),
            Program::Feetech(servo) => servo.device.due_us(),
            Program::Pulse(_) => None,
        }
    }

    fn speak(&mut self, out: &mut [u8]) -> usize {
        match &mut self.program {
            Program::Dynamixel(servo) => servo.device.speak(out),
            Program::Feetech(servo) => servo.device.speak(out),
            Program::Pulse(_) => 0,
        }
    }

    fn silence(&mut self) {
        if !self.runs() {
            return;
        }
        match &mut self.program {
            Program::Dynamixel(servo) => servo.device.silence(),
            Program::Feetech(servo) => servo.device.silence(),
            Program::Pulse(_) => {}
        }
    }
}
