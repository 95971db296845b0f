//! A face that speaks: from a sound or a file of mouth cues to a show with a sound, which simulated servos play.

use std::path::Path;

use sinew_performance::play::{Director, Memory, Options, RigParts, SimulatedRig};
use sinew_rig::toml_file;
use sinew_servo_sim::device::MEMORY_LEN;
use sinew_show::sound::split;

use super::{done, refused};
use crate::common::path;

const VOICE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/golden/voice");

fn voice() -> String {
    path(Path::new(VOICE), "talk.wav")
}

/// Returns the envelope of the voice that `envelope.py` has computed, every 10 ms.
fn envelope() -> Vec<f64> {
    let text = std::fs::read_to_string(Path::new(VOICE).join("envelope.csv")).unwrap();
    text.lines().map(|line| line.parse().unwrap()).collect()
}

/// Returns the positions of a joint, every 10 ms, while the simulated servos of a rig play a show.
fn played(rig: &str, show: &str, joint: &str) -> Vec<f64> {
    let rig = toml_file::read(&std::fs::read_to_string(rig).unwrap()).unwrap();
    let mechanism = rig.mechanism().unwrap();
    let body = mechanism.bodies.iter().position(|link| link.joint_name == joint).unwrap();
    let place = mechanism.coordinate_ranges()[body].start;
    let parts = RigParts::new(&rig, &mechanism, Options::default()).unwrap();
    assert_eq!(parts.rate_hz, 100);
    let bytes = std::fs::read(show).unwrap();
    let (bytes, _) = split(&bytes).unwrap();
    let mut memories: Vec<Memory> = vec![[0; MEMORY_LEN]; parts.servos.len()];
    let plant = parts.plant(&rig, &mechanism).unwrap();
    let mut sim = SimulatedRig::new(&parts, Some(bytes), &mut memories, plant).unwrap();
    let (mut director, mut positions) = (Director::default(), Vec::new());
    while director.tick(&mut sim, false).is_none() {
        if sim.runs() {
            positions.push(sim.q()[place]);
        }
    }
    positions
}

/// Returns the largest correlation of two series, and the delay of the first series at which it occurs, in rows.
fn correlation(one: &[f64], other: &[f64]) -> (f64, i32) {
    let at = |lag: i32| {
        let skip = |series: &[f64], count: i32| {
            series.iter().skip(usize::try_from(count).unwrap_or(0)).copied().collect::<Vec<_>>()
        };
        let pairs: Vec<(f64, f64)> = skip(one, lag).into_iter().zip(skip(other, -lag)).collect();
        let count = pairs.len() as f64;
        let mean = |of: fn(&(f64, f64)) -> f64| pairs.iter().map(of).sum::<f64>() / count;
        let (a, b) = (mean(|pair| pair.0), mean(|pair| pair.1));
        let sum = |of: &dyn Fn(f64, f64) -> f64| {
            pairs.iter().map(|pair| of(pair.0 - a, pair.1 - b)).sum::<f64>()
        };
        sum(&|a, b| a * b) / (sum(&|a, _| a * a) * sum(&|_, b| b * b)).sqrt()
    };
    let lags = (-15..=15).map(|lag| (at(lag), lag));
    lags.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap()
}

/// The jaw of an MG90S follows a voice: its simulated position correlates with an envelope that another program has
/// computed.
#[test]
fn a_jaw_on_a_hobby_servo_follows_a_voice() {
    let folder = tempfile::tempdir().unwrap();
    let [rig, keys, show] =
        ["face.toml", "jaw.csv", "talk.show"].map(|name| path(folder.path(), name));
    done(&["rig", "new", "--face", "-o", &rig]);
    done(&["clip", "jaw", &voice(), "--rig", &rig, "--lead-ms", "50", "-o", &keys]);
    // A fit that keeps the time begins at rest: a show that begins at speed would run slowly at first.
    done(&["bake", &keys, "--rig", &rig, "--keep-time", "--tolerance-deg", "0.05", "-o", &show]);
    // The jaw opens downwards.
    let jaw: Vec<f64> = played(&rig, &show, "jaw").iter().map(|q| -q).collect();
    let (best, lag) = correlation(&jaw, &envelope());
    println!("correlation {best:.3} at a lag of {} ms", 10 * lag);
    assert!(best >= 0.95 && lag.abs() < 4, "{best} at {lag} rows");
}

#[test]
fn a_show_names_its_sound_and_boards_never_get_it() {
    let folder = tempfile::tempdir().unwrap();
    let [rig, keys, wav, show, bare] =
        ["face.toml", "jaw.csv", "talk.wav", "talk.show", "bare.show"]
            .map(|name| path(folder.path(), name));
    std::fs::copy(voice(), &wav).unwrap();
    done(&["rig", "new", "--face", "-o", &rig]);
    std::fs::write(&keys, "time,jaw_deg\n0.5,0\n1,-10\n2,0\n").unwrap();
    let bake = ["bake", &keys, "--rig", &rig, "-o"];
    done(&[&bake[..], &[&bare]].concat());
    let [table, _] = done(&[&bake[..], &[&show, "--sound", &wav]].concat());
    assert!(table.contains("sound: talk.wav, 4.91 s; the show begins at 0.50 s of it"), "{table}");
    let file = std::fs::read(&show).unwrap();
    let (bytes, sound) = split(&file).unwrap();
    let sound = sound.unwrap();
    assert_eq!(bytes, std::fs::read(&bare).unwrap());
    assert_eq!((sound.offset_us, sound.file_len), (500_000, 39_336));
    done(&["play", &show, "--rig", &rig, "--fast"]);
    let later = ["--sound", &wav, "--sound-at-s", "0.8"];
    let [table, _] = done(&[&bake[..], &[&show], &later].concat());
    assert!(table.contains("the show begins at -0.30 s of it"), "{table}");
    refused(
        &[&bake[..], &[&show, "--sound", &wav, "--sound-at-s", "-9"]].concat(),
        "is over before the show begins, at 9.50 s",
    );
    refused(&[&bake[..], &[&show, "--sound", &keys]].concat(), "expected a WAV file");
    let play = ["play", &show, "--rig", &rig, "--sound-with"];
    refused(&[&play[..], &["aplay {}", "--fast"]].concat(), "sounds need real time");
    refused(&[&play[..], &["aplay"]].concat(), "expected a command with `{}`");
    std::fs::write(&wav, std::fs::read(&wav).unwrap().split_last().unwrap().1).unwrap();
    refused(&[&play[..], &["aplay {}", "--real-time"]].concat(), "it is not the sound with which");
    std::fs::remove_file(&wav).unwrap();
    refused(&[&play[..], &["aplay {}", "--real-time"]].concat(), "talk.wav is not there");
    refused(
        &["play", &bare, "--rig", &rig, "--sound-with", "aplay {}", "--real-time"],
        "has no sound: `sinew bake --sound` adds it",
    );
}

/// Mouth cues are a layer on idle life: they move the jaw, while idle life moves lids and eyes.
#[test]
fn a_face_speaks_while_its_eyes_live_on() {
    let folder = tempfile::tempdir().unwrap();
    let [rig, cues, keys, idle, show] =
        ["face.toml", "talk.tsv", "face.csv", "idle.csv", "talk.show"]
            .map(|name| path(folder.path(), name));
    done(&["rig", "new", "--face", "-o", &rig]);
    std::fs::write(
        &cues,
        "0.00\tX\n0.30\tD\n0.60\tA\n0.72\tE\n1.10\tG\n1.25\tD\n1.80\tX\n2.50\tX\n",
    )
    .unwrap();
    let [_, told] = done(&["clip", "face", &cues, "--rig", &rig, "-o", &keys]);
    assert!(told.contains("shapes: sil, aa, PP, oh, FF"), "{told}");
    assert!(told.contains("jaw: ") && told.contains("mean absolute jerk"), "{told}");
    done(&["clip", "idle", "--rig", &rig, "--seconds", "20", "-o", &idle]);
    done(&["bake", &idle, "--layer", &keys, "--rig", &rig, "-o", &show]);
    let text = std::fs::read_to_string(&idle).unwrap();
    let lids = |row: &str| row.split(',').nth(7).unwrap().parse::<f64>().unwrap();
    let header = text.lines().next().unwrap();
    assert_eq!(header.split(',').nth(7), Some("lid_upper_left_deg"));
    let (jaw, with) = (played(&rig, &show, "jaw"), played(&rig, &show, "lid_upper_left"));
    assert!(jaw.iter().any(|q| q.to_degrees() < -8.0), "the jaw speaks");
    // The lid follows the CSV of idle life, which has 100 rows per second.
    for row in [50, 100, 200] {
        let (layer, lid) = (lids(text.lines().nth(1 + row).unwrap()), with[row].to_degrees());
        assert!((layer - lid).abs() < 5.0, "row {row}: {layer} {lid}");
    }
}

/// Files of all kinds move joints of the face of `sinew rig new --face`.
#[test]
fn faces_of_other_programs_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let [rig, keys, show] =
        ["face.toml", "face.csv", "face.show"].map(|name| path(folder.path(), name));
    done(&["rig", "new", "--face", "-o", &rig]);
    let corpus = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/fuzz/corpus/readers");
    for (file, shape) in [
        ("face/rhubarb.json", "aa"),
        ("face/rhubarb.tsv", "PP"),
        ("face/papagayo.dat", "DD"),
        ("face/live_link.csv", "EyeBlinkLeft"),
        ("shape_keys/linear.gltf", "eyeBlink_L"),
    ] {
        let file = path(Path::new(corpus), file);
        let [_, told] = done(&["clip", "face", &file, "--rig", &rig, "-o", &keys]);
        assert!(told.contains(shape) && told.contains("jaw: "), "{file}: {told}");
        done(&["bake", &keys, "--rig", &rig, "-o", &show]);
    }
    refused(&["clip", "face", &voice(), "--rig", &rig, "-o", &keys], "a sound: `sinew clip jaw`");
    refused(&["clip", "face", &rig, "--rig", &rig, "-o", &keys], "docs/face.md");
}
