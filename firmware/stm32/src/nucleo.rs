//! Shared by the images of ST's NUCLEO-64 boards: their connectors are the same, and the same things are wired to
//! them (docs/nucleo.md).

use embassy_stm32::Peri;
use embassy_stm32::PeripheralType;
use embassy_stm32::flash::Flash;
use embassy_stm32::gpio::{Input, Level, Output, OutputType, Pull, Speed};
use embassy_stm32::i2c::{self, I2c, SclPin, SdaPin};
use embassy_stm32::pac;
use embassy_stm32::peripherals::{
    FLASH, I2C1, PA2, PA3, PA5, PA8, PA9, PB5, PC8, TIM2, USART1, USART2,
};
use embassy_stm32::time::{Hertz, hz};
use embassy_stm32::timer::low_level::CountingMode;
use embassy_stm32::timer::simple_pwm::{PwmPin, SimplePwm};
use embassy_stm32::usart::{self, HalfDuplexReadback, OutputConfig, Uart};
use sinew_storage::BoardTable;

use crate::{Chip, Dma, Hardware, Light, Serial, ServoLine, run};

/// Bit rate of the host link over the ST-Link's serial port. USART2's clock can be divided to exactly this rate on
/// each board.
const LINK_BPS: u32 = 1_000_000;

/// Bit rate of most new servos. The rig's wiring sets another rate.
const SERVO_BPS: u32 = 1_000_000;

/// Frequency of the light's PWM, Hz, high enough not to flicker.
const LIGHT_HZ: u32 = 500;

/// The pins, DMA channels and clock of a NUCLEO. Its clocks run.
pub struct Nucleo<Scl: PeripheralType + 'static, Sda: PeripheralType + 'static> {
    /// The output-enable pin (OE) of a PCA9685.
    pub outputs: Peri<'static, PB5>,
    /// Input of the emergency stop's circuit.
    pub stop: Peri<'static, PC8>,
    /// UART of the host link, on the ST-Link's serial port.
    pub link: Peri<'static, USART2>,
    /// Pin of the link's received bytes.
    pub link_rx: Peri<'static, PA3>,
    /// Pin of the link's sent bytes.
    pub link_tx: Peri<'static, PA2>,
    /// DMA channels of the link: for received bytes, for sent bytes.
    pub link_dma: [Dma; 2],
    /// UART of the servos' bus line.
    pub servos: Peri<'static, USART1>,
    /// Pin of the servos' single wire.
    pub servos_wire: Peri<'static, PA9>,
    /// Direction pin for a bus buffer: high while bytes are sent.
    pub servos_direction: Peri<'static, PA8>,
    /// DMA channels of the servos' line: for received bytes, for sent bytes.
    pub servos_dma: [Dma; 2],
    /// I2C bus of a PCA9685.
    pub i2c: Peri<'static, I2C1>,
    /// Clock pin of the I2C bus.
    pub scl: Peri<'static, Scl>,
    /// Data pin of the I2C bus.
    pub sda: Peri<'static, Sda>,
    /// Timer of the status light.
    pub light_timer: Peri<'static, TIM2>,
    /// Pin of the status light.
    pub light: Peri<'static, PA5>,
    /// The chip's flash.
    pub flash: Peri<'static, FLASH>,
    /// The parts of flash that storage uses.
    pub table: BoardTable,
    /// Clock of the processor, Hz.
    pub core_hz: u32,
}

impl<Scl, Sda> Nucleo<Scl, Sda>
where
    Scl: PeripheralType + SclPin<I2C1> + 'static,
    Sda: PeripheralType + SdaPin<I2C1> + 'static,
{
    /// Runs the node until the next reset. May be called only once.
    // Inlined into its one caller: handing over the channels would take 150 bytes of flash.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "it is called once")]
    pub fn run(self) -> ! {
        let core = cortex_m::Peripherals::take().expect("it is called once");
        // Switches the pulses off first of all. Until this line the pull-up has kept them off.
        let outputs = Output::new(self.outputs, Level::High, Speed::Low);
        // The input is high while the circuit is closed: 3.3 V through the button. It is low if the circuit is
        // open, cut or unplugged.
        let stop = Input::new(self.stop, Pull::Down);

        let mut config = usart::Config::default();
        config.baudrate = LINK_BPS;
        let link = Uart::new_blocking(self.link, self.link_rx, self.link_tx, config);
        let [come, out] = self.link_dma;
        let link = Serial::new(link.expect("the clock divides"), pac::USART2, come, out);

        let mut config = usart::Config::default();
        config.baudrate = SERVO_BPS;
        // A single wire carries both directions: the pull-up keeps the line high.
        config.tx_config = OutputConfig::OpenDrain;
        let readback = HalfDuplexReadback::NoReadback;
        let servos =
            Uart::new_blocking_half_duplex(self.servos, self.servos_wire, config, readback);
        let direction = Output::new(self.servos_direction, Level::Low, Speed::High);
        let [come, out] = self.servos_dma;
        let servos = servos.expect("the clock divides");
        let servos = ServoLine::new(servos, pac::USART1, direction, come, out);

        let mut config = i2c::Config::default();
        config.frequency = Hertz(400_000);
        // The longest write, of 16 channels, takes 1.5 ms.
        config.timeout = embassy_time::Duration::from_millis(2);
        let i2c = I2c::new_blocking(self.i2c, self.scl, self.sda, config);

        let light = PwmPin::new(self.light, OutputType::PushPull);
        let light = SimplePwm::new(
            self.light_timer,
            Some(light),
            None,
            None,
            None,
            hz(LIGHT_HZ),
            CountingMode::EdgeAlignedUp,
        );

        run(
            core,
            Hardware {
                link,
                link_bps: LINK_BPS,
                servos,
                i2c,
                outputs,
                stop,
                light: Light::new(light),
                flash: Chip::new(Flash::new_blocking(self.flash)),
                table: self.table,
                core_hz: self.core_hz,
            },
        )
    }
}
