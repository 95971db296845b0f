//! The image for QEMU's board computes the torques of the host, bit for bit.

use std::path::PathBuf;
use std::process::Command;
use std::{env, fs};

use sinew_bit_parity::replay::{METHODS, Replay, TorqueHash};
use sinew_firmware::show::Show;

/// Bodies that this program holds: as many as any board. The bits do not depend on it.
const CAPACITY: usize = 64;

/// Returns the file that an environment variable names.
fn file(variable: &str) -> PathBuf {
    env::var_os(variable).unwrap_or_else(|| panic!("{variable}: `cargo xtask test` sets it")).into()
}

#[test]
#[ignore = "needs the image that `cargo xtask firmware` builds"]
fn the_emulated_board_is_the_host() {
    let output = Command::new("qemu-system-arm")
        .args(["-machine", "mps2-an386", "-nographic"])
        .args(["-semihosting-config", "enable=on,target=native", "-kernel"])
        .arg(file("SINEW_BOARD_IMAGE"))
        .output()
        .expect("`cargo xtask setup` installs QEMU");
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{text}{}", String::from_utf8_lossy(&output.stderr));
    let word = |line: &str, name: &str| -> String {
        let of = |word: &str| Some(word.strip_prefix(name)?.strip_prefix('=')?.to_owned());
        line.split(' ').find_map(of).unwrap_or_else(|| panic!("no {name} in `{line}`"))
    };
    let on_board: Vec<_> =
        text.lines().map(|line| (word(line, "method"), word(line, "hash"))).collect();
    let bytes = fs::read(file("SINEW_BOARD_SHOW")).unwrap();
    let show = Show::parse(&bytes).unwrap();
    let on_host = METHODS.map(|method| {
        let mut replay = Replay::<CAPACITY>::new(show, method).unwrap();
        let mut hash = TorqueHash::default();
        for tick in 0..u32::try_from(show.frame_count()).unwrap() {
            hash.update(replay.step(tick).unwrap().torques());
        }
        (method.as_str().to_owned(), format!("{:016x}", hash.value()))
    });
    assert_eq!(on_board, on_host);
}
