//! The clocks of the NUCLEO-F446RE.

use embassy_stm32::Config;
use embassy_stm32::rcc;
use embassy_stm32::time::Hertz;

/// Returns the clock settings: 180 MHz from the ST-Link's 8 MHz. embassy switches over-drive on. Timers of APB1 run
/// at 90 MHz, timers of APB2 at 180 MHz.
pub(crate) fn clocks() -> Config {
    let mut config = Config::default();
    config.rcc.hse = Some(rcc::Hse { freq: Hertz(8_000_000), mode: rcc::HseMode::Bypass });
    config.rcc.pll_src = rcc::PllSource::HSE;
    config.rcc.pll = Some(rcc::Pll {
        prediv: rcc::PllPreDiv::DIV4,
        mul: rcc::PllMul::MUL180,
        divp: Some(rcc::PllPDiv::DIV2),
        divq: None,
        divr: None,
    });
    config.rcc.ahb_pre = rcc::AHBPrescaler::DIV1;
    config.rcc.apb1_pre = rcc::APBPrescaler::DIV4;
    config.rcc.apb2_pre = rcc::APBPrescaler::DIV2;
    config.rcc.sys = rcc::Sysclk::PLL1_P;
    config
}
