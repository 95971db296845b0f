//! Code that runs in every tick.

use core::hint::black_box;

use sinew_bit_parity::replay::{self, Replay, TorqueHash};
use sinew_bit_parity::{decode, play, run};
use sinew_core::coordinates::DofCommand;
use sinew_core::glam::Vec3;
use sinew_core::tracker::{Measured, MethodName, Settings, Timing, Tracker};
use sinew_core::{Transform, Workspace, Wrench};
use sinew_firmware::indicator;
use sinew_firmware::watchdog::Complete;
use sinew_show::{Show, ShowFrames};

use super::{N, construct, desired, measured, slice, slice_mut, tree};

/// The tick with any method, law, gains, limits and external wrenches.
#[inline(never)]
pub(crate) fn controller() {
    let Some(controller) = construct::controller() else { return };
    let (mut targets, mut workspace) = (desired(), black_box(Workspace::resolving()));
    black_box(controller.tick(&mut targets, &measured(), slice(), &mut workspace));
    controller.errors(&mut targets, &measured(), &mut workspace, slice_mut());
    let commands = slice_mut::<DofCommand>();
    black_box(&controller.dof_commands(&targets, &measured(), slice(), &mut workspace, commands));
    black_box(commands.first().map(DofCommand::effort));
    if let Some(supply) = construct::supply() {
        supply.share(workspace.torques_mut());
        let mut carried = [Wrench::ZERO; N];
        controller.bias_wrenches(&measured(), slice(), &mut workspace, &mut carried);
        supply.share_acceleration(workspace.torques_mut(), &carried);
        black_box(supply.supply_nm());
    }
    black_box(workspace.aim_status());
    black_box((workspace.torques(), workspace.commands()));
    black_box((controller.gains(), controller.method(), controller.law(), controller.limits()));
}

/// The tick with a workspace that has no room for resolved acceleration.
#[inline(never)]
pub(crate) fn controller_of_little_room() {
    let Some(controller) = construct::controller() else { return };
    let mut workspace = black_box(Workspace::new());
    black_box(controller.tick(&mut desired(), &measured(), slice(), &mut workspace));
}

/// The boards' tick, with any settings.
#[inline(never)]
pub(crate) fn tracker() {
    let Ok(show) = Show::open(slice()) else { return };
    let Ok(frames) = ShowFrames::<N>::new(black_box(show), black_box(0.01)) else { return };
    let timing = black_box(Timing { dt_s: 0.01, latency_ticks: 1 });
    black_box(timing.check_recommended().is_ok());
    let mut settings = black_box(Settings::default());
    if black_box(true) {
        settings = Settings::recommended();
    }
    settings = settings.with_method(black_box(MethodName::World)).named(black_box);
    let workspace = Workspace::resolving();
    let Ok(tracker) = Tracker::<N, 3, N>::with_workspace(tree(), &settings, timing, workspace)
    else {
        return;
    };
    black_box(&Tracker::<N, 3>::new(tree(), &settings, timing).is_ok());
    let Ok(tracker) = tracker.with_limits(slice()) else { return };
    let Ok(tracker) = tracker.with_gravity(black_box(Vec3::ZERO)) else { return };
    let Ok(tracker) = tracker.with_ranges(slice()) else { return };
    let Ok(mut tracker) = tracker.with_weights(slice()) else { return };
    if black_box(true) {
        let Some(supply) = construct::supply() else { return };
        let Ok(sharing) = tracker.with_supply(supply) else { return };
        tracker = sharing;
    }
    let mut tracker = black_box(tracker);
    let mut frames = black_box(frames);
    let readings = [
        Measured::Poses(slice()),
        Measured::Positions { q: slice() },
        Measured::Coordinates { q: slice(), qd: slice() },
    ];
    for measured in black_box(readings) {
        black_box(&tracker.begin(&mut frames, black_box(1), measured));
        black_box(&tracker.begin_frames(&mut frames, black_box(1)));
        tracker.skip(black_box(1));
        if let Ok(mut tick) = tracker.step(&mut frames, black_box(1), measured) {
            black_box(tick.torques());
            black_box(&tick.efforts(slice_mut()));
            black_box(&tick.dof_commands(slice_mut()));
        }
    }
    black_box((tracker.controller().tree(), frames.show(), tracker.states(), tracker.targets()));
    tracker.errors(slice_mut());
    let method = black_box(MethodName::World);
    black_box((MethodName::from_name(black_box("world")), method.as_str()));
    black_box((method.label(), method.summary()));
    black_box(indicator::breath(black_box(1)));
    black_box(indicator::duty(black_box(Some(1)), black_box(1)));
}

/// The stand-in for servos in bit comparisons.
#[inline(never)]
pub(crate) fn replay() {
    let Ok(show) = Show::open(slice()) else { return };
    let Ok(tree) = replay::tree::<N, N>(slice()) else { return };
    let method = black_box(MethodName::World);
    let Ok(replay) = Replay::<N, N>::new(&tree, black_box(show), method) else { return };
    let mut replay = black_box(replay);
    let mut hash = TorqueHash::default();
    replay.sense(black_box(1));
    if let Ok(tick) = replay.step(black_box(1)) {
        hash.update(tick.torques());
        black_box(&Complete::from(tick));
    }
    black_box((hash.value(), replay::ticks(&show)));
}

/// A run for the comparison with other machines.
#[inline(never)]
pub(crate) fn parity() {
    let read = |bytes: &mut [u8]| {
        bytes.fill(black_box(1));
        black_box(Ok(()))
    };
    let write = |bytes: &[u8]| {
        black_box(bytes);
        black_box(Ok(()))
    };
    black_box(&run::perform::<N, N>(slice_mut(), read, write));
    black_box(&play::perform::<N, N, N>(slice_mut(), read, write));
    black_box(&decode::perform::<N>(slice_mut(), read, write));
    black_box(run::pose_bytes(black_box(&Transform::IDENTITY)));
}
