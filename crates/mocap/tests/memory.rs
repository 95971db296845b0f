//! Measures the memory that readers use for files that need much of it, and compares it with the limit stated in
//! `recording.rs`.
#![cfg(target_os = "linux")]

use std::fs;
use std::path::Path;

use sinew_mocap::{asf_amc, bvh};

/// Maximum memory per byte of a file, and constant part, bytes.
const BYTES_PER_BYTE: usize = 200;
const BESIDE: usize = 8 << 20;

/// Returns the maximum growth of this process while `read` runs. The kernel records the largest size; writing 5
/// resets it.
fn grown_by<T>(read: impl FnOnce() -> T) -> (usize, T) {
    let status = |key: &str| -> usize {
        let text = fs::read_to_string("/proc/self/status").expect("Linux tells it");
        let line = text.lines().find(|line| line.starts_with(key)).expect("Linux tells it");
        let kilobytes = line.split_whitespace().nth(1).expect("a number");
        1024 * kilobytes.parse::<usize>().expect("a number")
    };
    fs::write("/proc/self/clear_refs", "5").expect("a process may forget its own");
    let before = status("VmRSS:");
    let read = read();
    (status("VmHWM:").saturating_sub(before), read)
}

/// Returns a chain of joints, of which the first has channels.
fn chain(joints: usize, channels: &str) -> String {
    let rest = "JOINT j { OFFSET 0 1 0 CHANNELS 0\n";
    let rest: String = (1..joints).map(|j| rest.replacen('j', &format!("j{j}"), 1)).collect();
    let ends = "}".repeat(joints);
    format!("HIERARCHY\nROOT r\n{{\nOFFSET 0 0 0\nCHANNELS {channels}\n{rest}{ends}\nMOTION\n")
}

/// Returns a BVH file with this number of rows.
fn rows(joints: usize, rows: usize) -> String {
    let head = chain(joints, "1 Xrotation");
    format!("{head}Frames: {rows}\nFrame Time: 0.01\n{}", "0\n".repeat(rows))
}

/// Returns bones on the root, and a motion that contains two of many frames.
fn bones(count: usize) -> (String, String) {
    let name = |bone: usize| format!("b{bone}");
    let bone = |bone: usize| {
        format!(
            "begin\nid {bone}\nname {}\ndirection 0 1 0\nlength 1\naxis 0 0 0 XYZ\nend\n",
            name(bone)
        )
    };
    let bones: String = (1..=count).map(bone).collect();
    let names: Vec<String> = (1..=count).map(name).collect();
    let asf = format!(
        ":version 1.10\n:name a\n:units\nmass 1\nlength 1\nangle deg\n:root\norder TX TY TZ RX RY RZ\naxis XYZ\n\
         position 0 0 0\norientation 0 0 0\n:bonedata\n{bones}:hierarchy\nbegin\nroot {}\nend\n",
        names.join(" ")
    );
    (asf, ":FULLY-SPECIFIED\n:DEGREES\n1\n9000\n".to_owned())
}

/// A single test, because memory of other tests at the same time would count.
#[test]
fn a_byte_asks_for_at_most_200() {
    let check = |what: &str, bytes: usize, grown: usize| {
        let most = BYTES_PER_BYTE * bytes + BESIDE;
        assert!(grown <= most, "{what}: {grown} bytes for {bytes}, at most {most}");
    };
    // Refused after reading much, read completely, and with the smallest possible frames.
    for (joints, count, is_read) in [
        (1024, 90_000, false),
        (1024, 100, false),
        (50, 90_000, false),
        (4, 1_000_000, true),
        (1, 2_000_000, true),
    ] {
        let text = rows(joints, count);
        let (grown, read) = grown_by(|| bvh::parse(text.as_bytes(), Path::new("a.bvh")));
        check(&format!("BVH of {joints} joints"), text.len(), grown);
        assert_eq!(read.is_ok(), is_read, "{joints} joints: {:?}", read.err());
    }
    let (asf, amc) = bones(1000);
    let (grown, read) = grown_by(|| {
        asf_amc::parse((asf.as_bytes(), Path::new("a.asf")), (amc.as_bytes(), Path::new("a.amc")))
    });
    check("ASF/AMC", asf.len() + amc.len(), grown);
    let error = read.expect_err("too many frames").to_string();
    assert!(error.contains("expected at most"), "{error}");
}
