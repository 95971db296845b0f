//! The status light: shows the brightness that [`sinew_firmware::indicator`] computes.

use embassy_stm32::peripherals::TIM2;
use embassy_stm32::timer::simple_pwm::SimplePwm;
use sinew_firmware::indicator;

/// Period of the light's steps, µs.
const EVERY_US: u64 = 10_000;

/// A light at channel 1 of TIM2.
pub struct Light {
    pwm: SimplePwm<'static, TIM2>,
    due_us: u64,
}

impl Light {
    /// Creates the light. It is dark until the first step.
    pub fn new(mut pwm: SimplePwm<'static, TIM2>) -> Self {
        pwm.ch1().enable();
        Self { pwm, due_us: 0 }
    }

    /// Sets the brightness. `fault` is the number of the first latched fault.
    pub(crate) fn step(&mut self, now_us: u64, fault: Option<u8>) {
        if now_us >= self.due_us {
            self.due_us = now_us.saturating_add(EVERY_US);
            let now_ms = u32::try_from(now_us / 1000 % 0x1_0000_0000).unwrap_or_default();
            let duty = indicator::duty(fault, now_ms);
            self.pwm.ch1().set_duty_cycle_fraction(duty.into(), u8::MAX.into());
        }
    }
}
