//! Image for QEMU's `mps2-an386` (Cortex-M4F): a tick of the drives of 18 servos, from the tracker's efforts to the
//! servos' commands.

#![no_std]
#![no_main]

use core::hint::black_box;

use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, hprintln};
use sinew_bench::emulated::{self, count_runs};
use sinew_core::coordinates::DofCommand;
use sinew_core::tracker::Timing;
use sinew_firmware::drives::{
    Condition, CurrentSettings, CutOff, DriveSettings, Drives, Encoder, PositionSettings,
};
use sinew_rig::board::BoardRig;
use sinew_servo_bus::{Effort, Feedback};

/// An arm with 18 XL330, one servo per joint (`build.rs`).
static RIG: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/arm_18.rig"));

const COUNT: usize = 18;
/// Number of runs of a tick.
const RUNS: u16 = 16;
/// Timing of the loop at 400 Hz.
const TIMING: Timing = Timing { dt_s: 0.0025, latency_ticks: 1 };

#[entry]
fn main() -> ! {
    emulated::run(|| {
        let rig = BoardRig::decode(RIG).map_err(|_| "the rig cannot be read")?;
        let current = CurrentSettings {
            encoder: Encoder::default(),
            blind_rad: 0.0059,
            current_a: 0.8,
            cut_off: CutOff::default(),
        };
        measure("drives_current", &rig, DriveSettings::Current(current))?;
        measure("drives_position", &rig, DriveSettings::Position(PositionSettings::default()))
    })
}

fn measure(
    name: &str,
    rig: &BoardRig<{ COUNT + 1 }, COUNT, COUNT>,
    settings: DriveSettings,
) -> Result<(), &'static str> {
    let mut drives =
        Drives::new(rig, &[settings; COUNT], TIMING).map_err(|_| "the drives are refused")?;
    let feedback = Feedback {
        position_rad: core::f32::consts::PI,
        velocity_rad_s: 0.1,
        effort: Effort::Current(0.05),
        age_ticks: 0,
    };
    let condition =
        Condition { feedback: Some(feedback), temperature_c: Some(40.0), supply_v: Some(5.0) };
    let conditions = [condition; COUNT];
    let mut out = [None; COUNT];
    drives.begin(&conditions);
    let mut all = true;
    count_runs::<COUNT, RUNS>(name, |run| {
        let asked = DofCommand {
            position: 0.002 * run as f32,
            velocity: 0.8,
            feedforward_effort: 0.05,
            feedback_effort: 0.01,
            limited: None,
        };
        let asked = black_box([asked; COUNT]);
        all &= drives.step(&asked, black_box(&conditions), &mut out).is_ok();
    });
    all &= out.iter().all(Option::is_some);
    if all { Ok(()) } else { Err("a servo was not commanded") }
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
    hprintln!("{}", info);
    loop {
        debug::exit(debug::EXIT_FAILURE);
    }
}
