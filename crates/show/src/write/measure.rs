//! Measures the error of a show at its samples, as it is played.

use super::error::WriteError;
use super::motion::Motion;
use super::refine::angle_between;
use super::settings::Settings;
use crate::joint::Joint;
use crate::player::Player;
use crate::position::Position;
use crate::show::Show;

/// Errors at the samples, as the decoder plays them.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Errors {
    /// Maximum error.
    pub largest: f64,
    /// Root mean square error, over all joints and samples.
    pub rms: f64,
    squares: f64,
    count: usize,
}

impl Errors {
    fn add(&mut self, error: f64) {
        self.largest = self.largest.max(error);
        self.squares += error * error;
        self.count += 1;
        self.rms = libm::sqrt(self.squares / self.count as f64);
    }
}

/// Measures the errors of a show at its samples: of angles and rotations in rad, and of displacements in m. Refuses an
/// error beyond its bound.
pub(super) fn measure(
    bytes: &[u8],
    motion: &Motion<'_>,
    settings: &Settings,
) -> Result<(Errors, Errors), WriteError> {
    const MOST: usize = 512;
    let show = Show::open(bytes).expect("a show that was just written opens");
    let mut player = Player::<MOST>::new(show).map_err(|_| WriteError::TooMuch {
        what: "coordinates",
        found: show.channel_count(),
        most: MOST,
    })?;
    let (mut angles, mut lengths) = (Errors::default(), Errors::default());
    let mut q = vec![0.0; show.channel_count()];
    let mut qd = vec![0.0; show.dof_count()];
    let mut qdd = qd.clone();
    for (sample, wanted) in (0u32..).zip(motion.q.chunks_exact(show.channel_count())) {
        let played = player.state_at(Position::from_samples(sample), &mut q, &mut qd, &mut qdd);
        played.expect("a show that was just written plays");
        let mut first = 0;
        for (joint, kind) in motion.joints.iter().enumerate() {
            let mut add = |error: f64, is_angle: bool| {
                let (errors, bound, unit) = if is_angle {
                    (&mut angles, settings.angle_rad, "rad")
                } else {
                    (&mut lengths, settings.length_m, "m")
                };
                errors.add(error);
                let sample = sample as usize;
                if error <= bound {
                    Ok(())
                } else {
                    Err(WriteError::Bound { joint, sample, error, bound, unit })
                }
            };
            let range = first..first + kind.coordinate_count();
            first = range.end;
            let (played, wanted) = (&q[range.clone()], &wanted[range]);
            let numbers = if kind.turns_freely() {
                let played: Vec<f64> = played[..4].iter().map(|x| f64::from(*x)).collect();
                add(angle_between(&played, &wanted[..4]), true)?;
                4..
            } else {
                0..
            };
            let is_angle = matches!(kind, Joint::Revolute | Joint::Universal);
            for (played, wanted) in played[numbers.clone()].iter().zip(&wanted[numbers]) {
                add((f64::from(*played) - wanted).abs(), is_angle)?;
            }
        }
    }
    Ok((angles, lengths))
}
