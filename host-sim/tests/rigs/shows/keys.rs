//! Keys, a jaw from a sound, and idle life: from a file to a show.

use sinew_show::Show;

use super::{done, refused};
use crate::common::path;

#[test]
fn uneven_keys_become_a_show_that_keeps_their_times() {
    let folder = tempfile::tempdir().unwrap();
    let [rig, keys, show] =
        ["face.toml", "talk.csv", "talk.show"].map(|name| path(folder.path(), name));
    done(&["rig", "new", "--face", "-o", &rig]);
    std::fs::write(
        &keys,
        "jaw_deg;time;eye_turn_left_deg;easing\n0;0;0;both\n-17;0,43;;both\n-4;1,1;10;both\n0;2,5;0;\n",
    )
    .unwrap();
    let [table, told] = done(&["bake", &keys, "--rig", &rig, "-o", &show]);
    assert!(told.contains("4 rows of keys, 2.50 s") && !told.contains("JUMP"), "{told}");
    assert!(table.contains("talk on face, 2.50 s"), "{table}");
    let bytes = std::fs::read(&show).unwrap();
    assert!((Show::open(&bytes).unwrap().duration_s() - 2.5).abs() < 0.02);
    // A key that comes too early.
    std::fs::write(&keys, "time,jaw_deg\n0,0\n1,-3\n1.01,-17\n2,0\n").unwrap();
    let [_, told] = done(&["bake", &keys, "--rig", &rig, "-o", &show]);
    assert!(told.contains("JUMP: talk: line 4: jaw moves by 14.0000 deg in 0.010 s"), "{told}");
    // A header without a unit is refused with both repairs, and taken with the second.
    std::fs::write(&keys, "time,jaw\n0,0\n1,-10\n2,0\n").unwrap();
    let bake = ["bake", &keys, "--rig", &rig, "-o", &show];
    refused(&bake, "`jaw_deg` or `jaw_rad`, or give `--unit deg` or `--unit rad`");
    done(&[&bake[..], &["--unit", "deg"]].concat());
    refused(
        &["bake", "punches_01", "--rig", &rig, "--unit", "deg", "-o", &show],
        "--unit: is of CSV files",
    );
}

/// `bake` and `export` read the degrees that `clip export` writes.
#[test]
fn an_exported_table_is_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let [rig, table, again, show] =
        ["arm.toml", "kick.csv", "again.csv", "kick.show"].map(|name| path(folder.path(), name));
    done(&["rig", "new", "--arm", "3", "-o", &rig]);
    done(&["clip", "export", "kicks_01", "--rig", &rig, "--rate-hz", "50", "-o", &table]);
    let text = std::fs::read_to_string(&table).unwrap();
    let header = text.lines().next().unwrap();
    assert!(header.starts_with("time,") && header.split(',').skip(1).all(|x| x.ends_with("_deg")));
    done(&["clip", "export", &table, "--rig", &rig, "-o", &again]);
    assert_eq!(text.lines().next(), std::fs::read_to_string(&again).unwrap().lines().next());
    let [_, told] = done(&["bake", &table, "--rig", &rig, "-o", &show]);
    assert!(!told.contains("rows of keys"), "{told}");
}

#[test]
fn layers_are_put_on_a_motion() {
    let folder = tempfile::tempdir().unwrap();
    let [rig, idle, talk, show, again] =
        ["face.toml", "idle.csv", "talk.csv", "idle.show", "again.show"]
            .map(|name| path(folder.path(), name));
    done(&["rig", "new", "--face", "-o", &rig]);
    done(&["clip", "idle", "--rig", &rig, "--seconds", "60", "-o", &idle]);
    done(&["bake", &idle, "--rig", &rig, "--loop", "-o", &show]);
    std::fs::write(&talk, "time,jaw_deg\n5,0\n5.5,-15\n6,-3\n90,0\n").unwrap();
    let bake = ["bake", "--rig", &rig, "--layer", &show, "--layer", &talk, "--fit", "--keep-time"];
    let [table, told] = done(&[&bake[..], &["-o", &again]].concat());
    assert!(told.contains("weight 1, 5.00 to 90.00 s: jaw"), "{told}");
    assert!(table.contains("idle on face, 90.00 s"), "{table}");
    let bake = ["bake", &idle, "--rig", &rig, "-o", &again];
    refused(
        &[&bake[..], &["--layer", "talk.bvh"]].concat(),
        "--layer talk.bvh: talk.bvh: expected",
    );
    refused(&[&bake[..], &["--layer", &format!("{talk}:over:3")]].concat(), "expected 0 to 1");
    refused(&["bake", "--rig", &rig, "--layer", &format!("{talk}:add"), "-o", &again], "no mode");
}

#[test]
fn idle_life_is_a_loop_within_all_limits() {
    let folder = tempfile::tempdir().unwrap();
    let [rig, idle, show] =
        ["face.toml", "idle.csv", "idle.show"].map(|name| path(folder.path(), name));
    done(&["rig", "new", "--face", "-o", &rig]);
    let make = ["clip", "idle", "--rig", &rig, "-o", &idle];
    let [_, told] = done(&[&make[..], &["--seconds", "60", "--seed", "5"]].concat());
    for part in ["blinking: lid_upper_left", "glances to the side: eye_turn_left", "at home: jaw"] {
        assert!(told.contains(part), "{told}");
    }
    let [table, _] = done(&["bake", &idle, "--rig", &rig, "--loop", "-o", &show]);
    assert!(table.contains("60.00 s") && table.contains("No limit is exceeded"), "{table}");
    refused(&[&make[..], &["--use", "blink=tail"]].concat(), "no joint `tail`");
    refused(&[&make[..], &["--use", "dance=jaw"]].concat(), "eye-turn");
}

#[test]
fn a_jaw_follows_a_sound() {
    let folder = tempfile::tempdir().unwrap();
    let [rig, sound, jaw, show] =
        ["face.toml", "talk.wav", "jaw.csv", "talk.show"].map(|name| path(folder.path(), name));
    done(&["rig", "new", "--face", "-o", &rig]);
    std::fs::write(&sound, wav(8000, 3)).unwrap();
    let [_, told] = done(&["clip", "jaw", &sound, "--rig", &rig, "-o", &jaw]);
    assert!(told.contains("3.00 s, 8000 Hz, 1 channel(s); jaw: -0.3 deg closed, -20.0"), "{told}");
    let [table, told] =
        done(&["bake", &jaw, "--rig", &rig, "--tolerance-deg", "0.05", "-o", &show]);
    assert!(!told.contains("JUMP") && table.contains("No limit is exceeded"), "{told}{table}");
    refused(&["clip", "jaw", &rig, "-o", &jaw], "expected a WAV file");
    refused(&["clip", "jaw", &sound, "--gate-db", "3", "-o", &jaw], "dB from -80 to -1");
    refused(&["clip", "jaw", &sound, "--rig", &rig, "--joint", "mouth", "-o", &jaw], "neck_turn");
}

/// Writes a WAV file of 16 bits: a square wave of 100 Hz, loud and soft in turn for a third of a second.
fn wav(rate_hz: u32, seconds: u32) -> Vec<u8> {
    let sample = |index: u32| -> i16 {
        let loud = if (3 * index / rate_hz).is_multiple_of(2) { 9000 } else { 20 };
        if (200 * index / rate_hz).is_multiple_of(2) { loud } else { -loud }
    };
    let length = 2 * rate_hz * seconds;
    let mut bytes = Vec::new();
    bytes.extend(b"RIFF");
    bytes.extend((36 + length).to_le_bytes());
    bytes.extend(b"WAVEfmt ");
    bytes.extend(16_u32.to_le_bytes());
    for number in [1_u16, 1] {
        bytes.extend(number.to_le_bytes());
    }
    bytes.extend(rate_hz.to_le_bytes());
    bytes.extend((2 * rate_hz).to_le_bytes());
    for number in [2_u16, 16] {
        bytes.extend(number.to_le_bytes());
    }
    bytes.extend(b"data");
    bytes.extend(length.to_le_bytes());
    bytes.extend((0..rate_hz * seconds).flat_map(|index| sample(index).to_le_bytes()));
    bytes
}
