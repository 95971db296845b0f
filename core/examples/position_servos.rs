//! An arm of two joints follows frames of joint angles. Its encoders measure no speeds, and its servos accept
//! positions.

use sinew_core::coordinates::DofCommand;
use sinew_core::math;
use sinew_core::prelude::*;

const DT_S: f32 = 0.002;

/// Both joints swing by 0.5 rad: positions, speeds and accelerations.
struct Swing([[f32; 2]; 3]);

impl FrameSource for Swing {
    fn frame(&mut self, index: i32) -> Frame<'_> {
        let (sin, cos) = math::sin_cos(DT_S * index as f32);
        self.0 = [0.5 * sin, 0.5 * cos, -0.5 * sin].map(|of_joint| [of_joint; 2]);
        let [q, qd, qdd] = &self.0;
        Frame::Coordinates { q, qd, qdd }
    }
}

fn main() -> Result<(), Box<dyn core::error::Error>> {
    let inertia = Inertia::of_box(0.2, Vec3::Y * 0.05, Vec3::new(0.04, 0.1, 0.04));
    let arm = Tree::serial_chain(&[Body::revolute(None, Vec3::X, Vec3::Y * 0.1, inertia); 2])?;
    let timing = Timing { dt_s: DT_S, latency_ticks: 0 };
    let mut tracker = RigTracker::<2>::new(arm, &Settings::default(), timing)?
        .with_limits(&[TorqueLimit::new(2.0, 0.0)?; 2])?;
    let (mut frames, mut commands) = (Swing([[0.0; 2]; 3]), [DofCommand::default(); 2]);
    // Readings of the encoders, rad.
    let mut positions = [0.0; 2];
    for tick in 0..5 {
        let measured = Measured::Positions { q: &positions };
        tracker.step(&mut frames, tick, measured)?.dof_commands(&mut commands)?;
        for DofCommand { position, feedforward_effort, .. } in &commands {
            println!("tick {tick}: {position:.4} rad, {feedforward_effort:.4} N m");
        }
        // Stands in for the servos: each moves exactly to its commanded position.
        positions = commands.map(|command| command.position);
    }
    Ok(())
}
