//! Layers: motions of a rig that replace the motion of some joints, or are added to it.

mod choice;

use anyhow::{Context as _, bail, ensure};
use glam::DQuat;
use sinew_retarget::exchange::HeaderUnits;
use sinew_retarget::feasibility::{Curve, Instant, Performance as _, RigMotion};
use sinew_rig::Mechanism;
use sinew_rig::mechanism::JointModel;

use super::own_motion::OwnMotion;
use super::rig::LoadedRig;
pub use choice::{LayerChoice, LayerMode};

/// Time over which a layer gains its effect, if it begins after the motion, or loses it, if it ends before, s.
const FADE_S: f64 = 0.3;
/// Longest motion, s, as for keys; and the most rows, which are two hours at 500 Hz.
const DURATION_MAX_S: f64 = 7200.0;
const ROWS_MAX: f64 = 3.6e6;

/// A motion to which layers are applied.
#[derive(Debug, Clone)]
pub struct LayeredMotion {
    /// The motion.
    pub motion: RigMotion,
    /// Time of the first row, s.
    pub start_s: f64,
    /// Whether the motion is a loop. A loop is repeated until the last layer ends.
    pub is_loop: bool,
}

/// A layer that was read from its file.
struct Layer {
    mode: LayerMode,
    weight: f64,
    /// For each body: whether the layer moves its joint.
    moves: Vec<bool>,
    /// Time of the first row, s.
    start_s: f64,
    curve: Curve,
    is_loop: bool,
}

impl LayeredMotion {
    /// Applies layers to the motion, in their order. The result ends with the motion or the layer that ends last; a
    /// loop is repeated until that time, and counts only if all are loops. Also returns a line about each layer.
    ///
    /// # Errors
    /// The error names the layer and the reason.
    pub fn with(
        self,
        rig: &LoadedRig,
        choices: &[LayerChoice],
        units: Option<HeaderUnits>,
    ) -> anyhow::Result<(Self, Vec<String>)> {
        let mechanism = &rig.mechanism;
        let mut lines = Vec::new();
        let mut layers = Vec::new();
        let mut dt_s = self.motion.dt_s;
        for choice in choices {
            let (layer, own_dt_s) = Layer::read(rig, choice, units)
                .with_context(|| format!("--layer {}", choice.text))?;
            dt_s = dt_s.min(own_dt_s);
            lines.push(layer.line(mechanism, choice));
            layers.push(layer);
        }
        let below = Curve::new(mechanism, &self.motion)?;
        let ends = layers.iter().filter(|layer| !layer.is_loop).map(Layer::end_s);
        let own_end_s = self.start_s + self.motion.duration_s();
        let all_loop = self.is_loop && layers.iter().all(|layer| layer.is_loop);
        // A motion that is a loop ends with the last layer that is not a loop.
        let end_s = if self.is_loop && !all_loop {
            ends.fold(f64::NEG_INFINITY, f64::max)
        } else {
            ends.fold(own_end_s, f64::max)
        };
        let duration_s = end_s - self.start_s;
        ensure!(duration_s > dt_s, "--layer: the layers end before the motion begins");
        ensure!(
            duration_s <= DURATION_MAX_S && duration_s / dt_s <= ROWS_MAX,
            "--layer: the layers would make {:.0} rows in {duration_s:.0} s; at most {ROWS_MAX} rows in \
             {DURATION_MAX_S} s are possible: give layers that are near the motion in time, or of a lower rate",
            duration_s / dt_s
        );
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive")]
        let last = (duration_s / dt_s - 1e-6).ceil().max(1.0) as usize;
        let (home, ranges, ties) =
            (mechanism.home(), mechanism.coordinate_ranges(), mechanism.ties());
        let (mut instant, mut own) = (Instant::default(), Instant::default());
        let mut rows = Vec::with_capacity(last + 1);
        for row in 0..=last {
            let time_s = row as f64 * dt_s;
            below.at(within(time_s, below.duration_s(), self.is_loop), &mut instant);
            let mut q = std::mem::take(&mut instant.q);
            for layer in &layers {
                let since_s = time_s + self.start_s - layer.start_s;
                let weight = layer.weight * layer.presence(since_s, [self.start_s, end_s]);
                if weight == 0.0 {
                    continue;
                }
                layer.curve.at(within(since_s, layer.curve.duration_s(), layer.is_loop), &mut own);
                for (body, range) in
                    ranges.iter().enumerate().filter(|(body, _)| layer.moves[*body])
                {
                    let of = |q: &[f64]| q[range.clone()].to_vec();
                    let free = mechanism.bodies[body].joint == JointModel::Free;
                    let put = blended(layer.mode, weight, [&of(&q), &of(&own.q), &of(&home)], free);
                    q[range.clone()].copy_from_slice(&put);
                }
            }
            ties.follow(&mut q);
            rows.push(q);
        }
        let motion = RigMotion { dt_s, rows };
        motion.check(mechanism)?;
        Ok((Self { motion, start_s: self.start_s, is_loop: all_loop }, lines))
    }
}

impl Layer {
    fn read(
        rig: &LoadedRig,
        choice: &LayerChoice,
        units: Option<HeaderUnits>,
    ) -> anyhow::Result<(Self, f64)> {
        let Some(kind) = OwnMotion::of(&choice.path) else {
            bail!(
                "{}: expected a motion of the rig's own joints: a show, a CSV of keys, or a JSON of servo positions",
                choice.path.display()
            );
        };
        let read = kind.read(rig, &choice.path, units)?;
        let mechanism = &rig.mechanism;
        let mut moves = vec![read.given.is_none(); mechanism.bodies.len()];
        let ranges = mechanism.coordinate_ranges();
        for place in read.given.iter().flatten() {
            let body = ranges.iter().position(|range| range.contains(place));
            moves[body.unwrap_or_default()] = true;
        }
        for pattern in &choice.joints {
            let fits = mechanism.bodies.iter().any(|link| is_named(&link.joint_name, pattern));
            ensure!(fits, "no joint `{pattern}` in {}", rig.description.name);
        }
        for (moves, link) in moves.iter_mut().zip(&mechanism.bodies) {
            let is_chosen = choice.joints.is_empty()
                || choice.joints.iter().any(|pattern| is_named(&link.joint_name, pattern));
            *moves &= is_chosen && link.joint != JointModel::Fixed;
        }
        ensure!(moves.contains(&true), "the file has none of these joints");
        let dt_s = read.motion.dt_s;
        let layer = Self {
            mode: choice.mode,
            weight: choice.weight,
            moves,
            start_s: read.start_s,
            curve: Curve::new(mechanism, &read.motion)?,
            is_loop: read.is_loop,
        };
        Ok((layer, dt_s))
    }

    fn end_s(&self) -> f64 {
        self.start_s + self.curve.duration_s()
    }

    /// Returns the share of the layer's effect at a time after the layer's start. The share rises and falls smoothly,
    /// except where the layer begins or ends with the whole motion.
    fn presence(&self, since_s: f64, [begin_s, end_s]: [f64; 2]) -> f64 {
        let smooth = |share: f64| {
            let x = share.clamp(0.0, 1.0);
            x * x * x * (10.0 + x * (6.0 * x - 15.0))
        };
        // Times may differ by rounding.
        let slack = 1e-6;
        let comes = if self.start_s <= begin_s + slack { 1.0 } else { smooth(since_s / FADE_S) };
        let left_s = self.curve.duration_s() - since_s;
        let goes = if self.is_loop || self.end_s() >= end_s - slack {
            1.0
        } else {
            smooth(left_s / FADE_S)
        };
        comes.min(goes)
    }

    fn line(&self, mechanism: &Mechanism, choice: &LayerChoice) -> String {
        let links = mechanism.bodies.iter().zip(&self.moves).filter(|(_, moves)| **moves);
        let names: Vec<&str> = links.map(|(link, _)| link.joint_name.as_str()).collect();
        let mode = match self.mode {
            LayerMode::Over => "over",
            LayerMode::Add => "added to",
        };
        let weight = self.weight;
        let length = if self.is_loop {
            "a loop".to_owned()
        } else {
            format!("{:.2} to {:.2} s", self.start_s, self.end_s())
        };
        format!(
            "layer {}: {mode} what is below with weight {weight}, {length}: {}",
            choice.path.display(),
            names.join(", ")
        )
    }
}

/// Returns a time within a motion. For a loop, returns the time in the present round; otherwise the nearest time within
/// the motion.
fn within(time_s: f64, duration_s: f64, is_loop: bool) -> f64 {
    if is_loop { time_s.rem_euclid(duration_s) } else { time_s.clamp(0.0, duration_s) }
}

/// Applies a layer to one joint. `[below, layer, home]`: coordinates in the motion below, in the layer, and at home.
fn blended(
    mode: LayerMode,
    weight: f64,
    [below, layer, home]: [&[f64]; 3],
    is_free: bool,
) -> Vec<f64> {
    let turned =
        below.first_chunk::<4>().zip(layer.first_chunk::<4>()).zip(home.first_chunk::<4>());
    let number = |k: usize| match mode {
        LayerMode::Over => below[k] + weight * (layer[k] - below[k]),
        LayerMode::Add => below[k] + weight * (layer[k] - home[k]),
    };
    let Some(((b, l), h)) = turned.filter(|_| below.len() == 4 || is_free) else {
        return (0..below.len()).map(number).collect();
    };
    let [b, l, h] = [b, l, h].map(|q| DQuat::from_array(*q));
    let turn = match mode {
        LayerMode::Over => b.slerp(l, weight),
        LayerMode::Add => {
            let change = (h.conjugate() * l).to_scaled_axis() * weight;
            b * DQuat::from_scaled_axis(change)
        }
    };
    let mut out = turn.normalize().to_array().to_vec();
    out.extend((4..below.len()).map(number));
    out
}

/// Returns whether a name matches a pattern, in which `*` stands for any text.
fn is_named(name: &str, pattern: &str) -> bool {
    match pattern.split_once('*') {
        None => name == pattern,
        Some((begin, rest)) => name.strip_prefix(begin).is_some_and(|name| {
            (0..=name.len())
                .filter(|at| name.is_char_boundary(*at))
                .any(|at| is_named(&name[at..], rest))
        }),
    }
}

#[cfg(test)]
mod tests;
