//! A show with clicks: a sound with a click each second, and keys with which a jaw opens at each click.

use std::fmt::Write as _;

/// Samples per second of the sound.
const RATE_HZ: u32 = 8000;
/// Time of the first click in the show, and time from click to click, s.
const EVERY_S: u32 = 1;
/// Length of the shortest click, and the difference from one length to the next, samples. Clicks of eight lengths
/// follow each other, so that a lost click is noticed.
const SHORTEST: usize = 48;
const LONGER: usize = 24;
const LENGTHS: usize = 8;
/// Half of the time in which the jaw opens, s: it is half open at the click.
const HALF_S: f64 = 0.06;
/// Angles of the closed and of the open jaw, deg.
const CLOSED_DEG: f64 = -1.0;
const OPEN_DEG: f64 = -13.0;

/// Returns the times of the clicks of a show, s. The show ends later, with a closed jaw.
fn times_s(seconds: u32) -> impl Iterator<Item = u32> {
    (0..seconds).step_by(EVERY_S as usize).skip(1)
}

/// Returns the duration of a click of the show, s.
pub(super) fn duration_s(index: usize) -> f64 {
    length(index) as f64 / f64::from(RATE_HZ)
}

fn length(index: usize) -> usize {
    SHORTEST + LONGER * (index % LENGTHS)
}

/// Returns a WAV file, 8 bits at 8 kHz: a soft tone, which marks where the sound begins and ends, and loud clicks.
pub(super) fn wav(seconds: u32) -> Vec<u8> {
    let count = RATE_HZ * seconds;
    // A tone of 500 Hz, around the middle of 128.
    let mut samples: Vec<u8> =
        (0..count).map(|at| if at / 8 % 2 == 0 { 122 } else { 134 }).collect();
    for (index, time_s) in times_s(seconds).enumerate() {
        let click = samples[(RATE_HZ * time_s) as usize..].iter_mut().take(length(index));
        // 1 kHz.
        click.enumerate().for_each(|(at, sample)| *sample = if at / 4 % 2 == 0 { 240 } else { 16 });
    }
    let mut bytes = Vec::new();
    bytes.extend(b"RIFF");
    bytes.extend((36 + count).to_le_bytes());
    bytes.extend(b"WAVEfmt ");
    bytes.extend(16_u32.to_le_bytes());
    bytes.extend([1_u16, 1].map(u16::to_le_bytes).concat());
    bytes.extend([RATE_HZ, RATE_HZ].map(u32::to_le_bytes).concat());
    bytes.extend([1_u16, 8].map(u16::to_le_bytes).concat());
    bytes.extend(b"data");
    bytes.extend(count.to_le_bytes());
    bytes.extend(samples);
    bytes
}

/// Returns the keys of a jaw that is half open at each click, and closes again before the next.
pub(super) fn keys(seconds: u32) -> String {
    let mut text = "time,jaw_deg,easing\n".to_owned();
    let mut key = |time_s: f64, angle_deg: f64| {
        let _ = writeln!(text, "{time_s:.3},{angle_deg},ease both");
    };
    key(0.0, CLOSED_DEG);
    for time_s in times_s(seconds).map(f64::from) {
        key(time_s - HALF_S, CLOSED_DEG);
        key(time_s + HALF_S, OPEN_DEG);
        key(time_s + 0.3, OPEN_DEG);
        key(time_s + 0.6, CLOSED_DEG);
    }
    key(f64::from(seconds), CLOSED_DEG);
    text
}
