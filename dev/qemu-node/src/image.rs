//! The image: a node whose host is at QEMU's standard input and output, by semihosting.
//!
//! The machine stands still while the host thinks, and nothing interrupts: what it computes depends on what it reads.

use core::convert::Infallible;
use core::sync::atomic::Ordering;

// What a critical section is.
use cortex_m as _;
use cortex_m::peripheral::SCB;
use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, heprintln};
use sinew_firmware::node::causes;
use sinew_qemu_node::message::{Bytes, End};
use sinew_qemu_node::node::{self, IS_ORDERED};
use static_cell::ConstStaticCell;

use crate::files;
use crate::persistent_ram::PersistentRam;

#[entry]
fn main() -> ! {
    static LENT: ConstStaticCell<[u8; 1 << 20]> = ConstStaticCell::new([0; 1 << 20]);
    let host = Host {
        input: files::open(c"/dev/stdin", files::READ).expect("QEMU has an input"),
        output: files::open(c"/dev/stdout", files::WRITE).expect("QEMU has an output"),
    };
    let persistent_ram = PersistentRam::take();
    let causes = causes(false, false, persistent_ram.take_panic());
    node::run(&mut End::new(host), causes, &mut persistent_ram.flash, LENT.take())
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

/// As on a board: a record that survives, then a reset. A panic that the host did not order is a mistake: it ends QEMU.
#[panic_handler]
fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
    if IS_ORDERED.load(Ordering::Relaxed) {
        PersistentRam::note_panic();
        SCB::sys_reset();
    }
    heprintln!("{}", info);
    loop {
        debug::exit(debug::EXIT_FAILURE);
    }
}
