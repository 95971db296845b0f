//! The known skeletons, their mappings, and how they are recognized.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::LazyLock;

use sinew_mocap::Skeleton;

use super::file::{Error, Mapping};

/// A known skeleton.
#[derive(Debug, Clone, PartialEq)]
pub struct KnownSkeleton {
    /// Description of the skeleton, in one line.
    pub about: &'static str,
    /// Mapping of the skeleton to the figure.
    pub mapping: Mapping,
}

/// Returns every known skeleton.
pub fn known_skeletons() -> &'static [KnownSkeleton] {
    static KNOWN: LazyLock<Vec<KnownSkeleton>> = LazyLock::new(|| {
        macro_rules! mappings {
            ($($name:literal),* $(,)?) => {
                [$(include_str!(concat!("../../mappings/", $name, ".toml"))),*]
            };
        }
        let files = mappings!(
            "sinew",
            "cgspeed_mb",
            "cgspeed_mb_asf",
            "asfamc",
            "cmu_asf",
            "cgspeed_daz",
            "m21",
            "bandai",
            "geno",
            "deepmimic",
            "mixamo",
            "mixamo_body",
            "lafan1",
            "xsens_mvn",
            "xsens_bvh",
            "axis_neuron",
            "rokoko",
            "mocopi",
            "makehuman",
            "makehuman_walks",
            "second_life",
        );
        let read = |text: &'static str| KnownSkeleton {
            about: about(text),
            mapping: Mapping::parse(text).expect("the tests read every file"),
        };
        files.into_iter().map(read).collect()
    });
    &KNOWN
}

impl Mapping {
    /// Resolves the value of `--mapping`: a mapping file, or else the name of a known skeleton.
    ///
    /// # Errors
    /// [`Error::NoSuchMapping`] if it is neither; those of [`read`](Self::read).
    pub fn named(path: &Path) -> Result<Self, Error> {
        if path.exists() {
            return Self::read(path);
        }
        let known = known_skeletons();
        let found = known.iter().find(|known| path.to_str() == Some(&known.mapping.name));
        found.map(|known| known.mapping.clone()).ok_or_else(|| Error::NoSuchMapping {
            path: path.to_path_buf(),
            known: names(known.iter().map(|known| &known.mapping)),
        })
    }
}

/// Returns the text of the comment in a file's first line.
fn about(text: &'static str) -> &'static str {
    text.lines().next().and_then(|line| line.strip_prefix("# ")).unwrap_or_default()
}

/// Returns the known mappings whose signature matches `skeleton`. If several match, only those with the most
/// conditions are kept.
fn matching(skeleton: &Skeleton) -> Vec<&'static Mapping> {
    let asks = |mapping: &Mapping| {
        let signature = &mapping.signature;
        let of = [&signature.joints, &signature.zero_offsets, &signature.nonzero_offsets];
        of.iter().map(|joints| joints.len()).sum::<usize>()
    };
    let all = known_skeletons().iter().map(|known| &known.mapping);
    let mut matching: Vec<_> = all.filter(|mapping| mapping.signature.matches(skeleton)).collect();
    let most = matching.iter().map(|mapping| asks(mapping)).max();
    matching.retain(|mapping| Some(asks(mapping)) == most);
    matching
}

/// Returns the known mapping whose signature matches `skeleton`. If several match, the one with the most
/// conditions is chosen.
///
/// # Errors
/// [`Error::NoneMatches`] with the joints found and the mappings tried, or [`Error::SeveralMatch`] with the names
/// if several have equally many conditions.
pub fn choose(skeleton: &Skeleton) -> Result<&'static Mapping, Error> {
    let best = matching(skeleton);
    match best[..] {
        [mapping] => Ok(mapping),
        [] => Err(Error::NoneMatches {
            found: joint_names(skeleton),
            tried: names(known_skeletons().iter().map(|known| &known.mapping)),
            nearest: find_nearest(skeleton).map_or_else(String::new, |(mapping, lacking)| {
                let why = if lacking.is_empty() {
                    "all of its joints are there, but other offsets are zero".to_owned()
                } else {
                    format!("the clip lacks its {}", lacking.join(", "))
                };
                format!(" The nearest is `{}`: {why}.", mapping.name)
            }),
        }),
        _ => Err(Error::SeveralMatch { names: names(best.into_iter()) }),
    }
}

/// Lists the names of mappings, for a message.
pub(super) fn names<'a>(mappings: impl Iterator<Item = &'a Mapping>) -> String {
    mappings.map(|mapping| mapping.name.as_str()).collect::<Vec<_>>().join(", ")
}

/// Lists the joints of a skeleton, for a message. A long list is shortened.
pub(super) fn joint_names(skeleton: &Skeleton) -> String {
    const SHOWN_MAX: usize = 40;
    let names: Vec<_> =
        skeleton.joints.iter().take(SHOWN_MAX).map(|joint| joint.name.as_str()).collect();
    let rest = skeleton.joints.len() - names.len();
    let names = names.join(", ");
    if rest > 0 { format!("{names} and {rest} more") } else { names }
}

/// Returns the nearest known mapping, and the joints that the skeleton lacks for it. A matching mapping is nearest;
/// otherwise the mapping of which `skeleton` has the largest share of the signature's joints, after any prefix. `None`
/// if the skeleton has no joint of any signature.
pub fn find_nearest(skeleton: &Skeleton) -> Option<(&'static Mapping, Vec<&'static str>)> {
    if let [own, ..] = matching(skeleton)[..] {
        return Some((own, Vec::new()));
    }
    known_skeletons()
        .iter()
        .map(|known| (&known.mapping, lacking(&known.mapping, skeleton)))
        .filter(|(mapping, lacking)| lacking.len() < mapping.signature.joints.len())
        .min_by_key(|(mapping, lacking)| lacking.len() * 1000 / mapping.signature.joints.len())
}

/// Returns the joints of a signature that a skeleton lacks, with the name prefix for which the fewest are missing.
fn lacking(mapping: &'static Mapping, skeleton: &Skeleton) -> Vec<&'static str> {
    let wanted: Vec<&'static str> = mapping.signature.joints.iter().map(String::as_str).collect();
    let found: BTreeSet<&str> = skeleton.joints.iter().map(|joint| joint.name.as_str()).collect();
    let prefixes =
        wanted.iter().flat_map(|name| found.iter().filter_map(move |full| full.strip_suffix(name)));
    let prefixes: BTreeSet<(usize, &str)> = prefixes.map(|prefix| (prefix.len(), prefix)).collect();
    let behind = |prefix: &str| -> Vec<&'static str> {
        let is_there = |name: &&str| found.contains(format!("{prefix}{name}").as_str());
        wanted.iter().copied().filter(|name| !is_there(name)).collect()
    };
    // A real prefix is followed by most of the names. Single names match another name's end by chance.
    prefixes
        .into_iter()
        .map(|(_, prefix)| behind(prefix))
        .filter(|lacking| 2 * lacking.len() < wanted.len())
        .chain([behind("")])
        .min_by_key(Vec::len)
        .unwrap_or_default()
}
