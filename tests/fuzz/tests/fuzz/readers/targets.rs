//! Every reader of files as a fuzz target: it accepts any bytes, and its result must be valid.

use std::fs;
use std::path::Path;

use sinew_evaluation::Setup;
use sinew_evaluation::sweep::{Journal, Plan, Shard, SweepFile};
use sinew_figure::measured::{Measured, UnitOverrides};
use sinew_figure::{Mapping, Subject};
use sinew_life::face::{FaceTrack, Weights};
use sinew_mocap::{Recording, asf_amc, bvh, deepmimic};
use sinew_pose_metrics::character::{self, Options};
use sinew_pose_metrics::weights::radii;
use sinew_retarget::exchange::{HeaderUnits, keys};
use sinew_rig::import::{self, Options as ImportOptions};
use sinew_rig::toml_file;
use sinew_show::sound;
use sinew_verification::verify_folder;

/// A target: its name, which is also the name of its folder in the corpus, and its function.
pub(crate) type Target = (&'static str, fn(&[u8]));

pub(crate) const TARGETS: [Target; 23] = [
    ("bvh", |bytes| motion(bvh::parse(bytes, Path::new("a.bvh")).ok())),
    ("asf", |bytes| {
        motion(asf_amc::parse((bytes, Path::new("a.asf")), (AMC, Path::new("a.amc"))).ok());
    }),
    ("amc", |bytes| {
        motion(asf_amc::parse((ASF, Path::new("a.asf")), (bytes, Path::new("a.amc"))).ok());
    }),
    ("deepmimic", |bytes| motion(deepmimic::parse(bytes, Path::new("a.txt")).ok())),
    ("geno", |bytes| character("a.bin", bytes)),
    ("gltf", |bytes| character("a.gltf", bytes)),
    ("glb", |bytes| character("a.glb", bytes)),
    ("urdf_character", |bytes| character("a.urdf", bytes)),
    ("urdf", |bytes| {
        rig(text(bytes).and_then(|text| {
            Some(import::urdf(text, &ImportOptions::default()).ok()?.description)
        }));
    }),
    ("mjcf", |bytes| {
        rig(text(bytes).and_then(|text| {
            Some(import::mjcf(text, &ImportOptions::default()).ok()?.description)
        }));
    }),
    ("rig_toml", |bytes| rig(text(bytes).and_then(|text| toml_file::read(text).ok()))),
    ("figure_mapping", |bytes| drop(text(bytes).map(Mapping::parse))),
    ("rig_mapping", |bytes| drop(text(bytes).map(sinew_retarget::mapping::Mapping::read))),
    ("subject", |bytes| in_file("a.toml", bytes, |file| drop(Subject::read(file)))),
    ("setup", |bytes| drop(text(bytes).map(Setup::parse))),
    ("sweep", |bytes| {
        drop(text(bytes).map(|text| SweepFile::parse(text.to_owned(), Path::new("a.toml"), None)));
    }),
    ("tables", |bytes| {
        in_file("a.csv", bytes, |file| drop(radii::read(file)));
    }),
    ("golden", |bytes| {
        in_file("a.json", bytes, |file| drop(verify_folder(file.parent().unwrap(), &[])));
    }),
    ("journal", journal),
    ("keys", keys),
    ("face", face),
    ("shape_keys", |bytes| {
        in_file("a.gltf", bytes, |file| {
            let Ok(keys) = character::shape_keys(file) else { return };
            let rows = Weights { names: keys.names, times_s: keys.times_s, rows: keys.rows };
            perform(&rows.checked().unwrap());
        });
    }),
    ("show_sound", |bytes| {
        let Ok((show, Some(sound))) = sound::split(bytes) else { return };
        let mut again = show.to_vec();
        sound.append_to(&mut again);
        assert_eq!(sound::split(&again), Ok((show, Some(sound))));
    }),
];

/// A skeleton of two bones, for motions from fuzzing.
const ASF: &[u8] = include_bytes!("../../../corpus/readers/asf/two_bones.asf");
const AMC: &[u8] = include_bytes!("../../../corpus/readers/amc/two_bones.amc");

/// Reads keys for the face of `rig new`, and checks that their motion fits this rig.
fn keys(bytes: &[u8]) {
    let Some(text) = text(bytes) else { return };
    let mechanism = sinew_rig::new::face().mechanism().unwrap();
    for units in [None, Some(HeaderUnits::Degrees), Some(HeaderUnits::Si)] {
        if let Ok(read) = keys::read(&mechanism, text, units) {
            read.motion.check(&mechanism).unwrap();
            assert!(read.start_s.is_finite() && read.motion.duration_s().is_finite());
        }
    }
}

fn text(bytes: &[u8]) -> Option<&str> {
    core::str::from_utf8(bytes).ok()
}

/// Reads a face file, and moves the joints of the face of `rig new` by it.
fn face(bytes: &[u8]) {
    let rig = sinew_rig::new::face();
    let weights = match sinew_life::face::read(bytes, None) {
        Ok(FaceTrack::Weights(weights)) => weights,
        Ok(FaceTrack::Cues(cues, end_s)) => {
            let names: Vec<&str> =
                rig.face_shapes.iter().map(|shape| shape.name.as_str()).collect();
            let Ok(weights) = Weights::of_cues(&cues, end_s.min(60.0), &names) else { return };
            weights
        }
        Err(_) => return,
    };
    perform(&weights);
}

/// Computes the motion of the face, and checks that all joints stay within their ranges.
fn perform(weights: &Weights) {
    let rig = sinew_rig::new::face();
    let mechanism = rig.mechanism().unwrap();
    let begin = weights.times_s[0];
    // One minute suffices.
    let rows = weights.times_s.partition_point(|time_s| *time_s < begin + 60.0);
    if rows < 2 {
        return;
    }
    let weights = Weights {
        names: weights.names.clone(),
        times_s: weights.times_s[..rows].to_vec(),
        rows: weights.rows[..rows].to_vec(),
    };
    let Ok(motion) = sinew_life::face::perform(&mechanism, &rig.face_shapes, &weights) else {
        return;
    };
    for (column, joint) in motion.joints.iter().enumerate() {
        let link = mechanism.bodies.iter().find(|link| link.joint_name == joint.name).unwrap();
        let [least, most] = link.ranges[0];
        assert!(motion.rows.iter().all(|row| (least..=most).contains(&row[column])), "{joint:?}");
        assert!(joint.correlation.is_finite() && joint.jerk.is_finite(), "{joint:?}");
    }
}

/// Checks a motion: it has a sample or a gap for each joint, all its numbers are finite, and it can be measured.
fn motion(recording: Option<Recording>) {
    let Some(recording) = recording else { return };
    let joints = recording.skeleton.joints.len();
    for frame in &recording.frames {
        assert_eq!(frame.len(), joints);
        for sample in frame.iter().flatten() {
            assert!(sample.rotation.is_finite() && sample.position_m.is_finite());
        }
    }
    let matched = sinew_retarget::skeleton::SkeletonMatch::of_recording(&recording);
    let measured = Measured::new(&recording, &matched, None, UnitOverrides::default());
    if let Ok(recording) = measured.apply(recording) {
        assert_eq!(recording.skeleton.joints.len(), joints);
    }
}

fn character(name: &str, bytes: &[u8]) {
    in_file(name, bytes, |file| {
        let Ok(character) = character::read(file, &Options::default()) else { return };
        assert!(character.joints().iter().all(|joint| joint.position_m.is_finite()));
    });
}

fn rig(description: Option<sinew_rig::Description>) {
    let Some(description) = description else { return };
    if let Ok(mechanism) = description.mechanism() {
        assert!(mechanism.poses(&mechanism.home()).iter().all(|pose| pose.position_m.is_finite()));
    }
}

/// Opens a journal of these bytes, and a journal with these bytes after a valid first line. Rows that were accepted
/// must be accepted again when the journal is reopened.
fn journal(bytes: &[u8]) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("journal.jsonl");
    let plan = plan();
    drop(Journal::open(folder.path(), &plan).unwrap());
    let head = fs::read(&file).unwrap();
    for before in [&b""[..], &head] {
        fs::write(&file, [before, bytes].concat()).unwrap();
        let Ok((journal, _)) = Journal::open(folder.path(), &plan) else { continue };
        let taken_up = |journal: &Journal| plan.units().map(|unit| journal.has(unit)).collect();
        let first: Vec<bool> = taken_up(&journal);
        drop(journal);
        assert_eq!(first, taken_up(&Journal::open(folder.path(), &plan).unwrap().0));
    }
}

/// Returns a plan of two cells on one clip.
pub(crate) fn plan() -> Plan {
    let text = "[[grid]]\ncontroller.kp = [1, 2]\n".to_owned();
    let file = SweepFile::parse(text, Path::new("a.toml"), None).unwrap();
    let clips = r#"[{"name": "kick", "dt_s": 0.01, "sha256": "0123456789abcdef"}]"#;
    Plan {
        text: file.text,
        cells: file.cells,
        clips: serde_json::from_str(clips).unwrap(),
        seconds: None,
        shard: Shard::WHOLE,
    }
}

/// Calls a reader with a file in a folder of its own.
fn in_file(name: &str, bytes: &[u8], read: impl FnOnce(&Path)) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join(name);
    fs::write(&file, bytes).unwrap();
    read(&file);
}
