//! Kinds of files in words, with the commands that accept them, for messages about a wrong file.

use std::fmt;
use std::path::Path;

use crate::encoding;

/// A kind of file that users may have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Kind {
    /// Biovision Hierarchy: a skeleton and its motion.
    Bvh,
    /// An Acclaim skeleton.
    Asf,
    /// An Acclaim motion.
    Amc,
    /// A `DeepMimic` motion.
    DeepMimic,
    /// A character in glTF, GLB or VRM.
    Gltf,
    /// The character of the Geno files.
    Geno,
    /// Autodesk's interchange format.
    Fbx,
    /// A C3D file with markers.
    C3d,
    /// A robot description of ROS (URDF), also as `xacro`.
    Urdf,
    /// A model of `MuJoCo`.
    Mjcf,
    /// Another XML file.
    Xml,
    /// A `rig.toml` file.
    Rig,
    /// A mapping onto a rig.
    RigMapping,
    /// A mapping onto the figure.
    FigureMapping,
    /// A sweep: a grid of setups to evaluate.
    Sweep,
    /// Another TOML file.
    Toml,
    /// A baked show.
    Show,
    /// A table in Parquet: recordings, or results of sweeps.
    Parquet,
    /// A picture.
    Picture,
    /// A table as text.
    Csv,
    /// Another JSON file.
    Json,
}

/// Maximum number of bytes of a text that are examined; they include comments at its beginning.
const LOOKED_AT: usize = 1 << 16;

impl Kind {
    /// Returns the kind of a file: from its content, otherwise from its name; `None` if neither shows it.
    pub fn of(path: &Path, bytes: &[u8]) -> Option<Self> {
        Self::of_magic(bytes).or_else(|| {
            let text = encoding::lossy(&bytes[..bytes.len().min(LOOKED_AT)]);
            let text = text.trim_start();
            Self::of_text(text).or_else(|| Self::of_name(path, text))
        })
    }

    /// Returns a description of the kind, for messages.
    pub fn found(kind: Option<Self>) -> String {
        kind.map_or_else(|| "another kind of file".to_owned(), |kind| kind.to_string())
    }

    fn of_magic(bytes: &[u8]) -> Option<Self> {
        const MAGIC: [(&[u8], Kind); 7] = [
            (b"glTF", Kind::Gltf),
            (b"SNWS", Kind::Show),
            (b"PAR1", Kind::Parquet),
            (b"\x89PNG", Kind::Picture),
            (b"\xff\xd8\xff", Kind::Picture),
            (b"GIF8", Kind::Picture),
            (b"Kaydara FBX Binary", Kind::Fbx),
        ];
        MAGIC.iter().find(|(magic, _)| bytes.starts_with(magic)).map(|(_, kind)| *kind)
    }

    /// Recognizes a text by its first characters and, if these fit several kinds, by words in the text. Returns `None`
    /// for other texts.
    fn of_text(text: &str) -> Option<Self> {
        let start: String = text.chars().take(64).collect::<String>().to_ascii_lowercase();
        let has = |word: &str| text.contains(word);
        if start.starts_with("hierarchy") {
            return Some(Self::Bvh);
        }
        if start.starts_with("#!oml:asf") || start.starts_with(':') {
            return Some(if has(":bonedata") || has(":root") { Self::Asf } else { Self::Amc });
        }
        if start.starts_with('<') {
            let kinds = [("<mujoco", Self::Mjcf), ("<robot", Self::Urdf), ("<svg", Self::Picture)];
            // The first element decides, because a URDF may contain elements for MuJoCo.
            let known = kinds
                .into_iter()
                .filter_map(|(element, kind)| Some((text.find(element)?, kind)))
                .min_by_key(|(place, _)| *place);
            return Some(known.map_or(Self::Xml, |(_, kind)| kind));
        }
        if start.starts_with('{') {
            return Some(if has("\"Frames\"") {
                Self::DeepMimic
            } else if has("\"asset\"") {
                Self::Gltf
            } else {
                Self::Json
            });
        }
        None
    }

    /// Recognizes a file by its extension, and a TOML file by tables that only one kind has. Returns `None` for an
    /// unknown extension.
    fn of_name(path: &Path, text: &str) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        Some(match extension.as_str() {
            "bvh" => Self::Bvh,
            "asf" => Self::Asf,
            "amc" => Self::Amc,
            "glb" | "gltf" | "vrm" => Self::Gltf,
            "bin" => Self::Geno,
            "fbx" => Self::Fbx,
            "c3d" => Self::C3d,
            "urdf" | "xacro" => Self::Urdf,
            "mjcf" => Self::Mjcf,
            "xml" => Self::Xml,
            "png" | "jpg" | "jpeg" | "gif" | "svg" => Self::Picture,
            "csv" => Self::Csv,
            "json" => Self::Json,
            "toml" => Self::of_tables(text),
            _ => return None,
        })
    }

    fn of_tables(text: &str) -> Self {
        let begins = |mark: &str| text.lines().any(|line| line.trim_start().starts_with(mark));
        let kinds = [
            ("[[body]]", Self::Rig),
            ("[body]", Self::FigureMapping),
            ("[body.", Self::FigureMapping),
            ("[[grid]]", Self::Sweep),
            ("[landmark", Self::RigMapping),
            ("[[curve]]", Self::RigMapping),
        ];
        let known = kinds.into_iter().find(|(mark, _)| begins(mark));
        known.map_or(Self::Toml, |(_, kind)| kind)
    }
}

/// Shows the kind with its article, and the commands that accept it.
impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Bvh => {
                "a BVH motion, for `sinew clip`, `bake` and `evaluate --clips`"
            }
            Self::Asf => {
                "an ASF skeleton: `sinew clip`, `bake` and `evaluate --clips` accept the AMC motion beside it"
            }
            Self::Amc => {
                "an AMC motion, for `sinew clip`, `bake` and `evaluate --clips`"
            }
            Self::DeepMimic => {
                "a DeepMimic motion, for `sinew clip`, `bake` and `evaluate --clips`"
            }
            Self::Gltf => {
                "a glTF character, for `sinew clip inspect` and `weights`; its animations are not read: export them as \
                 BVH (Blender does)"
            }
            Self::Geno => "a binary character, for `sinew clip inspect` and `weights`",
            Self::Fbx => "FBX, which is not read: export it as BVH (Blender does)",
            Self::C3d => {
                "C3D, which holds markers and is not read: export the solved skeleton as BVH"
            }
            Self::Urdf => {
                "a URDF rig, for `sinew rig`, `inspect`, `weights` and each `--rig`"
            }
            Self::Mjcf => "an MJCF rig, for `sinew rig`, `inspect` and each `--rig`",
            Self::Xml => "XML of another kind",
            Self::Rig => "a rig.toml, for `sinew rig`, `inspect` and each `--rig`",
            Self::RigMapping => "a mapping on a rig, for `--mapping` together with `--rig`",
            Self::FigureMapping => {
                "a mapping on the human figure, for `--mapping` without `--rig`"
            }
            Self::Sweep => "a sweep, for `sinew evaluate sweep`",
            Self::Toml => "TOML of another kind",
            Self::Show => "a show, for `sinew play` and `sinew board upload show`",
            Self::Parquet => "a Parquet table: recordings of `sinew play` are for `sinew report`",
            Self::Picture => "a picture, which no command reads",
            Self::Csv => {
                "a CSV table: joint coordinates of a rig are for `sinew bake --rig` and `sinew play`"
            }
            Self::Json => {
                "JSON of another kind: positions of a rig's servos are for `sinew bake --rig` and `sinew play`, golden \
                 files for `sinew evaluate verify`"
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_known_by_content_first() {
        let kind = |name: &str, text: &str| Kind::of(Path::new(name), text.as_bytes());
        for (name, text, expected) in [
            ("a.toml", "\u{feff} HIERARCHY\nROOT", Some(Kind::Bvh)),
            ("a", "#!OML:ASF x\n:version\n:root", Some(Kind::Asf)),
            ("a", ":FULLY-SPECIFIED\n:DEGREES\n1", Some(Kind::Amc)),
            ("a.urdf", "<?xml?><!-- x --><mujoco>", Some(Kind::Mjcf)),
            ("a.xml", "<robot name='a'>", Some(Kind::Urdf)),
            ("a.urdf", "<robot name='a'><mujoco/></robot>", Some(Kind::Urdf)),
            ("a.html", "<html>", Some(Kind::Xml)),
            ("a.txt", " {\"Loop\":\"wrap\",\"Frames\":[]}", Some(Kind::DeepMimic)),
            ("a.txt", "{}", Some(Kind::Json)),
            ("a.json", "{\"asset\":{}}", Some(Kind::Gltf)),
            ("a.bvh", "glTF\x02", Some(Kind::Gltf)),
            ("a.toml", "# mine\n[[body]]\n", Some(Kind::Rig)),
            ("a.toml", "name = 'x'\n[body]\n", Some(Kind::FigureMapping)),
            ("a.toml", "[landmark.head]\n", Some(Kind::RigMapping)),
            ("a.toml", "[[grid]]\n", Some(Kind::Sweep)),
            ("a.toml", "kp = 3\n", Some(Kind::Toml)),
            ("a.csv", "time,x\n", Some(Kind::Csv)),
            ("a.c3d", "\u{2}P", Some(Kind::C3d)),
            ("a", "", None),
            ("LICENSE.txt", "MIT", None),
        ] {
            assert_eq!(kind(name, text), expected, "{name}: {text}");
        }
    }
}
