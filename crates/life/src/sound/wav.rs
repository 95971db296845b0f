//! The loudness of a WAV file over time.

use std::io::Read;

use hound::{Sample, SampleFormat, WavReader};
use thiserror::Error;

use super::RATE_HZ;

/// Longest sound that is read, s.
const DURATION_MAX_S: f64 = 7200.0;

/// The loudness of a sound over time, at [`RATE_HZ`].
#[derive(Debug, Clone, PartialEq)]
pub struct Levels {
    /// Mean square of all samples of all channels in each interval; full scale is 1.
    pub squares: Vec<f64>,
    /// Duration of the sound, s.
    pub duration_s: f64,
    /// Sample rate of the file, Hz.
    pub sample_rate_hz: u32,
    /// Number of channels of the file.
    pub channels: u16,
}

/// The reason why a file is not a sound that can be read.
#[derive(Debug, Error)]
pub enum SoundError {
    /// The file is not WAV, or is damaged.
    #[error(
        "expected a WAV file with PCM or float samples: {0}; `ffmpeg -i IN -ac 1 OUT.wav` converts other sounds"
    )]
    Wav(#[from] hound::Error),
    /// The sample rate is outside 4 to 384 kHz, or there is no channel.
    #[error(
        "expected a sample rate from 4000 to 384000 Hz and at least one channel, found {rate_hz} Hz and {channels}"
    )]
    Format {
        /// Sample rate, Hz.
        rate_hz: u32,
        /// Number of channels.
        channels: u16,
    },
    /// The sound is too long.
    #[error("expected a sound of at most {DURATION_MAX_S} s")]
    TooLong,
    /// A sample is NaN or infinite.
    #[error("sample {0}: expected a finite number")]
    NotFinite(usize),
    /// The sound is empty, or all its samples are zero.
    #[error("the sound is silent: no sample differs from zero")]
    Silent,
}

/// Returns the duration of a WAV file, s.
///
/// # Errors
/// [`SoundError`] if the file is not a WAV with a supported rate, or the sound is too long.
pub fn duration_s(file: impl Read) -> Result<f64, SoundError> {
    let reader = WavReader::new(file)?;
    let spec = reader.spec();
    if !(4000..=384_000).contains(&spec.sample_rate) || spec.channels == 0 {
        return Err(SoundError::Format { rate_hz: spec.sample_rate, channels: spec.channels });
    }
    let duration_s = f64::from(reader.duration()) / f64::from(spec.sample_rate);
    if duration_s > DURATION_MAX_S { Err(SoundError::TooLong) } else { Ok(duration_s) }
}

/// Reads the loudness of a WAV file. The memory depends on the duration, not on the sample rate.
///
/// # Errors
/// [`SoundError`] if the file is not WAV or is damaged, its sample rate is unusual, a sample is not finite, or the
/// sound is too long or silent.
pub fn levels(file: impl Read) -> Result<Levels, SoundError> {
    let reader = WavReader::new(file)?;
    let spec = reader.spec();
    if !(4000..=384_000).contains(&spec.sample_rate) || spec.channels == 0 {
        return Err(SoundError::Format { rate_hz: spec.sample_rate, channels: spec.channels });
    }
    match spec.sample_format {
        SampleFormat::Float => squares::<f32>(reader, 1.0, f64::from),
        SampleFormat::Int => {
            let full = libm::ldexp(1.0, i32::from(spec.bits_per_sample) - 1);
            squares::<i32>(reader, full, f64::from)
        }
    }
}

fn squares<S: Sample>(
    reader: WavReader<impl Read>,
    full: f64,
    wide: fn(S) -> f64,
) -> Result<Levels, SoundError> {
    let spec = reader.spec();
    let (rate_hz, channels) = (f64::from(spec.sample_rate), usize::from(spec.channels));
    let (mut levels, mut sum, mut count, mut samples) = (Vec::new(), 0.0, 0_u32, 0_usize);
    for sample in reader.into_samples::<S>() {
        let sample = wide(sample?) / full;
        if !sample.is_finite() {
            return Err(SoundError::NotFinite(samples));
        }
        sum += sample * sample;
        count += 1;
        samples += 1;
        if samples.is_multiple_of(channels) {
            let time_s = (samples / channels) as f64 / rate_hz;
            if time_s > DURATION_MAX_S {
                return Err(SoundError::TooLong);
            }
            // An interval of 44.1 kHz has 220 or 221 samples.
            if time_s * RATE_HZ >= (levels.len() + 1) as f64 {
                levels.push(sum / f64::from(count));
                (sum, count) = (0.0, 0);
            }
        }
    }
    if count > 0 {
        levels.push(sum / f64::from(count));
    }
    if levels.iter().all(|square| *square <= 0.0) {
        return Err(SoundError::Silent);
    }
    Ok(Levels {
        squares: levels,
        duration_s: (samples / channels) as f64 / rate_hz,
        sample_rate_hz: spec.sample_rate,
        channels: spec.channels,
    })
}
