//! Damaged files are either refused or read, without a panic.

use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;
use sinew_rig::import::{Options, mjcf, urdf};

const URDF: &str = r#"<robot name="r" xmlns:x="urn:x"><link name="a"><inertial><origin xyz="0 0 1" rpy="0 1 0"/>
<mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link><link name="b"><inertial>
<mass value="2"/></inertial><collision><origin rpy="1 0 0"/><geometry><capsule radius="1" length="2"/></geometry>
</collision></link><link name="c"/><joint name="j" type="revolute"><parent link="a"/><child link="b"/>
<axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="2" velocity="3"/><dynamics damping="1" friction="2"/></joint>
<joint name="k" type="prismatic"><parent link="b"/><child link="c"/><limit lower="0" upper="1"/>
<mimic joint="j" multiplier="2" offset="1"/></joint><transmission><joint name="j"/></transmission></robot>"#;

const MJCF: &str = r#"<mujoco model="m"><compiler angle="radian" eulerseq="zYx"/><default><joint armature="1"/>
<default class="c"><geom type="box" size="1 2 3"/></default></default><worldbody><body name="a" quat="1 0 0 0">
<freejoint/><geom class="c"/><frame euler="1 2 3"><body name="b" childclass="c"><joint name="j" range="-1 1" ref="1"/>
<joint name="k" type="slide" axis="0 1 0"/><inertial pos="0 0 1" mass="1" fullinertia="1 1 1 0 0 0"/></body></frame>
<body name="d" xyaxes="1 0 0 0 1 0"><joint name="l" type="ball" range="0 1"/>
<geom type="capsule" fromto="0 0 0 1 0 0" size="1"/></body></body></worldbody>
<actuator><position joint="j" kp="1" forcerange="-1 1"/><motor joint="k" gear="2"/></actuator>
<equality><joint joint1="j" joint2="k"/><weld body1="a"/></equality></mujoco>"#;

/// Replacements for a byte or a word.
const WORDS: [&str; 18] = [
    "", "0", "-1", "1e999", "nan", "inf", "1e-320", "a", "b", "j", "k", "\"", "<", ">", "/>", "é",
    " 1 1 1", "world",
];

fn damaged(text: &str, places: &[(usize, usize, usize)]) -> String {
    let mut text: Vec<char> = text.chars().collect();
    for (place, length, word) in places {
        let from = place % (text.len() + 1);
        let to = (from + length).min(text.len());
        text.splice(from..to, WORDS[word % WORDS.len()].chars());
    }
    text.into_iter().collect()
}

/// Returns a file with some attribute values replaced.
fn with_values(text: &str, values: &[(usize, usize)]) -> String {
    let mut parts: Vec<&str> = text.split('"').collect();
    for (place, word) in values {
        let place = (place % (parts.len() / 2)) * 2 + 1;
        parts[place] = WORDS[word % WORDS.len()];
    }
    parts.join("\"")
}

fn read(text: &str) {
    let bold = Options { repair_inertia: true, open_loops: true, ..Options::default() };
    for options in [&Options::default(), &bold] {
        for imported in [urdf(text, options), mjcf(text, options)].into_iter().flatten() {
            // An accepted file is a valid rig.
            imported.description.mechanism().expect("a mechanism");
        }
    }
}

#[test]
fn the_files_are_right_before_they_are_damaged() {
    urdf(URDF, &Options::default()).expect("a rig");
    mjcf(MJCF, &Options::default()).expect("a rig");
}

/// Each case reads a file four times; failures are stored next to this file.
fn property() -> ProptestConfig {
    ProptestConfig {
        cases: 500,
        failure_persistence: Some(Box::new(FileFailurePersistence::WithSource("regressions"))),
        ..ProptestConfig::default()
    }
}

proptest! {
    #![proptest_config(property())]

    #[test]
    fn bytes(places in prop::collection::vec((any::<usize>(), 0..40_usize, any::<usize>()), 1..4)) {
        read(&damaged(URDF, &places));
        read(&damaged(MJCF, &places));
    }

    #[test]
    fn values(values in prop::collection::vec((any::<usize>(), any::<usize>()), 1..5)) {
        read(&with_values(URDF, &values));
        read(&with_values(MJCF, &values));
    }
}
