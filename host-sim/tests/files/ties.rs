//! Joints that follow others, in all commands that move a rig.

use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Stdio;

use sinew_rig::Mechanism;
use sinew_rig::mechanism::JointModel;

use crate::common::{command, sinew_in, text};
use crate::field::{done, folder_with, table};

/// Checks that each row has `j2 = factor j1 + offset`.
#[track_caller]
fn assert_tied(file: &Path, factor: f64, offset: f64, tolerance: f64) {
    let (header, rows) = table(file);
    let at = |name: &str| header.iter().position(|column| column == name).expect("a column");
    let (j1, j2) = (at("j1"), at("j2"));
    assert!(rows.len() > 1);
    for (index, row) in rows.iter().enumerate() {
        let off = row[j2] - factor * row[j1] - offset;
        assert!(off.abs() <= tolerance, "row {index}: off by {off}");
    }
}

#[test]
fn followers_follow_in_export_bake_fit_and_play() {
    let folder = folder_with(&[
        "mimic_offset.urdf",
        "mimic_factor.urdf",
        "mimic_factor_driven.toml",
        "still.csv",
        "move.csv",
    ]);
    let folder = folder.path();
    for name in ["mimic_offset", "mimic_factor"] {
        let rig = format!("{name}.toml");
        done(folder, &["rig", "import", &format!("{name}.urdf"), "-o", &rig]);
        let (factor, offset) = if name == "mimic_offset" { (1.0, 0.1) } else { (0.8, 0.0) };
        for clip in ["still.csv", "move.csv"] {
            for fit in [&[][..], &["--fit"]] {
                let export =
                    ["clip", "export", clip, "--rig", &rig, "--unit", "rad", "-o", "o.csv"];
                done(folder, &[&export[..], fit].concat());
                assert_tied(&folder.join("o.csv"), factor, offset, 1e-8);
                let bake = ["bake", clip, "--rig", &rig, "--unit", "rad", "-o", "o.show"];
                done(folder, &[&bake[..], fit].concat());
                let fine = [&bake[..], &["--tolerance-deg", "0.01"], fit].concat();
                done(folder, &fine);
            }
            done(folder, &["play", clip, "--rig", &rig, "--servo", "xm430", "--unit", "rad"]);
        }
    }
    let driven = ["bake", "move.csv", "--rig", "mimic_factor_driven.toml", "--fit", "-o", "o.show"];
    done(folder, &[&driven[..], &["--unit", "rad"]].concat());
}

#[test]
fn a_follower_needs_no_column_in_tables() {
    let folder = folder_with(&["mimic_factor.toml"]);
    let folder = folder.path();
    let dynamics = |table: &str| {
        let mut child = command()
            .current_dir(folder)
            .args(["rig", "dynamics", "mimic_factor.toml"])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the command runs");
        child.stdin.take().expect("a pipe").write_all(table.as_bytes()).expect("a table");
        let output = child.wait_with_output().expect("it ends");
        assert!(output.status.success(), "{}", text(&output.stderr));
        text(&output.stdout)
    };
    let whole = dynamics("q.j1,q.j2,qd.j1,qd.j2,qdd.j1,qdd.j2\n0.5,0.4,1,0.8,2,1.6\n");
    assert_eq!(dynamics("q.j1,qd.j1,qdd.j1\n0.5,1,2\n"), whole);
    let export = ["clip", "export", "own.csv", "--rig", "mimic_factor.toml", "-o", "o.csv"];
    // The leader of a follower with a column is where that puts it.
    fs::write(folder.join("own.csv"), "time,j2_rad\n0,0.4\n0.02,0.8\n").expect("a table");
    done(folder, &export);
    assert_tied(&folder.join("o.csv"), 0.8, 0.0, 1e-8);
    let (header, rows) = table(&folder.join("o.csv"));
    let j1 = header.iter().position(|column| column == "j1").expect("a column");
    assert!((rows[1][j1] - 1.0).abs() < 1e-8);
    fs::write(folder.join("own.csv"), "time,j1_rad,j2_rad\n0,0.5,0.4\n0.02,0.5,0.1\n")
        .expect("a table");
    let said = done(folder, &export);
    assert!(
        said.contains("`j2` follows `j1`: moved there from its own positions, by 17.2"),
        "{said}"
    );
}

/// Returns a table in which all leaders of a rig go through their ranges in 2 s, at a rate of 50 Hz.
fn swung(mechanism: &Mechanism) -> String {
    let ties = mechanism.ties();
    let mut leaders: Vec<usize> = ties.each().map(|tie| tie.leader).collect();
    leaders.sort_unstable();
    leaders.dedup();
    let column = |body: &usize| {
        let link = &mechanism.bodies[*body];
        let unit = if matches!(link.joint, JointModel::Prismatic(_)) { "m" } else { "rad" };
        format!("{}_{unit}", link.joint_name)
    };
    let names: Vec<String> = leaders.iter().map(column).collect();
    let mut csv = format!("time,{}\n", names.join(","));
    for row in 0..=100 {
        let time_s = 0.02 * f64::from(row);
        write!(csv, "{time_s:.2}").expect("a string takes everything");
        for body in &leaders {
            let [least, most] =
                mechanism.bodies[*body].ranges.first().copied().unwrap_or([-1.0, 1.0]);
            let home = mechanism.bodies[*body].home[0];
            let reach = (most - home).max(home - least);
            let swing = home + reach * libm::sin(std::f64::consts::PI * time_s);
            write!(csv, ",{:.6}", swing.max(least).min(most)).expect("a string takes everything");
        }
        csv.push('\n');
    }
    csv
}

/// Exports, fits, bakes and plays a rig with ties, and compares each follower with its leader. `rig` is in the folder.
#[track_caller]
fn assert_follows(folder: &Path, rig: &str, servo: &str) {
    let description = fs::read_to_string(folder.join(rig)).expect("a rig");
    let description = sinew_rig::toml_file::read(&description).expect("a rig");
    let mechanism = description.mechanism().expect("a mechanism");
    let ties = mechanism.ties();
    assert!(ties.each().count() > 0, "{rig} has no ties");
    fs::write(folder.join("own.csv"), swung(&mechanism)).expect("a table");
    for fit in [&[][..], &["--fit"]] {
        let export = ["clip", "export", "own.csv", "--rig", rig, "--base", "stand", "-o", "o.csv"];
        done(folder, &[&export[..], fit].concat());
        let (header, rows) = table(&folder.join("o.csv"));
        let column = |body: usize| {
            let name = &mechanism.bodies[body].joint_name;
            header.iter().position(|column| column == name).expect("a column")
        };
        for tie in ties.each() {
            let (own, leader) = (column(tie.body), column(tie.leader));
            let ways: Vec<f64> = rows.iter().map(|row| row[own]).collect();
            let most = ways.iter().copied().fold(f64::MIN, f64::max);
            let least = ways.iter().copied().fold(f64::MAX, f64::min);
            let name = &mechanism.bodies[tie.body].joint_name;
            assert!(most - least > 1e-3, "{rig}: {name} moves by {}", most - least);
            for row in &rows {
                let off = row[own] - tie.factor * row[leader] - tie.offset;
                assert!(off.abs() < 1e-7, "{rig}: {name} is off by {off}");
            }
            if let Some([low, high]) = mechanism.bodies[tie.body].ranges.first() {
                assert!(least >= low - 1e-6 && most <= high + 1e-6, "{rig}: {name}");
            }
        }
    }
    let bake = ["bake", "own.csv", "--rig", rig, "--fit", "-o", "o.show"];
    let baked = sinew_in(folder, &bake);
    let said = text(&baked.stderr) + &text(&baked.stdout);
    assert!(baked.status.success() && !said.contains("EXCEEDED"), "{rig}: {said}");
    // No servo slides.
    let turns = |body: usize| matches!(mechanism.bodies[body].joint, JointModel::Revolute(_));
    let tied = ties.each().flat_map(|tie| [tie.body, tie.leader]).filter(|body| turns(*body));
    let mut servos: Vec<String> =
        tied.map(|body| format!("{}={servo}", mechanism.bodies[body].joint_name)).collect();
    servos.sort_unstable();
    servos.dedup();
    if !servos.is_empty() {
        let mut play = vec!["play", "own.csv", "--rig", rig];
        play.extend(servos.iter().flat_map(|servo| ["--servo", servo.as_str()]));
        done(folder, &play);
    }
}

/// A joint that follows another: index of its leader, factor, offset, half of its range.
pub(crate) type Follower = (usize, f64, f64, f64);

/// Returns a URDF of hinges or slides in a row, each tied to an earlier one.
pub(crate) fn urdf(kind: &str, followers: &[Follower]) -> String {
    let inertia = r#"<inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/>"#;
    let link = |index: usize| {
        format!(
            r#"<link name="l{index}"><inertial><mass value="0.02"/>{inertia}</inertial></link>"#
        )
    };
    let mut text = format!(r#"<robot name="r">{}{}"#, link(0), link(1));
    let joint = |index: usize, half: f64, mimic: &str| {
        format!(
            r#"<joint name="j{index}" type="{kind}"><parent link="l{}"/><child link="l{index}"/>
            <origin xyz="0 0 0.03"/><axis xyz="0 1 0"/>
            <limit lower="{}" upper="{half}" effort="2" velocity="3"/>{mimic}</joint>"#,
            index - 1,
            -half
        )
    };
    text += &joint(1, if kind == "prismatic" { 0.02 } else { 1.0 }, "");
    for (index, (leader, factor, offset, half)) in followers.iter().enumerate() {
        let mimic =
            format!(r#"<mimic joint="j{leader}" multiplier="{factor}" offset="{offset}"/>"#);
        text += &(link(index + 2) + &joint(index + 2, *half, &mimic));
    }
    text + "</robot>"
}

#[test]
fn ten_rigs_with_ties_follow() {
    let rigs: [(&str, &[Follower]); 10] = [
        ("revolute", &[(1, 1.0, 0.1, 2.0)]),
        ("revolute", &[(1, 0.8, 0.0, 2.0)]),
        ("revolute", &[(1, -1.0, 0.0, 2.0)]),
        ("revolute", &[(1, 3.0, -0.5, 2.0)]),
        ("revolute", &[(1, 0.02, 0.3, 1.0)]),
        // A narrow follower.
        ("revolute", &[(1, 0.5, 0.0, 0.05)]),
        // Chains, and several followers of one leader.
        ("revolute", &[(1, 0.7, 0.1, 1.5), (2, -1.3, 0.0, 1.5)]),
        (
            "revolute",
            &[(1, 0.7, 0.1, 1.5), (2, 1.6, 0.2, 0.4), (3, -0.5, 0.0, 1.5), (1, 1.1, 0.0, 2.0)],
        ),
        ("prismatic", &[(1, -1.0, 0.0, 0.02)]),
        ("prismatic", &[(1, 0.5, 0.005, 0.008), (1, 2.0, 0.0, 0.05)]),
    ];
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folder = folder.path();
    for (index, (kind, followers)) in rigs.into_iter().enumerate() {
        fs::write(folder.join("r.urdf"), urdf(kind, followers)).expect("a robot");
        let rig = format!("r{index}.toml");
        done(folder, &["rig", "import", "r.urdf", "-o", &rig]);
        assert_follows(folder, &rig, "xm430");
    }
}

#[test]
fn slides_follow_hinges_and_hinges_follow_slides() {
    let model = |equality: &str| {
        let body = |name: &str, joint: &str| {
            format!(
                r#"<body name="{name}" pos="0.05 0 0"><joint {joint}/><geom size="0.01" mass="0.05"/></body>"#
            )
        };
        let turn = body("b", r#"name="turn" axis="0 1 0" range="-60 60""#);
        let ways: String = ["left", "right"]
            .map(|name| body(name, &format!(r#"name="{name}" type="slide" range="-0.03 0.03""#)))
            .concat();
        format!(
            r#"<mujoco model="m"><worldbody><body name="a"><geom size="0.02" mass="1"/>{turn}{ways}</body></worldbody>
            <equality>{equality}</equality></mujoco>"#
        )
    };
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folder = folder.path();
    for (index, equality) in [
        // The gripper has a pinion between two racks.
        r#"<joint joint1="left" joint2="turn" polycoef="0 0.02 0 0 0"/>
           <joint joint1="right" joint2="turn" polycoef="0.002 -0.02 0 0 0"/>"#,
        // A slide turns a lever, which moves another slide.
        r#"<joint joint1="turn" joint2="left" polycoef="0.1 30 0 0 0"/>
           <joint joint1="right" joint2="turn" polycoef="0 0.01 0 0 0"/>"#,
    ]
    .into_iter()
    .enumerate()
    {
        fs::write(folder.join("r.xml"), model(equality)).expect("a robot");
        let rig = format!("m{index}.toml");
        done(folder, &["rig", "import", "r.xml", "-o", &rig]);
        assert_follows(folder, &rig, "xm430");
    }
}

#[test]
fn the_leader_is_cut_to_what_its_followers_can() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folder = folder.path();
    let narrow = urdf("revolute", &[(1, 0.5, 0.0, 0.05), (2, 2.0, 0.0, 0.04)]);
    fs::write(folder.join("r.urdf"), narrow).expect("a robot");
    let said = done(folder, &["rig", "import", "r.urdf", "-o", "r.toml"]);
    // j3 = 2 j2 = j1.
    assert!(said.contains("j1 to -2.29 .. 2.29 deg by j2"), "{said}");
    assert!(said.contains("j2 to -1.15 .. 1.15 deg by j3"), "{said}");
}

#[test]
#[ignore = "needs SINEW_DATA"]
fn humanoids_and_grippers_with_ties_follow() {
    let data = std::env::var_os("SINEW_DATA").expect("SINEW_DATA names the folder of the data");
    let files = PathBuf::from(data).join("field/files");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folder = folder.path();
    for (name, servo) in [
        // Pepper's hands give 0.144 N m, less than the friction of a larger servo.
        ("pepper", "xl330"),
        ("g1_29dof_rev_1_0_with_inspire_hand_FTP", "xm430"),
        ("robotiq2F85", "xm430"),
    ] {
        let urdf = files.join(format!("{name}.urdf"));
        let (urdf, rig) = (urdf.to_str().expect("UTF-8"), format!("{name}.toml"));
        done(folder, &["rig", "import", urdf, "--repair-inertia", "-o", &rig]);
        assert_follows(folder, &rig, servo);
    }
}
