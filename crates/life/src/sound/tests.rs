use std::io::Cursor;

use hound::{SampleFormat, WavSpec, WavWriter};
use proptest::prelude::*;
use sinew_rig::new::face;

use super::*;

/// Returns a WAV file of a sound. `sound` returns its value at a time, s; all channels are the same.
#[expect(clippy::cast_possible_truncation, reason = "a sample of 16 bits")]
fn wav(rate_hz: u32, channels: u16, seconds: f64, sound: impl Fn(f64) -> f64) -> Vec<u8> {
    let spec = WavSpec {
        channels,
        sample_rate: rate_hz,
        bits_per_sample: 16,
        sample_format: SampleFormat::Int,
    };
    let mut bytes = Cursor::new(Vec::new());
    let mut writer = WavWriter::new(&mut bytes, spec).unwrap();
    let rate_hz = f64::from(rate_hz);
    for index in (0_u32..).map(f64::from).take_while(|index| *index < seconds * rate_hz) {
        let value = sound(index / rate_hz);
        for _ in 0..channels {
            writer.write_sample((value * 32767.0) as i16).unwrap();
        }
    }
    writer.finalize().unwrap();
    bytes.into_inner()
}

/// Returns the value of a tone of 200 Hz that is loud from 0.5 s to 1 s.
fn burst(time_s: f64) -> f64 {
    let tone = libm::sin(std::f64::consts::TAU * 200.0 * time_s);
    if (0.5..1.0).contains(&time_s) { 0.5 * tone } else { 0.001 * tone }
}

fn opening(bytes: &[u8]) -> Vec<f64> {
    envelope(&levels(bytes).unwrap().squares, EnvelopeSettings::default())
}

/// Returns the time, s, at which an opening first crosses a half upwards (`above`) or downwards, from a row on.
fn crosses(opening: &[f64], from: usize, above: bool) -> f64 {
    let row = (from..opening.len()).find(|row| (opening[*row] > 0.5) == above).unwrap();
    row as f64 / RATE_HZ
}

#[test]
fn a_mouth_opens_with_the_sound_and_closes_after_it() {
    let opening = opening(&wav(22_050, 1, 1.5, burst));
    let (opens_s, closes_s) = (crosses(&opening, 0, true), crosses(&opening, 160, false));
    assert!((0.46..0.52).contains(&opens_s), "{opens_s}");
    assert!((0.98..1.05).contains(&closes_s), "{closes_s}");
    assert!(opening[190] > 0.95 && opening[..90].iter().all(|open| *open == 0.0));
    assert!(opening.last() == Some(&0.0));
    let lead = EnvelopeSettings { lead_s: 0.1, ..EnvelopeSettings::default() };
    let early = envelope(&levels(&wav(22_050, 1, 1.5, burst)[..]).unwrap().squares, lead);
    assert!((crosses(&early, 0, true) - opens_s + 0.08).abs() < 0.006);
}

#[test]
fn rate_channels_and_loudness_do_not_matter() {
    let one = opening(&wav(22_050, 1, 1.5, burst));
    for other in [
        wav(44_100, 1, 1.5, burst),
        wav(48_000, 2, 1.5, burst),
        wav(22_050, 1, 1.5, |time_s| 0.2 * burst(time_s)),
    ] {
        let other = opening(&other);
        assert_eq!(one.len(), other.len());
        for (a, b) in one.iter().zip(&other) {
            assert!((a - b).abs() < 0.03, "{a} {b}");
        }
    }
}

#[test]
fn what_is_no_sound_is_refused() {
    let told = |bytes: &[u8]| levels(bytes).unwrap_err().to_string();
    assert!(told(b"ID3 of an MP3").contains("ffmpeg"));
    assert!(told(&wav(8000, 1, 0.5, |_| 0.0)).contains("silent"));
    assert!(told(&wav(100, 1, 0.5, burst)).contains("4000"));
    let whole = wav(8000, 1, 1.0, burst);
    assert!(levels(&whole[..whole.len() / 2]).is_err());
}

#[test]
fn a_jaw_takes_its_range_from_the_rig_and_keeps_its_limits() {
    let mechanism = face().mechanism().unwrap();
    let jaw = Jaw::of(&mechanism, "jaw").unwrap();
    assert!(
        (jaw.closed_rad.to_degrees() + 0.3).abs() < 1e-9
            && (jaw.open_rad.to_degrees() + 20.0).abs() < 1e-9
    );
    let motion = jaw.follow(&opening(&wav(22_050, 1, 1.5, burst))).unwrap();
    assert!(motion.smoothed_s > 0.0 && motion.fastest <= 0.9 * jaw.speed + 1e-9);
    assert!(motion.share > 0.1 && motion.share <= 1.0, "{}", motion.share);
    let weak = Jaw { acceleration: 0.3 * jaw.acceleration, ..jaw.clone() };
    let less = weak.follow(&opening(&wav(22_050, 1, 1.5, burst))).unwrap();
    assert!(less.share < 1.0 && less.share < motion.share + 1e-9, "{}", less.share);
    let text = jaw.csv(&motion);
    let read = sinew_retarget::exchange::keys::read(&mechanism, &text, None).unwrap();
    assert!(read.jumps.is_empty() && (read.motion.dt_s - 0.01).abs() < 1e-9);
    assert!(Jaw::of(&mechanism, "mouth").unwrap_err().to_string().contains("jaw"));
    let far = Jaw { open_rad: -1.0, ..jaw.clone() };
    assert!(far.follow(&[0.0]).unwrap_err().to_string().contains("range"));
    let slow = Jaw { speed: 0.01, ..jaw };
    let loud = opening(&wav(22_050, 1, 1.5, burst));
    assert!(slow.follow(&loud).unwrap_err().to_string().contains("too slow"));
}

/// The envelope of a sound like speech correlates with an envelope that is computed in another way: the magnitude of
/// the signal, smoothed by a Gaussian.
#[test]
fn the_jaw_is_the_envelope() {
    let loud = |time_s: f64| {
        let syllable = libm::sin(std::f64::consts::PI * 4.3 * time_s);
        let phrase = 0.6 + 0.4 * libm::sin(1.7 * time_s);
        syllable * syllable * phrase
    };
    let sound =
        |time_s: f64| 0.8 * loud(time_s) * libm::sin(std::f64::consts::TAU * 180.0 * time_s);
    let opening = opening(&wav(16_000, 1, 6.0, sound));
    let jaw = Jaw::of(&face().mechanism().unwrap(), "jaw").unwrap();
    let angles: Vec<f64> = jaw.follow(&opening).unwrap().angles_rad;
    let at = |shift: usize| {
        let pairs = (0..1150).map(|row| (-angles[row + shift], loud(row as f64 / RATE_HZ)));
        correlation(pairs.collect())
    };
    let (lag, best) = (0..20).map(|lag| (lag, at(lag))).max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
    assert!(best > 0.95 && lag as f64 / RATE_HZ < 0.04, "{best} at {lag}");
}

fn correlation(pairs: Vec<(f64, f64)>) -> f64 {
    let count = pairs.len() as f64;
    let (a, b) = pairs.iter().fold((0.0, 0.0), |(a, b), (x, y)| (a + x / count, b + y / count));
    let (mut ab, mut aa, mut bb) = (0.0, 0.0, 0.0);
    for (x, y) in pairs {
        ab += (x - a) * (y - b);
        aa += (x - a) * (x - a);
        bb += (y - b) * (y - b);
    }
    ab / (aa * bb).sqrt()
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    /// An opening is between 0 and 1, ends closed, opens no faster than the attack and closes no faster than the
    /// release.
    #[test]
    fn envelopes_are_openings(
        squares in proptest::collection::vec(0.0..1.0_f64, 1..400),
        attack_s in 0.005..0.1_f64,
        release_s in 0.005..0.3_f64,
        gate_db in -60.0..-6.0_f64,
    ) {
        let settings = EnvelopeSettings { attack_s, release_s, gate_db, lead_s: 0.0 };
        let opening = envelope(&squares, settings);
        prop_assert!(opening.iter().all(|open| (0.0..=1.0).contains(open)));
        prop_assert_eq!(opening.last(), Some(&0.0));
        let step = |time_s: f64| 1.0 - libm::exp(-1.0 / (RATE_HZ * time_s)) + 1e-12;
        for pair in opening.windows(2) {
            prop_assert!(pair[1] - pair[0] <= step(attack_s) && pair[0] - pair[1] <= step(release_s));
        }
    }

    /// Angles are between closed and open, and the motion keeps the limits.
    #[test]
    fn jaws_keep_their_limits(
        opening in proptest::collection::vec(0.0..1.0_f64, 2..200),
        speed in 0.5..20.0_f64,
        acceleration in 10.0..500.0_f64,
    ) {
        let free = Jaw::free("jaw", 0.1, -0.3);
        let jaw = Jaw { speed, acceleration, ..free };
        if let Ok(motion) = jaw.follow(&opening) {
            prop_assert_eq!(motion.angles_rad.len(), opening.len());
            prop_assert!(motion.angles_rad.iter().all(|angle| (-0.3..=0.1).contains(angle)));
            prop_assert!(motion.fastest <= speed && motion.share <= 1.0);
        }
    }
}
