//! Pings servo 1 every 2 ms while the emergency stop is not pressed, feeds the watchdog, and accepts commands of one
//! letter over the host link: `e` erases the last sector of flash, `w` programs a word of it, `h` hangs, `p` panics.
//! It reports each action.

use core::fmt::Write as _;
use core::panic::PanicInfo;

use embassy_executor::Spawner;
use embassy_stm32::flash::Flash;
use embassy_stm32::gpio::{Input, Level, Output, Pull, Speed};
use embassy_stm32::mode::Async;
use embassy_stm32::usart::{self, HalfDuplexReadback, Uart, UartTx};
use embassy_stm32::wdg::IndependentWatchdog;
use embassy_stm32::{bind_interrupts, dma, peripherals, rcc};
use embassy_time::{Duration, Instant, Ticker, with_timeout};
use heapless::String;

use crate::clocks::clocks;

bind_interrupts!(struct Irqs {
    USART1 => usart::InterruptHandler<peripherals::USART1>;
    USART2 => usart::InterruptHandler<peripherals::USART2>;
    DMA1_STREAM5 => dma::InterruptHandler<peripherals::DMA1_CH5>;
    DMA1_STREAM6 => dma::InterruptHandler<peripherals::DMA1_CH6>;
    DMA2_STREAM2 => dma::InterruptHandler<peripherals::DMA2_CH2>;
    DMA2_STREAM7 => dma::InterruptHandler<peripherals::DMA2_CH7>;
});

/// A ping to servo 1.
const PING: [u8; 10] = [0xFF, 0xFF, 0xFD, 0, 1, 3, 0, 1, 0x19, 0x4E];
const ANSWER_LEN: usize = 14;
const TICK: Duration = Duration::from_millis(2);
/// Watchdog time, µs: longer than the longest erase of the last sector.
const WATCHDOG_US: u32 = 5_000_000;
/// Start and end of the last sector, from the start of flash.
const SECTOR: u32 = 0x6_0000;
const SECTOR_END: u32 = 0x8_0000;
/// Number of ticks between reports of answered pings.
const REPORT_TICKS: u32 = 50;

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    // The watchdog resets the board.
    loop {
        cortex_m::asm::nop();
    }
}

fn baud(baudrate: u32) -> usart::Config {
    let mut config = usart::Config::default();
    config.baudrate = baudrate;
    config
}

async fn say(link: &mut UartTx<'_, Async>, line: core::fmt::Arguments<'_>) {
    let mut text: String<96> = String::new();
    // Text that does not fit is cut off.
    let _ = text.write_fmt(line);
    let _ = link.write(text.as_bytes()).await;
}

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    // A single task does all the work.
    let _: Spawner = spawner;
    let board = embassy_stm32::init(clocks());
    let mut watchdog = IndependentWatchdog::new(board.IWDG, WATCHDOG_US);
    watchdog.unleash();
    let mut light = Output::new(board.PA5, Level::Low, Speed::Low);
    let stop = Input::new(board.PC8, Pull::Down);
    let link = Uart::new(
        board.USART2,
        board.PA3,
        board.PA2,
        board.DMA1_CH6,
        board.DMA1_CH5,
        Irqs,
        baud(115_200),
    );
    let Ok(link) = link else { return };
    let (mut link, orders) = link.split();
    let mut room = [0; 64];
    // The port receives continuously: bytes between two reads are stored.
    let mut orders = orders.into_ring_buffered(&mut room);
    let bus = Uart::new_half_duplex(
        board.USART1,
        board.PA9,
        board.DMA2_CH7,
        board.DMA2_CH2,
        Irqs,
        baud(1_000_000),
        HalfDuplexReadback::NoReadback,
    );
    let Ok(mut bus) = bus else { return };
    let mut flash = Flash::new_blocking(board.FLASH);
    let mut kept = [0; 4];
    let read = flash.blocking_read(SECTOR, &mut kept).is_ok();
    let sys = rcc::clocks(&board.RCC).sys.to_hertz().map_or(0, |hertz| hertz.0);
    say(&mut link, format_args!("boot {sys} {read} {:08x}\n", u32::from_le_bytes(kept))).await;

    let mut ticks = Ticker::every(TICK);
    let (mut count, mut answered) = (0_u32, 0_u32);
    loop {
        ticks.next().await;
        watchdog.pet();
        count = count.wrapping_add(1);
        // The switch is normally closed: low means pressed, unplugged or cut.
        if stop.is_high() {
            light.set_high();
            #[cfg(not(feature = "stale-tc"))]
            embassy_stm32::pac::USART1.sr().modify(|status| status.set_tc(false));
            let _ = bus.write(&PING).await;
            let mut answer = [0; ANSWER_LEN];
            let read = with_timeout(Duration::from_millis(1), bus.read(&mut answer)).await;
            answered += u32::from(matches!(read, Ok(Ok(()))));
        } else {
            light.set_low();
        }
        if count % REPORT_TICKS == 0 {
            let ms = Instant::now().as_millis();
            say(&mut link, format_args!("ticks {count} answered {answered} at {ms}\n")).await;
        }
        let mut order = [0; 8];
        let wait = Duration::from_micros(100);
        let Ok(Ok(len)) = with_timeout(wait, orders.read(&mut order)).await else {
            continue;
        };
        match order.get(..len) {
            Some([b'e', ..]) => {
                // embassy-stm32 0.6.0 leaves PSIZE at x8 until the first write: 2 s instead of 1.
                embassy_stm32::pac::FLASH.cr().modify(|control| {
                    control.set_psize(embassy_stm32::pac::flash::vals::Psize::PSIZE32);
                });
                let erased = flash.blocking_erase(SECTOR, SECTOR_END).is_ok();
                say(&mut link, format_args!("erased {erased}\n")).await;
            }
            Some([b'w', ..]) => {
                let wrote = flash.blocking_write(SECTOR, b"kept").is_ok();
                let read = flash.blocking_read(SECTOR, &mut kept).is_ok() && kept == *b"kept";
                say(&mut link, format_args!("wrote {wrote} {read}\n")).await;
            }
            Some([b'h', ..]) => hang(),
            Some([b'p', ..]) => panic!("as ordered"),
            _ => {}
        }
    }
}

/// Hangs on purpose: the watchdog resets the board.
fn hang() -> ! {
    loop {
        cortex_m::asm::nop();
    }
}
