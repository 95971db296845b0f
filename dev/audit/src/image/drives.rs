//! Drives of servos: a rig with any drives, and arbitrary commands.

use core::hint::black_box;

use sinew_core::tracker::Timing;
use sinew_firmware::drives::{
    Class, Condition, CurrentDrive, DriveSettings, Drives, PositionDrive, ServoDrive, TargetDrive,
    VoltageDrive,
};
use sinew_rig::board::BoardRig;
use sinew_servo_bus::{dynamixel, feetech, pca9685};

use super::{slice, slice_mut};

/// Numbers of bodies, dofs and servos of a rig.
const BODIES: usize = 20;
const DOFS: usize = 24;
const SERVOS: usize = 20;

#[inline(never)]
pub(crate) fn rig() {
    let rig = black_box(None::<BoardRig<BODIES, DOFS, SERVOS>>);
    let Some(rig) = &rig else { return };
    let timing = black_box(Timing { dt_s: 0.01, latency_ticks: 1 });
    if let Ok(mut drives) = Drives::new(rig, slice::<DriveSettings>(), timing) {
        drives.begin(slice::<Condition>());
        black_box(drives.step(slice(), slice(), slice_mut()).is_ok());
        black_box(drives.measured(slice(), slice_mut()).is_ok());
        black_box(drives.servos().first().map(ServoDrive::class));
    }
}

#[inline(never)]
pub(crate) fn classes() {
    black_box(Class::of_dynamixel(
        black_box(&dynamixel::table::MODELS[0]),
        black_box(dynamixel::Mode::Position),
    ))
    .ok();
    black_box(Class::of_feetech(black_box(feetech::Mode::Position))).ok();
    black_box(black_box(Class::Current).least_hz());
    if let Some(bus) = black_box(None::<pca9685::Bus>) {
        black_box(Condition::of(&bus, black_box(1)));
    }
    if let Some(mut drive) = black_box(None::<CurrentDrive>) {
        drive.begin();
        black_box(drive);
    }
    if let Some(mut drive) = black_box(None::<VoltageDrive>) {
        drive.begin();
        black_box(drive);
    }
    if let Some(mut drive) = black_box(None::<PositionDrive>) {
        drive.begin(black_box(1.0));
        black_box(drive.offset_rad());
    }
    if let Some(mut drive) = black_box(None::<TargetDrive>) {
        drive.begin(black_box(1.0));
        black_box(drive);
    }
}
