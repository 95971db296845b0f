//! Checks every mocap file of `SINEW_DATA` against the index that is delivered with it.

use std::path::PathBuf;

use glam::{DQuat, DVec3, EulerRot};
use sinew_figure::mapping::{self, Binding};
use sinew_figure::pipeline::{Notice, Settings, load_paths, prepare, tpose};
use sinew_figure::{BODIES, BODY_COUNT, FigureMotion};
use sinew_mocap::deepmimic::skeleton;
use sinew_mocap::flips::Flips;
use sinew_mocap::gaps::FilledGaps;
use sinew_mocap::{Clip, Recording, bvh, gaps};

/// A line of an `index.csv`.
struct Entry {
    file: PathBuf,
    frames: usize,
    rate_hz: f64,
    skeleton: String,
    t_pose: bool,
    metres_per_unit: f64,
    height_m: f64,
}

fn data() -> PathBuf {
    std::env::var_os("SINEW_DATA").expect("SINEW_DATA names the folder of the mocap data").into()
}

fn index(folder: &str) -> Vec<Entry> {
    let folder = data().join(folder);
    let mut reader = csv::Reader::from_path(folder.join("index.csv")).expect("an index");
    let headers = reader.headers().expect("a header").clone();
    let entry = |record: csv::StringRecord| {
        let field = |name: &str| {
            let column = headers.iter().position(|header| header == name).expect("a column");
            record[column].to_owned()
        };
        let number = |name: &str| field(name).parse::<f64>().expect("a number");
        Entry {
            file: folder.join(field("file")),
            frames: field("frames").parse().expect("a number"),
            rate_hz: number("fps"),
            skeleton: field("skeleton").replace('-', "_"),
            t_pose: field("tpose_first_frame") == "1",
            metres_per_unit: number("metres_per_unit"),
            height_m: number("height_m"),
        }
    };
    reader.records().map(|record| entry(record.expect("a record"))).collect()
}

fn entries() -> Vec<Entry> {
    let entries: Vec<Entry> = ["cmu", "bandai"].into_iter().flat_map(index).collect();
    assert_eq!(entries.len(), 816);
    entries
}

/// Reads the file and binds the mapping for its skeleton.
fn read(entry: &Entry) -> (Recording, &'static str, Binding) {
    let motion = bvh::read(&entry.file).expect("a BVH motion");
    let mapping = mapping::choose(&motion.skeleton).expect("a known skeleton");
    assert!(
        (mapping.metres_per_unit - entry.metres_per_unit).abs() < 1e-9,
        "{}",
        entry.file.display()
    );
    let clip = motion.in_metres(mapping.metres_per_unit);
    let binding = Binding::new(mapping, &clip.skeleton).expect("all joints of the mapping");
    (clip, &mapping.name, binding)
}

/// Returns the recording in metres, at its own rate or, if it states none, at the rate of its mapping. It must have no
/// gaps.
fn gapless(recording: Recording) -> (Clip, FilledGaps) {
    let mapping = mapping::choose(&recording.skeleton).expect("a known skeleton");
    let frame_time_s = mapping.frame_time_s(&recording, false).expect("a rate");
    gaps::fill(recording.in_metres(mapping.metres_per_unit), frame_time_s, 0.0).expect("no gaps")
}

/// Returns the height from the lowest to the highest joint or end site in frame 0, m.
fn height_m(clip: &Clip) -> f64 {
    let world = clip.world_poses(0);
    let heights_m = clip.skeleton.joints.iter().zip(&world).flat_map(|(joint, pose)| {
        let ends = joint.end_sites_m.iter().map(|end| pose.position_m + pose.rotation * *end);
        ends.chain([pose.position_m]).map(|point| point.y)
    });
    let (low, high) = heights_m
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), y| (low.min(y), high.max(y)));
    high - low
}

#[test]
#[ignore = "needs SINEW_DATA"]
fn every_file_reads_as_its_index_says() {
    for entry in entries() {
        let (clip, mapping, binding) = read(&entry);
        let name = entry.file.display();
        // The index lists two trials as cgspeed-mb although their joints have the names of ASF files.
        assert_eq!(mapping.trim_end_matches("_asf"), entry.skeleton, "{name}");
        assert_eq!(clip.frames.len(), entry.frames, "{name}");
        assert_eq!(
            tpose::is_inserted(&clip, |body| binding.joint_of(body)),
            entry.t_pose,
            "{name}"
        );
        let (clip, filled) = gapless(clip);
        // The index has the rounded rates of the files: 59.999 for 60 Hz.
        assert!((clip.rate_hz() / entry.rate_hz - 1.0).abs() < 1e-4, "{name}: {}", clip.rate_hz());
        assert_eq!(filled.gaps, [], "{name}");
        // If the T-pose was cut off a cgspeed file, the index still has the T-pose's height.
        if entry.t_pose || !entry.skeleton.starts_with("cgspeed") {
            let height_m = height_m(&clip);
            // The index rounds heights to 1 mm and the scale to 1e-6.
            assert!((height_m - entry.height_m).abs() < 1e-3, "{name}: {height_m} m");
        }
    }
}

#[test]
#[ignore = "needs SINEW_DATA"]
fn the_figure_stands_where_the_recording_does() {
    let legs = 12..BODY_COUNT;
    for entry in entries() {
        let (clip, mapping, binding) = read(&entry);
        let clip = gapless(clip).0;
        let worst_m = binding.worst_distance_m(&clip, &binding.map(&clip));
        // Only asfamc merges a joint and its bone (Spine1, 0.125 m) into a body that has children: up to 20 degrees
        // of bending there move neck and arms by at most 41 mm.
        let limit_m = if mapping == "asfamc" { 0.042 } else { 1e-4 };
        for (i, worst_m) in worst_m.into_iter().enumerate() {
            let limit_m = if legs.contains(&i) { 1e-4 } else { limit_m };
            assert!(worst_m < limit_m, "{:?} {}: {worst_m} m", entry.file, BODIES[i].name);
        }
    }
}

/// Returns the vector from the origin of each body to the end of its segment in a frame, in the world, m.
fn world_segments(motion: &FigureMotion, frame: usize) -> Vec<DVec3> {
    let mut world = motion.rotation[frame].clone();
    for (i, body) in BODIES.iter().enumerate() {
        if let Some(parent) = body.parent {
            world[i] = world[parent] * world[i];
        }
    }
    world.iter().zip(&motion.segment_end_m).map(|(turn, end_m)| *turn * *end_m).collect()
}

#[test]
#[ignore = "needs SINEW_DATA"]
fn walkers_face_their_way_with_the_left_on_the_left() {
    let settings = Settings::default();
    for folder in ["cmu/walk", "bandai/walk"] {
        let clips = load_paths(&[data().join(folder)], &settings).expect("clips");
        assert!(clips.len() >= 10);
        for clip in clips {
            let name = clip.name.clone();
            let t_pose_or_none = clip.skeleton.find("LHipJoint").is_none();
            let (motion, notices) = prepare(clip, &settings).expect("a motion");
            assert_eq!(notices.contains(&Notice::TPoseSkipped), !t_pose_or_none, "{name}");
            let (mut sideways, mut way, mut lowest) = (0.0, 0.0, f64::INFINITY);
            let (mut toes, mut crown) = (0.0, 0.0);
            for f in 1..motion.rotation.len() {
                let at = motion.world_positions_m(f);
                let step = (at[0] - motion.root_position_m[f - 1]).with_y(0.0);
                // Hips and shoulders, from right to left, compared with the left of the walking direction.
                for (left, right) in [(12, 15), (5, 9)] {
                    sideways += (at[left] - at[right]).dot(DVec3::Y.cross(step));
                }
                way += step.length();
                let ends = world_segments(&motion, f);
                toes += (ends[14] + ends[17]).dot(step);
                crown += ends[3].y * step.length();
                lowest = f64::min(lowest, at[14].y.min(at[17].y));
            }
            // Sum of the widths of hips and shoulders. Bandai's figure has the smallest, 0.33 m.
            let breadth_m = sideways / way;
            assert!((0.3..0.65).contains(&breadth_m), "{name}: {breadth_m} m");
            // The toes of both feet point forward (Bandai's mostly down) and the crown of the head up.
            let (toes_m, crown_m) = (toes / way, crown / way);
            assert!((0.05..0.4).contains(&toes_m), "{name}: {toes_m} m");
            assert!((0.2..0.35).contains(&crown_m), "{name}: {crown_m} m");
            // The height of the lower ankle: 4 to 12 cm above the floor, whose height is known to 4 cm.
            assert!((0.0..0.12).contains(&lowest), "{name}: {lowest} m");
        }
    }
}

#[test]
#[ignore = "needs SINEW_DATA"]
fn every_file_becomes_a_figure_of_human_proportions() {
    let settings = Settings::default();
    for entry in entries() {
        let (clip, _, _) = read(&entry);
        let name = entry.file.display();
        let (motion, notices) = prepare(clip, &settings).expect("a motion");
        assert_eq!(notices.contains(&Notice::TPoseSkipped), entry.t_pose, "{name}");
        let low_rate = notices.iter().any(|notice| matches!(notice, Notice::NotFiltered { .. }));
        assert_eq!(low_rate, entry.rate_hz < 12.5, "{name}");
        check_proportions(&motion);
    }
}

fn check_proportions(motion: &FigureMotion) {
    // Adult segments in metres. The shortest are the forearms of CMU's subject 05, and the feet of m21 and Bandai,
    // which end at the toes' joint.
    let bounds_m = [
        ("upper_arm", 0.22..0.34),
        ("forearm", 0.13..0.28),
        ("hand", 0.10..0.22),
        ("thigh", 0.35..0.50),
        ("shank", 0.35..0.50),
        ("foot", 0.11..0.25),
    ];
    for (limb, bounds_m) in bounds_m {
        let [left_m, right_m] = ["l", "r"].map(|side| {
            let name = format!("{limb}_{side}");
            let body = BODIES.iter().position(|body| body.name == name).expect("a body");
            motion.segment_end_m[body].length()
        });
        let name = &motion.name;
        assert!(bounds_m.contains(&left_m), "{name}: {limb} {left_m} m");
        assert!((left_m / right_m - 1.0).abs() < 0.15, "{name}: {limb} {left_m} m {right_m} m");
    }
}

#[test]
#[ignore = "needs SINEW_DATA"]
fn geno_stands_in_his_bind_pose() {
    let settings = Settings { lead_in_s: 0.0, ..Settings::default() };
    for file in ["Geno_bind.bvh", "Geno_stance.bvh"] {
        let clip = load_paths(&[data().join("geno").join(file)], &settings).expect("a clip");
        let clip = clip.into_iter().next().expect("a clip");
        assert_eq!((clip.frames.len(), clip.skeleton.joints.len()), (2, 75));
        let full = gapless(clip.clone()).0;
        // 1.65 m from toe to HeadEnd, according to the source of the data.
        assert!((height_m(&full) - 1.65).abs() < 0.01, "{file}: {} m", height_m(&full));
        let (motion, notices) = prepare(clip, &settings).expect("a motion");
        assert!(matches!(notices[..], [Notice::Measured(_)]), "{file}: {notices:?}");
        assert_eq!(motion.rotation.len(), 2);
        check_proportions(&motion);
    }
}

/// Returns the name in the mapping `cmu_asf` of a joint of `asfamc`.
fn asf_name(joint: &str) -> String {
    let parts: [(&str, &[(&str, &str)]); 2] = [
        (
            "",
            &[
                ("Hips", "root"),
                ("LHipJoint", "lhipjoint"),
                ("RHipJoint", "rhipjoint"),
                ("LowerBack", "lowerback"),
                ("Spine", "upperback"),
                ("Spine1", "thorax"),
                ("Neck", "lowerneck"),
                ("Neck1", "upperneck"),
                ("Head", "head"),
                ("LThumb", "lthumb"),
                ("RThumb", "rthumb"),
            ],
        ),
        (
            "side",
            &[
                ("UpLeg", "femur"),
                ("Leg", "tibia"),
                ("Foot", "foot"),
                ("ToeBase", "toes"),
                ("Shoulder", "clavicle"),
                ("Arm", "humerus"),
                ("ForeArm", "radius"),
                ("Hand", "wrist"),
                ("FingerBase", "hand"),
                ("HandIndex1", "fingers"),
            ],
        ),
    ];
    let find = |names: &[(&str, &str)], name: &str| {
        names.iter().find(|(bvh, _)| *bvh == name).map(|(_, asf)| (*asf).to_owned())
    };
    find(parts[0].1, joint).unwrap_or_else(|| {
        let (side, part) = joint.strip_prefix("Left").map_or_else(
            || ("r", joint.strip_prefix("Right").expect("a side")),
            |part| ("l", part),
        );
        format!("{side}{}", find(parts[1].1, part).expect("a joint"))
    })
}

/// Returns the rotation by the angles about x, y and z in degrees, about fixed axes in the order of `sequence`.
fn about_fixed_axes(angles_deg: [f64; 3], sequence: [usize; 3]) -> DQuat {
    sequence.iter().fold(DQuat::IDENTITY, |rotation, &axis| {
        DQuat::from_axis_angle(DVec3::AXES[axis], angles_deg[axis].to_radians()) * rotation
    })
}

/// Writes the motion in the format of CMU's originals: an ASF and an AMC. Every bone has axes of its own.
///
/// This function follows only the definition of the formats, and uses no code of the reader.
fn as_asf_and_amc(clip: &Clip, units_per_metre: f64) -> (String, String) {
    use std::fmt::Write as _;
    const SEQUENCES: [(&str, [usize; 3]); 3] =
        [("XYZ", [0, 1, 2]), ("ZYX", [2, 1, 0]), ("YZX", [1, 2, 0])];
    let joints = &clip.skeleton.joints;
    // Any axes will do; every bone has different ones.
    let axes = |j: usize| {
        let k = j as f64;
        ([37.0 * k % 180.0, 53.0 * k % 90.0, 71.0 * k % 180.0], SEQUENCES[j % 3])
    };
    let mut bones = String::new();
    for (j, joint) in joints.iter().enumerate().skip(1) {
        // A bone ends at the start of its first child.
        let child = joints.iter().find(|other| other.parent == Some(j));
        let end_m = child.map_or_else(|| joint.end_sites_m[0], |child| child.offset_m);
        let direction = end_m.normalize_or_zero();
        let ([x, y, z], (sequence, _)) = axes(j);
        let _ = write!(
            bones,
            "  begin\r\n     id {j}\r\n     name {}\r\n     direction {:.12} {:.12} {:.12}\r\n     length \
             {:.12}\r\n     axis {x} {y} {z}  {sequence}\r\n    dof rx ry rz\r\n    limits (-180.0 180.0)\r\n           \
             (-180.0 180.0)\r\n           (-180.0 180.0)\r\n  end\r\n",
            asf_name(&joint.name),
            direction.x,
            direction.y,
            direction.z,
            end_m.length() * units_per_metre,
        );
    }
    let mut hierarchy = String::new();
    for (j, joint) in joints.iter().enumerate() {
        let children: Vec<String> = joints
            .iter()
            .filter(|other| other.parent == Some(j))
            .map(|other| asf_name(&other.name))
            .collect();
        if !children.is_empty() {
            let _ = write!(hierarchy, "    {} {}\r\n", asf_name(&joint.name), children.join(" "));
        }
    }
    let asf = format!(
        "# written for a test\r\n:version 1.10\r\n:name VICON\r\n:units\r\n  mass 1.0\r\n  length 0.45\r\n  angle \
         deg\r\n:root\r\n   order TX TY TZ RX RY RZ\r\n   axis XYZ\r\n   position 0 0 0\r\n   orientation 0 0 \
         0\r\n:bonedata\r\n{bones}:hierarchy\r\n  begin\r\n{hierarchy}  end\r\n"
    );
    let mut amc = "#!OML:ASF 135.ASF\r\n:FULLY-SPECIFIED\r\n:DEGREES\r\n".to_owned();
    for (f, frame) in clip.frames.iter().enumerate() {
        let _ = write!(amc, "{}\r\n", f + 1);
        for (j, (joint, sample)) in joints.iter().zip(frame).enumerate() {
            let _ = write!(amc, "{}", asf_name(&joint.name));
            let turn = if joint.parent.is_none() {
                let at = sample.position_m * units_per_metre;
                let _ = write!(amc, " {:.9} {:.9} {:.9}", at.x, at.y, at.z);
                sample.rotation
            } else {
                let (angles, (_, sequence)) = axes(j);
                let axes = about_fixed_axes(angles, sequence);
                axes.inverse() * sample.rotation * axes
            };
            // About fixed axes, rx first: rz is last, so outermost.
            let (z, y, x) = turn.to_euler(EulerRot::ZYX);
            let [x, y, z] = [x, y, z].map(f64::to_degrees);
            let _ = write!(amc, " {x:.9} {y:.9} {z:.9}\r\n");
        }
    }
    (asf, amc)
}

#[test]
#[ignore = "needs SINEW_DATA"]
fn the_same_motion_as_bvh_and_as_asf_and_amc_is_the_same() {
    let settings = Settings::default();
    let bvh = data().join("cmu/fight/135_06.bvh");
    let clip = load_paths(&[bvh], &settings).expect("a clip").remove(0);
    let mut full = gapless(clip).0;
    full.frames.truncate(600);
    let (asf, amc) = as_asf_and_amc(&full, 0.45 / 0.0254);

    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("135.asf"), asf).expect("written");
    std::fs::write(folder.path().join("135_06.amc"), amc).expect("written");
    let read = load_paths(&[folder.path().to_path_buf()], &settings).expect("a clip").remove(0);
    assert_eq!((read.name.as_str(), read.frames.len()), ("135_06", 600));
    let (_, notices) = prepare(read.clone(), &settings).expect("a motion");
    assert_eq!(
        notices[1].to_string(),
        "taken as 120 Hz, the mapping's `rate_hz`: the recording does not state its rate"
    );
    let read = gapless(read).0;
    assert!((read.rate_hz() - 120.0).abs() < 1e-9);
    // Nine decimals of a degree and of a unit of 56 mm; a chain of ten joints 2 m long.
    let bound_m = 10.0 * (0.5e-9_f64.to_radians() * 2.0 + 1e-9 * 0.056);
    for frame in 0..600 {
        let (expected, found) = (full.world_poses(frame), read.world_poses(frame));
        for (j, joint) in full.skeleton.joints.iter().enumerate() {
            let name = asf_name(&joint.name);
            let found = found[read.skeleton.find(&name).expect("the bone")];
            let distance_m = found.position_m.distance(expected[j].position_m);
            assert!(distance_m < bound_m, "frame {frame}, {name}: {distance_m} m");
        }
    }

    // The figures by the mappings `asfamc` and `cmu_asf` must be equal, too.
    let figures = [&full, &read].map(|clip| {
        let mapping = mapping::choose(&clip.skeleton).expect("a known skeleton");
        Binding::new(mapping, &clip.skeleton).expect("all joints").map(clip)
    });
    for frame in 0..600 {
        let [expected, found] = [&figures[0], &figures[1]].map(|f| f.world_positions_m(frame));
        for (i, body) in BODIES.iter().enumerate() {
            let distance_m = found[i].distance(expected[i]);
            assert!(distance_m < bound_m, "frame {frame}, {}: {distance_m} m", body.name);
        }
    }
    for (found, expected) in figures[1].segment_end_m.iter().zip(&figures[0].segment_end_m) {
        assert!(found.distance(*expected) < bound_m, "{found} {expected}");
    }
}

#[test]
#[ignore = "needs SINEW_DATA"]
fn the_humanoid_has_the_joints_of_its_urdf() {
    let text = std::fs::read_to_string(data().join("deepmimic/humanoid.urdf")).expect("a URDF");
    // Enough of an XML reader for this file: returns the value of the first `key` after `from`.
    let value = |from: usize, key: &str| {
        let text = &text[from + text[from..].find(key).expect("the key")..];
        text.split('"').nth(1).expect("a quoted value").to_owned()
    };
    let at = |element: &str, name: &str| {
        text.find(&format!("<{element} name=\"{name}\"")).expect("an element of the name")
    };
    for joint in &skeleton::JOINTS[1..] {
        let from = at("joint", joint.name);
        let parent = &skeleton::JOINTS[joint.parent.expect("not the root")];
        assert_eq!(value(from, "parent"), parent.name, "{}", joint.name);
        let kind = match joint.kind {
            skeleton::Kind::Spherical => "spherical",
            skeleton::Kind::Revolute => "revolute",
            skeleton::Kind::Fixed => "fixed",
        };
        assert_eq!(value(from, "type"), kind, "{}", joint.name);
        let numbers: Vec<f64> = value(from, "xyz")
            .split_whitespace()
            .map(|number| number.parse().expect("a number"))
            .collect();
        let offset_m = DVec3::from_slice(&numbers) / 4.0;
        assert!(offset_m.distance(joint.offset_m) < 1e-9, "{}: {offset_m}", joint.name);
    }
}

#[test]
#[ignore = "needs SINEW_DATA"]
fn every_humanoid3d_becomes_a_figure() {
    let settings = Settings::default();
    let clips = load_paths(&[data().join("deepmimic")], &settings).expect("clips");
    assert_eq!(clips.len(), 15);
    for clip in clips {
        let name = clip.name.clone();
        let (motion, _) = prepare(clip, &settings).expect("a motion");
        let at = motion.world_positions_m(0);
        // In frame 0 all stand on the floor, except for two that lie and one that crawls.
        let low_m = at.iter().map(|at| at.y).fold(f64::INFINITY, f64::min);
        let high_m = at.iter().map(|at| at.y).fold(f64::NEG_INFINITY, f64::max);
        let stands = !["getup", "crawl"].iter().any(|what| name.contains(what));
        assert!((-0.05..0.2).contains(&low_m), "{name}: lowest joint at {low_m} m");
        assert_eq!((1.0..1.6).contains(&high_m), stands, "{name}: highest joint at {high_m} m");
        if name.ends_with("walk") || name.ends_with("run") {
            // The forward direction is x, and the left is at negative z.
            let last = motion.world_positions_m(motion.rotation.len() - 1);
            assert!((last[0] - at[0]).x > 0.5, "{name}");
            assert!(at[12].z < at[15].z && at[5].z < at[9].z, "{name}");
        }
    }
}

#[test]
#[ignore = "needs SINEW_DATA"]
fn flips_are_found_where_they_are_and_nowhere_else() {
    let settings = Settings::default();
    let flips_of = |files: &[&str]| -> Vec<(String, Option<Flips>)> {
        let paths: Vec<PathBuf> = files.iter().map(|file| data().join(file)).collect();
        let clips = load_paths(&paths, &settings).expect("clips");
        let flips = |clip: Recording| {
            let (motion, notices) = prepare(clip, &settings).expect("a motion");
            let flips = notices.into_iter().find_map(|notice| match notice {
                Notice::JointFlips(flips) => Some(flips),
                _ => None,
            });
            (motion.name, flips)
        };
        clips.into_iter().map(flips).collect()
    };
    // Left arm and left hand flip in the same frame, near gimbal lock: the source of the data reports the arm's 7,300
    // deg/s. The right hand flips 5 frames later.
    let (_, flips) = flips_of(&["cmu/fight/135_06.bvh"]).remove(0);
    let flips = flips.expect("flips").0;
    let expected =
        [("LeftHand", 1798, 9461.0), ("LeftArm", 1798, 7354.0), ("RightHand", 1803, 6850.5)];
    assert_eq!(flips.len(), expected.len(), "{flips:?}");
    for (flip, (joint, frame, peak_deg_s)) in flips.iter().zip(expected) {
        assert_eq!((flip.joint.as_str(), flip.frame), (joint, frame));
        assert!((flip.peak_rad_s.to_degrees() - peak_deg_s).abs() < 1.0, "{flip:?}");
    }
    assert!((flips[1].time_s - 1798.0 / 120.0).abs() < 1e-9);

    let clean =
        ["02_05", "10_01", "11_01", "135_03", "135_04", "135_05", "135_07", "135_10", "kick_m21"]
            .map(|name| format!("cmu/fight/{name}.bvh"));
    let mut files: Vec<&str> = clean.iter().map(String::as_str).collect();
    files.extend(["bandai/fight", "bandai/walk", "bandai/run", "deepmimic"]);
    for (name, flips) in flips_of(&files) {
        assert_eq!(flips, None, "{name}");
    }
}
