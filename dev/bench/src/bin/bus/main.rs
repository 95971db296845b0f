//! Image for QEMU's `mps2-an386` (Cortex-M4F): a cycle of servo buses, from commands to packets and from replies to
//! readings. Simulated servos give the replies before the counting.

#![no_std]
#![no_main]

use core::array;
use core::hint::black_box;

use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, hprintln};
use sinew_bench::emulated::{self, count_runs};
use sinew_servo_bus::dynamixel::{self, table as dynamixel_table};
use sinew_servo_bus::feetech::{self, Family, table as feetech_table};
use sinew_servo_bus::{BusDevice, Command, Line, Schedule, ServoBus, Timing};

const SERVOS: u8 = 18;
const COUNT: usize = SERVOS as usize;

/// Number of runs of each cycle.
const RUNS: u16 = 16;

/// Timing that is fast enough to read all servos in every tick.
const TIMING: Timing = Timing { baud: 3_000_000, return_delay_us: 2, turnaround_us: 5 };
const TICK_HZ: u32 = 200;

/// Smallest commanded position, rad.
const FIRST_RAD: f32 = 2.0;
const RANGE_RAD: [f32; 2] = [1.0, 5.0];
const SPEED_RAD_S: f32 = 11.0;

/// Room for the bytes that a cycle sends, and for those that it receives.
type Bytes = [u8; 1024];

#[entry]
fn main() -> ! {
    emulated::run(|| {
        of_dynamixel("bus_dynamixel", false)?;
        of_dynamixel("bus_dynamixel_fast", true)?;
        of_feetech("bus_feetech")
    })
}

fn of_dynamixel(name: &str, fast: bool) -> Result<(), &'static str> {
    use dynamixel::{Bus, Device, Mode, ServoSetup, Settings, traffic};
    use dynamixel_table::{Table, address};
    let table = Table::of(1200, 52).ok_or("no such model")?;
    let setups: [ServoSetup; COUNT] = array::from_fn(|index| ServoSetup {
        id: id(index),
        model: table.model,
        mode: Mode::Position,
        range_rad: RANGE_RAD,
        current_a: 0.8,
        pwm: 1.0,
        speed_rad_s: SPEED_RAD_S,
    });
    let mut memories = [[0; 228]; COUNT];
    let mut ids = (0..).map(id);
    let mut devices = memories.each_mut().map(|memory| {
        let mut device = Device::<256>::new(table, ids.next().unwrap_or_default(), memory);
        // Disables answers to writes.
        device.memory_mut().set(address::STATUS_LEVEL, 1);
        device.memory_mut().set(address::PRESENT_POSITION, 2000);
        device
    });
    let schedule = Schedule::new(TIMING, &traffic(SERVOS.into(), 4, fast), TICK_HZ);
    let schedule = schedule.map_err(|_| "no such schedule")?;
    let bus = Bus::<COUNT>::new(&setups, schedule, Settings { fast, retries: 0 });
    measure(name, bus.map_err(|_| "no such bus")?, &mut devices)
}

fn of_feetech(name: &str) -> Result<(), &'static str> {
    use feetech::{Bus, Device, Mode, ServoSetup, Settings, Table, traffic};
    use feetech_table::address;
    let family = Family::Sts;
    let table = Table::of("STS3215").ok_or("no such model")?;
    let setups: [ServoSetup; COUNT] = array::from_fn(|index| ServoSetup {
        id: id(index),
        mode: Mode::Position,
        range_rad: RANGE_RAD,
        pwm: 1.0,
        speed_rad_s: SPEED_RAD_S,
    });
    let mut memories = [[0; 256]; COUNT];
    let mut ids = (0..).map(id);
    let mut devices = memories.each_mut().map(|memory| {
        let mut device = Device::new(table, ids.next().unwrap_or_default(), memory);
        device.set(address::PRESENT_POSITION, 2000);
        device
    });
    let schedule = Schedule::new(TIMING, &traffic(family, SERVOS.into()), TICK_HZ);
    let schedule = schedule.map_err(|_| "no such schedule")?;
    let settings = Settings { family, echo: false, retries: 0, speed_counts: 1 };
    let bus = Bus::<COUNT>::new(&setups, schedule, settings);
    measure(name, bus.map_err(|_| "no such bus")?, &mut devices)
}

/// Returns the id of a servo; ids begin at 1.
fn id(index: usize) -> u8 {
    u8::try_from(index + 1).unwrap_or(u8::MAX)
}

fn measure(
    name: &str,
    mut bus: impl ServoBus,
    devices: &mut [impl BusDevice],
) -> Result<(), &'static str> {
    for servo in 0..COUNT {
        bus.command(servo, Command::Torque(true)).map_err(|_| "a command is refused")?;
    }
    let (mut out, mut replies): (Bytes, Bytes) = ([0; 1024], [0; 1024]);
    let request = bus.plan(&mut out).map_err(|_| "there is no room for a request")?;
    let mut came = 0;
    Line::new(devices).exchange(&out[..request.len], &mut [0; 512], |said, _| {
        replies[came..came + said.len()].copy_from_slice(said);
        came += said.len();
    });
    let replies = &replies[..came];

    let mut all = bus.reply(replies);
    count_runs::<COUNT, RUNS>(name, |run| {
        all &= cycle(&mut bus, FIRST_RAD + 0.01 * run as f32, &mut out, black_box(replies));
    });
    all &= (0..COUNT).all(|servo| bus.feedback(servo).is_some_and(|now| now.age_ticks == 0));
    if all { Ok(()) } else { Err("a servo was not commanded or not read") }
}

/// Commands all servos and reads all. Returns false if a servo did not take part.
#[inline(never)]
fn cycle(bus: &mut impl ServoBus, position_rad: f32, out: &mut [u8], replies: &[u8]) -> bool {
    let position = Command::Position(position_rad);
    let commanded = (0..COUNT).all(|servo| bus.command(servo, position) == Ok(None));
    let planned = bus.plan(out).is_ok_and(|request| request.reply_len == replies.len());
    commanded && planned && bus.reply(replies)
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
    hprintln!("{}", info);
    loop {
        debug::exit(debug::EXIT_FAILURE);
    }
}
