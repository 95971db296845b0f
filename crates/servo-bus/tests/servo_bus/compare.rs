//! Tests the comparison of device registers with the requirements of a rig, over a bus.

use sinew_servo_bus::dynamixel::table::{MODELS, Model, Table, address};
use sinew_servo_bus::dynamixel::{self, Device};
use sinew_servo_bus::feetech::{self, Family};
use sinew_servo_bus::settings::{self, Mode, ServoRequirements, Setting};
use sinew_servo_bus::{
    BusDevice, Command, Compared, Difference, Line, Schedule, ServoBus, Timing, pca9685,
};

const TIMING: Timing = Timing { baud: 1_000_000, return_delay_us: 2, turnaround_us: 5 };

/// Requirements for an XL330: the values of its kind, and a range of 100 degrees to either side of the middle.
const DEMAND: ServoRequirements = ServoRequirements {
    mode: Mode::Position,
    range_rad: [std::f32::consts::PI - 1.75, std::f32::consts::PI + 1.75],
    torque_nm: 0.2,
    stall_nm: 0.52,
    friction_nm: 0.0128,
    torque_constant_nm_a: 0.387,
    shutdown_c: 70.0,
    gain_ratio: 1.0,
};

fn model(name: &str) -> &'static Model {
    MODELS.iter().find(|model| model.name == name).unwrap()
}

/// Runs one tick. Returns the number of questions after the readings. `damage` changes the replies to these questions.
fn tick<D: BusDevice>(
    bus: &mut impl ServoBus,
    device: &mut D,
    left_us: u32,
    mut damage: impl FnMut(&mut Vec<u8>),
) -> usize {
    let (mut out, mut scratch, mut questions) = ([0; 256], [0; 256], 0);
    // A controller sends this in every tick while torque is off.
    bus.command(0, Command::Torque(false)).unwrap();
    let mut request = Some(bus.plan(&mut out).unwrap());
    while let Some(asked) = request {
        let mut came = Vec::new();
        let mut line = Line::new(std::slice::from_mut(device));
        line.exchange(&out[..asked.len], &mut scratch, |said, _| came.extend_from_slice(said));
        line.silence(&mut scratch, |said, _| came.extend_from_slice(said));
        if questions > 0 {
            assert!(asked.time_us <= left_us, "{asked:?}");
            damage(&mut came);
        }
        came.chunks(3).for_each(|piece| _ = bus.reply(piece));
        questions += 1;
        request = bus.plan_more(left_us, &mut out).unwrap();
    }
    questions - 1
}

/// Runs ticks until the comparison has a result.
fn compare<D: BusDevice>(
    bus: &mut impl ServoBus,
    device: &mut D,
    requirements: ServoRequirements,
) -> Compared {
    bus.compare(Some((0, requirements)));
    for _ in 0..40 {
        tick(bus, device, 3_000, |_| {});
        if bus.compared() != Compared::Reading {
            return bus.compared();
        }
    }
    panic!("it is not known after 40 ticks");
}

fn dynamixel_bus(model: &'static Model) -> dynamixel::Bus<1> {
    let schedule = Schedule::new(TIMING, &dynamixel::traffic(1, 4, false), 100).unwrap();
    let setup = dynamixel::ServoSetup {
        id: 1,
        model,
        mode: dynamixel::Mode::Position,
        range_rad: [1.0, 5.0],
        current_a: 1.0,
        pwm: 1.0,
        speed_rad_s: 11.0,
    };
    let settings = dynamixel::Settings { fast: false, retries: 1 };
    dynamixel::Bus::new(&[setup], schedule, settings).unwrap()
}

fn feetech_bus(family: Family) -> feetech::Bus<1> {
    let schedule = Schedule::new(TIMING, &feetech::traffic(family, 1), 100).unwrap();
    let setup = feetech::ServoSetup {
        id: 1,
        mode: feetech::Mode::Position,
        range_rad: [1.0, 4.0],
        pwm: 1.0,
        speed_rad_s: 11.0,
    };
    let settings = feetech::Settings { family, echo: false, retries: 1, speed_counts: 1 };
    feetech::Bus::new(&[setup], schedule, settings).unwrap()
}

/// Returns a value that differs from the required value.
fn wrong(setting: &Setting) -> i32 {
    // A status level of 0 would make the servo silent.
    if setting.raw > 1 { setting.raw - 1 } else { setting.raw + 1 }
}

fn difference(setting: &Setting) -> Compared {
    let (item, address) = (setting.item.name, setting.item.address);
    let found = wrong(setting);
    Compared::Differs(Difference { item, address, found, expected: setting.wanted(found) })
}

#[test]
fn every_register_of_a_dynamixel_is_compared() {
    for name in ["XL330-M288", "XL430-W250", "XM430-W350", "MX-28"] {
        let table = Table { model: model(name), firmware: 52 };
        let settings: Vec<_> = settings::dynamixel(table, DEMAND).collect();
        assert!(settings.is_sorted_by_key(|setting| setting.item.address));
        let mut memory = [0; 1024];
        let mut device = Device::<256>::new(table, 1, &mut memory);
        let mut bus = dynamixel_bus(table.model);
        let first = compare(&mut bus, &mut device, DEMAND);
        assert!(matches!(first, Compared::Differs(_)), "as the factory ships it: {first:?}");
        for setting in &settings {
            device.memory_mut().set(setting.item.address, setting.raw);
        }
        assert_eq!(compare(&mut bus, &mut device, DEMAND), Compared::Same, "{name}");
        for setting in &settings {
            device.memory_mut().set(setting.item.address, wrong(setting));
            let found = compare(&mut bus, &mut device, DEMAND);
            // A servo loses its P gain without power, so the bus writes it.
            let is_written = setting.item.address == address::POSITION_P;
            let expected = if is_written { Compared::Same } else { difference(setting) };
            assert_eq!(found, expected, "{name}");
            device.memory_mut().set(setting.item.address, setting.raw);
        }
        let others = [Mode::CurrentPosition, Mode::Current, Mode::Pwm];
        for mode in others {
            let found = compare(&mut bus, &mut device, ServoRequirements { mode, ..DEMAND });
            assert!(
                matches!(found, Compared::Differs(Difference { address: 11, .. })),
                "{found:?}"
            );
        }
    }
}

#[test]
fn every_register_of_a_feetech_is_compared() {
    for (name, family) in [("STS3215", Family::Sts), ("SCS0009", Family::Scs)] {
        let table = feetech::Table::of(name).unwrap();
        let settings: Vec<_> = settings::feetech(family, DEMAND).collect();
        let mut memory = [0; feetech::Table::LEN];
        let mut device = feetech::Device::new(table, 1, &mut memory);
        let mut bus = feetech_bus(family);
        let set = |device: &mut feetech::Device<'_>, setting: &Setting, raw| {
            device.set(u8::try_from(setting.item.address).unwrap(), raw);
        };
        for setting in &settings {
            set(&mut device, setting, setting.raw);
        }
        assert_eq!(compare(&mut bus, &mut device, DEMAND), Compared::Same, "{name}");
        for setting in &settings {
            set(&mut device, setting, wrong(setting));
            let found = compare(&mut bus, &mut device, DEMAND);
            assert_eq!(found, difference(setting), "{name}");
            set(&mut device, setting, setting.raw);
        }
    }
}

/// A servo whose torque stays on, whatever it is commanded.
struct Stuck<D>(D, fn(&mut D));

impl<D: BusDevice> BusDevice for Stuck<D> {
    fn hear(&mut self, bytes: &[u8]) {
        self.0.hear(bytes);
        self.1(&mut self.0);
    }
    fn due_us(&self) -> Option<u32> {
        self.0.due_us()
    }
    fn speak(&mut self, out: &mut [u8]) -> usize {
        self.0.speak(out)
    }
    fn silence(&mut self) {
        self.0.silence();
    }
}

fn is_torque(found: Compared) -> bool {
    matches!(found, Compared::Differs(difference) if difference.is_torque())
}

#[test]
fn a_servo_that_keeps_its_torque_is_found_by_its_register() {
    let table = Table { model: model("XL330-M288"), firmware: 52 };
    let mut memory = [0; 256];
    let mut device = Device::<256>::new(table, 1, &mut memory);
    for setting in settings::dynamixel(table, DEMAND) {
        device.memory_mut().set(setting.item.address, setting.raw);
    }
    let mut bus = dynamixel_bus(table.model);
    assert_eq!(compare(&mut bus, &mut device, DEMAND), Compared::Same);
    let mut stuck = Stuck(device, |device| device.memory_mut().set(64, 1));
    assert!(is_torque(compare(&mut bus, &mut stuck, DEMAND)), "{:?}", bus.compared());

    for (name, family) in [("STS3215", Family::Sts), ("SCS0009", Family::Scs)] {
        let mut memory = [0; feetech::Table::LEN];
        let mut device = feetech::Device::new(feetech::Table::of(name).unwrap(), 1, &mut memory);
        for setting in settings::feetech(family, DEMAND) {
            device.set(u8::try_from(setting.item.address).unwrap(), setting.raw);
        }
        let mut bus = feetech_bus(family);
        assert_eq!(compare(&mut bus, &mut device, DEMAND), Compared::Same);
        let mut stuck = Stuck(device, |device| device.set(40, 1));
        assert!(is_torque(compare(&mut bus, &mut stuck, DEMAND)), "{:?}", bus.compared());
    }
}

/// A watchdog that has expired accepts only 0. If the packets of one turn are lost, the next turn repeats them.
#[test]
fn the_watchdog_of_a_dynamixel_is_cleared_and_set_while_torque_is_off() {
    let table = Table { model: model("XL330-M288"), firmware: 52 };
    for is_lost in [false, true] {
        let mut memory = [0; 256];
        let mut device = Device::<256>::new(table, 1, &mut memory);
        let mut bus = dynamixel_bus(table.model);
        device.memory_mut().set(98, -1);
        tick(&mut bus, &mut device, 0, |_| {});
        if is_lost {
            device.memory_mut().set(98, -1);
        }
        for _ in 0..2 {
            tick(&mut bus, &mut device, 0, |_| {});
        }
        assert_eq!(device.memory().get(98), 5, "100 ms");
    }
}

#[test]
fn a_servo_that_has_stopped_by_itself_is_told_until_its_torque_was_off() {
    let table = Table { model: model("XL330-M288"), firmware: 52 };
    let mut memory = [0; 256];
    let mut device = Device::<256>::new(table, 1, &mut memory);
    let mut bus = dynamixel_bus(table.model);
    let exchange = |bus: &mut dynamixel::Bus<1>, device: &mut Device<'_, 256>, command| {
        let (mut out, mut scratch) = ([0; 256], [0; 256]);
        bus.command(0, command).unwrap();
        let mut request = Some(bus.plan(&mut out).unwrap());
        while let Some(asked) = request {
            let mut line = Line::new(std::slice::from_mut(device));
            line.exchange(&out[..asked.len], &mut scratch, |said, _| _ = bus.reply(said));
            request = bus.plan_more(3_000, &mut out).unwrap();
        }
        bus.health(0).unwrap().has_stopped
    };
    let (off, on, goal) = (Command::Torque(false), Command::Torque(true), Command::Position(3.0));
    for _ in 0..2 {
        for command in [off, off, on, goal, goal] {
            assert!(!exchange(&mut bus, &mut device, command));
        }
        device.pass_time(100_001);
        assert!(exchange(&mut bus, &mut device, goal));
        assert!(exchange(&mut bus, &mut device, goal));
    }
}

fn raw(settings: Vec<Setting>, address: u16) -> i32 {
    settings.into_iter().find(|setting| setting.item.address == address).unwrap().raw
}

#[test]
fn limits_are_what_the_rig_says() {
    let of = |name, requirements| {
        settings::dynamixel(Table { model: model(name), firmware: 52 }, requirements)
            .collect::<Vec<_>>()
    };
    // 1.75 rad are 1140.8 counts, rounded inwards. 0.2 N m and friction, over 0.387 N m/A, are 0.55 A.
    assert_eq!([48, 52].map(|at| raw(of("XL330-M288", DEMAND), at)), [2048 + 1140, 2048 - 1140]);
    assert_eq!([36, 38].map(|at| raw(of("XL330-M288", DEMAND), at)), [885, 550]);
    // A range that ends on a count ends there despite f32 rounding. A whole turn is one count less.
    let right = std::f32::consts::FRAC_PI_2;
    let middle = std::f32::consts::PI;
    let quarter = ServoRequirements { range_rad: [middle - right, middle + right], ..DEMAND };
    assert_eq!([48, 52].map(|at| raw(of("XL330-M288", quarter), at)), [3072, 1024]);
    let whole = ServoRequirements { range_rad: [0.0, 2.0 * middle], ..DEMAND };
    assert_eq!([48, 52].map(|at| raw(of("XL330-M288", whole), at)), [4095, 0]);
    // Full torque means the factory value. A servo without current measurement is limited by its PWM.
    let strong = ServoRequirements { torque_nm: 0.52, ..DEMAND };
    assert_eq!(raw(of("XL330-M288", strong), 38), 1750);
    assert_eq!(raw(of("XL430-W250", strong), 36), 885);
    assert_eq!(raw(of("XL430-W250", DEMAND), 36), 340);
    let sts = |requirements| settings::feetech(Family::Sts, requirements).collect::<Vec<_>>();
    assert_eq!([16, 48].map(|at| raw(sts(DEMAND), at)), [385, 385]);
    assert_eq!([16, 48].map(|at| raw(sts(strong), at)), [1000, 1000]);
}

#[test]
fn what_is_lost_is_asked_for_again_and_one_damaged_answer_is_no_difference() {
    let table = feetech::Table::of("STS3215").unwrap();
    let mut memory = [0; feetech::Table::LEN];
    let mut device = feetech::Device::new(table, 1, &mut memory);
    for setting in settings::feetech(Family::Sts, DEMAND) {
        device.set(u8::try_from(setting.item.address).unwrap(), setting.raw);
    }
    let mut bus = feetech_bus(Family::Sts);
    let mut ticks = |damage: &mut dyn FnMut(usize, &mut Vec<u8>)| {
        bus.compare(Some((0, DEMAND)));
        let mut count = 0;
        while bus.compared() == Compared::Reading {
            tick(&mut bus, &mut device, 3_000, |came| damage(count, came));
            count += 1;
            assert!(count < 100);
        }
        (count, bus.compared())
    };
    let (whole, same) = ticks(&mut |_, _| {});
    assert_eq!(same, Compared::Same);
    // Every second answer is lost.
    let (lossy, same) = ticks(&mut |count, came| {
        if count % 2 == 0 {
            came.clear();
        }
    });
    assert_eq!((lossy, same), (2 * whole, Compared::Same));
    // Every second answer has another number with a matching sum: one damaged packet in 256 has this by chance.
    let (damaged, same) = ticks(&mut |count, came| {
        if let (0, [_, _, _, _, _, first, .., sum]) = (count % 2, came.as_mut_slice()) {
            (*first, *sum) = (first.wrapping_add(1), sum.wrapping_sub(1));
        }
    });
    assert_eq!((damaged, same), (2 * whole, Compared::Same));
}

#[test]
fn supply_and_temperature_wait_where_there_is_no_time_for_both() {
    let table = Table { model: model("XL330-M288"), firmware: 52 };
    let mut memory = [0; 256];
    let mut device = Device::<256>::new(table, 1, &mut memory);
    for setting in settings::dynamixel(table, DEMAND) {
        device.memory_mut().set(setting.item.address, setting.raw);
    }
    let mut bus = dynamixel_bus(table.model);
    bus.compare(Some((0, DEMAND)));
    // 28 bytes for supply and temperature, 24 to 35 bytes for registers, at 10 us each; and 7 us between question and
    // answer.
    let mut count = 0;
    while bus.compared() == Compared::Reading {
        let mut left_us = 400;
        let (mut out, mut scratch) = ([0; 256], [0; 256]);
        bus.command(0, Command::Torque(false)).unwrap();
        let mut request = Some(bus.plan(&mut out).unwrap());
        let mut is_first = true;
        while let Some(asked) = request {
            let mut line = Line::new(std::slice::from_mut(&mut device));
            line.exchange(&out[..asked.len], &mut scratch, |said, _| _ = bus.reply(said));
            left_us -= if is_first { 0 } else { asked.time_us };
            is_first = false;
            request = bus.plan_more(left_us, &mut out).unwrap();
        }
        count += 1;
        assert!(count < 40);
    }
    assert_eq!(bus.compared(), Compared::Same);
    // Supply and temperature alternate with the registers.
    assert!(bus.health(0).unwrap().age_ticks <= 2, "{:?}", bus.health(0));
}

#[test]
fn a_bus_compares_what_it_was_asked_last_and_nothing_of_servos_without_registers() {
    let table = Table { model: model("XL330-M288"), firmware: 52 };
    let mut memory = [0; 256];
    let mut device = Device::<256>::new(table, 1, &mut memory);
    let mut bus = dynamixel_bus(table.model);
    assert_eq!(bus.compared(), Compared::Nothing);
    let without = tick(&mut bus, &mut device, 3_000, |_| {});
    bus.compare(Some((0, DEMAND)));
    assert_eq!(tick(&mut bus, &mut device, 3_000, |_| {}), without + 1);
    bus.compare(None);
    assert_eq!(bus.compared(), Compared::Nothing);
    assert_eq!(tick(&mut bus, &mut device, 3_000, |_| {}), without);
    // The comparison never ends for a servo that the bus does not have.
    bus.compare(Some((1, DEMAND)));
    for _ in 0..40 {
        tick(&mut bus, &mut device, 3_000, |_| {});
    }
    assert_eq!(bus.compared(), Compared::Reading);

    let prescale = pca9685::Prescale::new(25e6, 50.0);
    let mut hobby = pca9685::Bus::new(&[], prescale.unwrap(), 400_000).unwrap();
    hobby.compare(Some((0, DEMAND)));
    assert_eq!(hobby.compared(), Compared::Nothing);
}

#[test]
fn a_gain_is_a_part_of_the_factorys_and_written_before_it_is_compared() {
    let stiff = ServoRequirements { gain_ratio: 2.5, ..DEMAND };
    let table = Table { model: model("XL430-W250"), firmware: 52 };
    let settings: Vec<_> = settings::dynamixel(table, stiff).collect();
    assert_eq!(raw(settings.clone(), 84), 1600);
    let beyond = ServoRequirements { gain_ratio: 100.0, ..DEMAND };
    assert_eq!(raw(settings::dynamixel(table, beyond).collect(), 84), 16_383);
    assert_eq!(raw(settings::feetech(Family::Sts, stiff).collect(), 21), 80);
    let mut memory = [0; 1024];
    let mut device = Device::<256>::new(table, 1, &mut memory);
    let mut bus = dynamixel_bus(table.model);
    for setting in settings.iter().filter(|setting| setting.item.address != address::POSITION_P) {
        device.memory_mut().set(setting.item.address, setting.raw);
    }
    assert_eq!(device.memory().get(address::POSITION_P), 640);
    assert_eq!(compare(&mut bus, &mut device, stiff), Compared::Same);
    assert_eq!(device.memory().get(address::POSITION_P), 1600);
}
