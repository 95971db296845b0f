//! The opening of a mouth, from the loudness of a sound.

use super::RATE_HZ;

/// Number of intervals of which a level is the root mean square: 20 ms.
const WINDOW: usize = 4;
/// Share of the intervals above the gate whose level does not open the mouth fully.
const FULL_SHARE: f64 = 0.95;

/// Settings of an envelope.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EnvelopeSettings {
    /// Time constant of opening, s.
    pub attack_s: f64,
    /// Time constant of closing, s.
    pub release_s: f64,
    /// Level below which the mouth is closed, dB relative to the loudest 20 ms.
    pub gate_db: f64,
    /// Time by which the mouth moves earlier, s. Without it, attack and window delay the mouth by about 20 ms.
    pub lead_s: f64,
}

impl Default for EnvelopeSettings {
    fn default() -> Self {
        Self { attack_s: 0.015, release_s: 0.04, gate_db: -35.0, lead_s: 0.02 }
    }
}

/// Returns the opening of a mouth at [`RATE_HZ`], from 0 (closed) to 1. The level is the root mean square of 20 ms. The
/// opening rises in proportion from 0 at the gate to 1 at the level that a twentieth of the intervals above the gate
/// exceeds; it then follows with the attack and the release, and is moved earlier by the lead. After the sound the
/// mouth closes: the last value is 0.
pub fn envelope(squares: &[f64], settings: EnvelopeSettings) -> Vec<f64> {
    let level = |at: usize| {
        let window = &squares[at.saturating_sub(WINDOW / 2)..(at + WINDOW / 2).min(squares.len())];
        (window.iter().sum::<f64>() / window.len().max(1) as f64).sqrt()
    };
    let levels: Vec<f64> = (0..squares.len()).map(level).collect();
    let loudest = levels.iter().copied().fold(0.0, f64::max);
    let gate = loudest * libm::pow(10.0, settings.gate_db / 20.0);
    let mut loud: Vec<f64> = levels.iter().copied().filter(|level| *level > gate).collect();
    loud.sort_unstable_by(f64::total_cmp);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a share of the length"
    )]
    let full = loud.get((FULL_SHARE * loud.len() as f64) as usize).copied().unwrap_or(loudest);
    let span = (full - gate).max(f64::MIN_POSITIVE);
    let share =
        |time_constant_s: f64| 1.0 - libm::exp(-1.0 / (RATE_HZ * time_constant_s.max(1e-6)));
    let [attack, release] = [settings.attack_s, settings.release_s].map(share);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "seconds, positive"
    )]
    let [lead, tail] = [settings.lead_s, 7.0 * settings.release_s]
        .map(|time_s| (time_s.max(0.0) * RATE_HZ).round() as usize);
    let mut opening: f64 = 0.0;
    let mut openings: Vec<f64> = levels
        .iter()
        .map(|level| ((level - gate) / span).clamp(0.0, 1.0))
        .chain(std::iter::repeat_n(0.0, tail + lead + 1))
        .map(|target| {
            opening += (target - opening) * if target > opening { attack } else { release };
            opening
        })
        .skip(lead)
        .collect();
    if let Some(last) = openings.last_mut() {
        *last = 0.0;
    }
    openings
}
