//! Animation of shape keys (morph targets): a weight of each shape over time.

use ::gltf::accessor::{DataType, Dimensions};
use ::gltf::animation::{Channel, Interpolation, Property};
use ::gltf::{Document, Mesh as GltfMesh};

use super::Buffers;
use super::accessor::Elements;
use crate::character::error::{Refusal, refuse};

/// Rate at which the animation is sampled, Hz.
const RATE_HZ: f64 = 100.0;
/// Maximum duration of an animation, s.
const DURATION_MAX_S: f64 = 7200.0;
/// Maximum number of weights, which limits the memory.
const WEIGHTS_MAX: usize = 1 << 26;

/// Weights of shape keys over time.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ShapeKeys {
    /// Names of the shapes.
    pub names: Vec<String>,
    /// Times of the rows, s: from 0, at 100 Hz.
    pub times_s: Vec<f64>,
    /// Rows with a weight for each shape.
    pub rows: Vec<Vec<f64>>,
    /// Name of the animation that was read, if it has a name.
    pub animation: Option<String>,
    /// Number of animations of shape keys in the file. Only the first of them is read.
    pub animations: usize,
}

/// Animation of the shape keys of one mesh.
struct Track {
    names: Vec<String>,
    times_s: Vec<f64>,
    /// Values of all shapes at each key. For a cubic spline, they are between the tangents before and after the key.
    values: Vec<f64>,
    interpolation: Interpolation,
}

/// Reads the first animation of shape keys. If several meshes, such as head and teeth, have a shape of the same name,
/// the first mesh is used.
///
/// # Errors
/// [`Refusal`] if there is no such animation, or a part of it is damaged.
pub(super) fn read(document: &Document, buffers: &Buffers) -> Result<ShapeKeys, Refusal> {
    let is_weights =
        |channel: &Channel<'_>| channel.target().property() == Property::MorphTargetWeights;
    let mut of_shapes =
        document.animations().filter(|animation| animation.channels().any(|c| is_weights(&c)));
    let Some(animation) = of_shapes.next() else {
        return Err(refuse("animations", "an animation of shape keys (`weights`)", "none"));
    };
    let animations = 1 + of_shapes.count();
    let channels = animation.channels().enumerate().filter(|(_, channel)| is_weights(channel));
    let mut tracks = Vec::new();
    for (index, channel) in channels {
        let of_channel = format!("animation {}: channel {index}", animation.index());
        tracks.push(track(&channel, buffers).map_err(|refusal| refusal.of(of_channel))?);
    }
    let keys = rows(&tracks)?;
    Ok(ShapeKeys { animation: animation.name().map(str::to_owned), animations, ..keys })
}

/// Returns the names of a mesh's shapes, from the extras that Blender and other programs write.
fn names(mesh: &GltfMesh<'_>) -> Result<Vec<String>, Refusal> {
    #[derive(serde::Deserialize)]
    struct Extras {
        #[serde(rename = "targetNames", default)]
        target_names: Vec<String>,
    }
    let extras = mesh.extras().as_ref();
    let extras = extras.and_then(|extras| serde_json::from_str::<Extras>(extras.get()).ok());
    let names = extras.map(|extras| extras.target_names).unwrap_or_default();
    let count = mesh.primitives().next().map_or(0, |primitive| primitive.morph_targets().count());
    if names.is_empty() || names.len() != count {
        let expected =
            format!("`targetNames` in its extras with {count} names, as Blender writes them");
        return Err(refuse(format!("mesh {}", mesh.index()), expected, names.len()));
    }
    Ok(names)
}

/// Reads the keys of a channel.
fn track(channel: &Channel<'_>, buffers: &Buffers) -> Result<Track, Refusal> {
    let (sampler, node) = (channel.sampler(), channel.target().node());
    let mesh = node.mesh().ok_or_else(|| {
        refuse(format!("node {}", node.index()), "a mesh with shape keys", "none")
    })?;
    let names = names(&mesh)?;
    let times = Elements::new(&sampler.input(), buffers, Dimensions::Scalar, &[DataType::F32])?;
    let types = [DataType::F32, DataType::I8, DataType::U8, DataType::I16, DataType::U16];
    let output = Elements::new(&sampler.output(), buffers, Dimensions::Scalar, &types)?;
    let interpolation = sampler.interpolation();
    let each = names.len() * if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
    if Some(output.count()) != times.count().checked_mul(each) || output.count() > WEIGHTS_MAX {
        let expected = format!("{} weights of {} keys", each, times.count());
        return Err(refuse("its output", expected, output.count()));
    }
    let times_s: Vec<f64> = (0..times.count()).flat_map(|key| times.numbers(key)).collect();
    let is_sorted = times_s.windows(2).all(|pair| pair[1] > pair[0]);
    // The comparisons also refuse NaN.
    if !(is_sorted && times_s.iter().all(|time_s| (0.0..=DURATION_MAX_S).contains(time_s)))
        || times_s.is_empty()
    {
        let expected = format!("times that increase, from 0 to {DURATION_MAX_S} s");
        return Err(refuse("its input", expected, "others"));
    }
    let one = output.one();
    let values: Vec<f64> = (0..output.count())
        .flat_map(|index| output.numbers(index))
        // A signed integer may be one step below -1. A float is taken as it is, so that NaN is found below.
        .map(|number| if one > 1.0 { (number / one).max(-1.0) } else { number })
        .collect();
    if let Some(index) = values.iter().position(|value| value.is_nan() || value.abs() > 1e3) {
        return Err(refuse("its output", "weights from 0 to 1", values[index]));
    }
    Ok(Track { names, times_s, values, interpolation })
}

impl Track {
    /// Returns the weight of a shape at a time, s.
    fn at(&self, shape: usize, time_s: f64) -> f64 {
        let (shapes, is_cubic) =
            (self.names.len(), self.interpolation == Interpolation::CubicSpline);
        // Values of a key: tangent before, value, and tangent after.
        let part = |key: usize, part: usize| {
            let row = if is_cubic { 3 * key + part } else { key };
            self.values[row * shapes + shape]
        };
        let value = |key: usize| part(key, 1);
        let next = self.times_s.partition_point(|time| *time <= time_s);
        let last = self.times_s.len() - 1;
        let Some(from) = next.checked_sub(1) else { return value(0) };
        if from == last {
            return value(last);
        }
        let span_s = self.times_s[next] - self.times_s[from];
        let t = (time_s - self.times_s[from]) / span_s;
        match self.interpolation {
            Interpolation::Step => value(from),
            Interpolation::Linear => value(from) + t * (value(next) - value(from)),
            Interpolation::CubicSpline => {
                let (square, cube) = (t * t, t * t * t);
                let begin = 2.0 * cube - 3.0 * square + 1.0;
                value(from) * begin
                    + span_s * part(from, 2) * (cube - 2.0 * square + t)
                    + value(next) * (1.0 - begin)
                    + span_s * part(next, 0) * (cube - square)
            }
        }
    }
}

/// Samples all tracks, and returns them as one table.
fn rows(tracks: &[Track]) -> Result<ShapeKeys, Refusal> {
    let mut places: Vec<(usize, usize)> = Vec::new();
    let mut names: Vec<String> = Vec::new();
    for (index, track) in tracks.iter().enumerate() {
        for (shape, name) in track.names.iter().enumerate() {
            if !names.contains(name) {
                names.push(name.clone());
                places.push((index, shape));
            }
        }
    }
    let ends = tracks.iter().filter_map(|track| track.times_s.last().copied());
    let end_s = ends.fold(0.0, f64::max);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most 7200 s")]
    let last = (end_s * RATE_HZ - 1e-6).ceil().max(1.0) as usize;
    if (last + 1).saturating_mul(names.len()) > WEIGHTS_MAX {
        let expected = format!("at most {WEIGHTS_MAX} weights at {RATE_HZ} Hz");
        return Err(refuse("its animation", expected, (last + 1) * names.len()));
    }
    let times_s: Vec<f64> = (0..=last).map(|row| row as f64 / RATE_HZ).collect();
    let row = |time_s: &f64| {
        let weight = |(track, shape): &(usize, usize)| tracks[*track].at(*shape, *time_s);
        places.iter().map(weight).collect()
    };
    let rows = times_s.iter().map(row).collect();
    Ok(ShapeKeys { names, times_s, rows, ..ShapeKeys::default() })
}
