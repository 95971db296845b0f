//! The image: a node whose host uses QEMU's standard input and output, through semihosting.
//!
//! The machine stops while the host computes, and there are no interrupts: its results depend only on its input.

use core::convert::Infallible;
use core::sync::atomic::Ordering;

// Defines the critical section.
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

/// Files of the host.
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

/// Handles a panic as on a board: writes a record that survives a reset, then resets. A panic that the host did not
/// order is an error, and ends QEMU.
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
