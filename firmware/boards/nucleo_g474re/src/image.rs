//! Image for ST's NUCLEO-G474RE: its clocks, pins and DMA channels. What it does is [`sinew_stm32::run`].
//!
//! The wiring is that of docs/nucleo.md, but for I2C: PB8 is BOOT0 here, and a pull-up there would keep the board from
//! starting. So it is on PA15 and PB7.

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

/// Pages have 2 kB here, and an area may be of any number of them: the reference board's parts.
const TABLE: BoardTable = BoardTable {
    slots: &[Area { start: 0x6_0000, sector_len: 0x2_0000, sectors: 1 }],
    capacity: CAPACITY,
    ..BoardTable::NUCLEO_F446RE
};

const CORE_HZ: u32 = 170_000_000;

/// What the ST-Link's serial port carries, and USART2's clock of 170 MHz divides to exactly.
const LINK_BPS: u32 = 1_000_000;

/// What new servos of most kinds talk at; the rig's wiring says another rate.
const SERVO_BPS: u32 = 1_000_000;

/// The light's PWM: it does not flicker.
const LIGHT_HZ: u32 = 500;

bind_interrupts!(struct Irqs {
    DMA1_CHANNEL1 => dma::InterruptHandler<peripherals::DMA1_CH1>;
    DMA1_CHANNEL2 => dma::InterruptHandler<peripherals::DMA1_CH2>;
    DMA1_CHANNEL3 => dma::InterruptHandler<peripherals::DMA1_CH3>;
    DMA1_CHANNEL4 => dma::InterruptHandler<peripherals::DMA1_CH4>;
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
    let link = Uart::new_blocking(p.USART2, p.PA3, p.PA2, config).expect("170 MHz divides");
    let come = RxDma::<peripherals::USART2>::request(&*p.DMA1_CH1);
    let out = TxDma::<peripherals::USART2>::request(&*p.DMA1_CH2);
    let link = Serial::new(
        link,
        pac::USART2,
        Dma { channel: Channel::new(p.DMA1_CH1, Irqs), request: come },
        Dma { channel: Channel::new(p.DMA1_CH2, Irqs), request: out },
    );

    let mut config = usart::Config::default();
    config.baudrate = SERVO_BPS;
    // One wire for both sides: the line is high by its pull-up.
    config.tx_config = OutputConfig::OpenDrain;
    let readback = HalfDuplexReadback::NoReadback;
    let servos = Uart::new_blocking_half_duplex(p.USART1, p.PA9, config, readback);
    let come = RxDma::<peripherals::USART1>::request(&*p.DMA1_CH3);
    let out = TxDma::<peripherals::USART1>::request(&*p.DMA1_CH4);
    let servos = ServoLine::new(
        servos.expect("170 MHz divides"),
        pac::USART1,
        Output::new(p.PA8, Level::Low, Speed::High),
        Dma { channel: Channel::new(p.DMA1_CH3, Irqs), request: come },
        Dma { channel: Channel::new(p.DMA1_CH4, Irqs), request: out },
    );

    let mut config = i2c::Config::default();
    config.frequency = Hertz(400_000);
    // The longest write, of 16 channels, takes 1.5 ms.
    config.timeout = embassy_time::Duration::from_millis(2);
    let i2c = I2c::new_blocking(p.I2C1, p.PA15, p.PB7, config);

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

/// 170 MHz of the board's 24 MHz crystal.
fn clocks() -> embassy_stm32::Config {
    let mut config = embassy_stm32::Config::default();
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
