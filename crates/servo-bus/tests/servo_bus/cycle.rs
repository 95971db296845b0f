//! Tests a bus against simulated devices on one line: commands arrive, readings return, and a tick takes the time that
//! the schedule computes.

use sinew_servo_bus::dynamixel::table::{MODELS, Table, address};
use sinew_servo_bus::dynamixel::{self, Mode, ServoSetup, Settings};
use sinew_servo_bus::feetech::{self, Family};
use sinew_servo_bus::{
    BusDevice, Command, CommandError, Effort, Limit, Line, Schedule, ScheduleError, ServoBus,
    SetupError, Timing,
};

const RAD: f32 = std::f32::consts::TAU / 4096.0;
const TIMING: Timing = Timing { baud: 2_000_000, return_delay_us: 2, turnaround_us: 5 };

type Dxl<'m> = dynamixel::Device<'m, 512>;

/// The traffic of one tick: the number of bytes on the wire, the total time of the servos' delays, us, and the number
/// of the controller's turnarounds.
#[derive(Debug, Default, PartialEq, Clone, Copy)]
struct Wire {
    bytes: usize,
    delays_us: u32,
    turns: u32,
}

/// Runs one tick like a controller: asks, passes on the replies, and asks again until there is nothing to ask.
fn tick<D: BusDevice>(bus: &mut impl ServoBus, devices: &mut [D], left_us: u32) -> Wire {
    tick_with(bus, devices, left_us, false)
}

/// Runs one tick with an adapter that may echo the bytes that it sends.
fn tick_with<D: BusDevice>(
    bus: &mut impl ServoBus,
    devices: &mut [D],
    left_us: u32,
    echo: bool,
) -> Wire {
    let (mut out, mut scratch, mut wire) = ([0; 1024], [0; 512], Wire::default());
    let mut request = Some(bus.plan(&mut out).unwrap());
    while let Some(asked) = request {
        let mut came = if echo { out[..asked.len].to_vec() } else { Vec::new() };
        let mut line = Line::new(devices);
        let mut answer = |said: &[u8], delay_us| {
            came.extend_from_slice(said);
            wire.delays_us += delay_us;
        };
        line.exchange(&out[..asked.len], &mut scratch, &mut answer);
        line.silence(&mut scratch, &mut answer);
        wire.bytes += asked.len + came.len();
        wire.turns += u32::from(asked.reply_len > 0);
        came.chunks(7).for_each(|piece| {
            bus.reply(piece);
        });
        request = bus.plan_more(left_us, &mut out).unwrap();
    }
    wire
}

fn setup(id: u8, mode: Mode) -> ServoSetup {
    let model = MODELS.iter().find(|model| model.number == 1200).unwrap();
    ServoSetup {
        id,
        model,
        mode,
        range_rad: [1.0, 5.0],
        current_a: 0.8,
        pwm: 0.5,
        speed_rad_s: 11.0,
    }
}

fn devices(memories: &mut [Vec<u8>], mode: Mode) -> Vec<Dxl<'_>> {
    let table = Table::of(1200, 52).unwrap();
    let devices = memories.iter_mut().zip(1..).map(|(memory, id)| {
        memory.resize(table.size(), 0);
        let mut device = Dxl::new(table, id, memory);
        let memory = device.memory_mut();
        memory.set(address::OPERATING_MODE, mode.number().into());
        memory.set(address::STATUS_LEVEL, 1);
        memory.set(address::RETURN_DELAY, 1);
        memory.set(address::PRESENT_POSITION, 2000 + i32::from(id));
        memory.set(address::PRESENT_CURRENT, -5 * i32::from(id));
        memory.set(address::PRESENT_VOLTAGE, 50);
        memory.set(address::PRESENT_TEMPERATURE, 30 + i32::from(id));
        device
    });
    devices.collect()
}

/// Creates a bus at 100 Hz that reads all servos in each tick.
fn with_retries(count: u8, fast: bool, retries: u8) -> dynamixel::Bus<40> {
    let setups: Vec<_> = (1..=count).map(|id| setup(id, Mode::Position)).collect();
    let schedule = Schedule::new(TIMING, &dynamixel::traffic(count.into(), 4, fast), 100).unwrap();
    assert_eq!(schedule.groups(), 1);
    dynamixel::Bus::new(&setups, schedule, Settings { fast, retries }).unwrap()
}

fn bus(count: u8, mode: Mode, fast: bool, rate_hz: u32) -> dynamixel::Bus<40> {
    let setups: Vec<_> = (1..=count).map(|id| setup(id, mode)).collect();
    let schedule =
        Schedule::new(TIMING, &dynamixel::traffic(count.into(), 4, fast), rate_hz).unwrap();
    dynamixel::Bus::new(&setups, schedule, Settings { fast, retries: 2 }).unwrap()
}

#[test]
fn commands_arrive_and_readings_come_back() {
    for fast in [false, true] {
        let mut memories = vec![Vec::new(); 6];
        let mut devices = devices(&mut memories, Mode::Position);
        let mut bus = bus(6, Mode::Position, fast, 200);
        for servo in 0..6 {
            assert_eq!(bus.command(servo, Command::Torque(true)), Ok(None));
            assert_eq!(bus.command(servo, Command::Stiffness(300)), Ok(None));
            let limit = bus.command(servo, Command::Position(servo as f32)).unwrap();
            assert_eq!(limit, (servo == 0).then_some(Limit::Position));
        }
        for _ in 0..6 {
            tick(&mut bus, &mut devices, 5_000);
        }
        for (servo, device) in devices.iter().enumerate() {
            let goal = device.memory().get(address::GOAL_POSITION) as f32 * RAD;
            assert!(
                (goal - (servo as f32).max(1.0)).abs() < RAD && goal >= 1.0,
                "servo {servo}: {goal}"
            );
            assert_eq!(device.memory().get(address::TORQUE_ENABLE), 1);
            assert_eq!(device.memory().get(address::POSITION_P), 300);
            let feedback = bus.feedback(servo).unwrap();
            assert!((feedback.position_rad - (2001 + servo) as f32 * RAD).abs() < 1e-6);
            assert_eq!(
                (feedback.effort, feedback.age_ticks),
                (Effort::Current(-5.0 * (servo as f32 + 1.0) * 0.001), 0)
            );
            let health = bus.health(servo).unwrap();
            assert_eq!(
                (health.voltage_v, health.temperature_c),
                (Some(5.0), Some(31.0 + servo as f32))
            );
            assert_eq!((health.missed, health.not_believed), (0, 0));
        }
    }
}

#[test]
fn currents_are_limited_and_nan_refused() {
    let mut memories = vec![Vec::new(); 1];
    let mut devices = devices(&mut memories, Mode::Current);
    let mut bus = bus(1, Mode::Current, false, 200);
    assert_eq!(bus.command(0, Command::Current(-3.0)), Ok(Some(Limit::Current)));
    tick(&mut bus, &mut devices, 5_000);
    assert_eq!(devices[0].memory().get(address::GOAL_CURRENT), -800);
    for number in [f32::NAN, f32::INFINITY] {
        assert_eq!(
            bus.command(0, Command::Current(number)),
            Err(CommandError::NotFinite("current"))
        );
    }
    assert_eq!(bus.command(0, Command::Position(1.0)), Err(CommandError::Unsupported("position")));
    assert_eq!(
        bus.command(1, Command::Current(0.0)),
        Err(CommandError::Servo { index: 1, count: 1 })
    );
    tick(&mut bus, &mut devices, 5_000);
    assert_eq!(
        devices[0].memory().get(address::GOAL_CURRENT),
        -800,
        "a refused command changes nothing"
    );
}

/// With a fast read, all servos after a dead servo are silent. The bus asks the dead servo alone and leaves it out from
/// then on. The other servos thus miss one tick for each servo that dies, on a bus of any size.
#[test]
fn dead_servos_do_not_silence_the_others() {
    for (fast, dead) in [(false, &[2][..]), (true, &[2]), (true, &[0]), (true, &[0, 7, 19])] {
        let mut memories = vec![Vec::new(); 20];
        let mut devices = devices(&mut memories, Mode::Position);
        let mut bus = with_retries(20, fast, 1);
        for _ in 0..4 {
            tick(&mut bus, &mut devices, 5_000);
        }
        let mut taken = Vec::new();
        for servo in dead.iter().rev() {
            taken.push(devices.remove(*servo));
        }
        for ticks in 1..60 {
            tick(&mut bus, &mut devices, 5_000);
            for servo in 0..20 {
                let missed = bus.health(servo).unwrap().missed_in_a_row as usize;
                if dead.contains(&servo) {
                    assert_eq!(missed, ticks - 1, "fast {fast}: {servo}");
                } else {
                    assert!(missed <= dead.len(), "fast {fast}, {dead:?}: {servo} {missed}");
                    assert!(ticks <= dead.len() + 1 || missed == 0, "{dead:?}: {servo} {missed}");
                }
            }
        }
        // The bus still asks the dead servos, one in each tick, and they are back as soon as they answer.
        for servo in dead {
            devices.insert(*servo, taken.pop().unwrap());
        }
        for _ in 0..=dead.len() {
            tick(&mut bus, &mut devices, 5_000);
        }
        assert!((0..20).all(|servo| bus.feedback(servo).unwrap().age_ticks == 0));
    }
}

#[test]
fn an_alert_is_read_out() {
    let mut memories = vec![Vec::new(); 3];
    let mut devices = devices(&mut memories, Mode::Position);
    devices[1].memory_mut().set(address::HARDWARE_ERROR, 0x20);
    let mut bus = bus(3, Mode::Position, true, 200);
    tick(&mut bus, &mut devices, 5_000);
    let health = bus.health(1).unwrap();
    assert_eq!((health.alert, health.hardware_error), (true, dynamixel::hardware_error::OVERLOAD));
    assert!(!bus.health(0).unwrap().alert);
}

/// Computes the wire time from the logged bytes and silences, independently of the schedule's own arithmetic.
#[test]
fn ticks_take_what_the_schedule_says() {
    for count in [6, 18, 40] {
        for baud in [1_000_000, 2_000_000, 3_000_000, 4_000_000] {
            for fast in [false, true] {
                let timing = Timing { baud, ..TIMING };
                let traffic = dynamixel::traffic(count.into(), 4, fast);
                let schedule = Schedule::new(timing, &traffic, 100).unwrap();
                let setups: Vec<_> = (1..=count).map(|id| setup(id, Mode::Position)).collect();
                let mut bus =
                    dynamixel::Bus::<40>::new(&setups, schedule, Settings { fast, retries: 1 })
                        .unwrap();
                let mut memories = vec![Vec::new(); count.into()];
                let mut devices = devices(&mut memories, Mode::Position);
                for servo in 0..usize::from(count) {
                    bus.command(servo, Command::Position(2.0)).unwrap();
                }
                let wire = tick(&mut bus, &mut devices, 10_000);
                let wire_us = wire.bytes as f32 * 1e7 / baud as f32
                    + (wire.delays_us + wire.turns * 5) as f32;
                let said_us = schedule.busy_us() as f32;
                assert!(
                    (said_us / wire_us - 1.0).abs() < 0.05,
                    "{count} at {baud}, fast {fast}: {said_us} {wire_us}"
                );
            }
        }
    }
}

#[test]
fn reads_are_spread_where_a_tick_is_too_short() {
    let traffic = dynamixel::traffic(18, 4, false);
    let spread = Schedule::new(TIMING, &traffic, 1000).unwrap();
    // 104 bytes of goals, 16 of a question and 42 of answers, 28 of the additional read: 950 us. Plus three return
    // delays of 2 us and two turnarounds of 5 us.
    assert_eq!((spread.tick_us(), spread.groups(), spread.busy_us()), (1000, 9, 966));
    assert!(spread.busy_us() <= 1000);
    let reads: Vec<usize> =
        (0..9).map(|tick| (0..18).filter(|servo| spread.reads(tick, *servo)).count()).collect();
    assert_eq!(reads, [2; 9]);
    let Err(ScheduleError::TooFast { asked_hz: 4000, most_hz }) =
        Schedule::new(TIMING, &traffic, 4000)
    else {
        panic!("18 servos at 4 kHz do not fit");
    };
    assert!(
        Schedule::new(TIMING, &traffic, most_hz).is_ok()
            && Schedule::new(TIMING, &traffic, most_hz + 2).is_err()
    );
    assert_eq!(
        Schedule::new(Timing { baud: 0, ..TIMING }, &traffic, 100),
        Err(ScheduleError::Number)
    );

    let mut memories = vec![Vec::new(); 18];
    let mut devices = devices(&mut memories, Mode::Position);
    let mut bus = bus(18, Mode::Position, false, 1000);
    for _ in 0..9 {
        tick(&mut bus, &mut devices, 1000);
    }
    let mut ages: Vec<_> = (0..18).map(|servo| bus.feedback(servo).unwrap().age_ticks).collect();
    ages.sort_unstable();
    ages.dedup();
    assert_eq!(ages, [0, 1, 2, 3, 4, 5, 6, 7, 8]);
}

#[test]
fn setups_that_cannot_be_are_refused() {
    let schedule = Schedule::new(TIMING, &dynamixel::traffic(2, 4, false), 100).unwrap();
    let settings = Settings { fast: false, retries: 0 };
    let refused = |setups: &[ServoSetup]| {
        let checked = dynamixel::Bus::<2>::check(setups, &schedule).unwrap_err();
        assert_eq!(dynamixel::Bus::<2>::new(setups, schedule, settings).unwrap_err(), checked);
        checked
    };
    let ok = setup(1, Mode::Position);
    assert_eq!(dynamixel::Bus::<2>::check(&[ok, setup(2, Mode::Position)], &schedule), Ok(()));
    assert_eq!(refused(&[ok, ok]), SetupError::Shared(1));
    assert_eq!(refused(&[ServoSetup { id: 253, ..ok }]), SetupError::Id(253));
    assert_eq!(
        refused(&[ok, setup(2, Mode::Position), setup(3, Mode::Position)]),
        SetupError::Capacity { holds: 2 }
    );
    let range = SetupError::Setting { id: 1, what: "range_rad" };
    for range_rad in [[f32::NAN, 1.0], [2.0, 1.0], [1.0, f32::INFINITY]] {
        assert_eq!(refused(&[ServoSetup { range_rad, ..ok }]), range);
    }
    let model = MODELS.iter().find(|model| model.current.is_none()).unwrap();
    assert!(matches!(
        refused(&[ServoSetup { model, mode: Mode::Current, ..ok }]),
        SetupError::Setting { .. }
    ));
}

#[test]
fn feetech_of_both_families() {
    for (family, name) in [(Family::Sts, "STS3215"), (Family::Scs, "SCS0009")] {
        for echo in [false, true] {
            let table = feetech::Table::of(name).unwrap();
            let mut memories = vec![[0; 256]; 4];
            let mut devices: Vec<_> = memories
                .iter_mut()
                .zip(1..)
                .map(|(memory, id)| feetech::Device::new(table, id, memory))
                .collect();
            for (device, id) in devices.iter_mut().zip(1..) {
                device.set(feetech::table::address::PRESENT_POSITION, 500 + id);
                device.set(60, -70 * id);
                device.set(62, 74);
                device.set(69, -10 * id);
            }
            let schedule = Schedule::new(TIMING, &feetech::traffic(family, 4), 100).unwrap();
            let setups: Vec<_> = (1..=4)
                .map(|id| feetech::ServoSetup {
                    id,
                    mode: feetech::Mode::Position,
                    range_rad: [0.5, 4.0],
                    pwm: 1.0,
                    speed_rad_s: 5.0,
                })
                .collect();
            let settings = feetech::Settings { family, echo, retries: 1, speed_counts: 1 };
            let mut bus = feetech::Bus::<4>::new(&setups, schedule, settings).unwrap();
            // A goal would switch torque on, so none is sent while torque must be off.
            assert_eq!(bus.command(0, Command::Position(2.0)), Ok(Some(Limit::TorqueOff)));
            tick_with(&mut bus, &mut devices, 10_000, echo);
            assert_eq!(devices[0].get(feetech::table::address::TORQUE_ENABLE), 0);
            for servo in 0..4 {
                assert_eq!(bus.command(servo, Command::Torque(true)), Ok(None));
                assert_eq!(bus.command(servo, Command::Position(9.0)), Ok(Some(Limit::Position)));
            }
            tick_with(&mut bus, &mut devices, 10_000, echo);
            for (servo, device) in devices.iter().enumerate() {
                let goal = device.get(feetech::table::address::GOAL_POSITION) as f32
                    * family.rad_per_count();
                assert!(
                    goal <= 4.0 && goal > 4.0 - family.rad_per_count(),
                    "{name} {servo}: {goal}"
                );
                let feedback = bus.feedback(servo).unwrap();
                assert!(
                    (feedback.position_rad / family.rad_per_count() - (501 + servo) as f32).abs()
                        < 1e-3
                );
                let id = servo as f32 + 1.0;
                let (Effort::Current(effort) | Effort::Load(effort)) = feedback.effort;
                let expected = if family == Family::Sts { -0.065 * id } else { -0.07 * id };
                assert!((effort - expected).abs() < 1e-6, "{name} {servo}: {effort}");
                assert!((bus.health(servo).unwrap().voltage_v.unwrap() - 7.4).abs() < 1e-5);
            }
        }
    }
}

proptest::proptest! {
    /// For any command, the goals on the wire are within the limits of the setup.
    #[test]
    fn no_command_leaves_its_limits(
        numbers in proptest::collection::vec(proptest::num::f32::ANY, 4),
        stiffness in 0_u16..,
    ) {
        let modes = [Mode::Position, Mode::Current, Mode::CurrentPosition, Mode::Pwm, Mode::ExtendedPosition];
        for mode in modes {
            let mut memories = vec![Vec::new(); 1];
            let mut devices = devices(&mut memories, mode);
            let mut bus = bus(1, mode, false, 200);
            let commands = [
                Command::Position(numbers[0]),
                Command::PositionWithin { position_rad: numbers[0], current_a: numbers[1] },
                Command::Current(numbers[2]),
                Command::Pwm(numbers[3]),
                Command::Stiffness(stiffness),
            ];
            for command in commands {
                let before = bus.clone();
                if bus.command(0, command).is_err() {
                    bus = before;
                }
            }
            // A goal that was not commanded has the factory's value, which the test replaces.
            let memory = devices[0].memory_mut();
            memory.set(address::GOAL_POSITION, 1000);
            memory.set(address::GOAL_PWM, 0);
            tick(&mut bus, &mut devices, 5_000);
            let memory = devices[0].memory();
            let position = memory.get(address::GOAL_POSITION) as f32 * RAD;
            proptest::prop_assert!((1.0..=5.0).contains(&position), "{mode:?}: {position} rad");
            let current = memory.get(address::GOAL_CURRENT) as f32 * 0.001;
            proptest::prop_assert!(current.abs() <= 0.8 + 1e-6, "{mode:?}: {current} A");
            let pwm = memory.get(address::GOAL_PWM) as f32 / 885.0;
            proptest::prop_assert!(pwm.abs() <= 0.5, "{mode:?}: {pwm}");
        }
    }
}
