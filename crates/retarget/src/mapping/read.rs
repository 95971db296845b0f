//! Reads a mapping from its text.

use serde::{Deserialize, Deserializer};
use toml::Spanned;

use super::{Curve, Entry, Mapping, MappingError, Performance, Point, all};
use crate::Landmark;
use crate::solve::Limb;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default)]
    rig: String,
    #[serde(default)]
    clip: String,
    #[serde(default)]
    performance: PerformanceTable,
    #[serde(default)]
    landmark: Vec<LandmarkTable>,
    #[serde(default)]
    curve: Vec<CurveTable>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
struct PerformanceTable {
    scale: Option<Spanned<Scale>>,
    mirror: Option<bool>,
    travels: Option<bool>,
    arms: Option<LimbWord>,
    legs: Option<LimbWord>,
    tilt_deg: Option<Spanned<f64>>,
    speed_deg_s: Option<Spanned<f64>>,
    forward: Option<Spanned<[f64; 3]>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LandmarkTable {
    name: Spanned<String>,
    clip: Option<String>,
    #[serde(default)]
    rig: Vec<String>,
    point: Option<PointTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PointTable {
    body: String,
    position_m: Spanned<[f64; 3]>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CurveTable {
    clip: String,
    axis: Spanned<[f64; 3]>,
    rig: Spanned<String>,
    points_deg: Option<Spanned<Vec<[f64; 2]>>>,
    points_m: Option<Spanned<Vec<[f64; 2]>>>,
}

#[derive(Deserialize)]
#[serde(rename_all = "lowercase")]
enum LimbWord {
    Both,
    End,
    Upper,
    Path,
}

enum Scale {
    Auto,
    Number(f64),
}

impl<'de> Deserialize<'de> for Scale {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;
        impl serde::de::Visitor<'_> for Visitor {
            type Value = Scale;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("a number above 0, or \"auto\"")
            }

            fn visit_str<E: serde::de::Error>(self, word: &str) -> Result<Scale, E> {
                if word == "auto" {
                    return Ok(Scale::Auto);
                }
                Err(E::invalid_value(serde::de::Unexpected::Str(word), &self))
            }

            fn visit_f64<E: serde::de::Error>(self, number: f64) -> Result<Scale, E> {
                Ok(Scale::Number(number))
            }

            fn visit_i64<E: serde::de::Error>(self, number: i64) -> Result<Scale, E> {
                Ok(Scale::Number(number as f64))
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}

impl Mapping {
    /// Reads a mapping.
    ///
    /// # Errors
    /// [`MappingError::Text`] with line, column, key, and a description of a valid value; [`MappingError::Value`] for a
    /// landmark or a joint that is named twice; [`MappingError::Several`] for several errors.
    ///
    /// ```
    /// use sinew_retarget::mapping::Mapping;
    /// let error = Mapping::read("[[landmark]]\nname = \"l_kneee\"\nrig = [\"l_knee_y\"]\n").unwrap_err();
    /// assert!(error.to_string().starts_with("line 2, column 8: landmark[0].name: expected one of pelvis, chest,"));
    /// ```
    pub fn read(text: &str) -> Result<Self, MappingError> {
        let file: File = toml::from_str(text).map_err(|error| {
            let at = error.span().map_or(0, |span| span.start);
            wrong(text, at, error.message().to_owned())
        })?;
        let landmarks = file.landmark.into_iter().enumerate();
        let landmarks = all(landmarks.map(|(k, table)| landmark(text, k, table)));
        let curves = file.curve.into_iter().enumerate();
        let curves = all(curves.map(|(k, table)| curve(text, k, table)));
        let performance = performance(text, file.performance);
        let mistakes =
            [landmarks.as_ref().err(), curves.as_ref().err(), performance.as_ref().err()];
        all(mistakes.into_iter().flatten().cloned().map(Err::<(), _>))?;
        let (landmarks, curves) = (landmarks?, curves?);
        let performance = performance?;
        let mapping = Self { rig: file.rig, clip: file.clip, performance, landmarks, curves };
        mapping.refuse_twice()?;
        Ok(mapping)
    }

    /// Refuses a landmark, or a joint of the rig, that is named twice.
    fn refuse_twice(&self) -> Result<(), MappingError> {
        let mut landmarks = Vec::new();
        let mut joints: Vec<(&str, String)> = Vec::new();
        let mut take = |joint, item: String| {
            if let Some((_, first)) = joints.iter().find(|(other, _)| *other == joint) {
                let found = format!("`{joint}`, which {first} has as well");
                return Err(MappingError::value(item, "a joint of the rig once", found));
            }
            joints.push((joint, item));
            Ok(())
        };
        for entry in &self.landmarks {
            let item = format!("landmark {}", entry.landmark.name());
            if landmarks.contains(&entry.landmark) {
                return Err(MappingError::value(item, "each landmark once", "it twice"));
            }
            landmarks.push(entry.landmark);
            for joint in &entry.rig {
                take(joint, item.clone())?;
            }
        }
        for (k, curve) in self.curves.iter().enumerate() {
            take(&curve.rig, format!("curve[{k}]"))?;
        }
        Ok(())
    }
}

fn performance(text: &str, table: PerformanceTable) -> Result<Performance, MappingError> {
    let mut performance = Performance::default();
    let refuse = |at: usize, key: &str, expected: &str, found: String| {
        Err(wrong(text, at, format!("performance.{key}: expected {expected}, found {found}")))
    };
    if let Some(scale) = table.scale {
        performance.scale = match scale.get_ref() {
            Scale::Auto => None,
            Scale::Number(number) if number.is_finite() && *number > 0.0 => Some(*number),
            Scale::Number(number) => {
                let expected = "a number above 0, or \"auto\"";
                return refuse(scale.span().start, "scale", expected, number.to_string());
            }
        };
    }
    if let Some(speed) = table.speed_deg_s {
        let number = *speed.get_ref();
        if !(number.is_finite() && number > 0.0) {
            return refuse(
                speed.span().start,
                "speed_deg_s",
                "a number above 0",
                number.to_string(),
            );
        }
        performance.speed_rad_s = number.to_radians();
    }
    if let Some(tilt) = table.tilt_deg {
        let number = *tilt.get_ref();
        if !(-180.0..=180.0).contains(&number) {
            let expected = "an angle from -180 to 180";
            return refuse(tilt.span().start, "tilt_deg", expected, number.to_string());
        }
        performance.tilt_rad = number.to_radians();
    }
    if let Some(forward) = table.forward {
        let [x, y, z] = *forward.get_ref();
        if !(x.is_finite() && y.is_finite() && z.is_finite() && x * x + z * z > 0.0) {
            let found = format!("{:?}", forward.get_ref());
            return refuse(
                forward.span().start,
                "forward",
                "a direction that is not upright",
                found,
            );
        }
        performance.forward = Some([x, y, z]);
    }
    performance.mirror = table.mirror.unwrap_or(performance.mirror);
    performance.travels = table.travels.unwrap_or(performance.travels);
    performance.arms = table.arms.map_or(performance.arms, Into::into);
    performance.legs = table.legs.map_or(performance.legs, Into::into);
    Ok(performance)
}

fn landmark(text: &str, k: usize, table: LandmarkTable) -> Result<Entry, MappingError> {
    let Some(landmark) = Landmark::named(table.name.get_ref()) else {
        let names = Landmark::ALL.map(Landmark::name).join(", ");
        let found = table.name.get_ref();
        let message = format!("landmark[{k}].name: expected one of {names}, found {found:?}");
        return Err(wrong(text, table.name.span().start, message));
    };
    let point = table.point.map(|point| {
        let position_m = *point.position_m.get_ref();
        if position_m.iter().all(|x| x.is_finite()) {
            return Ok(Point { body: point.body, position_m });
        }
        let message = format!(
            "landmark[{k}].point.position_m: expected three finite numbers, found {position_m:?}"
        );
        Err(wrong(text, point.position_m.span().start, message))
    });
    Ok(Entry {
        landmark,
        clip: table.clip,
        rig: table.rig,
        point: point.transpose()?,
        confidence: 1.0,
        reason: String::new(),
    })
}

fn curve(text: &str, k: usize, table: CurveTable) -> Result<Curve, MappingError> {
    let refuse = |at: usize, key: &str, expected: &str, found: String| {
        Err(wrong(text, at, format!("curve[{k}].{key}: expected {expected}, found {found}")))
    };
    let axis = *table.axis.get_ref();
    if !axis.iter().all(|x| x.is_finite()) || axis.iter().all(|x| x.abs() <= 0.0) {
        return refuse(table.axis.span().start, "axis", "a direction", format!("{axis:?}"));
    }
    let (slides, key, points) = match (table.points_deg, table.points_m) {
        (Some(points), None) => (false, "points_deg", points),
        (None, Some(points)) => (true, "points_m", points),
        (both, _) => {
            let found = if both.is_some() { "both" } else { "neither" };
            let expected = "points_deg (of a joint that turns) or points_m (of one that slides)";
            return refuse(table.rig.span().start, "points_deg", expected, found.to_owned());
        }
    };
    let list = points.get_ref();
    let grows = list.windows(2).all(|pair| pair[0][0] < pair[1][0]);
    if list.len() < 2 || !grows || !list.iter().flatten().all(|x| x.is_finite()) {
        let expected = "two or more points [clip, rig] of finite numbers, the first growing";
        return refuse(points.span().start, key, expected, format!("{list:?}"));
    }
    let point =
        |[from, to]: &[f64; 2]| [from.to_radians(), if slides { *to } else { to.to_radians() }];
    Ok(Curve {
        clip: table.clip,
        axis,
        rig: table.rig.into_inner(),
        points: list.iter().map(point).collect(),
        slides,
    })
}

impl From<LimbWord> for Limb {
    fn from(word: LimbWord) -> Self {
        match word {
            LimbWord::Both => Self::Both,
            LimbWord::End => Self::End,
            LimbWord::Upper => Self::Upper,
            LimbWord::Path => Self::Path,
        }
    }
}

/// Creates the error at a byte of the text.
fn wrong(text: &str, at: usize, message: String) -> MappingError {
    let before = text.as_bytes().get(..at).unwrap_or(text.as_bytes());
    let lines = before.split(|byte| *byte == b'\n');
    let on_line = String::from_utf8_lossy(lines.clone().next_back().unwrap_or_default());
    let (line, column) = (lines.count(), on_line.chars().count() + 1);
    MappingError::Text { line, column, message }
}
