//! Finds out, for each register of each simulated table, whether the register is simulated, kept without an effect, or
//! refused. The test writes values over the bus, and compares motion, answers and all other registers.
//! `INSTA_UPDATE=always` with this test writes `docs/simulated-registers.md`.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use sinew_servo_bus::BusDevice;
use sinew_servo_bus::dynamixel::Instruction;
use sinew_servo_bus::table::{Access, Area, ByteOrder, Item, Range};
use sinew_servo_sim::device::{MEMORY_LEN, STEP_S, Servo};
use sinew_servo_sim::load::Arm;
use sinew_servo_sim::model::Parameters;
use sinew_servo_sim::registers::RegisterTable;

/// Kinds of Dynamixel with physics, one for each register table. The next constant contains those of Feetech.
const DYNAMIXEL: [&str; 4] = ["XL330-M288-T", "XL430-W250-T", "XM430-W350-T", "MX-64"];
const FEETECH: [&str; 1] = ["STS3215-7.4V"];

/// Registers without an effect, and why that is harmless.
const KEPT: [(&str, &str); 6] = [
    ("LED", "a light"),
    ("LED Alarm Condition", "which errors the light shows"),
    ("Return Delay Time", "has no effect on STS, by the maker's table"),
    ("Goal Time", "a speed and an acceleration decide a move"),
    ("Velocity Limit", "no goal is above it"),
    ("Registered Instruction", "a flag"),
];
/// Registers of which some values are refused: name, and the refused values with their meaning in a real servo.
const REFUSED: [(&str, &str); 12] = [
    ("Drive Mode", "bit 1, the slave of a dual joint"),
    ("Protocol Type", "all but 2: other protocols"),
    ("Acceleration Limit", "all but the factory's: a limit of profiles"),
    ("Startup Configuration", "all but 0: torque on, or kept goals, at power-up"),
    ("PWM Slope", "all but the factory's: a slower rise of PWM"),
    ("D Coefficient", "all but the factory's: damping"),
    ("I Coefficient", "all but 0"),
    ("Integral Limit", "all but 0"),
    ("Velocity P Coefficient", "all but 0"),
    ("Velocity I Coefficient", "all but 0"),
    ("Angular Resolution", "all but 1: several turns in coarser counts"),
    ("Operating Mode", "3: steps"),
];

/// Reason that the page shows for a register that is in neither list.
const UNEXPLAINED: &str = "nobody knows";

/// A sequence of a mode, registers and goals.
struct Script {
    /// Registers that are written before torque is on.
    set: &'static [(u16, i32)],
    /// Goals.
    goals: &'static [(u16, i32)],
    arm: Arm,
    time_s: f64,
}

/// A light arm. The next constant is an arm that is too heavy to move.
const LIGHT: Arm = Arm { inertia_kg_m2: 5e-4, ..REST };
const WALL: Arm = Arm { inertia_kg_m2: 1e4, ..REST };
const REST: Arm = Arm {
    inertia_kg_m2: 0.0,
    gravity_nm: 0.0,
    level_rad: 0.0,
    torque_nm: 0.0,
    stops_rad: [-1e6, 1e6],
};

fn scripts(is_feetech: bool) -> Vec<Script> {
    let script = |set, goals, arm, time_s| Script { set, goals, arm, time_s };
    if is_feetech {
        vec![
            script(&[], &[(41, 20), (46, 800), (42, 2600)], LIGHT, 0.5),
            script(&[], &[(42, 1500)], LIGHT, 0.4),
            script(&[(33, 1)], &[(46, 900)], LIGHT, 0.4),
            script(&[(33, 2)], &[(44, 300)], LIGHT, 0.4),
            script(&[(35, 20), (28, 100), (38, 20)], &[(42, 3500)], WALL, 0.8),
            script(&[(35, 20), (19, 0)], &[(42, 3500)], WALL, 0.8),
        ]
    } else {
        vec![
            script(&[], &[(108, 40), (112, 60), (116, 2600)], LIGHT, 0.5),
            script(&[(11, 1)], &[(104, 100)], LIGHT, 0.4),
            script(&[(11, 5)], &[(116, 2600)], LIGHT, 0.4),
            script(&[(11, 0)], &[(102, 200)], LIGHT, 0.4),
            script(&[(11, 16)], &[(100, 300)], LIGHT, 0.4),
            script(&[], &[(116, 3500)], WALL, 2.6),
        ]
    }
}

/// A servo on a desk, and all that is seen of it.
struct Bench<'m> {
    servo: Servo<'m>,
    is_feetech: bool,
    volts: f64,
    arm: Arm,
    seen: Vec<i64>,
}

impl Bench<'_> {
    /// Reads a register of the servo with this id, or writes `value` to it, and notes the answer.
    fn ask(&mut self, id: u8, item: &Item, value: Option<i32>) {
        let bytes = item.bytes(value.unwrap_or(0), ByteOrder::Little);
        let data = &bytes[..usize::from(item.size)];
        let packet = if self.is_feetech {
            let address = u8::try_from(item.address).unwrap();
            let body = match value {
                Some(_) => [&[3, address][..], data].concat(),
                None => vec![2, address, item.size],
            };
            feetech(id, &body)
        } else {
            let mut out = [0; 64];
            let (address, length) = (item.address, u16::from(item.size));
            let instruction = match value {
                Some(_) => Instruction::Write { address, data },
                None => Instruction::Read { address, length },
            };
            let len = instruction.encode(id, &mut out).unwrap();
            out[..len].to_vec()
        };
        self.send(&packet);
    }

    fn send(&mut self, packet: &[u8]) {
        self.servo.hear(packet);
        self.seen.push(self.servo.due_us().map_or(-1, i64::from));
        let mut out = [0; 64];
        let len = self.servo.speak(&mut out);
        self.seen.extend(out[..len].iter().map(|byte| i64::from(*byte)));
    }

    fn run(&mut self, time_s: f64) {
        let mut left_s = time_s;
        while left_s > 0.0 {
            self.servo.step(self.volts, &self.arm);
            left_s -= STEP_S;
        }
        #[expect(clippy::cast_possible_truncation, reason = "a trace")]
        self.seen.push((self.servo.shaft().position_rad * 1e7) as i64);
        self.seen.push(i64::from(self.servo.baud()));
    }
}

fn feetech(id: u8, body: &[u8]) -> Vec<u8> {
    let mut packet = vec![0xFF, 0xFF, id, u8::try_from(body.len() + 1).unwrap()];
    packet.extend(body);
    packet.push(!packet[2..].iter().fold(0, |sum: u8, byte| sum.wrapping_add(*byte)));
    packet
}

/// Observations during a script.
#[derive(PartialEq)]
struct Seen {
    trace: Vec<i64>,
    /// Values of all registers, at several times during the script.
    registers: Vec<Vec<i32>>,
    /// Whether the register that was tried holds the value.
    is_taken: bool,
}

/// Plays a script. With `other`, writes this value to this register: before torque is on if it is in EEPROM, otherwise
/// after the goals.
fn play(kind: &str, items: &[Item], script: &Script, other: Option<(&Item, i32)>) -> Seen {
    let parameters = Parameters::built_in(kind).unwrap();
    let mut memory = [0; MEMORY_LEN];
    let servo = Servo::new(&parameters, 1, &mut memory).unwrap();
    let is_feetech = kind.starts_with("STS");
    let (volts, arm) = (parameters.voltage_v, script.arm);
    let mut bench = Bench { servo, is_feetech, volts, arm, seen: Vec::new() };
    let at = |address: u16| items.iter().find(|item| item.address == address);
    let mut registers = Vec::new();
    let look = |bench: &Bench<'_>| -> Vec<i32> {
        let value = |item: &Item| match other {
            Some((own, _)) if own.address == item.address => 0,
            _ => bench.servo.get(item.address),
        };
        items.iter().map(value).collect()
    };
    // Feetechs keep EEPROM while the lock is open.
    let lock = |bench: &mut Bench<'_>, value| {
        if let Some(item) = at(55).filter(|_| is_feetech) {
            bench.ask(1, item, Some(value));
        }
    };
    let (torque, ping) = if is_feetech { (40, 65) } else { (64, 122) };
    lock(&mut bench, 0);
    for (address, value) in script.set {
        if let Some(item) = at(*address) {
            bench.ask(1, item, Some(*value));
        }
    }
    let try_other = |bench: &mut Bench<'_>, area| {
        let (item, value) = other.filter(|(item, _)| item.area == area)?;
        let length = bench.seen.len();
        bench.ask(1, item, Some(value));
        // The answer to this packet is no effect.
        bench.seen.truncate(length);
        Some(bench.servo.get(item.address) == value)
    };
    let mut is_taken = try_other(&mut bench, Area::Eeprom);
    if is_taken == Some(false) {
        return Seen { trace: Vec::new(), registers, is_taken: false };
    }
    lock(&mut bench, 1);
    bench.run(0.02);
    if let Some(item) = at(torque) {
        bench.ask(1, item, Some(1));
    }
    bench.run(0.02);
    for (address, value) in script.goals {
        if let Some(item) = at(*address) {
            bench.ask(1, item, Some(*value));
        }
    }
    is_taken = is_taken.or_else(|| try_other(&mut bench, Area::Ram));
    for _ in 0..4 {
        bench.run(script.time_s / 4.0);
        // A packet makes the servo publish its measurements; then it is left alone.
        if let Some(item) = at(ping) {
            bench.ask(1, item, None);
        }
        registers.push(look(&bench));
    }
    // A second id, and a change of EEPROM without the lock, before a restart.
    let (goal, gain) = if is_feetech { (42, 21) } else { (116, 84) };
    for (id, address, value) in [(5, goal, 1500), (1, torque, 0), (1, gain, 20)] {
        if let Some(item) = at(address) {
            bench.ask(id, item, Some(value));
        }
        bench.run(0.05);
    }
    registers.push(look(&bench));
    let mut packet = [0; 16];
    let reboot = if is_feetech {
        feetech(1, &[8])
    } else {
        let len = Instruction::Reboot.encode(1, &mut packet).unwrap();
        packet[..len].to_vec()
    };
    bench.send(&reboot);
    bench.run(1.2);
    registers.push(look(&bench));
    Seen { trace: bench.seen, registers, is_taken: is_taken == Some(true) }
}

/// Returns the values to try in a register.
fn candidates(item: &Item) -> BTreeSet<i32> {
    let [least, most] = match item.range {
        Range::Between(least, most) => [least, most],
        _ => [0, 255],
    };
    let near = [item.initial + 1, item.initial / 2, item.initial - 1];
    let all = [least, most, 0, 1, 2, 3, 4, 5, 8, 16, 20, 40, 100].into_iter().chain(near);
    all.filter(|value| (least..=most).contains(value)).collect()
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Fate {
    Simulated,
    Kept,
    Refused,
    /// The register is read-only, and its value never changes.
    Constant,
}

/// Finds out for each register of a kind whether it is simulated, kept, refused or constant.
fn fates(kind: &str) -> BTreeMap<(u16, &'static str), Fate> {
    let table = RegisterTable::of(kind).unwrap();
    let (items, is_feetech): (Vec<Item>, bool) = match table {
        RegisterTable::Dynamixel(table) => (table.items().collect(), false),
        RegisterTable::Feetech(table) => (table.items().collect(), true),
    };
    let scripts = scripts(is_feetech);
    let as_shipped: Vec<Seen> =
        scripts.iter().map(|script| play(kind, &items, script, None)).collect();
    let mut fates = BTreeMap::new();
    for (index, item) in items.iter().enumerate() {
        let changes = || {
            let values = as_shipped.iter().flat_map(|seen| &seen.registers);
            values.map(|registers| registers[index]).collect::<BTreeSet<_>>().len() > 1
        };
        let fate = if item.access == Access::Read {
            if changes() { Fate::Simulated } else { Fate::Constant }
        } else {
            let mut fate = Fate::Refused;
            'tried: for (script, shipped) in scripts.iter().zip(&as_shipped) {
                for value in candidates(item) {
                    let seen = play(kind, &items, script, Some((item, value)));
                    if seen.registers.is_empty() {
                        continue;
                    }
                    let same = |(mut own, other): (Vec<i32>, &Vec<i32>)| {
                        own[index] = 0;
                        own == *other
                    };
                    let mut registers = shipped.registers.iter().cloned().zip(&seen.registers);
                    let has_effect = seen.trace != shipped.trace || !registers.all(same);
                    if has_effect {
                        fate = Fate::Simulated;
                        break 'tried;
                    }
                    if seen.is_taken && value != item.initial {
                        fate = Fate::Kept;
                    }
                }
            }
            fate
        };
        fates.insert((item.address, item.name), fate);
    }
    fates
}

/// Returns the section of the page for the kinds of a protocol.
fn section(title: &str, kinds: &[&str]) -> String {
    let mut all: BTreeMap<(u16, &str), Fate> = BTreeMap::new();
    for kind in kinds {
        for (register, fate) in fates(kind) {
            let known = *all.entry(register).or_insert(fate);
            // A register that one model simulates and another keeps counts as simulated.
            all.insert(register, known.min(fate));
        }
    }
    let reason = |list: &[(&str, &'static str)], name: &str| {
        list.iter().find(|(known, _)| *known == name).map(|(_, why)| *why)
    };
    let names = |fate: Fate| {
        let of_fate = all.iter().filter(move |(_, found)| **found == fate);
        of_fate.map(|((address, name), _)| (*address, *name)).collect::<Vec<_>>()
    };
    let list = |registers: &[(u16, &str)]| {
        let each = registers.iter().map(|(address, name)| format!("{name} ({address})"));
        each.collect::<Vec<_>>().join(", ")
    };
    let mut out = format!("## {title}\n\nTried on {}.\n\n", kinds.join(", "));
    let simulated = names(Fate::Simulated);
    let simulates = format!("**Simulated:** {}.", list(&simulated));
    let constant = format!("**Read-only, and always the same:** {}.", list(&names(Fate::Constant)));
    let _ = writeln!(out, "{}\n\n{}\n", wrapped(&simulates), wrapped(&constant));
    out.push_str("| register | in the simulation | why, or which values |\n| --- | --- | --- |\n");
    for (address, name) in names(Fate::Kept) {
        let why = reason(&KEPT, name);
        let why = why.unwrap_or(UNEXPLAINED);
        let _ = writeln!(out, "| {name} ({address}) | kept, without an effect | {why} |");
    }
    // A Dynamixel's Operating Mode is at another address.
    let is_partly = |(address, name): &(u16, &str)| {
        reason(&REFUSED, name).is_some() && (*name != "Operating Mode" || *address == 33)
    };
    for (address, name) in names(Fate::Refused) {
        let why = reason(&REFUSED, name);
        let why = why.unwrap_or(UNEXPLAINED);
        let _ = writeln!(out, "| {name} ({address}) | refused | {why} |");
    }
    for (address, name) in simulated.iter().filter(|register| is_partly(register)) {
        let why = reason(&REFUSED, name).unwrap_or_default();
        let _ = writeln!(out, "| {name} ({address}) | some values refused | {why} |");
    }
    out.push('\n');
    out
}

/// Returns a paragraph in lines of at most 120 characters.
fn wrapped(text: &str) -> String {
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        let length = lines.last().map_or(0, |line| line.chars().count());
        if length > 0 && length + 1 + word.chars().count() > 120 {
            lines.push(String::new());
        }
        if let Some(line) = lines.last_mut() {
            if !line.is_empty() {
                line.push(' ');
            }
            line.push_str(word);
        }
    }
    lines.join("\n")
}

#[test]
fn each_register_is_simulated_kept_or_refused_and_the_page_says_which() {
    let mut page = format!(
        "# Registers of simulated servos\n\n{}\n\n",
        wrapped(
            "A test tries values of each register over the bus, in all simulated modes, with a light arm and against a \
             wall, and compares motion, answers and all other registers (`registers.rs` of `crates/servo-sim`). A \
             Dynamixel answers a refused value with an error, a Feetech keeps its old value, and `sinew servo write` \
             says so. Indirect addresses of Dynamixels work. Kinds without physics (`--load none`, SCS) keep all that is \
             written, and go to their goal at once."
        )
    );
    page += &section("Dynamixel", &DYNAMIXEL);
    page += &section("Feetech STS", &FEETECH);
    let page = page.trim_end().to_owned() + "\n";
    assert!(!page.contains(UNEXPLAINED), "{page}");
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/simulated-registers.md");
    if std::env::var_os("INSTA_UPDATE").is_some_and(|update| update == "always") {
        std::fs::write(path, &page).unwrap();
    }
    let written = std::fs::read_to_string(path).unwrap_or_default();
    assert!(
        written == page,
        "docs/simulated-registers.md must be (INSTA_UPDATE=always writes it):\n{page}"
    );
}
