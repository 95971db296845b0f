//! Reads the skeleton (ASF).

use std::collections::BTreeMap;

use glam::{DQuat, DVec3};

use super::Problem;
use super::channel::{Channel, composed};
use super::lines::{Failure, Line, Lines, Word};
use crate::recording::JOINT_COUNT_MAX;
use crate::skeleton::{Skeleton, SkeletonJoint};
use crate::text::{Position, shown};

/// The bones, parents before children; bone 0 is the root, which has no length.
#[derive(Debug)]
pub(super) struct Asf {
    /// Divisor of lengths; the result is in inches.
    pub(super) length_unit: f64,
    /// Whether angles are in degrees, in the skeleton and, unless stated otherwise, in the motion.
    pub(super) degrees: bool,
    pub(super) bones: Vec<Bone>,
}

#[derive(Debug, Clone)]
pub(super) struct Bone {
    pub(super) name: String,
    pub(super) parent: Option<usize>,
    /// Vector from its beginning to its end in the rest pose, in the file's unit.
    pub(super) vector: DVec3,
    /// Rotation from the bone's rotation axes to the world's axes, in the rest pose.
    pub(super) axes: DQuat,
    pub(super) channels: Vec<Channel>,
    line: usize,
    has_children: bool,
}

impl Asf {
    /// Returns the beginning of the bone in its parent's frame.
    pub(super) fn offset(&self, bone: &Bone) -> DVec3 {
        bone.parent.map_or(DVec3::ZERO, |parent| self.bones[parent].vector)
    }

    pub(super) fn skeleton(&self) -> Skeleton {
        let joint = |bone: &Bone| SkeletonJoint {
            name: bone.name.clone(),
            parent: bone.parent,
            offset_m: self.offset(bone),
            end_sites_m: if bone.has_children { Vec::new() } else { vec![bone.vector] },
        };
        Skeleton { joints: self.bones.iter().map(joint).collect() }
    }
}

pub(super) fn parse(text: &str) -> Result<Asf, Failure> {
    let mut parser = Parser {
        lines: Lines::new(text),
        length_unit: 1.0,
        degrees: true,
        root: None,
        bones: Vec::new(),
        parents: None,
    };
    while let Some(line) = parser.lines.next() {
        let key = line.key();
        match key.text.to_ascii_lowercase().as_str() {
            ":units" => parser.units(key)?,
            ":root" => parser.root(key.at)?,
            ":bonedata" => parser.bones()?,
            ":hierarchy" => parser.hierarchy()?,
            // Notes, and data for drawing the figure.
            section if section.starts_with(':') => parser.lines.skip_section(),
            _ => return Err(key.not("a section, such as `:root`")),
        }
    }
    parser.finish()
}

struct Parser<'a> {
    lines: Lines<'a>,
    length_unit: f64,
    degrees: bool,
    root: Option<Bone>,
    bones: Vec<Bone>,
    /// For each bone, by its name: the bone's parent in the hierarchy, and the position in the file where the hierarchy
    /// names the bone.
    parents: Option<BTreeMap<String, (String, Position)>>,
}

impl Parser<'_> {
    fn units(&mut self, key: Word<'_>) -> Result<(), Failure> {
        if self.root.is_some() || !self.bones.is_empty() {
            return Err(key.not("`:units` before `:root` and `:bonedata`"));
        }
        while let Some(line) = self.lines.next_in_section() {
            let key = line.key();
            match key.text.to_ascii_lowercase().as_str() {
                "mass" => drop(line.word(1).finite()?),
                "length" => {
                    self.length_unit = line.word(1).finite()?;
                    if !(1e-3..=1e3).contains(&self.length_unit) {
                        return Err(line.word(1).not("a unit of length from 0.001 to 1000"));
                    }
                }
                "angle" => self.degrees = is_degrees(line.word(1))?,
                _ => return Err(key.not("`mass`, `length` or `angle`")),
            }
            line.ends(2)?;
        }
        Ok(())
    }

    /// Reads the root's `order`, `axis`, `position` and `orientation`, in any order.
    ///
    /// Readers disagree on the meaning of a `position` or `orientation` other than zero (according to Vicon's notes
    /// on the format, whose files never have it), therefore other values are refused. With zeros, `axis` has no
    /// effect.
    fn root(&mut self, at: Position) -> Result<(), Failure> {
        let mut channels = None;
        while let Some(line) = self.lines.next_in_section() {
            let key = line.key();
            match key.text.to_ascii_lowercase().as_str() {
                "order" => channels = Some(order_of_root(&line)?),
                "axis" => {
                    axes(line.word(1))?;
                    line.ends(2)?;
                }
                "position" | "orientation" => {
                    let preset: [f64; 3] = line.numbers(1)?;
                    if let Some(index) = preset.iter().position(|&number| number != 0.0) {
                        return Err(line.word(1 + index).not(format!("`{} 0 0 0`", key.text)));
                    }
                    line.ends(4)?;
                }
                _ => return Err(key.not("`order`, `axis`, `position` or `orientation`")),
            }
        }
        let missing = (at, Problem::Missing { bone: "root".to_owned(), key: "order" });
        self.root = Some(Bone {
            name: "root".to_owned(),
            parent: None,
            vector: DVec3::ZERO,
            axes: DQuat::IDENTITY,
            channels: channels.ok_or(missing)?,
            line: at.line,
            has_children: true,
        });
        Ok(())
    }

    fn bones(&mut self) -> Result<(), Failure> {
        while let Some(line) = self.lines.next_in_section() {
            if !line.key().is("begin") {
                return Err(line.key().not("the `begin` of a bone or the next section"));
            }
            if self.bones.len() + 1 == JOINT_COUNT_MAX {
                let problem = Problem::TooMany { items: "bones", limit: JOINT_COUNT_MAX - 1 };
                return Err((line.key().at, problem));
            }
            let bone = self.bone(line.key().at)?;
            self.bones.push(bone);
        }
        Ok(())
    }

    /// Reads a bone from its `begin` at position `at` to its `end`.
    fn bone(&mut self, at: Position) -> Result<Bone, Failure> {
        let mut name: Option<String> = None;
        let (mut direction, mut length, mut axes_of_bone) = (None, None, None);
        let mut channels = Vec::new();
        let mut in_limits = false;
        loop {
            let Some(line) = self.lines.next_in_section() else {
                let end = Word { text: "", at: self.lines.end() };
                let name = name.unwrap_or_else(|| "without a name".to_owned());
                return Err(end.not(format!("the `end` of bone `{name}`")));
            };
            let key = line.key();
            let shown_name = name.clone().unwrap_or_else(|| format!("of line {}", at.line));
            match key.text.to_ascii_lowercase().as_str() {
                "end" => {
                    let missing = |key_name| {
                        (key.at, Problem::Missing { bone: shown_name.clone(), key: key_name })
                    };
                    let name = name.ok_or_else(|| missing("name"))?;
                    let direction: DVec3 = direction.ok_or_else(|| missing("direction"))?;
                    let length: f64 = length.ok_or_else(|| missing("length"))?;
                    if length > 0.0 && direction.try_normalize().is_none() {
                        let length = length.to_string();
                        return Err((key.at, Problem::NoDirection { bone: name, length }));
                    }
                    return Ok(Bone {
                        name,
                        parent: None,
                        vector: direction.normalize_or_zero() * length,
                        axes: axes_of_bone.ok_or_else(|| missing("axis"))?,
                        channels,
                        line: at.line,
                        has_children: false,
                    });
                }
                "name" => {
                    self.new_name(line.word(1))?;
                    name = Some(line.word(1).text.to_owned());
                    line.ends(2)?;
                }
                "direction" => {
                    direction = Some(DVec3::from_array(line.numbers(1)?));
                    line.ends(4)?;
                }
                "length" => {
                    let found = line.word(1).finite()?;
                    if found < 0.0 {
                        return Err(line.word(1).not("a length from 0"));
                    }
                    length = Some(found);
                    line.ends(2)?;
                }
                "axis" => {
                    let order = axes(line.word(4))?;
                    axes_of_bone = Some(self.orientation(order, line.numbers(1)?));
                    line.ends(5)?;
                }
                "dof" => channels = parse_dofs(&line, &shown_name)?,
                // Keys that a motion does not need.
                "id" | "limits" | "bodymass" | "cofmass" => {}
                _ if in_limits && is_limit(key) => {}
                _ => {
                    let expected = "`name`, `direction`, `length`, `axis`, `dof`, `limits`, `id`, \
                                    `bodymass`, `cofmass` or `end`";
                    return Err(key.not(format!("{expected} in bone `{shown_name}`")));
                }
            }
            in_limits = key.is("limits") || in_limits && is_limit(key);
        }
    }

    fn new_name(&self, name: Word<'_>) -> Result<(), Failure> {
        if name.text.is_empty() {
            return Err(name.not("the bone's name"));
        }
        if name.is("root") {
            return Err(name.not("the name of a bone other than the root"));
        }
        self.bones.iter().find(|bone| bone.name == name.text).map_or(Ok(()), |first| {
            let problem =
                Problem::Duplicate { item: "bone", name: shown(name.text), first_line: first.line };
            Err((name.at, problem))
        })
    }

    fn hierarchy(&mut self) -> Result<(), Failure> {
        let mut parents = BTreeMap::<String, (String, Position)>::new();
        while let Some(line) = self.lines.next_in_section() {
            if line.key().is("begin") || line.key().is("end") {
                line.ends(1)?;
                continue;
            }
            for child in &line.words[1..] {
                if let Some((_, first)) = parents.get(child.text) {
                    let problem = Problem::Duplicate {
                        item: "child",
                        name: shown(child.text),
                        first_line: first.line,
                    };
                    return Err((child.at, problem));
                }
                parents.insert(child.text.to_owned(), (line.key().text.to_owned(), child.at));
            }
        }
        self.parents = Some(parents);
        Ok(())
    }

    /// Sorts the bones so that parents precede their children.
    fn finish(mut self) -> Result<Asf, Failure> {
        let end = Word { text: "", at: self.lines.end() };
        let root = self.root.ok_or_else(|| end.not("a `:root` section"))?;
        let parents = self.parents.ok_or_else(|| end.not("a `:hierarchy` section"))?;
        for (child, (parent, at)) in &parents {
            let is_bone = |name: &String| self.bones.iter().any(|bone| bone.name == *name);
            for (name, known) in
                [(child, is_bone(child)), (parent, parent == "root" || is_bone(parent))]
            {
                if !known {
                    return Err(Word { text: name, at: *at }.not("a bone of `:bonedata`"));
                }
            }
        }
        let mut bones = vec![root];
        let mut index = 0;
        while index < bones.len() {
            let name = bones[index].name.clone();
            let is_child = |bone: &mut Bone| {
                parents.get(&bone.name).is_some_and(|(parent, _)| *parent == name)
            };
            for mut child in self.bones.extract_if(.., is_child) {
                bones[index].has_children = true;
                child.parent = Some(index);
                bones.push(child);
            }
            index += 1;
        }
        match self.bones.first() {
            None => Ok(Asf { length_unit: self.length_unit, degrees: self.degrees, bones }),
            Some(bone) => {
                let at = Position { line: bone.line, column: 1 };
                Err((at, Problem::NotInHierarchy { bone: shown(&bone.name) }))
            }
        }
    }

    /// Returns the rotation by `angles` about the fixed axes, in the order of `axes`.
    fn orientation(&self, axes: [usize; 3], angles: [f64; 3]) -> DQuat {
        // The angles are given for x, y and z, whatever the order.
        composed(axes.map(|axis| {
            (axis, if self.degrees { angles[axis].to_radians() } else { angles[axis] })
        }))
        .normalize()
    }
}

/// Reads the unit of angles.
fn is_degrees(word: Word<'_>) -> Result<bool, Failure> {
    match word.text.to_ascii_lowercase().as_str() {
        "deg" | "degrees" => Ok(true),
        "rad" | "radians" => Ok(false),
        _ => Err(word.not("`deg` or `rad`")),
    }
}

/// Reads a sequence of three axes, such as `XYZ`.
fn axes(word: Word<'_>) -> Result<[usize; 3], Failure> {
    let letters: Vec<usize> =
        word.text.to_ascii_lowercase().chars().filter_map(|letter| "xyz".find(letter)).collect();
    match letters[..] {
        [a, b, c] if word.text.len() == 3 && a != b && b != c && a != c => Ok([a, b, c]),
        _ => Err(word.not("a sequence of the three axes, such as `XYZ`")),
    }
}

fn channel(word: Word<'_>) -> Option<Channel> {
    match word.text.to_ascii_lowercase().as_str() {
        "tx" => Some(Channel::Position(0)),
        "ty" => Some(Channel::Position(1)),
        "tz" => Some(Channel::Position(2)),
        "rx" => Some(Channel::Rotation(0)),
        "ry" => Some(Channel::Rotation(1)),
        "rz" => Some(Channel::Rotation(2)),
        _ => None,
    }
}

/// Reads the channels that a line names after its first word.
fn channels(line: &Line<'_>, expected: &str) -> Result<Vec<Channel>, Failure> {
    let mut channels = Vec::with_capacity(6);
    for &word in &line.words[1..] {
        match channel(word) {
            Some(channel) if !channels.contains(&channel) => channels.push(channel),
            _ => return Err(word.not(expected)),
        }
    }
    Ok(channels)
}

fn order_of_root(line: &Line<'_>) -> Result<Vec<Channel>, Failure> {
    let expected = "each of TX, TY, TZ, RX, RY and RZ once";
    let channels = channels(line, expected)?;
    if channels.len() == 6 { Ok(channels) } else { Err(line.word(7).not(expected)) }
}

fn parse_dofs(line: &Line<'_>, bone: &str) -> Result<Vec<Channel>, Failure> {
    for word in &line.words[1..] {
        if word.is("l") || matches!(channel(*word), Some(Channel::Position(_))) {
            let problem = Problem::NotRotation { bone: shown(bone), found: word.text.to_owned() };
            return Err((word.at, problem));
        }
    }
    channels(line, "each of rx, ry and rz at most once")
}

/// Returns whether the word is a number of `limits`, which continue over several lines.
fn is_limit(word: Word<'_>) -> bool {
    word.text.parse::<f64>().is_ok()
}
