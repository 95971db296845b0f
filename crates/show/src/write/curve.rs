//! Places knots where the motion needs them, and computes control values in whole steps.

use super::fit::fit;
use crate::span::Cubic;
use crate::span_lengths::{RUNGS, span};

/// Samples of a channel. The samples of a loop repeat forever; if it `flips`, every other round has the opposite sign.
pub(super) struct Samples {
    pub(super) values: Vec<f64>,
    pub(super) is_loop: bool,
    pub(super) flips: bool,
}

impl Samples {
    /// Returns the number of samples to the end of the show, or of a round.
    pub(super) fn length(&self) -> i32 {
        let samples = i32::try_from(self.values.len()).expect("checked by `encode`");
        if self.is_loop { samples } else { samples - 1 }
    }

    /// Returns a sample of a loop, in any round.
    fn value(&self, sample: i32) -> f64 {
        let count = i32::try_from(self.values.len()).expect("checked by `encode`");
        let value = self.values[sample.rem_euclid(count).unsigned_abs() as usize];
        let flipped = self.flips && sample.div_euclid(count).rem_euclid(2) == 1;
        if flipped { -value } else { value }
    }

    /// Returns all samples before `end`. After the last sample they continue on a straight line, which only the last
    /// span uses.
    fn continued(&self, end: i32) -> Vec<f64> {
        let count = self.values.len();
        let (before, last) = (self.values[count - 2], self.values[count - 1]);
        let behind = self.length() + 1..end;
        let straight =
            behind.map(|sample| last + (last - before) * f64::from(sample - self.length()));
        let mut values = self.values.clone();
        values.extend(straight);
        values
    }
}

/// Knots with their control values, from two before the start to two after the end; the knots of a loop end at its next
/// round.
#[derive(Debug, Clone, Default)]
pub(super) struct Curve {
    pub(super) knots: Vec<i32>,
    pub(super) controls: Vec<i32>,
}

/// Desired lengths of spans, sample by sample.
pub(super) struct Spans {
    pub(super) wanted: Vec<f64>,
    longest: i32,
}

impl Spans {
    pub(super) fn new(samples: &Samples, first: f64, longest: i32) -> Self {
        Self { wanted: vec![first; samples.values.len()], longest }
    }

    /// Sets the desired lengths to the distances between these knots.
    pub(super) fn begin_with(&mut self, knots: &[i32]) {
        for span in knots.windows(2) {
            let [from, to] =
                [span[0], span[1]].map(|k| (k.unsigned_abs() as usize).min(self.wanted.len()));
            self.wanted[from..to].fill(f64::from(span[1] - span[0]));
        }
    }

    /// Returns knots from 0 to the end or beyond; the knots of a loop end exactly at its end.
    pub(super) fn knots(&self, samples: &Samples) -> Vec<i32> {
        let length = samples.length();
        let index = |sample: i32| (sample.unsigned_abs() as usize).min(self.wanted.len());
        let mut knots = vec![0];
        let mut at = 0;
        while at < length || (!samples.is_loop && at == length) {
            // The longest span that is desired at all its samples.
            let mut best = 1;
            let (mut least, mut seen) = (f64::INFINITY, at);
            for len in (0..RUNGS).map(span).take_while(|len| *len <= self.longest) {
                for wanted in &self.wanted[index(seen)..index(at + len)] {
                    if *wanted < least {
                        least = *wanted;
                    }
                }
                seen = at + len;
                if f64::from(len) > least || (samples.is_loop && at + len > length) {
                    break;
                }
                best = len;
            }
            at += best;
            knots.push(at);
        }
        knots
    }
}

impl Curve {
    /// Returns the spline with these knots (from 0 on) that is nearest to the samples, with control values in whole
    /// steps.
    pub(super) fn new(samples: &Samples, knots: &[i32], step: f64) -> Self {
        if samples.is_loop {
            Self::looped(samples, knots, step)
        } else {
            Self::open(samples, knots, step)
        }
    }

    fn open(samples: &Samples, knots: &[i32], step: f64) -> Self {
        let [head, .., tail] =
            [knots[1], knots[1], knots[knots.len() - 1] - knots[knots.len() - 2]];
        let end = knots[knots.len() - 1];
        let mut all = vec![-2 * head, -head];
        all.extend(knots);
        all.extend([end + tail, end + 2 * tail]);
        let controls = fit(&all, &samples.continued(end));
        Self { knots: all, controls: rounded(&controls, step) }
    }

    fn looped(samples: &Samples, knots: &[i32], step: f64) -> Self {
        // Enough knots of the rounds before and after that the effect of more is negligible.
        const APART: usize = 32;
        let spans = knots.len() - 1;
        let length = samples.length();
        let knot = |index: isize| {
            let spans = spans.cast_signed();
            let round = i32::try_from(index.div_euclid(spans)).expect("few rounds");
            knots[index.rem_euclid(spans).unsigned_abs()] + round * length
        };
        let apart = APART.cast_signed();
        let all: Vec<i32> = (-apart..spans.cast_signed() + apart).map(knot).collect();
        let within = all[2]..all[all.len() - 3];
        let controls = fit(&all, &within.map(|sample| samples.value(sample)).collect::<Vec<_>>());
        let from = APART - 2;
        Self {
            knots: all[from..from + spans].to_vec(),
            controls: rounded(&controls[from..from + spans], step),
        }
    }

    /// Returns knots and control values in the order of a player, up to three after the end.
    fn unrolled(&self, samples: &Samples) -> (Vec<i32>, Vec<i32>) {
        let (mut knots, mut controls) = (self.knots.clone(), self.controls.clone());
        if samples.is_loop {
            let mut at = 0;
            let mut round = samples.length();
            let mut sign = if samples.flips { -1 } else { 1 };
            for _ in 0..6 {
                knots.push(self.knots[at] + round);
                controls.push(self.controls[at] * sign);
                at += 1;
                if at == self.knots.len() {
                    at = 0;
                    round += samples.length();
                    sign = if samples.flips { -sign } else { sign };
                }
            }
        }
        (knots, controls)
    }

    /// Returns the curve at all samples, as the player evaluates it.
    pub(super) fn played(&self, samples: &Samples, step: f32) -> Vec<f32> {
        let (knots, controls) = self.unrolled(samples);
        let count = samples.values.len();
        let last = i32::try_from(count).expect("checked by `encode`");
        let mut played = Vec::with_capacity(count);
        for (first, window) in knots.windows(6).enumerate() {
            let window: [i32; 6] = window.try_into().expect("windows of six");
            let controls = controls[first + 1..first + 5].try_into().expect("four of them");
            let cubic = Cubic::new(&window, controls, step);
            let places = 0..window[3].min(last) - window[2];
            played.extend(places.map(|place| cubic.at(place as f32)[0]));
        }
        played
    }
}

fn rounded(controls: &[f64], step: f64) -> Vec<i32> {
    #[expect(
        clippy::cast_possible_truncation,
        reason = "it saturates, and the writer checks the range"
    )]
    let round = |control: &f64| libm::round(control / step) as i32;
    controls.iter().map(round).collect()
}
