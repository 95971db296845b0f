//! The image: a node whose host is at QEMU's standard input and output, by semihosting.
//!
//! The machine stands still while the host thinks, and nothing interrupts: what it computes depends on what it reads.

use core::convert::Infallible;

// What a critical section is.
use cortex_m as _;
use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, heprintln};
use sinew_emulated::message::{Bytes, End};
use sinew_emulated::node::{self, FLASH_LEN};
use static_cell::ConstStaticCell;

use crate::files;

#[entry]
fn main() -> ! {
    static FLASH: ConstStaticCell<[u8; FLASH_LEN]> = ConstStaticCell::new([0; FLASH_LEN]);
    static LENT: ConstStaticCell<[u8; 1 << 20]> = ConstStaticCell::new([0; 1 << 20]);
    let host = Host {
        input: files::open(c"/dev/stdin", files::READ).expect("QEMU has an input"),
        output: files::open(c"/dev/stdout", files::WRITE).expect("QEMU has an output"),
    };
    node::run(&mut End::new(host), FLASH.take(), LENT.take())
}

/// The host's files.
struct Host {
    input: usize,
    output: usize,
}

impl Bytes for Host {
    type Error = Infallible;
    fn read(&mut self, bytes: &mut [u8]) -> Result<(), Infallible> {
        files::read(self.input, bytes).expect("the host goes on");
        Ok(())
    }
    fn write(&mut self, bytes: &[u8]) -> Result<(), Infallible> {
        files::write(self.output, bytes).expect("the host goes on");
        Ok(())
    }
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
    heprintln!("{}", info);
    loop {
        debug::exit(debug::EXIT_FAILURE);
    }
}
