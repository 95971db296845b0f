//! The controller with any rig, show, stream and bus.

use core::hint::black_box;

use sinew_firmware::controller::{
    ControllerSettings, Inputs, MotionController, ServoSetup, Start, Wire, approach, estimated_us,
    exchange, open_show,
};
use sinew_firmware::supervisor::Settings;
use sinew_rig::board::BoardRig;
use sinew_servo_bus::{EncodeError, Schedule, pca9685};
use sinew_show::{Show, ShowFrames};

use super::{slice, slice_mut};

/// Numbers of bodies, dofs, servos and coordinates of a rig.
pub(crate) const BODIES: usize = 20;
pub(crate) const DOFS: usize = 24;
pub(crate) const SERVOS: usize = 20;
pub(crate) const COORDINATES: usize = 28;

/// A line with arbitrary answers.
pub(crate) struct Anything;

impl Wire for Anything {
    fn exchange(&mut self, bytes: &[u8], wait_us: u32, mut reply: impl FnMut(&[u8]) -> bool) {
        black_box((bytes, wait_us, reply(slice())));
    }

    fn left_us(&self) -> u32 {
        black_box(1)
    }
}

#[inline(never)]
pub(crate) fn ticks() {
    let (rig, schedule) = black_box((None::<BoardRig<BODIES, DOFS, SERVOS>>, None::<Schedule>));
    let (Some(rig), Some(schedule)) = (&rig, &schedule) else { return };
    let Some(mut bus) = black_box(None::<pca9685::Bus>) else { return };
    black_box(estimated_us(black_box(1), black_box(1)));
    let (settings, start) = black_box((ControllerSettings::default(), Start::default()));
    let controller = MotionController::<BODIES, DOFS, SERVOS, COORDINATES>::new(
        rig,
        &settings,
        slice::<ServoSetup>(),
        schedule,
        start,
    );
    let Ok(Ok(mut controller)) = controller.map(|controller| controller.with_rest(slice())) else {
        return;
    };
    let (setup, servo) = (slice::<ServoSetup>().first(), rig.servos().first());
    black_box(setup.zip(servo).map(|(setup, servo)| setup.requirements(&servo.servo)));
    black_box(&controller.load_show(black_box(Some(slice()))));
    let (crc, dt_s) = (black_box(1), controller.dt_s());
    controller.put_show(open_show(rig, crc, dt_s, slice()).ok());
    way(rig, dt_s);
    let begun = controller.begin(&black_box(Inputs::default()), &mut (), &mut bus);
    let exchanged: Result<(), EncodeError> = exchange(&mut bus, &mut Anything, slice_mut());
    black_box(controller.end(begun, exchanged, black_box(1)).is_ok());
    black_box((controller.report(), controller.supervisor(), controller.permission()));
    black_box((controller.commanded(), controller.measured()));
    controller.forget_registers(&mut bus);
}

#[inline(never)]
fn way(rig: &BoardRig<BODIES, DOFS, SERVOS>, dt_s: f32) {
    let Ok(show) = Show::open(slice()) else { return };
    let Ok(mut frames) = ShowFrames::<COORDINATES>::new(black_box(show), dt_s) else { return };
    black_box(&approach(rig, &black_box(Settings::default()), &mut frames, dt_s, slice()));
}
