//! Controls servos of any make on a serial port: `master dxl|fast|sts|scs PORT 1,2,3 TICKS`.
//!
//! Sends every servo to random positions, and compares the position that it reports with the goal. Needs servos that
//! reach a goal at once, as simulated servos do.

use std::fs::{File, OpenOptions};
use std::io::{Read, Write};
use std::os::fd::AsFd;
use std::time::{Duration, Instant};

use nix::poll::{PollFd, PollFlags, PollTimeout, poll};
use sinew_servo_bus::dynamixel::table::MODELS;
use sinew_servo_bus::feetech::{self, Family};
use sinew_servo_bus::{Command, Schedule, ServoBus, Timing, dynamixel};

const TIMING: Timing = Timing { baud: 1_000_000, return_delay_us: 500, turnaround_us: 1_000 };
/// Maximum wait for a reply: simulated servos answer when the operating system schedules their program.
const PATIENCE: Duration = Duration::from_millis(20);
const RANGE_RAD: [f32; 2] = [0.5, 4.5];
const FAST_RAD_S: f32 = 1000.0;

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [kind, link, ids, ticks] = arguments.as_slice() else {
        return Err("usage: master dxl|fast|sts|scs PORT IDS TICKS, for example: master sts /tmp/bus 1,2,3 1000".into());
    };
    let ids = ids.split(',').map(str::parse).collect::<Result<Vec<u8>, _>>()?;
    let port = OpenOptions::new().read(true).write(true).open(link)?;
    let servos = u32::try_from(ids.len())?;
    match kind.as_str() {
        "dxl" | "fast" => {
            let fast = kind == "fast";
            let model = MODELS.iter().find(|model| model.number == 1200).ok_or("no such model")?;
            let setups = ids.iter().map(|id| dynamixel::ServoSetup {
                id: *id,
                model,
                mode: dynamixel::Mode::Position,
                range_rad: RANGE_RAD,
                current_a: 1.0,
                pwm: 1.0,
                speed_rad_s: FAST_RAD_S,
            });
            let schedule = Schedule::new(TIMING, &dynamixel::traffic(servos, 4, fast), 20)?;
            let settings = dynamixel::Settings { fast, retries: 3 };
            let setups: Vec<_> = setups.collect();
            run(dynamixel::Bus::<32>::new(&setups, schedule, settings)?, port, ticks.parse()?)
        }
        _ => {
            let family = if kind == "sts" { Family::Sts } else { Family::Scs };
            let setups = ids.iter().map(|id| feetech::ServoSetup {
                id: *id,
                mode: feetech::Mode::Position,
                range_rad: RANGE_RAD,
                pwm: 1.0,
                speed_rad_s: FAST_RAD_S,
            });
            let schedule = Schedule::new(TIMING, &feetech::traffic(family, servos), 20)?;
            let settings = feetech::Settings { family, echo: false, retries: 3, speed_counts: 1 };
            let setups: Vec<_> = setups.collect();
            run(feetech::Bus::<32>::new(&setups, schedule, settings)?, port, ticks.parse()?)
        }
    }
}

fn run(mut bus: impl ServoBus, mut port: File, ticks: u32) -> Result<(), Failure> {
    let (mut wrong, mut late, mut seed) = (0, 0, 16_u32);
    for servo in 0..bus.len() {
        bus.command(servo, Command::Torque(true))?;
    }
    for _ in 0..ticks {
        let mut goals = Vec::new();
        for servo in 0..bus.len() {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let [least, most] = RANGE_RAD;
            let goal = least + (most - least) * ((seed >> 8) as f32 / (1 << 24) as f32);
            bus.command(servo, Command::Position(goal))?;
            goals.push(goal);
        }
        // The first tick writes the goals, the second reads the resulting positions.
        tick(&mut bus, &mut port)?;
        tick(&mut bus, &mut port)?;
        for (servo, goal) in goals.iter().enumerate() {
            match bus.feedback(servo).filter(|feedback| feedback.age_ticks == 0) {
                Some(feedback) => wrong += u32::from((feedback.position_rad - goal).abs() > 0.004),
                None => late += 1,
            }
        }
    }
    let health: Vec<_> = (0..bus.len()).filter_map(|servo| bus.health(servo)).collect();
    println!(
        "{ticks} ticks, {} servos: {wrong} wrong, {late} without an answer; {:?}",
        bus.len(),
        health.first()
    );
    if wrong + late == 0 { Ok(()) } else { Err("not all was right".into()) }
}

fn tick(bus: &mut impl ServoBus, port: &mut File) -> Result<(), Failure> {
    let (mut out, mut bytes) = ([0; 1024], [0; 1024]);
    let mut request = Some(bus.plan(&mut out)?);
    while let Some(asked) = request {
        port.write_all(&out[..asked.len])?;
        let end = Instant::now() + PATIENCE;
        let mut is_complete = bus.reply(&[]);
        while !is_complete && Instant::now() < end {
            if poll(&mut [PollFd::new(port.as_fd(), PollFlags::POLLIN)], PollTimeout::from(1_u8))?
                > 0
            {
                let count = port.read(&mut bytes)?;
                is_complete = bus.reply(&bytes[..count]);
            }
        }
        request = bus.plan_more(50_000, &mut out)?;
    }
    Ok(())
}
