//! Image for ST's NUCLEO-G474RE: its clocks, pins and DMA channels. All boards run the same node,
//! [`sinew_stm32::run`].
//!
//! The wiring is described in docs/nucleo.md, except for I2C: on this board PB8 is BOOT0, and a pull-up there would
//! keep the board from starting. I2C is therefore on PA15 and PB7.

use cortex_m_rt::entry;
use embassy_stm32::{bind_interrupts, dma, peripherals};
use sinew_stm32::{CAPACITY, Dma, Nucleo};
use sinew_storage::{Area, BoardTable};

use crate::clocks::clocks;

/// Flash areas: the same as on the reference board. Pages have 2 kB on this chip, and an area may consist of any
/// number of pages.
const TABLE: BoardTable = BoardTable {
    slots: &[Area { start: 0x6_0000, sector_len: 0x2_0000, sectors: 1 }],
    capacity: CAPACITY,
    ..BoardTable::NUCLEO_F446RE
};

bind_interrupts!(struct Irqs {
    DMA1_CHANNEL1 => dma::InterruptHandler<peripherals::DMA1_CH1>;
    DMA1_CHANNEL2 => dma::InterruptHandler<peripherals::DMA1_CH2>;
    DMA1_CHANNEL3 => dma::InterruptHandler<peripherals::DMA1_CH3>;
    DMA1_CHANNEL4 => dma::InterruptHandler<peripherals::DMA1_CH4>;
});

#[entry]
fn main() -> ! {
    let p = embassy_stm32::init(clocks());
    let nucleo = Nucleo {
        outputs: p.PB5,
        stop: p.PC8,
        link: p.USART2,
        link_rx: p.PA3,
        link_tx: p.PA2,
        link_dma: [
            Dma::arriving::<peripherals::USART2, _>(p.DMA1_CH1, Irqs),
            Dma::leaving::<peripherals::USART2, _>(p.DMA1_CH2, Irqs),
        ],
        servos: p.USART1,
        servos_wire: p.PA9,
        servos_direction: p.PA8,
        servos_dma: [
            Dma::arriving::<peripherals::USART1, _>(p.DMA1_CH3, Irqs),
            Dma::leaving::<peripherals::USART1, _>(p.DMA1_CH4, Irqs),
        ],
        i2c: p.I2C1,
        scl: p.PA15,
        sda: p.PB7,
        light_timer: p.TIM2,
        light: p.PA5,
        flash: p.FLASH,
        table: TABLE,
        core_hz: 170_000_000,
    };
    nucleo.run()
}
