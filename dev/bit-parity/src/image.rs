//! Answers a request of [`sinew_bit_parity::answer`] on QEMU's `mps2-an386`, with or without its floating-point unit,
//! depending on the target. Standard input and output are the host's, through semihosting.

use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, heprintln};
use sinew_bit_parity::answer;
use static_cell::ConstStaticCell;

use crate::{BODIES, BUFFER_LEN, COORDINATES, DOFS, files};

#[entry]
fn main() -> ! {
    match perform() {
        Ok(()) => debug::exit(debug::EXIT_SUCCESS),
        Err(problem) => {
            heprintln!("error: {}", problem);
            debug::exit(debug::EXIT_FAILURE);
        }
    }
    loop {
        cortex_m::asm::wfi();
    }
}

fn perform() -> Result<(), &'static str> {
    static BUFFER: ConstStaticCell<[u8; BUFFER_LEN]> = ConstStaticCell::new([0; BUFFER_LEN]);
    let input = files::open(c"/dev/stdin", files::READ)?;
    let output = files::open(c"/dev/stdout", files::WRITE)?;
    answer::<BODIES, DOFS, COORDINATES>(
        BUFFER.take(),
        |bytes| files::read(input, bytes),
        |bytes| files::write(output, bytes),
    )
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
    heprintln!("{}", info);
    loop {
        debug::exit(debug::EXIT_FAILURE);
    }
}
