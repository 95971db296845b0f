//! `sinew study` prints the command that replaces it.

use crate::common::sinew;

#[test]
fn who_asks_for_a_study_is_told_the_command() {
    let output = sinew(&["study", "mds", "--quick", "--help"]);
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{told}");
    let command = "`cargo run --release --manifest-path dev/studies/Cargo.toml --`";
    assert!(told.contains(command), "{told}");
    let help = sinew(&["--help"]);
    assert!(!String::from_utf8_lossy(&help.stdout).contains("study"));
}
