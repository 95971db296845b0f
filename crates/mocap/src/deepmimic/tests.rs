use proptest::prelude::*;

use super::*;

/// Creates rows: the root at (1, 2, 3), all joints straight except the right knee; each further row moves by 1
/// along x.
fn rows(times_s: &[f64]) -> Vec<Vec<f64>> {
    let row = |(k, &time_s): (usize, &f64)| {
        let mut row = vec![time_s, 1.0 + k as f64, 2.0, 3.0];
        for joint in &JOINTS {
            match joint.kind {
                Kind::Spherical => row.extend([-1.0, 0.0, 0.0, 0.0]),
                Kind::Revolute => row.push(if joint.name == "right_knee" { -0.5 } else { 0.0 }),
                Kind::Fixed => {}
            }
        }
        row
    };
    times_s.iter().enumerate().map(row).collect()
}

fn text(rows: &[Vec<f64>]) -> String {
    format!("{{\"Loop\": \"none\",\n\"Frames\":\n{rows:?}}}")
}

fn read_text(text: &str) -> Result<Recording, Error> {
    parse(text.as_bytes(), Path::new("folder/kick.txt"))
}

fn error_of(text: &str) -> String {
    let error = read_text(text).expect_err("an invalid file").to_string();
    error.strip_prefix("folder/kick.txt: ").expect("the file's name").to_owned()
}

fn error(change: impl Fn(&mut Vec<Vec<f64>>)) -> String {
    let mut rows = rows(&[0.033_333_3, 0.033_333_3, 0.0]);
    change(&mut rows);
    error_of(&text(&rows))
}

#[test]
fn reads_a_motion() {
    let recording = read_text(&text(&rows(&[0.033_333_3, 0.033_333, 0.0]))).unwrap();
    assert_eq!(recording.name, "kick");
    assert_eq!(recording.frame_time_s, Some(1.0 / 30.0));
    assert_eq!(recording.metres_per_unit, Some(1.0));
    assert_eq!(recording.frames.len(), 3);
    for (k, frame) in recording.frames.iter().enumerate() {
        let sample = |name| frame[recording.skeleton.find(name).unwrap()].unwrap();
        assert_eq!(sample("root").position_m, DVec3::new(1.0 + k as f64, 2.0, 3.0));
        assert!(sample("root").rotation.w.abs() > 1.0 - 1e-15);
        assert_eq!(sample("right_knee").rotation, DQuat::from_rotation_z(-0.5));
        assert_eq!(sample("left_knee").rotation, DQuat::IDENTITY);
        assert_eq!(sample("left_knee").position_m, DVec3::new(0.0, -0.421_546, 0.0));
    }
}

#[test]
fn a_quaternion_is_w_first_and_made_unit() {
    let mut rows = rows(&[0.1, 0.1]);
    // The left shoulder's quaternion is the last one, before the elbow's angle.
    rows[0][39..43].copy_from_slice(&[0.0, 0.0, 0.6, 0.0]);
    let recording = read_text(&text(&rows)).unwrap();
    let shoulder = recording.skeleton.find("left_shoulder").unwrap();
    let rotation = recording.frames[0][shoulder].unwrap().rotation;
    assert_eq!(rotation, DQuat::from_xyzw(0.0, 1.0, 0.0, 0.0));
}

#[test]
fn brings_uneven_times_to_the_shortest() {
    // Frames at 0, 0.1, 0.3 and 0.35 s, with x = 1, 2, 3 and 4.
    let recording = read_text(&text(&rows(&[0.1, 0.2, 0.05, 0.0]))).unwrap();
    assert_eq!(recording.frame_time_s, Some(0.05));
    let found: Vec<f64> =
        recording.frames.iter().map(|frame| frame[0].unwrap().position_m.x).collect();
    let expected = [1.0, 1.5, 2.0, 2.25, 2.5, 2.75, 3.0, 4.0];
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-12, "{found} {expected}");
    }
}

#[test]
fn refuses_what_is_no_humanoid3d() {
    assert_eq!(error_of(""), "EOF while parsing a value at line 1 column 0");
    assert_eq!(error_of("{\"Loop\": \"wrap\"}"), "missing field `Frames` at line 1 column 16");
    assert_eq!(
        error_of("{\"Loop\": \"often\", \"Frames\": []}"),
        "unknown variant `often`, expected `wrap` or `none` at line 1 column 16"
    );
    assert_eq!(error(|rows| rows.truncate(1)), "`Frames`: expected at least 2 rows, found 1");
    assert_eq!(
        error(|rows| rows.iter_mut().for_each(|row| row.resize(84, 0.0))),
        "`Frames`: expected rows of 44 numbers, those of a humanoid3d, found 84: the motion of another character (a \
         dog3d has 84, a laikago 19), which is not read"
    );
    assert_eq!(
        error(|rows| rows[1].truncate(43)),
        "`Frames`, frame 1: expected 44 numbers, found 43"
    );
    assert_eq!(
        error(|rows| rows[1][0] = 0.0),
        "`Frames`, frame 1: expected a time to the next frame from 0.00001 to 1 second, found 0"
    );
    assert_eq!(
        error(|rows| rows[1][0] = 0.0001),
        "`Frames`: expected times between frames that differ by 100 times at most, found 0.0001 s and \
         0.0333333 s"
    );
    assert_eq!(
        error(|rows| rows[2][16] = 0.0),
        "`Frames`, frame 2, right_hip: expected a unit quaternion (norm 0.5 to 1.5), found 0"
    );
    assert_eq!(
        error(|rows| rows[0][20] = -1e10),
        "`Frames`, frame 0, row: expected numbers of at most 1e9, found -10000000000"
    );
}

#[test]
fn a_small_file_cannot_ask_for_gigabytes() {
    let (_, poses) = motion(&rows(&[0.1, 0.1, 0.0])).unwrap();
    let limit = 100_000 / JOINTS.len();
    let problem = evenly(&[0.0, 0.01, 1e6], &poses, 0.01).unwrap_err();
    assert_eq!(problem, Problem::TooMany { frames: 100_000_001.0, frame_time_s: 0.01, limit });
}

/// Asserts that the reader returns only finite numbers and unit rotations.
fn check(read: Result<Recording, Error>) {
    let Ok(recording) = read else { return };
    assert!(recording.frame_time_s.is_some_and(|time_s| FRAME_TIME_S.contains(&time_s)));
    for sample in recording.frames.iter().flatten().flatten() {
        assert!(sample.position_m.is_finite() && sample.rotation.is_normalized());
    }
}

proptest! {
    #[test]
    fn never_panics_on_bytes(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        check(parse(&bytes, Path::new("x")));
    }

    #[test]
    fn never_panics_on_numbers(
        rows in prop::collection::vec(
            prop::collection::vec(prop_oneof![-2.0..2.0, Just(1e300), Just(1e-4)], 43..46),
            0..6,
        ),
    ) {
        check(read_text(&text(&rows)));
    }

    #[test]
    fn never_panics_on_damaged_files(
        times_s in prop::collection::vec(1e-5..1.0_f64, 2..5),
        damage in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..4),
    ) {
        let mut bytes = text(&rows(&times_s)).into_bytes();
        for (at, byte) in damage {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        check(parse(&bytes, Path::new("x")));
    }
}
