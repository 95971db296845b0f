//! The same bits on a Cortex-M4F, as QEMU emulates it, and on this host.
//!
//! The image performs a built-in clip with each method and leaves all its torques in a file; here the same run is
//! made and compared number by number, so that a difference has a name.

use std::path::PathBuf;
use std::process::Command;

use sinew_firmware::replay::{METHODS, Replay, components};
use sinew_firmware::show::Show;
use sinew_sim::figure::{BODIES, BODY_COUNT};

const QUANTITIES: [&str; 6] = ["moment x", "moment y", "moment z", "force x", "force y", "force z"];

fn path(variable: &str) -> PathBuf {
    std::env::var_os(variable)
        .unwrap_or_else(|| panic!("{variable} is not set: run this test with `cargo xtask test`"))
        .into()
}

/// Torques of the image, in the order the image writes them, as bits.
fn on_the_board() -> Vec<u32> {
    let folder = tempfile::tempdir().unwrap();
    let output = Command::new("qemu-system-arm")
        .args(["-machine", "mps2-an386", "-nographic", "-icount", "shift=0"])
        .args(["-semihosting-config", "enable=on,target=native", "-kernel"])
        .arg(path("SINEW_QEMU_IMAGE"))
        .current_dir(&folder)
        .output()
        .expect("qemu-system-arm can be started");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let bytes = std::fs::read(folder.path().join("torques.bin")).unwrap();
    bytes.chunks_exact(4).map(|word| u32::from_le_bytes(word.try_into().unwrap())).collect()
}

#[test]
#[ignore = "needs SINEW_QEMU_IMAGE and SINEW_QEMU_SHOW, which `cargo xtask test` sets"]
fn the_board_and_the_host_compute_the_same_bits() {
    let board = on_the_board();
    let bytes = std::fs::read(path("SINEW_QEMU_SHOW")).unwrap();
    let show = Show::parse(&bytes).unwrap();
    assert!(show.frame_count() >= 2000, "only {} ticks of each method", show.frame_count());
    let per_tick = BODY_COUNT * QUANTITIES.len();
    assert_eq!(board.len(), METHODS.len() * show.frame_count() * per_tick);

    let mut board = board.into_iter();
    for method in METHODS {
        let mut replay = Replay::<BODY_COUNT>::new(show, method).unwrap();
        for tick in 0..show.frame_count() {
            replay.observe(tick).unwrap();
            let torques = replay.control();
            assert_eq!(torques.len(), BODY_COUNT);
            for (body, torque) in BODIES.iter().zip(torques) {
                for (quantity, number) in QUANTITIES.iter().zip(components(&torque.value)) {
                    let (here, there) = (number.to_bits(), board.next().unwrap());
                    assert!(
                        here == there,
                        "{method}, tick {tick}, {}, {quantity}: {here:08x} ({number}) here, \
                         {there:08x} ({}) on the board",
                        body.name,
                        f32::from_bits(there)
                    );
                }
            }
        }
    }
}
