//! Fits that keep the time: their duration, limits, and remaining motion, compared with fits that slow down.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use sinew_mocap::files::ClipFile;
use sinew_performance::rig::LoadedRig;
use sinew_performance::{
    ClipSettings, JointLeft, MotionChoices, PreparedClip, RigPerformance, ShowChoices,
    ShowPlayback, retarget_clip,
};
use sinew_retarget::feasibility::{Performance as _, RigMotion, check};
use sinew_rig::new::arm;
use sinew_rig::{Description, Mechanism};

use crate::stillness::robots::{OP3, POPPY, robot};

/// Rate at which a baked show is checked, Hz: twice the rate of the fit's own check.
const CHECK_HZ: f64 = 2000.0;
/// Way and correlation above which the headline need not name a joint.
const LEAST_WAY: f64 = 0.5;
const LEAST_ALIKE: f64 = 0.9;
const CLIPS: [&str; 20] = [
    "walk/07_01",
    "walk/08_01",
    "walk/16_15",
    "walk/35_01",
    "walk/02_01",
    "walk/07_08",
    "walk/49_01",
    "run/09_01",
    "run/35_17",
    "run/02_03",
    "run/49_04",
    "run/09_06",
    "fight/02_05",
    "fight/10_01",
    "fight/11_01",
    "fight/135_04",
    "fight/135_06",
    "fight/14_01",
    "fight/88_06",
    "fight/kick_m21",
];
/// Maximum duration of the part of a clip that is fitted, s.
const LONGEST_S: f64 = 10.0;

/// Results of both fits of a clip on a rig.
struct Row {
    rig: &'static str,
    clip: String,
    kept: Result<Outcome, String>,
    slowed: Result<Outcome, String>,
}

struct Outcome {
    given_s: f64,
    duration_s: f64,
    /// Way of all joints as a share of the given way.
    way: f64,
    /// Mean correlation of all joints that move in the given motion.
    alike: f64,
    headline: String,
    left: Vec<JointLeft>,
}

fn loaded(description: Description, mechanism: Mechanism) -> LoadedRig {
    LoadedRig { description, mechanism, world: None, notes: Vec::new(), doubts: Vec::new() }
}

/// Fits and bakes a clip. Checks the duration, and checks the baked show against all limits.
fn outcome(rig: &LoadedRig, clip: &PreparedClip, keep_time: bool) -> Result<Outcome, String> {
    let mechanism = &rig.mechanism;
    let retargeted = retarget_clip(mechanism, clip, None, false).unwrap();
    let choices = MotionChoices { fit: true, keep_time, ..MotionChoices::default() };
    let name = &clip.clip.name;
    let performance = RigPerformance::new(rig, name, clip.start_s, retargeted, choices);
    let mut performance = performance.map_err(|error| format!("{error:#}"))?;
    let (baked, _) = performance
        .bake(mechanism, &ShowChoices::default())
        .map_err(|error| format!("{error:#}"))?;
    let show = ShowPlayback::new(&baked.written.bytes).unwrap();
    let report = check(mechanism, &performance.limits, &show, CHECK_HZ).unwrap();
    assert_eq!(report.excesses, [], "{name} on {}", rig.description.name);
    let given = &performance.clip.motion;
    if keep_time {
        let sample_s = given.dt_s.max(0.01);
        let off_s = (show.duration_s() - given.duration_s()).abs();
        assert!(off_s <= sample_s, "{name} on {}: {off_s} s", rig.description.name);
    }
    let left = performance.left(mechanism);
    let headline = performance.headline(mechanism).unwrap_or_default();
    let ways = |motion: &RigMotion| {
        let step = |pair: &[Vec<f64>]| -> f64 {
            pair[0].iter().zip(&pair[1]).map(|(from, to)| (to - from).abs()).sum()
        };
        motion.rows.windows(2).map(step).sum::<f64>()
    };
    let alike = left.iter().map(|joint| joint.alike).sum::<f64>() / left.len().max(1) as f64;
    let way = (ways(performance.motion()) / ways(given)).min(1.0);
    let (given_s, duration_s) = (given.duration_s(), show.duration_s());
    Ok(Outcome { given_s, duration_s, way, alike, headline, left })
}

impl Row {
    fn of((name, rig): (&'static str, &LoadedRig), clip: &Path) -> Self {
        let mut clip = PreparedClip::read(&ClipFile::new(clip), ClipSettings::default()).unwrap();
        clip.cut(LONGEST_S);
        let (kept, slowed) =
            rayon::join(|| outcome(rig, &clip, true), || outcome(rig, &clip, false));
        Self { rig: name, clip: clip.clip.name.clone(), kept, slowed }
    }

    /// Checks that each joint keeps over half of its way and correlates with the given motion, or is named in the
    /// headline.
    fn check(&self) {
        let kept = self.kept.as_ref().expect("each of these motions is possible in its time");
        for joint in &kept.left {
            let is_well = joint.way > LEAST_WAY && joint.alike >= LEAST_ALIKE;
            let is_named = kept.headline.contains(&format!("{} (", joint.name));
            assert!(
                is_well || is_named,
                "{} on {}: {joint:?}, {}",
                self.clip,
                self.rig,
                kept.headline
            );
        }
    }

    fn line(&self) -> String {
        let percent =
            |outcome: &Outcome| format!("{:.0} % | {:.2}", 100.0 * outcome.way, outcome.alike);
        let kept = match &self.kept {
            Ok(kept) => {
                let far = kept.left.iter().filter(|joint| joint.is_far()).count();
                format!("{} | {far} of {}", percent(kept), kept.left.len())
            }
            Err(_) => "refused | |".to_owned(),
        };
        let slowed = match &self.slowed {
            Ok(slowed) => format!("{:.2} | {}", slowed.duration_s, percent(slowed)),
            Err(_) => "refused | |".to_owned(),
        };
        let given = [&self.kept, &self.slowed].into_iter().find_map(|done| done.as_ref().ok());
        let given_s = given.map_or(0.0, |done| done.given_s);
        format!("| {} | {} | {given_s:.2} | {kept} | {slowed} |", self.rig, self.clip)
    }
}

#[test]
fn fits_keep_the_time_of_built_in_clips() {
    let description = arm(6).unwrap();
    let mechanism = description.mechanism().unwrap();
    let rig = loaded(description, mechanism);
    let rows: Vec<Row> = ["kicks_01", "punches_01"]
        .par_iter()
        .map(|clip| Row::of(("starter arm", &rig), Path::new(clip)))
        .collect();
    for row in &rows {
        println!("{}", row.line());
        row.check();
        assert!(row.kept.is_ok(), "{}", row.kept.as_ref().err().unwrap());
    }
}

/// Computes the table of [docs/keep-time.md](../../../docs/keep-time.md). `INSTA_UPDATE=always` writes the table.
#[test]
#[ignore = "needs SINEW_DATA"]
fn robots_keep_the_time_of_twenty_clips() {
    let data: PathBuf = std::env::var_os("SINEW_DATA").expect("SINEW_DATA").into();
    let of = |rig: crate::stillness::run::Rig| loaded(rig.description, rig.mechanism);
    let description = arm(6).unwrap();
    let mechanism = description.mechanism().unwrap();
    let rigs = [
        ("OP3, XM430", of(robot(OP3, None, &["xm430"]))),
        ("Poppy, MX-64", of(robot(POPPY, Some("l_knee_y"), &["mx-64"]))),
        ("starter arm", loaded(description, mechanism)),
    ];
    let cases: Vec<_> =
        rigs.iter().flat_map(|rig| CLIPS.iter().map(move |clip| (rig, *clip))).collect();
    let rows: Vec<Row> = cases
        .par_iter()
        .map(|((name, rig), clip)| {
            let clip = data.join("cmu").join(format!("{clip}.bvh"));
            Row::of((*name, rig), &clip)
        })
        .collect();
    let mut table = String::from(
        "| rig | clip | s | way left | correlation | named | slowed: s | way left | correlation |\n\
         | --- | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n",
    );
    for row in &rows {
        let _ = writeln!(table, "{}", row.line());
    }
    println!("{table}");
    rows.iter().for_each(Row::check);
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/keep-time.md");
    let text = std::fs::read_to_string(&page).unwrap();
    let (head, rest) = text.split_once("<!-- table -->\n\n").expect("the table's place");
    let (old, tail) = rest.split_once("\n<!-- end -->").expect("the table's end");
    if std::env::var("INSTA_UPDATE").is_ok_and(|update| update == "always") {
        let new = format!("{head}<!-- table -->\n\n{table}\n<!-- end -->{tail}");
        std::fs::write(&page, new).unwrap();
    } else {
        assert_eq!(old, table, "docs/keep-time.md: INSTA_UPDATE=always writes the table");
    }
}
