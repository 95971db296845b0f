//! What runs in every tick.

use core::hint::black_box;

use sinew_core::coordinates::DofCommand;
use sinew_core::{Transform, Workspace, Wrench};
use sinew_firmware::app::App;
use sinew_firmware::indicator;
use sinew_firmware::parity;
use sinew_firmware::recommended::Recommended;
use sinew_firmware::replay::{Replay, TorqueHash, method};
use sinew_firmware::show::Show;

use crate::{N, construct, desired, measured, slice, slice_mut, tree};

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

/// The tick without room for resolved acceleration.
#[inline(never)]
pub(crate) fn controller_of_little_room() {
    let Some(controller) = construct::controller() else { return };
    let mut workspace = black_box(Workspace::new());
    black_box(controller.tick(&mut desired(), &measured(), slice(), &mut workspace));
}

/// The boards' tick, plain and in the setting for real rigs.
#[inline(never)]
pub(crate) fn app() {
    let Some(controller) = construct::controller() else { return };
    let Ok(show) = Show::parse(slice()) else { return };
    let mut app = App::new(black_box(show), controller);
    if black_box(true) {
        let Ok(setting) = Recommended::new(&show, &tree(), black_box(1)) else { return };
        app = app.with(black_box(setting));
        let weighted = Recommended::with_weights(&show, &tree(), slice(), black_box(1));
        let Ok(setting) = weighted else { return };
        app = app.with(black_box(setting));
    }
    if black_box(true) {
        let Some(supply) = construct::supply() else { return };
        app = app.with_supply(black_box(supply));
    }
    let mut app = black_box(app);
    black_box(&app.observe(black_box(1), slice()));
    black_box(app.control());
    black_box((app.controller().tree(), app.show()));
    app.errors(slice_mut());
    black_box(indicator::breath(black_box(1)));
}

/// What stands in for servos where bits are compared.
#[inline(never)]
pub(crate) fn replay() {
    let Ok(show) = Show::parse(slice()) else { return };
    let name = black_box("world");
    black_box(&method(name, &tree()));
    let Ok(replay) = Replay::<N>::new(black_box(show), name) else { return };
    let mut replay = black_box(replay);
    black_box(&replay.observe(black_box(1)));
    let mut hash = TorqueHash::default();
    hash.update(replay.control());
    black_box(hash.value());
}

/// What makes a run that is compared with other machines'.
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
    black_box(&parity::perform::<N>(slice_mut(), read, write));
    black_box(parity::pose_bytes(black_box(&Transform::IDENTITY)));
}
