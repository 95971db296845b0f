//! Properties that hold for any bytes: used by the replay of the corpus, and by the fuzz targets.

use sinew_servo_bus::dynamixel::fast::{FastReader, FastTurn};
use sinew_servo_bus::dynamixel::table::{MODELS, Table, address};
use sinew_servo_bus::dynamixel::{
    self, FrameWriter, Instruction, Mode, ServoSetup, Settings, Status, StatusError,
};
use sinew_servo_bus::feetech::{self, Family};
use sinew_servo_bus::{BusDevice, Schedule, ServoBus, Timing, pca9685};

use super::reference;

/// A decoder with its name.
pub(crate) type Decoder = (&'static str, fn(&[u8]));

/// All decoders, of controller and servos.
pub(crate) const DECODERS: [Decoder; 9] = [
    ("dynamixel_stream", dynamixel_stream),
    ("dynamixel_controller", dynamixel_controller),
    ("dynamixel_servo", dynamixel_servo),
    ("fast_answer", fast_answer),
    ("feetech_stream", feetech_stream),
    ("feetech_controller", feetech_controller),
    ("sts_servo", sts_servo),
    ("scs_servo", scs_servo),
    ("pca9685_chip", pca9685_chip),
];

const TIMING: Timing = Timing { baud: 1_000_000, return_delay_us: 0, turnaround_us: 0 };

/// Separator between the parts of an input. Each part becomes a packet.
const BETWEEN: u8 = 0xA5;

/// Returns two streams: the input itself, and its parts as packets with correct checksums, which random bytes almost
/// never have.
fn dynamixel_streams(bytes: &[u8]) -> [Vec<u8>; 2] {
    let mut stream = Vec::new();
    for part in bytes.split(|byte| *byte == BETWEEN) {
        let [id, code, params @ ..] = part else { continue };
        let mut out = [0; 1024];
        let mut frame = FrameWriter::new(&mut out, near_id(*id), *code);
        frame.extend(params);
        let len = frame.finish().unwrap_or(0);
        stream.extend_from_slice(&out[..len]);
    }
    [bytes.to_vec(), stream]
}

/// Returns the two streams for Feetech: the input itself, and its parts as packets with correct checksums.
fn feetech_streams(bytes: &[u8]) -> [Vec<u8>; 2] {
    let mut stream = Vec::new();
    for part in bytes.split(|byte| *byte == BETWEEN) {
        let [id, code, data @ ..] = part else { continue };
        let mut out = [0; 300];
        // Encoded as a status, with any instruction byte in the place of the status bits.
        let status = feetech::Status { id: near_id(*id), bits: *code, data };
        let len = status.encode(&mut out).unwrap_or(0);
        stream.extend_from_slice(&out[..len]);
    }
    [bytes.to_vec(), stream]
}

/// Maps a byte to the broadcast id or a low id, so that a servo listens.
fn near_id(byte: u8) -> u8 {
    if byte >= 0x80 { dynamixel::BROADCAST } else { byte & 3 }
}

/// The parser finds the same packets as a reference parser that has the whole stream at once.
pub(crate) fn dynamixel_stream(bytes: &[u8]) {
    for stream in dynamixel_streams(bytes) {
        let mut parser = dynamixel::Parser::<64>::new();
        let mut found = Vec::new();
        for mut piece in stream.chunks(7) {
            while let Some(packet) = parser.next(&mut piece) {
                found.push((packet.id, packet.instruction, packet.params.to_vec()));
            }
        }
        while let Some(packet) = parser.flush() {
            found.push((packet.id, packet.instruction, packet.params.to_vec()));
        }
        assert_eq!(found, contents(reference::dynamixel(&stream, 64)));
    }
}

/// The parser for Feetech finds the same packets as a reference parser that has the whole stream at once.
pub(crate) fn feetech_stream(bytes: &[u8]) {
    for stream in feetech_streams(bytes) {
        let mut parser = feetech::Parser::<64>::new();
        let mut found = Vec::new();
        for mut piece in stream.chunks(7) {
            while let Some(packet) = parser.next(&mut piece) {
                found.push((packet.id, packet.code, packet.params.to_vec()));
            }
        }
        while let Some(packet) = parser.flush() {
            found.push((packet.id, packet.code, packet.params.to_vec()));
        }
        assert_eq!(found, contents(reference::feetech(&stream, 64)));
    }
}

fn contents(found: Vec<reference::Found>) -> Vec<(u8, u8, Vec<u8>)> {
    found.into_iter().map(|found| (found.id, found.code, found.params)).collect()
}

/// A decoded packet encodes to the same bytes, and accepted values are within bounds.
pub(crate) fn dynamixel_controller(bytes: &[u8]) {
    for stream in dynamixel_streams(bytes) {
        hear_dynamixel(&stream);
    }
}

fn hear_dynamixel(bytes: &[u8]) {
    let mut parser = dynamixel::Parser::<512>::new();
    let mut input = bytes;
    while let Some(packet) = parser.next(&mut input) {
        let mut out = [0; 1024];
        if let Some(status) = Status::of(packet) {
            let len = status.encode(&mut out).unwrap();
            let mut again = dynamixel::Parser::<1024>::new();
            let packet = again.next(&mut &out[..len]).unwrap();
            // A fast answer has the broadcast id, and no byte stuffing.
            assert!(packet.id == dynamixel::BROADCAST || Status::of(packet) == Some(status));
        } else if let Ok(instruction) = Instruction::decode(&packet)
            && let Ok(len) = instruction.encode(packet.id, &mut out)
        {
            let mut again = dynamixel::Parser::<1024>::new();
            assert_eq!(
                Instruction::decode(&again.next(&mut &out[..len]).unwrap()),
                Ok(instruction)
            );
        }
    }
    let model = MODELS.iter().find(|model| model.number == 1200).unwrap();
    let setup = |id| ServoSetup {
        id,
        model,
        mode: Mode::Position,
        range_rad: [0.0, 6.0],
        current_a: 1.0,
        pwm: 1.0,
        speed_rad_s: 10.0,
    };
    for fast in [false, true] {
        let schedule = Schedule::new(TIMING, &dynamixel::traffic(2, 4, fast), 100).unwrap();
        let setups = [setup(1), setup(2)];
        let mut bus =
            dynamixel::Bus::<2>::new(&setups, schedule, Settings { fast, retries: 2 }).unwrap();
        drive(&mut bus, bytes);
    }
}

/// After any input a servo still answers a ping.
pub(crate) fn dynamixel_servo(bytes: &[u8]) {
    for stream in dynamixel_streams(bytes) {
        tell_dynamixel(&stream);
    }
}

fn tell_dynamixel(bytes: &[u8]) {
    let table = Table::of(1200, 52).unwrap();
    let mut memory = vec![0; table.size()];
    let mut device = dynamixel::Device::<1024>::new(table, 1, &mut memory);
    device.hear(bytes);
    device.silence();
    let mut out = [0; 1024];
    device.speak(&mut out);
    device.pass_time(3_000_000);
    let id = u8::try_from(device.memory().get(address::ID)).unwrap();
    let len = Instruction::Ping.encode(id, &mut out).unwrap();
    device.hear(&out[..len]);
    assert!(device.due_us().is_some());
    let len = device.speak(&mut out);
    let mut parser = dynamixel::Parser::<64>::new();
    let status = Status::of(parser.next(&mut &out[..len]).unwrap()).unwrap();
    assert!(status.answers(id, 3));
}

/// Reads the answer to a fast read, in which some bytes are changed. The first input bytes choose the servos, and the
/// last ones choose the changes. The reader keeps the data before the first wrong checksum.
pub(crate) fn fast_answer(bytes: &[u8]) {
    let [count, length, rest @ ..] = bytes else { return };
    let (count, length) = (1 + u16::from(count & 7), u16::from(length & 15));
    let lengths = (0..count).map(|servo| length + servo);
    let servos: Vec<_> = (1_u8..).zip(lengths.clone().map(usize::from)).collect();
    let mut stream = Vec::new();
    for (place, (id, length)) in servos.iter().enumerate() {
        let mut turn = FastTurn::new(lengths.clone().take(place), lengths.clone());
        for byte in &stream {
            turn.hear(*byte);
        }
        let data: Vec<_> = (0..*length).map(|at| rest.get(at).copied().unwrap_or(*id)).collect();
        let mut out = [0; 64];
        let error = StatusError::from_byte(*id);
        let len = turn.encode(&Status { id: *id, error, data: &data }, &mut out).unwrap();
        stream.extend_from_slice(&out[..len]);
    }
    let (changes, _) = rest.as_chunks::<2>();
    for [at, change] in changes.iter().rev().take(usize::from(count & 3)) {
        let len = stream.len();
        stream[usize::from(*at) % len] ^= *change;
    }
    let mut reader = FastReader::<32>::new(stream.len());
    let mut found = Vec::new();
    let mut servos_left = servos.iter();
    let mut next = servos_left.next();
    for mut piece in stream.chunks(5) {
        while let Some((id, length)) = next
            && let Some(status) = reader.next(*id, u16::try_from(*length).unwrap(), &mut piece)
        {
            found.push((status.id, status.error.byte(), status.data.to_vec()));
            next = servos_left.next();
        }
    }
    assert_eq!(found, reference::fast(&servos, &stream));
}

/// A decoded packet encodes to the same bytes, and accepted values are within bounds.
pub(crate) fn feetech_controller(bytes: &[u8]) {
    for stream in feetech_streams(bytes) {
        hear_feetech(&stream);
    }
}

fn hear_feetech(bytes: &[u8]) {
    let mut parser = feetech::Parser::<259>::new();
    let mut input = bytes;
    while let Some(packet) = parser.next(&mut input) {
        let mut out = [0; 300];
        if let Some(status) = feetech::Status::of(packet) {
            let len = status.encode(&mut out).unwrap();
            let mut again = feetech::Parser::<259>::new();
            assert_eq!(feetech::Status::of(again.next(&mut &out[..len]).unwrap()), Some(status));
        }
    }
    for family in [Family::Sts, Family::Scs] {
        let schedule = Schedule::new(TIMING, &feetech::traffic(family, 2), 100).unwrap();
        let setups = [1, 2].map(|id| feetech::ServoSetup {
            id,
            mode: feetech::Mode::Position,
            range_rad: [0.0, 4.0],
            pwm: 1.0,
            speed_rad_s: 10.0,
        });
        let settings = feetech::Settings { family, echo: false, retries: 2, speed_counts: 1 };
        let mut bus = feetech::Bus::<2>::new(&setups, schedule, settings).unwrap();
        drive(&mut bus, bytes);
    }
}

/// After any input an STS servo still answers a ping, unless its id has become one that cannot be addressed.
pub(crate) fn sts_servo(bytes: &[u8]) {
    for stream in feetech_streams(bytes) {
        tell_feetech("STS3215", &stream);
    }
}

/// After any input an SCS servo, which sends the high byte first, still answers a ping.
pub(crate) fn scs_servo(bytes: &[u8]) {
    for stream in feetech_streams(bytes) {
        tell_feetech("SCS0009", &stream);
    }
}

fn tell_feetech(model: &str, bytes: &[u8]) {
    let table = feetech::Table::of(model).unwrap();
    let mut memory = [0; 256];
    let mut device = feetech::Device::new(table, 1, &mut memory);
    device.hear(bytes);
    device.silence();
    let mut out = [0; 300];
    device.speak(&mut out);
    let id = u8::try_from(device.get(feetech::table::address::ID)).unwrap();
    if id <= feetech::MAX_ID {
        let family = table.model.family;
        let len = feetech::Instruction::Ping.encode(family, id, &mut out).unwrap();
        device.hear(&out[..len]);
        assert!(device.due_us().is_some());
    }
}

/// Every pulse length of the chip is a number, and not longer than the period.
pub(crate) fn pca9685_chip(bytes: &[u8]) {
    let mut chip = pca9685::Device::new(25e6);
    for transfer in bytes.split(|byte| *byte == BETWEEN) {
        chip.write(transfer);
    }
    for channel in 0..16 {
        assert!(chip.pulse_us(channel).is_none_or(|us| (0.0..=42_000.0).contains(&us)));
    }
}

fn drive(bus: &mut impl ServoBus, bytes: &[u8]) {
    let mut out = [0; 256];
    for piece in bytes.chunks(40) {
        bus.plan(&mut out).unwrap();
        bus.reply(piece);
        while bus.plan_more(10_000, &mut out).unwrap().is_some() {
            bus.reply(piece);
        }
        for servo in 0..bus.len() {
            let feedback = bus.feedback(servo);
            assert!(feedback.is_none_or(|feedback| {
                feedback.position_rad.abs() <= 1610.0 && feedback.velocity_rad_s.is_finite()
            }));
        }
    }
}
