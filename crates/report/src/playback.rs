//! The playback of a motion: desired and actual positions of the bodies, packed for the page's script.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use glam::DVec3;
use serde::Serialize;
use sinew_evaluation::{Errors, EvaluatedMotion, MethodName, Protocol, RunError};

use super::scene::{Ground, MEASURED_GIRTH, Mannequin, Part, Points};
use super::view::View;

/// Maximum duration of a playback, in seconds.
const LONGEST_S: f64 = 30.0;

/// Approximate time between two stored frames, in seconds, if the motion has that many. The script interpolates between
/// them.
const FRAME_S: f64 = 0.02;

/// One motion, performed by every rig with every method.
#[derive(Debug, Clone, PartialEq)]
pub struct Playback {
    /// Name of the motion.
    pub clip: String,
    /// Whether the motion is longer than the stored part.
    pub cut: bool,
    /// Time between stored frames, in seconds.
    pub dt_s: f64,
    pub(super) view: View,
    pub(super) mannequin: Mannequin,
    pub(super) desired: Vec<Points>,
    pub(super) runs: Vec<Run>,
}

/// The run of one rig with one method.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Run {
    pub(super) scale: f64,
    pub(super) method: MethodName,
    pub(super) mannequin: Mannequin,
    pub(super) measured: Vec<Points>,
    /// Mean errors in each frame: all bodies in degrees and cm, leaves in degrees and cm.
    pub(super) errors: Vec<[f64; 4]>,
}

impl Playback {
    /// Tracks a motion again with every method on its rig of every scale, and stores the visible points. `mannequin` is
    /// the mannequin of the rig in the motion's dimensions; `stream` is the index of the motion among the evaluated
    /// motions.
    ///
    /// # Errors
    /// [`RunError`] of the runs.
    pub fn record<T: EvaluatedMotion>(
        take: &T,
        mannequin: Mannequin,
        protocol: &Protocol,
        stream: u64,
    ) -> Result<Self, RunError> {
        let limit_s = protocol.seconds.map_or(LONGEST_S, |seconds| seconds.min(LONGEST_S));
        // The setup's dimensions apply only to the figure.
        let is_figure = take.rig_name().is_none();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "not negative, and saturates"
        )]
        let every = (FRAME_S / take.dt_s()).round().max(1.0) as usize;
        let mut desired = Vec::new();
        let mut runs = Vec::new();
        for scale in &protocol.scales {
            for method in &protocol.methods {
                let setup = protocol.setup_of(*scale, *method);
                desired.clear();
                let scaled = if is_figure {
                    mannequin.scaled_by(&setup.dimensions.factors())
                } else {
                    mannequin.clone()
                };
                let mut run = Run {
                    scale: *scale,
                    method: *method,
                    mannequin: scaled,
                    measured: Vec::new(),
                    errors: Vec::new(),
                };
                sinew_evaluation::Run::new(take, &setup, Some(limit_s), stream)?.track(|step| {
                    if !(step.frame - 1).is_multiple_of(every) {
                        return;
                    }
                    let mut errors = Errors::default();
                    errors.add_step(&step);
                    let ([deg, cm, ..], [leaf_deg, leaf_cm, ..]) =
                        (errors.all.figures(), errors.leaf.figures());
                    desired.push(mannequin.points(step.desired));
                    run.measured.push(run.mannequin.points(step.measured));
                    run.errors.push([deg, cm, leaf_deg, leaf_cm]);
                })?;
                runs.push(run);
            }
        }
        let dt_s = take.dt_s() * every as f64;
        let cut = take.frame_count() as f64 * take.dt_s() > LONGEST_S + dt_s;
        let view = if is_figure { View::of_figure } else { View::of_rig };
        let view = view(&mannequin, &desired);
        Ok(Self { clip: take.name().to_owned(), cut, dt_s, view, mannequin, desired, runs })
    }

    /// Returns the script's data as JSON that is safe in HTML.
    pub(super) fn json(&self) -> String {
        let tracks = || std::iter::once(&self.desired).chain(self.runs.iter().map(|r| &r.measured));
        let extent_m =
            tracks().flatten().flatten().map(|point| point.abs().max_element()).fold(0.0, f64::max);
        let unit_m = extent_m / f64::from(i16::MAX);
        let document = Document {
            dt_s: self.dt_s,
            frames: self.desired.len(),
            points: self.desired.first().map_or(0, Vec::len),
            start: self.view.frame,
            yaw_rad: self.view.yaw_rad,
            target_m: self.view.target_m.map(|target_m| target_m.to_array()),
            size_m: self.view.size_m,
            unit_m,
            ground: self.view.ground,
            parts: self.mannequin.parts(),
            trunk: self.mannequin.trunk(),
            girth: self.mannequin.girth(),
            desired: pack(&self.desired, unit_m),
            runs: self
                .runs
                .iter()
                .map(|run| PackedRun {
                    scale: run.scale,
                    method: run.method,
                    girth: run.mannequin.girth() * MEASURED_GIRTH,
                    measured: pack(&run.measured, unit_m),
                    errors: pack_errors(&run.errors),
                })
                .collect(),
        };
        let text = serde_json::to_string(&document).expect("plain data turns into JSON");
        // Escaped, to keep a text in it from ending the HTML element.
        text.replace('<', "\\u003c")
    }
}

#[derive(Serialize)]
struct Document<'a> {
    dt_s: f64,
    frames: usize,
    points: usize,
    start: usize,
    yaw_rad: f64,
    /// Target of the camera; `null` if the camera follows the first point.
    target_m: Option<[f64; 3]>,
    size_m: f64,
    unit_m: f64,
    ground: Ground,
    parts: &'a [Part],
    trunk: usize,
    girth: f64,
    /// Points x, y, z of all frames in `unit_m`: i16, little-endian, base64.
    desired: String,
    runs: Vec<PackedRun>,
}

#[derive(Serialize)]
struct PackedRun {
    scale: f64,
    method: MethodName,
    /// Factor on the thickness of the measured mannequin.
    girth: f64,
    measured: String,
    /// The four mean errors of all frames in hundredths: u16, little-endian, base64.
    errors: String,
}

fn pack(track: &[Points], unit_m: f64) -> String {
    let bytes: Vec<u8> = track
        .iter()
        .flatten()
        .flat_map(DVec3::to_array)
        .flat_map(|coordinate| {
            #[expect(
                clippy::cast_possible_truncation,
                reason = "the unit is chosen so that it fits"
            )]
            let steps = libm::round(coordinate / unit_m) as i16;
            steps.to_le_bytes()
        })
        .collect();
    STANDARD.encode(bytes)
}

fn pack_errors(errors: &[[f64; 4]]) -> String {
    let bytes: Vec<u8> = errors
        .iter()
        .flatten()
        .flat_map(|error| {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "not negative, and saturates above 655: a lost figure is no result"
            )]
            let hundredths = libm::round(error * 100.0) as u16;
            hundredths.to_le_bytes()
        })
        .collect();
    STANDARD.encode(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use sinew_figure::fixture::moving;

    #[test]
    fn a_playback_is_bounded_and_fine() {
        let motion = moving("clip", 400);
        let methods = vec![MethodName::Local];
        let protocol = Protocol { methods, seconds: Some(2.0), ..Protocol::default() };
        let playback =
            Playback::record(&motion, Mannequin::of_figure(&motion), &protocol, 0).unwrap();
        assert_eq!(playback.runs.len(), 2);
        // 200 frames are 198 steps, of which every second is stored.
        assert_eq!(playback.desired.len(), 99);
        let unit_m: f64 =
            serde_json::from_str::<serde_json::Value>(&playback.json()).unwrap()["unit_m"]
                .as_f64()
                .unwrap();
        assert!(unit_m < 1e-3, "finer than a millimetre: {unit_m}");
        let bytes = STANDARD.decode(pack(&playback.desired, unit_m)).unwrap();
        let coordinates: Vec<f64> = bytes
            .chunks(2)
            .map(|two| f64::from(i16::from_le_bytes([two[0], two[1]])) * unit_m)
            .collect();
        for (packed, point) in coordinates.chunks(3).zip(playback.desired.iter().flatten()) {
            assert!(DVec3::from_slice(packed).distance(*point) < unit_m);
        }
    }
}
