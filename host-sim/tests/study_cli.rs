//! `sinew study`: it says where the studies went.

use std::process::Command;

#[test]
fn who_asks_for_a_study_is_told_the_command() {
    let output = Command::new(env!("CARGO_BIN_EXE_sinew"))
        .args(["study", "mds", "--quick", "--help"])
        .output()
        .expect("the command starts");
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{told}");
    let command = "`cargo run --release --manifest-path dev/studies/Cargo.toml --`";
    assert!(told.contains(command), "{told}");
    let help = Command::new(env!("CARGO_BIN_EXE_sinew")).arg("--help").output().expect("it starts");
    assert!(!String::from_utf8_lossy(&help.stdout).contains("study"));
}
