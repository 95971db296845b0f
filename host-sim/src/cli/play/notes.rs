//! Notes on the control loop before a show plays: its buses, rates and pulses, and the joints without servos.

use sinew_host_util::command::note;
use sinew_performance::play::{Drive, PulseRange, RigParts};

/// Shortest and longest pulse that are safe for usual hobby servos, us.
const SAFE_PULSES_US: [f32; 2] = [1000.0, 2000.0];

/// Prints facts about the loop. `is_here`: whether this program chooses the rates; otherwise the board does.
pub(super) fn tell(parts: &RigParts, is_here: bool) {
    if is_here {
        tell_buses(parts);
    }
    tell_pulses(parts);
    if is_here {
        tell_rate(parts);
    }
    let idle: Vec<&str> = (parts.names.iter().zip(&parts.drives))
        .filter(|(_, drive)| drive.is_none())
        .map(|(name, _)| name.as_str())
        .collect();
    if !idle.is_empty() {
        note(format_args!("no servo moves {}", idle.join(", ")));
    }
}

/// Prints the buses, drives and rates of the loop.
fn tell_buses(parts: &RigParts) {
    for (index, line) in parts.lines.iter().enumerate() {
        let count = line.servos.len();
        let by = |drive| line.servos.iter().filter(|s| parts.servos[**s].drive == drive).count();
        if line.is_of_pulses() {
            note(format_args!(
                "bus {:?}: {count} servos on pulses of a PCA9685, I2C at {} bit/s; {} Hz, nothing is read",
                line.name, line.baud, parts.rate_hz
            ));
            continue;
        }
        let (currents, positions) = (by(Drive::Current), by(Drive::Position));
        let voltages = match by(Drive::Voltage) {
            0 => String::new(),
            voltages => format!("{voltages} by voltage, "),
        };
        let each = match parts.groups(index) {
            1 => "all read in each tick".to_owned(),
            groups => format!("each read once in {groups} ticks"),
        };
        note(format_args!(
            "bus {:?}: {count} servos at {} bit/s, {currents} by current, {voltages}{positions} by position; {} Hz, \
             {each}",
            line.name, line.baud, parts.rate_hz
        ));
    }
}

/// Prints the rate at which a board can run the loop, if that rate differs.
fn tell_rate(parts: &RigParts) {
    let (compute_us, holds) = parts.on_board;
    if holds != Some(parts.rate_hz) {
        let holds =
            holds.map_or_else(|| "no rate of this loop".to_owned(), |hz| format!("{hz} Hz"));
        note(format_args!(
            "{} Hz apply to this simulation only: by estimate, a board of 180 MHz computes {:.1} ms per tick for {} \
             servos, and can run at {holds} (docs/speed.md)",
            parts.rate_hz,
            f64::from(compute_us) / 1000.0,
            parts.servos.len()
        ));
    }
}

/// Prints the pulses for hobby servos at the ends of their joints' ranges.
fn tell_pulses(parts: &RigParts) {
    let all = parts.pulses_us();
    let told = |of: &[&PulseRange<'_>]| {
        let each = of.iter().map(|PulseRange { servo, us: [least, most], .. }| {
            format!("{servo} {:.2} to {:.2} ms", 1e-3 * least, 1e-3 * most)
        });
        each.collect::<Vec<_>>().join(", ")
    };
    let [safe_least, safe_most] = SAFE_PULSES_US;
    // A person has tested the pulses that the rig's file gives.
    let (safe, wide): (Vec<_>, Vec<_>) = (all.iter())
        .partition(|of| of.is_measured || of.us[0] >= safe_least && of.us[1] <= safe_most);
    if !safe.is_empty() {
        note(format_args!("pulses within the joints' ranges: {}", told(&safe)));
    }
    if !wide.is_empty() {
        note(format_args!(
            "warning: pulses outside of 1.0 to 2.0 ms, where many servos stall at an end: try them by hand first: {}",
            told(&wide)
        ));
    }
}
