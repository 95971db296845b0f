//! Image for ST's NUCLEO-F446RE: its clocks, pins and DMA channels. What it does is [`sinew_stm32::run`].
//!
//! docs/nucleo.md has the wiring, pin by pin.

use cortex_m_rt::entry;
use embassy_stm32::dma::Channel;
use embassy_stm32::flash::Flash;
use embassy_stm32::gpio::{Input, Level, Output, OutputType, Pull, Speed};
use embassy_stm32::i2c::{self, I2c};
use embassy_stm32::time::{Hertz, hz};
use embassy_stm32::timer::low_level::CountingMode;
use embassy_stm32::timer::simple_pwm::{PwmPin, SimplePwm};
use embassy_stm32::usart::{self, HalfDuplexReadback, OutputConfig, RxDma, TxDma, Uart};
use embassy_stm32::{bind_interrupts, dma, pac, peripherals, rcc};
use sinew_stm32::{CAPACITY, Chip, Dma, Hardware, Light, Serial, ServoLine};
use sinew_storage::{Area, BoardTable};

/// Sectors of 16 kB for settings, rig and faults, of 128 kB for a show; memory.x has where the code lies.
const TABLE: BoardTable = BoardTable {
    slots: &[Area { start: 0x6_0000, sector_len: 0x2_0000, sectors: 1 }],
    capacity: CAPACITY,
    ..BoardTable::NUCLEO_F446RE
};

const CORE_HZ: u32 = 180_000_000;

/// What the ST-Link's serial port carries, and USART2's clock of 45 MHz divides to exactly.
const LINK_BPS: u32 = 1_000_000;

/// What new servos of most kinds talk at; the rig's wiring says another rate.
const SERVO_BPS: u32 = 1_000_000;

/// The light's PWM: it does not flicker.
const LIGHT_HZ: u32 = 500;

bind_interrupts!(struct Irqs {
    DMA1_STREAM5 => dma::InterruptHandler<peripherals::DMA1_CH5>;
    DMA1_STREAM6 => dma::InterruptHandler<peripherals::DMA1_CH6>;
    DMA2_STREAM2 => dma::InterruptHandler<peripherals::DMA2_CH2>;
    DMA2_STREAM7 => dma::InterruptHandler<peripherals::DMA2_CH7>;
});

#[entry]
fn main() -> ! {
    let core = cortex_m::Peripherals::take().expect("this is the first line");
    let p = embassy_stm32::init(clocks());

    // First of all: no pulses. The pull-up has held it until here.
    let outputs = Output::new(p.PB5, Level::High, Speed::Low);
    // Closed: 3.3 V through the button. Open, cut or unplugged: low.
    let stop = Input::new(p.PC8, Pull::Down);

    let mut config = usart::Config::default();
    config.baudrate = LINK_BPS;
    let link = Uart::new_blocking(p.USART2, p.PA3, p.PA2, config).expect("45 MHz divides");
    let come = RxDma::<peripherals::USART2>::request(&*p.DMA1_CH5);
    let out = TxDma::<peripherals::USART2>::request(&*p.DMA1_CH6);
    let link = Serial::new(
        link,
        pac::USART2,
        Dma { channel: Channel::new(p.DMA1_CH5, Irqs), request: come },
        Dma { channel: Channel::new(p.DMA1_CH6, Irqs), request: out },
    );

    let mut config = usart::Config::default();
    config.baudrate = SERVO_BPS;
    // One wire for both sides: the line is high by its pull-up.
    config.tx_config = OutputConfig::OpenDrain;
    let readback = HalfDuplexReadback::NoReadback;
    let servos = Uart::new_blocking_half_duplex(p.USART1, p.PA9, config, readback);
    let come = RxDma::<peripherals::USART1>::request(&*p.DMA2_CH2);
    let out = TxDma::<peripherals::USART1>::request(&*p.DMA2_CH7);
    let servos = ServoLine::new(
        servos.expect("90 MHz divides"),
        pac::USART1,
        Output::new(p.PA8, Level::Low, Speed::High),
        Dma { channel: Channel::new(p.DMA2_CH2, Irqs), request: come },
        Dma { channel: Channel::new(p.DMA2_CH7, Irqs), request: out },
    );

    let mut config = i2c::Config::default();
    config.frequency = Hertz(400_000);
    // The longest write, of 16 channels, takes 1.5 ms.
    config.timeout = embassy_time::Duration::from_millis(2);
    let i2c = I2c::new_blocking(p.I2C1, p.PB8, p.PB9, config);

    let light = PwmPin::new(p.PA5, OutputType::PushPull);
    let light = SimplePwm::new(
        p.TIM2,
        Some(light),
        None,
        None,
        None,
        hz(LIGHT_HZ),
        CountingMode::EdgeAlignedUp,
    );

    sinew_stm32::run(
        core,
        Hardware {
            link,
            link_bps: LINK_BPS,
            servos,
            i2c,
            outputs,
            stop,
            light: Light::new(light),
            flash: Chip::new(Flash::new_blocking(p.FLASH)),
            table: TABLE,
            core_hz: CORE_HZ,
        },
    )
}

/// 180 MHz of the ST-Link's 8 MHz; embassy switches over-drive on. Timers of APB1 run at 90 MHz, of APB2 at 180.
fn clocks() -> embassy_stm32::Config {
    let mut config = embassy_stm32::Config::default();
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
