//! The supervisor, its detectors, and the guard, with arbitrary inputs.

use core::hint::black_box;

use sinew_firmware::drives::{Condition, DriveSettings};
use sinew_firmware::supervisor::detect::{
    Derated, Following, FollowingSettings, Heat, HeatSettings, Overrun, OverrunSettings, Silence,
    Supply, SupplySettings, Winding, WindingSettings,
};
use sinew_firmware::supervisor::{
    Fault, FaultLog, FaultRecord, FaultSet, Findings, Guard, GuardSettings, Inputs, Moving,
    Permission, Settings, Supervisor,
};
use sinew_rig::servo::Servo;
use sinew_servo_bus::Command;

use super::slice;

#[inline(never)]
pub(crate) fn states() {
    let log = FaultLog::restored(black_box(None), slice::<FaultRecord>().iter().copied());
    let settings = black_box(Settings::default());
    let Ok(mut supervisor) = Supervisor::new(settings, black_box(1), log) else { return };
    black_box(supervisor.step(black_box(&Inputs::default())));
    if let Some(moving) = black_box(None::<Moving>) {
        black_box(moving.rad_s());
    }
    black_box((supervisor.mode(), supervisor.settings(), supervisor.log().first()));
    black_box(supervisor.log().last().count());
}

#[inline(never)]
pub(crate) fn faults() {
    let mut findings = black_box(Findings::default());
    let fault = black_box(Fault::LinkLate);
    findings.note(fault);
    findings.note_of(fault, black_box(1));
    black_box((findings.servo(fault), fault.name(), fault.when(), fault.remedy()));
    black_box(fault.is_warning());
    let present: FaultSet = findings.present().iter().collect();
    black_box(present.minus(black_box(present)).and(black_box(present)).first());
}

#[inline(never)]
pub(crate) fn detectors() {
    let dt_s = black_box(0.01);
    if let Ok(mut following) = Following::new(black_box(FollowingSettings::default()), dt_s) {
        following.begin();
        black_box(following.step(black_box(1.0)));
    }
    let mut derated = black_box(Derated::FULL);
    if let Ok(mut supply) = Supply::new(SupplySettings::of(dt_s, dt_s, dt_s), dt_s) {
        derated = derated.and(supply.step(black_box(None)));
        black_box(supply.filtered_v());
    }
    if let Ok(mut heat) = Heat::new(HeatSettings::of_limit(dt_s)) {
        derated = derated.and(heat.step(black_box(None)));
    }
    if let Ok(mut winding) = Winding::new(WindingSettings::of_stall(dt_s), dt_s) {
        derated = derated.and(winding.step(dt_s));
        black_box(winding.heat());
    }
    black_box(derated);
    if let Ok(silence) = Silence::new(black_box(5)) {
        black_box(silence.step(black_box(1)));
    }
    if let Ok(mut overrun) = Overrun::new(black_box(OverrunSettings::default())) {
        black_box((overrun.step(black_box(true)), overrun.count()));
    }
}

#[inline(never)]
pub(crate) fn guard() {
    let (servo, drive) = black_box((None::<Servo>, None::<DriveSettings>));
    let (Some(servo), Some(drive)) = (servo, drive) else { return };
    let Ok(mut guard) = Guard::new(GuardSettings::of(&servo, &drive), black_box(0.01)) else {
        return;
    };
    let Some(permission) = black_box(None::<Permission>) else { return };
    let (command, condition) = black_box((Command::Torque(true), Condition::default()));
    black_box(guard.check(command, &condition, &permission));
}
