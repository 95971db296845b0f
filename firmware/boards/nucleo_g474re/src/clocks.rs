//! The clocks of the NUCLEO-G474RE.

use embassy_stm32::Config;
use embassy_stm32::rcc;
use embassy_stm32::time::Hertz;

/// Returns the clock settings: 170 MHz from the board's 24 MHz crystal.
pub(crate) fn clocks() -> Config {
    let mut config = Config::default();
    config.rcc.hse = Some(rcc::Hse { freq: Hertz(24_000_000), mode: rcc::HseMode::Oscillator });
    config.rcc.pll = Some(rcc::Pll {
        source: rcc::PllSource::HSE,
        prediv: rcc::PllPreDiv::DIV6,
        mul: rcc::PllMul::MUL85,
        divp: None,
        divq: None,
        divr: Some(rcc::PllRDiv::DIV2),
    });
    config.rcc.sys = rcc::Sysclk::PLL1_R;
    config.rcc.boost = true;
    config
}
