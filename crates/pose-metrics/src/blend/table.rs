//! Writes the result of a blend as text and JSON.

use std::fmt::Write as _;

use serde::Serialize;

use super::nearest::Nearest;
use super::transition::Blend;

/// A blend with the reported values.
#[derive(Debug, Clone, Copy)]
pub struct Outcome<'a> {
    /// The first clip.
    pub a: Side<'a>,
    /// The second clip.
    pub b: Side<'a>,
    /// The nearest pair of frames, in the middle of the blend.
    pub nearest: &'a Nearest,
    /// Length in space of the straight line between the joint coordinates of the nearest frames, m.
    pub line_m: f64,
    /// The blended motion.
    pub blend: &'a Blend,
    /// Scale factor of the second clip's motion through space.
    pub scale: f64,
}

/// A clip, and the times of its frames in its file.
#[derive(Debug, Clone, Copy)]
pub struct Side<'a> {
    /// Name of the clip.
    pub name: &'a str,
    /// Time of the clip's first frame in the file, in seconds.
    pub start_s: f64,
    /// Frames per second of the file.
    pub file_rate_hz: f64,
}

impl Side<'_> {
    /// Returns the time in the file for a frame at the blend's rate, and the nearest frame of the file.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a frame of the file"
    )]
    fn place(&self, frame: usize, frame_time_s: f64) -> FrameTime {
        let time_s = self.start_s + frame as f64 * frame_time_s;
        FrameTime { time_s, frame: libm::round(time_s * self.file_rate_hz) as usize }
    }
}

#[derive(Serialize, Clone, Copy)]
struct FrameTime {
    time_s: f64,
    frame: usize,
}

impl std::fmt::Display for FrameTime {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:.3} s (frame {})", self.time_s, self.frame)
    }
}

impl Outcome<'_> {
    /// Returns the places where the first clip is left and the second is entered, and the middle of the blend in
    /// both.
    fn places(&self) -> [FrameTime; 4] {
        let Self { a, b, nearest, blend, .. } = self;
        let half = (blend.last - blend.first) / 2;
        let dt_s = blend.clip.frame_time_s;
        [
            a.place(nearest.a - half, dt_s),
            b.place(nearest.b - half, dt_s),
            a.place(nearest.a, dt_s),
            b.place(nearest.b, dt_s),
        ]
    }

    fn seconds(&self) -> f64 {
        (self.blend.last - self.blend.first) as f64 * self.blend.clip.frame_time_s
    }
}

/// Returns the report as text, one line per value.
pub fn text(outcome: &Outcome<'_>) -> String {
    let Outcome { a, b, nearest, line_m, blend, scale } = outcome;
    let [leaves, enters, middle_a, middle_b] = outcome.places();
    let mut text = String::new();
    let mut line = |name: &str, value: String| {
        writeln!(text, "{name:<18}{value}").expect("a string takes everything");
    };
    line("leaves", format!("{} at {leaves}", a.name));
    line("enters", format!("{} at {enters}", b.name));
    line(
        "nearest",
        format!(
            "{middle_a} and {middle_b}, in the middle of a blend of {:.3} s",
            outcome.seconds()
        ),
    );
    line(
        "distance there",
        format!(
            "geodesic {:.4} m, line {line_m:.4} m, positions {:.4} m",
            nearest.geodesic_m, nearest.positions_m
        ),
    );
    line(
        "found",
        format!("of {} pairs of frames, {} geodesics solved", nearest.pairs, nearest.solved),
    );
    line(
        "iterations",
        format!("{} there, at most {} in the blend", nearest.iterations, blend.iterations),
    );
    if nearest.gave_up + blend.gave_up > 0 {
        let (found, blended) = (nearest.gave_up, blend.gave_up);
        line("not converged", format!("{found} of the search, {blended} of the blend"));
    }
    if blend.gave_up > 0 {
        line(
            "way",
            "every joint on its own shortest path, because geodesics did not converge".into(),
        );
    }
    line(
        "body",
        format!(
            "{} turned by {:.1}° about the vertical, its way through space times {scale:.3}; what is left to blend: {:.1}°, {:.3} m up",
            b.name,
            blend.turn_rad.to_degrees(),
            blend.tilt_rad.to_degrees(),
            blend.rise_m
        ),
    );
    line(
        "fastest joint",
        format!(
            "{} {:.2} m/s in the blend; {} {:.2} m/s in the clips meanwhile",
            blend.fastest.joint,
            blend.fastest.speed_m_s,
            blend.fastest_alone.joint,
            blend.fastest_alone.speed_m_s
        ),
    );
    line("written", format!("{} frames", blend.clip.frames.len()));
    text
}

#[derive(Serialize)]
struct Document<'a> {
    schema: &'static str,
    a: &'a str,
    b: &'a str,
    leaves_a: FrameTime,
    enters_b: FrameTime,
    middle_a: FrameTime,
    middle_b: FrameTime,
    blend_s: f64,
    geodesic_m: f64,
    line_m: f64,
    positions_m: f64,
    pairs: usize,
    solved: usize,
    iterations: usize,
    iterations_most: usize,
    not_converged: usize,
    /// Kind of path of the poses: `geodesics`, or `joints` if each joint moves on its own path.
    way: &'static str,
    turn_rad: f64,
    scale: f64,
    tilt_rad: f64,
    rise_m: f64,
    fastest_joint: &'a str,
    fastest_m_s: f64,
    fastest_alone_joint: &'a str,
    fastest_alone_m_s: f64,
    frames: usize,
}

/// Returns the report as one JSON object, schema `sinew-blend/1`.
pub fn json(outcome: &Outcome<'_>) -> String {
    let Outcome { a, b, nearest, line_m, blend, scale } = outcome;
    let [leaves_a, enters_b, middle_a, middle_b] = outcome.places();
    let document = Document {
        schema: "sinew-blend/1",
        a: a.name,
        b: b.name,
        leaves_a,
        enters_b,
        middle_a,
        middle_b,
        blend_s: outcome.seconds(),
        geodesic_m: nearest.geodesic_m,
        line_m: *line_m,
        positions_m: nearest.positions_m,
        pairs: nearest.pairs,
        solved: nearest.solved,
        iterations: nearest.iterations,
        iterations_most: blend.iterations,
        not_converged: nearest.gave_up + blend.gave_up,
        way: if blend.gave_up > 0 { "joints" } else { "geodesics" },
        turn_rad: blend.turn_rad,
        scale: *scale,
        tilt_rad: blend.tilt_rad,
        rise_m: blend.rise_m,
        fastest_joint: &blend.fastest.joint,
        fastest_m_s: blend.fastest.speed_m_s,
        fastest_alone_joint: &blend.fastest_alone.joint,
        fastest_alone_m_s: blend.fastest_alone.speed_m_s,
        frames: blend.clip.frames.len(),
    };
    serde_json::to_string_pretty(&document).expect("all keys are texts") + "\n"
}
