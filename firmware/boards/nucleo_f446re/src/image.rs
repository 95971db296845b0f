//! Image for ST's NUCLEO-F446RE: its clocks, pins and DMA channels. All boards run the same node,
//! [`sinew_stm32::run`].
//!
//! docs/nucleo.md has the wiring, pin by pin.

use cortex_m_rt::entry;
use embassy_stm32::{bind_interrupts, dma, peripherals};
use sinew_stm32::{CAPACITY, Dma, Nucleo};
use sinew_storage::{Area, BoardTable};

use crate::clocks::clocks;

/// Flash areas: sectors of 16 kB for settings, rig and faults, and a sector of 128 kB for a show. memory.x places the
/// code.
const TABLE: BoardTable = BoardTable {
    slots: &[Area { start: 0x6_0000, sector_len: 0x2_0000, sectors: 1 }],
    capacity: CAPACITY,
    ..BoardTable::NUCLEO_F446RE
};

bind_interrupts!(struct Irqs {
    DMA1_STREAM5 => dma::InterruptHandler<peripherals::DMA1_CH5>;
    DMA1_STREAM6 => dma::InterruptHandler<peripherals::DMA1_CH6>;
    DMA2_STREAM2 => dma::InterruptHandler<peripherals::DMA2_CH2>;
    DMA2_STREAM7 => dma::InterruptHandler<peripherals::DMA2_CH7>;
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
            Dma::arriving::<peripherals::USART2, _>(p.DMA1_CH5, Irqs),
            Dma::leaving::<peripherals::USART2, _>(p.DMA1_CH6, Irqs),
        ],
        servos: p.USART1,
        servos_wire: p.PA9,
        servos_direction: p.PA8,
        servos_dma: [
            Dma::arriving::<peripherals::USART1, _>(p.DMA2_CH2, Irqs),
            Dma::leaving::<peripherals::USART1, _>(p.DMA2_CH7, Irqs),
        ],
        i2c: p.I2C1,
        scl: p.PB8,
        sda: p.PB9,
        light_timer: p.TIM2,
        light: p.PA5,
        flash: p.FLASH,
        table: TABLE,
        core_hz: 180_000_000,
    };
    nucleo.run()
}
