//! Tests of the sound that the console's page plays with a show.

use crate::common::sinew_in;
use crate::console::{Served, arm, wait_for_state, wait_until};
use crate::page::with_url;

/// Returns the duration of the show, s: that of the variable `SINEW_SOUND_S`, otherwise 20.
fn duration_s() -> u32 {
    std::env::var("SINEW_SOUND_S").ok().and_then(|text| text.parse().ok()).unwrap_or(20)
}

/// Returns a WAV file with a tone, 8 bits at 8 kHz.
fn wav(seconds: u32) -> Vec<u8> {
    let length = 8000 * seconds;
    let mut bytes = Vec::new();
    bytes.extend(b"RIFF");
    bytes.extend((36 + length).to_le_bytes());
    bytes.extend(b"WAVEfmt ");
    bytes.extend(16_u32.to_le_bytes());
    bytes.extend([1_u16, 1].map(u16::to_le_bytes).concat());
    bytes.extend([8000_u32, 8000].map(u32::to_le_bytes).concat());
    bytes.extend([1_u16, 8].map(u16::to_le_bytes).concat());
    bytes.extend(b"data");
    bytes.extend(length.to_le_bytes());
    bytes.extend((0..length).map(|at| if (at / 20) % 2 == 0 { 100 } else { 156 }));
    bytes
}

/// The sound follows the board's time in the show: it starts within 40 ms of the show's start, drifts by less than 20
/// ms, and stops together with the show.
#[test]
#[ignore = "needs SINEW_CHROMIUM"]
fn the_sound_keeps_the_time_of_the_board() {
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| {
        assert!(sinew_in(folder.path(), arguments).status.success(), "{arguments:?}");
    };
    let seconds = duration_s();
    std::fs::write(folder.path().join("tone.wav"), wav(seconds)).unwrap();
    run(&["rig", "new", "--arm", "6", "--output", "arm.toml"]);
    let keys = format!("time,turn1_deg\n0,0\n{},8\n{seconds},0\n", seconds / 2);
    std::fs::write(folder.path().join("turn.csv"), keys).unwrap();
    run(&["bake", "turn.csv", "--rig", "arm.toml", "--sound", "tone.wav", "-o", "turn.show"]);
    let [rig, show] = ["arm.toml", "turn.show"].map(|name| folder.path().join(name));
    let console =
        Served::start(&["--rig", &rig.display().to_string(), &show.display().to_string()]);
    let origin = console.origin().to_owned();
    with_url(
        &console.address,
        |request| request.starts_with(&origin),
        |page| {
            wait_for_state(page, "limp");
            arm(page);
            let plays =
                |yes: bool| format!("document.getElementById('sound').dataset.plays === '{yes}'");
            page.hold("#play", 50);
            wait_until(page, &plays(true));
            for _ in 3..seconds {
                page.wait_ms(1000);
            }
            let number = |key: &str| {
                let text = page.ask(&format!("document.getElementById('sound').dataset.{key}"));
                text.as_str().unwrap().parse::<f64>().unwrap()
            };
            let [start, most] = ["start", "most"].map(number);
            println!("{seconds} s: start {:.1} ms, drift {:.1} ms", 1e3 * start, 1e3 * most);
            assert!(start.abs() < 0.04 && most < 0.02, "{start} s, {most} s");
            wait_for_state(page, "holding");
            wait_until(page, &plays(false));
            // A hold stops the sound, too.
            page.hold("#play", 50);
            wait_until(page, &plays(true));
            page.press("Escape");
            wait_until(page, &plays(false));
        },
    );
}
