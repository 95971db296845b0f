//! Compares the proposals of `sinew clip map` for recorded files with the included maps, on the page
//! `docs/mappings.md`. `INSTA_UPDATE=always` with this test accepts a change.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use sinew_mocap::skeleton_map::{BodyJoints, End};
use sinew_mocap::{Recording, SkeletonMap, format};
use sinew_retarget::skeleton::{FigureMapping, MapHead, SkeletonMatch, figure_mapping};

const PAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/mappings.md");

const FOLDERS: [&str; 12] = [
    "cmu/fight",
    "cmu/walk",
    "cmu/run",
    "cmu/broad-12hz",
    "bandai/fight",
    "bandai/run",
    "bandai/walk",
    "bandai/broad-12hz",
    "deepmimic",
    "geno",
    "foreign/bvh",
    "foreign/amc/zump",
];

/// Bodies in the order of the figure.
const BODIES: [&str; 18] = [
    "pelvis",
    "abdomen",
    "thorax",
    "head",
    "clavicle_l",
    "upper_arm_l",
    "forearm_l",
    "hand_l",
    "clavicle_r",
    "upper_arm_r",
    "forearm_r",
    "hand_r",
    "thigh_l",
    "shank_l",
    "foot_l",
    "thigh_r",
    "shank_r",
    "foot_r",
];

const HEAD: &str = "\
# Skeletons and their maps

`sinew evaluate`, `find`, `blend` and `bake` put a recorded skeleton on a figure of 18 bodies. A map says which joint
is which body. You rarely write one:

- **A known skeleton** is found by its joints' names, behind any prefix: `mixamorig7:Hips` is Mixamo's `Hips`.
  `sinew clip map --list` names them, `--mapping NAME` takes one by its name.
- **Another human's** is proposed by names, tree, lengths and directions of bones, and used with a note that says what
  is least sure. `sinew clip map CLIP` prints the proposal with reasons, as a file to edit for `--mapping FILE`.
- **What is no human, or cannot be told**, is refused with the reason. `find` and `blend` take it without a map.

All mistakes of a map are told at once.

This page is printed by a test of `sinew-retarget` (`mappings_page.rs`) from the files named here; it compares each
proposal with the map that was written by hand.
";

struct Shipped {
    about: String,
    map: SkeletonMap,
}

/// A file whose skeleton has an included map.
struct Compared {
    file: String,
    /// For each body: the entry of the map, and the proposal if it differs.
    bodies: Vec<(String, Option<String>)>,
    /// Whether all bodies begin at the correct joints and rotate with them; their ends may differ.
    has_joints: bool,
}

/// The proposal for a file, or the reason why there is none.
type Proposal = Result<(FigureMapping, SkeletonMatch), String>;

fn data() -> PathBuf {
    std::env::var_os("SINEW_DATA").expect("SINEW_DATA is set").into()
}

fn shipped() -> Vec<Shipped> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../figure/mappings");
    let mut files = sorted(Path::new(folder));
    files.retain(|file| file.extension().is_some_and(|extension| extension == "toml"));
    let read = |file: PathBuf| {
        let text = std::fs::read_to_string(&file).expect("a map");
        let about = text.lines().next().expect("a line").trim_start_matches("# ").to_owned();
        Shipped { about, map: toml::from_str(&text).expect("a map") }
    };
    files.into_iter().map(read).collect()
}

fn sorted(folder: &Path) -> Vec<PathBuf> {
    let entries =
        std::fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.expect("an entry").path()).collect();
    files.sort();
    files
}

/// Returns the map with the most specific signature among those that match the skeleton.
fn known<'a>(maps: &'a [Shipped], recording: &Recording) -> Option<&'a Shipped> {
    let asks = |shipped: &&Shipped| {
        let signature = &shipped.map.signature;
        signature.joints.len() + signature.zero_offsets.len() + signature.nonzero_offsets.len()
    };
    let bears = |shipped: &&Shipped| shipped.map.signature.matches(&recording.skeleton);
    maps.iter().filter(bears).max_by_key(asks)
}

fn proposal(recording: &Recording) -> Proposal {
    let matched = SkeletonMatch::of_recording(recording);
    let head = MapHead { name: "proposal", metres_per_unit: 1.0, rate_hz: None };
    let mapping = figure_mapping(&recording.skeleton, &matched, head);
    mapping.map(|mapping| (mapping, matched)).map_err(|error| error.to_string())
}

/// Describes a part in a few words, without the common prefix of the names.
fn words(part: &BodyJoints, prefix: &str) -> String {
    let bare = |name: &str| name.strip_prefix(prefix).unwrap_or(name).to_owned();
    let (origin, rotation) = (bare(&part.origin), bare(&part.rotation));
    let turned = if origin == rotation { String::new() } else { format!(" turned by {rotation}") };
    let end = match &part.end {
        End::Joint(end) => bare(end),
        End::Site { site } => format!("end of {}", bare(site)),
        End::Beyond { beyond, ratio } => format!("{ratio:.2} beyond {}", bare(beyond)),
    };
    format!("{origin}{turned} to {end}")
}

fn has_joints(ours: &BodyJoints, right: &BodyJoints, prefix: &str) -> bool {
    let same = |a: &str, b: &str| a == format!("{prefix}{b}");
    same(&ours.origin, &right.origin) && same(&ours.rotation, &right.rotation)
}

/// Returns whether two parts are equal. Ends that are not in the file are estimates, and their lengths may differ.
fn is_same(ours: &BodyJoints, right: &BodyJoints, prefix: &str) -> bool {
    let same = |a: &str, b: &str| a == format!("{prefix}{b}");
    let ends = match (&ours.end, &right.end) {
        (End::Joint(a), End::Joint(b)) | (End::Site { site: a }, End::Site { site: b }) => {
            same(a, b)
        }
        (End::Beyond { beyond: a, .. }, End::Beyond { beyond: b, .. }) => same(a, b),
        _ => false,
    };
    has_joints(ours, right, prefix) && ends
}

fn compared(file: String, map: &SkeletonMap, recording: &Recording) -> Compared {
    let prefix = map.signature.prefix(&recording.skeleton).expect("the map is this skeleton's");
    let proposal = proposal(recording);
    let of = |body: &&str| {
        let right = &map.bodies[*body];
        let ours = match &proposal {
            Ok((proposed, _)) => {
                let ours = &proposed.map.bodies[*body];
                (!is_same(ours, right, prefix)).then(|| words(ours, prefix))
            }
            Err(_) => Some("nothing".to_owned()),
        };
        (words(right, ""), ours)
    };
    let has_joints = proposal.as_ref().is_ok_and(|(proposed, _)| {
        let all = BODIES.iter().map(|body| (&proposed.map.bodies[*body], &map.bodies[*body]));
        all.into_iter().all(|(ours, right)| has_joints(ours, right, prefix))
    });
    Compared { file, bodies: BODIES.iter().map(of).collect(), has_joints }
}

#[test]
#[ignore = "needs SINEW_DATA"]
fn the_page_is_what_the_files_say() {
    let maps = shipped();
    let mut known_files: BTreeMap<String, Vec<Compared>> = BTreeMap::new();
    let mut others = Vec::new();
    for folder in FOLDERS {
        for path in sorted(&data().join(folder)) {
            let Ok(recording) = format::read(&path) else { continue };
            let file =
                format!("{folder}/{}", path.file_name().unwrap_or_default().to_string_lossy());
            match known(&maps, &recording) {
                Some(shipped) => {
                    let compared = compared(file, &shipped.map, &recording);
                    known_files.entry(shipped.map.name.clone()).or_default().push(compared);
                }
                None => others.push((file, proposal(&recording))),
            }
        }
    }
    let mut page = HEAD.to_owned();
    summary(&mut page, &maps, &known_files);
    unknown(&mut page, &others);
    for (name, files) in &known_files {
        details(&mut page, name, files);
    }
    if std::env::var("INSTA_UPDATE").is_ok_and(|update| update == "always") {
        std::fs::write(PAGE, &page).expect(PAGE);
    }
    let committed = std::fs::read_to_string(PAGE).unwrap_or_default();
    assert!(
        page == committed,
        "docs/mappings.md is another: INSTA_UPDATE=always accepts it\n{page}"
    );
}

fn summary(page: &mut String, maps: &[Shipped], known_files: &BTreeMap<String, Vec<Compared>>) {
    page.push_str(
        "\n## Known skeletons\n\n| name | what it is | files | joints right | ends too |\n",
    );
    page.push_str("| --- | --- | ---: | ---: | ---: |\n");
    for Shipped { about, map } in maps {
        let files = known_files.get(&map.name).map_or(&[][..], Vec::as_slice);
        let right = files.iter().filter(|file| file.has_joints).count();
        let same = files.iter().filter(|file| file.bodies.iter().all(|(_, ours)| ours.is_none()));
        let (about, count) = (about.trim_end_matches('.'), files.len());
        let _ =
            writeln!(page, "| `{}` | {about} | {count} | {right} | {} |", map.name, same.count());
    }
    page.push_str(
        "\nProposals of how many files have the map's joints, and how many end its bodies as it does. Where a file does \
         not\ntell an end, the map and the proposal estimate it: beyond the same bone counts as the same.\n",
    );
}

fn unknown(page: &mut String, others: &[(String, Proposal)]) {
    page.push_str(
        "\n## Others\n\n| file | joints of the proposal | least sure |\n| --- | --- | ---: |\n",
    );
    for (file, proposed) in others {
        let file = file.trim_start_matches("foreign/");
        let Ok((proposed, _)) = proposed else {
            let _ = writeln!(page, "| {file} | none: no human | |");
            continue;
        };
        let origin = |body: &&str| proposed.map.bodies[*body].origin.clone();
        let turned = |body: &str| proposed.map.bodies[body].rotation.clone();
        let trunk = [origin(&"pelvis"), turned("thorax"), turned("head")].join(", ");
        let least = proposed.notes.iter().map(|note| note.confidence).fold(1.0, f64::min);
        let _ = writeln!(page, "| {file} | {trunk} | {:.0} % |", 100.0 * least);
        for limb in [["upper_arm_l", "forearm_l", "hand_l"], ["thigh_l", "shank_l", "foot_l"]] {
            let limb: Vec<String> = limb.iter().map(origin).collect();
            let _ = writeln!(page, "| | {} | |", limb.join(", "));
        }
    }
    page.push_str(
        "\nPelvis, chest, head; left shoulder, elbow, wrist; left hip, knee, ankle. The right side mirrors the left.\n",
    );
}

fn details(page: &mut String, name: &str, files: &[Compared]) {
    let first = &files[0];
    let _ = writeln!(page, "\n## {name}: {}\n", first.file);
    page.push_str("| body | map | proposal |\n| --- | --- | --- |\n");
    for (place, (body, (right, ours))) in BODIES.iter().zip(&first.bodies).enumerate() {
        let said = |ours: &Option<String>| ours.clone().unwrap_or_else(|| "the same".to_owned());
        let _ = writeln!(page, "| {body} | {right} | {} |", said(ours));
        let mut others: BTreeMap<String, usize> = BTreeMap::new();
        for other in files.iter().map(|file| &file.bodies[place].1).filter(|other| *other != ours) {
            *others.entry(said(other)).or_default() += 1;
        }
        for (other, count) in others {
            let _ = writeln!(page, "| | in {count} of the {} files | {other} |", files.len());
        }
    }
}
