//! Pulses that servos get within the ranges of their joints.

use super::pulses::pulse_us;
use super::rig_parts::RigParts;
use super::servo_part::Drive;

/// Pulses of a servo while its joints move within their ranges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PulseRange<'a> {
    /// Name of the servo.
    pub servo: &'a str,
    /// Shortest and longest pulse, us.
    pub us: [f32; 2],
    /// Whether the rig's file gives the pulses of this servo.
    pub is_measured: bool,
}

impl RigParts {
    /// Returns the pulses of all servos that are driven by pulses.
    pub fn pulses_us(&self) -> Vec<PulseRange<'_>> {
        let mut all = Vec::new();
        for drive in self.board.drives() {
            let ranges: Vec<[f32; 2]> =
                (drive.dofs.iter()).map(|dof| self.board.dofs()[usize::from(*dof)].range).collect();
            // Shafts are farthest where each joint is at an end of its range.
            let corners: Vec<Vec<f32>> = (0..1_usize << ranges.len())
                .map(|corner| {
                    ranges.iter().enumerate().map(|(at, ends)| ends[(corner >> at) & 1]).collect()
                })
                .collect();
            for (place, servo) in drive.servos.iter().map(|at| usize::from(*at)).enumerate() {
                let part = &self.servos[servo];
                if part.drive != Drive::Pulses {
                    continue;
                }
                let own = self.board.servos()[servo].servo.settings();
                let [least, most] = own.range_rad;
                let mut pulses = [f32::INFINITY, f32::NEG_INFINITY];
                for q in &corners {
                    // A joint without a limit moves as far as its servo.
                    let ends = drive.drive.at_joints(q).map_or(own.range_rad, |pose| {
                        [own.gear * pose.servos()[place] + own.offset_rad; 2]
                    });
                    for us in ends.map(|rad| pulse_us(part, rad.clamp(least, most))) {
                        pulses = [pulses[0].min(us), pulses[1].max(us)];
                    }
                }
                let is_measured = part.own.kind.pulses.is_measured;
                all.push(PulseRange { servo: &part.own.name, us: pulses, is_measured });
            }
        }
        all
    }
}
