//! Checks a motion and the settings.

use super::error::WriteError;
use super::motion::Motion;
use super::settings::Settings;
use crate::joint::Joint;
use crate::layout::{LARGEST, LONGEST};
use crate::position::Rate;

pub(super) fn per_sample(motion: &Motion<'_>) -> usize {
    motion.joints.iter().map(|joint| joint.coordinate_count()).sum()
}

/// Refuses invalid values; returns the number of samples.
pub(super) fn check(motion: &Motion<'_>, settings: &Settings) -> Result<usize, WriteError> {
    let per_sample = per_sample(motion);
    let found = motion.q.len();
    let least = if motion.is_loop { 8 } else { 2 };
    if per_sample == 0 || !found.is_multiple_of(per_sample) || found / per_sample < least {
        return Err(WriteError::Count { found, per_sample, least });
    }
    let samples = found / per_sample;
    for (what, found, most) in [
        ("samples", samples, LONGEST as usize),
        ("joints", motion.joints.len(), usize::from(u16::MAX)),
        ("coordinates", per_sample, usize::from(u16::MAX)),
        ("cues", motion.cues.len(), usize::from(u16::MAX)),
        ("pairs of the course", motion.course.len(), usize::from(u16::MAX)),
    ] {
        if found > most {
            return Err(WriteError::TooMuch { what, found, most });
        }
    }
    let Rate { samples: num, seconds: den } = motion.rate;
    let settings = [
        (
            "the rate's numerator",
            f64::from(num),
            1.0,
            f64::from(Rate::MOST_SAMPLES),
            "from 1 to 2^20",
        ),
        (
            "the rate's denominator",
            f64::from(den),
            1.0,
            f64::from(Rate::MOST_SECONDS),
            "from 1 to 4095",
        ),
        ("the largest error of angles", settings.angle_rad, 1e-5, 1.0, "from 1e-5 to 1 rad"),
        ("the largest error of displacements", settings.length_m, 1e-6, 1.0, "from 1e-6 to 1 m"),
        ("the length of a block", settings.block_s, 0.1, 60.0, "from 0.1 to 60 s"),
        ("the step", settings.step, 1e-3, 1.0, "from 0.001 to 1"),
    ];
    for (name, value, least, most, must) in settings {
        // Written so that NaN is refused.
        if !(least <= value && value <= most) {
            return Err(WriteError::Setting { name, value, must });
        }
    }
    for (sample, q) in motion.q.chunks_exact(per_sample).enumerate() {
        if let Some(coordinate) = q.iter().position(|x| x.is_nan() || x.abs() > f64::from(LARGEST))
        {
            return Err(WriteError::Number { sample, coordinate, value: q[coordinate] });
        }
        let mut first = 0;
        for (joint, kind) in motion.joints.iter().enumerate() {
            if kind.turns_freely() {
                let squared: f64 = q[first..first + 4].iter().map(|x| x * x).sum();
                if (squared - 1.0).abs() > 1e-3 {
                    return Err(WriteError::NotUnit { sample, joint, squared });
                }
            }
            first += kind.coordinate_count();
        }
    }
    check_steps(motion, per_sample)?;
    let mut before = (0, 0);
    for (pair, now) in motion.course.iter().enumerate() {
        if now.0 <= before.0 || now.1 < before.1 || now.0.max(now.1) > LONGEST {
            return Err(WriteError::Course { pair });
        }
        before = *now;
    }
    let mut last = 0;
    for (cue, (sample, name)) in motion.cues.iter().enumerate() {
        let why = if *sample < last {
            "is before the one above it"
        } else if name.len() > 255 {
            "has a name of more than 255 bytes"
        } else if *sample as usize > samples {
            "is after the end"
        } else {
            last = *sample;
            continue;
        };
        return Err(WriteError::Cue { cue, why });
    }
    Ok(samples)
}

/// Refuses angles that jump by more than half a turn, and loops whose last sample is not close to the first.
fn check_steps(motion: &Motion<'_>, per_sample: usize) -> Result<(), WriteError> {
    let mut first = 0;
    for (joint, kind) in motion.joints.iter().enumerate() {
        let numbers = first..first + kind.coordinate_count();
        first = numbers.end;
        // Both signs of a quaternion are the same rotation.
        let numbers = if kind.turns_freely() { numbers.start + 4..numbers.end } else { numbers };
        for coordinate in numbers {
            let at = |sample: usize| motion.q[sample * per_sample + coordinate];
            let samples = motion.q.len() / per_sample;
            let is_angle = matches!(kind, Joint::Revolute | Joint::Universal);
            let mut largest = 0.0f64;
            for sample in 1..samples {
                let step = (at(sample) - at(sample - 1)).abs();
                if is_angle && step > std::f64::consts::PI {
                    return Err(WriteError::Leap { joint, sample, step });
                }
                largest = largest.max(step);
            }
            let seam = (at(0) - at(samples - 1)).abs();
            if motion.is_loop && seam > 2.0 * largest {
                return Err(WriteError::Seam { joint, seam, largest });
            }
        }
    }
    Ok(())
}
