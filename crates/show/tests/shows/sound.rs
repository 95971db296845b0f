//! Tests of the section for a sound, which follows a show in its file.

use sinew_show::sound::{Sound, SoundError, split};
use sinew_show::write::{Motion, Settings, write};
use sinew_show::{Joint, Rate, Show};

fn show() -> Vec<u8> {
    let q: Vec<f64> = (0..=100).map(|k| 0.5 * f64::from(k) / 100.0).collect();
    let motion = Motion {
        joints: &[Joint::Revolute],
        q: &q,
        rate: Rate { samples: 100, seconds: 1 },
        is_loop: false,
        rig: 7,
        cues: &[],
        time_code: None,
        course: &[],
    };
    write(&motion, &Settings::default()).expect("a show").bytes
}

fn sound() -> Sound {
    Sound {
        name: "grüße.wav".to_owned(),
        sha256: std::array::from_fn(|index| u8::try_from(index).expect("below 32")),
        file_len: 123_456,
        duration_us: 2_500_000,
        offset_us: -20_000,
    }
}

#[test]
fn a_show_is_the_same_with_and_without_a_sound() {
    let bytes = show();
    let mut file = bytes.clone();
    sound().append_to(&mut file);
    let (show, found) = split(&file).expect("a section");
    assert_eq!((show, found), (&bytes[..], Some(sound())));
    assert_eq!(split(&bytes), Ok((&bytes[..], None)));
    Show::open(show).expect("the same show");
    // `Show::open`, which boards use, refuses bytes after the show, so no board can store a section.
    Show::open(&file).expect_err("longer than a show");
    for other in [&b""[..], b"SNWS", b"HIERARCHY and more text"] {
        assert_eq!(split(other), Ok((other, None)));
    }
}

#[test]
fn damaged_sections_are_refused() {
    let bytes = show();
    let mut file = bytes.clone();
    sound().append_to(&mut file);
    for at in bytes.len()..file.len() {
        let mut damaged = file.clone();
        damaged[at] ^= 0x10;
        split(&damaged).expect_err("one bit is another");
        split(&file[..at]).map_or_else(drop, |(_, found)| assert_eq!(found, None));
    }
    let mut more = file.clone();
    more.extend(b"RIFF");
    assert!(matches!(split(&more), Err(SoundError::Checksum { .. })));
    let mut long = Sound { name: "ü".repeat(300), ..sound() };
    let mut file = bytes;
    long.append_to(&mut file);
    long.name.truncate(254);
    assert_eq!(split(&file).expect("a section").1, Some(long));
}
