//! Compares `docs/retargeting.md` with the scores that `cargo xtask retargeting` has written, and these with their
//! bounds.

use std::collections::BTreeMap;

const SCORES: &str = include_str!("../../../../docs/retargeting.csv");
const PAGE: &str = include_str!("../../../../docs/retargeting.md");

const ROBOTS: [&str; 3] = ["G1", "Hi", "ToddlerBot"];
const CLIPS: [&str; 3] = ["07_01", "02_01", "02_05"];

/// Rows of the page's tables: a quantity, its name in the scores, and its number of decimals. `None`: the page has a
/// mean (two decimals) and a maximum (one decimal). The script in the reference folder has already rounded the scores
/// to these decimals, so the formatting here changes no value.
const ROWS: [(&str, &str, Option<usize>); 8] = [
    ("limbs, deg", "limb_dir_deg_world", None),
    ("hand, cm", "hand_pos_cm", None),
    ("foot, cm", "foot_pos_cm", None),
    ("sliding, cm/s", "foot_slide_cm_s", None),
    ("height spread, cm", "foot_height_spread_cm", Some(2)),
    ("frames at a limit, %", "frames_at_a_limit_%", Some(1)),
    ("fastest joint, rad/s", "max_speed_rad_s", Some(2)),
    ("largest jerk, rad/s³", "max_jerk_rad_s3", Some(0)),
];

/// Numbers by name, for each robot, clip and author of the motion.
type Scores = BTreeMap<[String; 3], BTreeMap<String, f64>>;

fn scores() -> Scores {
    let mut lines = SCORES.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let head = lines.next().expect("a head");
    let number = |(name, cell): (&&str, &&str)| Some(((*name).to_owned(), cell.parse().ok()?));
    lines
        .map(|cells| {
            assert_eq!(cells.len(), head.len(), "{cells:?}");
            let numbers = head.iter().zip(&cells).skip(3).filter_map(number).collect();
            ([0, 1, 2].map(|k| cells[k].to_owned()), numbers)
        })
        .collect()
}

fn of<'a>(scores: &'a Scores, robot: &str, clip: &str, by: &str) -> &'a BTreeMap<String, f64> {
    &scores[&[robot, clip, by].map(str::to_owned)]
}

#[track_caller]
fn is_on_page(line: &str) {
    assert!(PAGE.lines().any(|other| other == line), "docs/retargeting.md has not: {line}");
}

#[test]
fn the_tables_are_the_scores() {
    let scores = scores();
    assert_eq!(scores.len(), ROBOTS.len() * CLIPS.len() * 2);
    for robot in ROBOTS {
        let head = CLIPS.map(|clip| format!(" {clip}: GMR | Sinew |"));
        is_on_page(&format!("| {robot} |{}", head.concat()));
        for (what, name, digits) in ROWS {
            let cell = |clip, by| {
                let numbers = of(&scores, robot, clip, by);
                if let Some(digits) = digits {
                    return format!(" {:.digits$} |", numbers[name]);
                }
                let [mean, max] = ["mean", "max"].map(|end| numbers[&format!("{name} {end}")]);
                format!(" {mean:.2} / {max:.1} |")
            };
            let cells = CLIPS.map(|clip| ["GMR", "Sinew"].map(|by| cell(clip, by)).concat());
            is_on_page(&format!("| {what} |{}", cells.concat()));
        }
    }
}

/// Lists every score in which our result is larger, and therefore worse, than GMR's.
#[test]
fn where_it_is_not_better_is_told() {
    let scores = scores();
    let mut told = 0;
    for (robot, clip) in ROBOTS.iter().flat_map(|robot| CLIPS.map(|clip| (robot, clip))) {
        let [gmr, ours] = ["GMR", "Sinew"].map(|by| of(&scores, robot, clip, by));
        for (name, theirs) in gmr.iter().filter(|(name, theirs)| ours[*name] > **theirs) {
            let (what, ..) = ROWS.iter().find(|(_, row, _)| name.starts_with(row)).unwrap();
            is_on_page(&format!("| {robot} | {clip} | {what} | {theirs} | {} |", ours[name]));
            told += 1;
        }
    }
    // The page lists no other rows.
    let is_told = |line: &&str| {
        let of_clip = |robot: &&str| CLIPS.map(|clip| format!("| {robot} | {clip} | "));
        ROBOTS.iter().flat_map(of_clip).any(|start| line.starts_with(&start))
    };
    assert_eq!(PAGE.lines().filter(is_told).count(), told);
}

/// Checks that all scores keep the bounds that define "better than GMR". The bounds are those of the reference folder,
/// which also contains the robots, GMR's results and the script.
#[test]
fn bounds_are_kept_in_every_cell() {
    let scores = scores();
    let mut other_start_deg = 0.0;
    for (robot, clip) in ROBOTS.iter().flat_map(|robot| CLIPS.map(|clip| (robot, clip))) {
        let [gmr, ours] = ["GMR", "Sinew"].map(|by| of(&scores, robot, clip, by));
        for (name, most) in [
            ("limb_dir_deg_world mean", 2.5),
            ("limb_dir_deg_world max", 8.0),
            ("hand_pos_cm mean", 3.0),
            ("foot_pos_cm mean", 3.0),
            ("foot_slide_cm_s mean", 1.0),
            ("worst_over_limit_deg", 0.0),
            // The joints of these robots have no speed limit: the mapping's default applies.
            ("max_speed_rad_s", 12.0),
            ("other_start_deg", 1.0),
        ] {
            assert!(ours[name] <= most, "{robot}, {clip}: {name} is {} of {most}", ours[name]);
        }
        for name in ["foot_slide_cm_s mean", "foot_slide_cm_s max"] {
            assert!(ours[name] < gmr[name], "{robot}, {clip}: {name} is {}", ours[name]);
        }
        other_start_deg = f64::max(other_start_deg, ours["other_start_deg"]);
    }
    // The sentence may be wrapped anywhere.
    let page = PAGE.split_whitespace().collect::<Vec<_>>().join(" ");
    let told = format!("by at most {other_start_deg:.2} degrees from 0.5 s on");
    assert!(page.contains(&told), "docs/retargeting.md has not: {told}");
}
