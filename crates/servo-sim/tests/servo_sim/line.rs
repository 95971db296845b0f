//! Tests a stream of bytes: which bytes arrive, and when.

use proptest::prelude::*;
use sinew_servo_bus::dynamixel::Instruction;
use sinew_servo_bus::feetech::{self, Family};
use sinew_servo_sim::bench::Bench;
use sinew_servo_sim::device::MEMORY_LEN;
use sinew_servo_sim::fault::FaultOrder;
use sinew_servo_sim::kind::Kind;
use sinew_servo_sim::line::{Line, LineDevice};
use sinew_servo_sim::load::Arm;
use sinew_servo_sim::registers::{RegisterServo, Registers};
use sinew_servo_sim::supply::Supply;

use crate::common::{BAUD, bench, registers};

fn ping(id: u8) -> Vec<u8> {
    let mut packet = vec![0; 16];
    let len = Instruction::Ping.encode(id, &mut packet).unwrap();
    packet.truncate(len);
    packet
}

/// Reads all bytes until none arrive for `timeout_us`.
fn all<W: LineDevice>(line: &mut Line<W>, timeout_us: u32) -> Vec<u8> {
    let (mut all, mut out) = (Vec::new(), [0; 64]);
    loop {
        match line.read(&mut out, timeout_us) {
            0 => return all,
            count => all.extend_from_slice(&out[..count]),
        }
    }
}

fn with<R>(faults: &[&str], use_it: impl FnOnce(&mut Line<Bench<'_, Vec<Arm>>>) -> R) -> R {
    let mut memory = registers(3);
    let mut bench = bench(&mut memory, Arm::default(), Supply::stiff(5.0));
    for fault in faults {
        let order: FaultOrder = fault.parse().unwrap();
        let id: usize = order.servo.parse().unwrap();
        bench.faults.push(order.of(id - 1));
    }
    use_it(&mut Line::new(bench))
}

#[test]
fn an_answer_comes_when_its_last_byte_is_over_the_wire() {
    with(&[], |line| {
        // 10 bytes, a return delay of 2 us, 14 bytes; 10 bits each at 2 Mbps.
        assert_eq!(BAUD, 2_000_000);
        line.write(&ping(2));
        line.run_until(50_000 + 2_000 + 69_999);
        assert_eq!(line.take(&mut [0; 64]), 0);
        line.run_until(50_000 + 2_000 + 70_000);
        let mut reply = [0; 64];
        assert_eq!(line.take(&mut reply), 14);
        assert_eq!(reply[4], 2);
    });
}

#[test]
fn what_is_written_while_the_wire_is_busy_waits() {
    with(&[], |line| {
        line.write(&ping(1));
        line.write(&ping(2)[..4]);
        line.write(&ping(2)[4..]);
        // The second question arrives before the first is answered, and replaces it: the servos hear each other.
        assert_eq!(all(line, 5_000).len(), 14);
        line.write(&ping(3));
        assert_eq!(all(line, 5_000)[4], 3);
    });
}

#[test]
fn at_another_rate_nobody_understands() {
    with(&[], |line| {
        line.servos.set_rate(57_600);
        line.write(&ping(1));
        assert!(all(line, 20_000).is_empty());
        line.servos.set_rate(BAUD);
        line.write(&ping(1));
        assert_eq!(all(line, 20_000).len(), 14);
    });
}

#[test]
fn all_answer_a_broadcast_though_one_is_silent() {
    for (faults, ids) in [(&[][..], &[1, 2, 3][..]), (&["2:silent"], &[1, 3])] {
        with(faults, |line| {
            line.write(&ping(254));
            let said = all(line, 10_000);
            let found: Vec<u8> = said.chunks(14).map(|reply| reply[4]).collect();
            assert_eq!(found, ids);
        });
    }
}

#[test]
fn faults_come_when_they_are_ordered() {
    let at = |fault: &str, ns: u64| {
        with(&[fault], |line| {
            line.run_until(ns);
            line.write(&ping(2));
            all(line, 5_000)
        })
    };
    let right = at("1:silent", 0);
    assert_eq!(right.len(), 14);
    for (fault, damaged) in [
        ("2:silent@1s+1s", vec![]),
        ("2:late=6ms@1s+1s", vec![]),
        ("2:late=4ms@1s+1s", right.clone()),
        ("2:short=5@1s+1s", right[..5].to_vec()),
    ] {
        assert_eq!(at(fault, 500_000_000), right, "{fault}");
        assert_eq!(at(fault, 1_500_000_000), damaged, "{fault}");
        assert_eq!(at(fault, 2_500_000_000), right, "{fault}");
    }
    let other = at("2:wrong-id=9", 0);
    assert!(other[4] == 9 && other[12..] != right[12..]);
    let torn = at("2:wrong-crc", 0);
    assert!(torn[..13] == right[..13] && torn[13] != right[13]);
}

#[test]
fn registers_alone_are_at_once_where_they_were_sent() {
    let mut memory = [0; MEMORY_LEN];
    let table = Kind::named("scs0009").unwrap().registers().unwrap();
    let servo = RegisterServo::new(table, 5, 1_000_000, &mut memory).unwrap();
    let mut line = Line::new(Registers::new(vec![servo]));
    let mut packet = [0; 32];
    for instruction in [
        feetech::Instruction::Write { address: 42, data: &[0x01, 0x23] },
        feetech::Instruction::Read { address: 56, length: 2 },
    ] {
        let len = instruction.encode(Family::Scs, 5, &mut packet).unwrap();
        line.write(&packet[..len]);
        let said = all(&mut line, 5_000);
        if matches!(instruction, feetech::Instruction::Read { .. }) {
            assert_eq!(said[5..7], [0x01, 0x23]);
        }
    }
}

proptest! {
    /// For any bytes, split in any way, the line becomes silent and can answer again.
    #[test]
    fn any_bytes_in_any_pieces_leave_it_able_to_answer(
        pieces in prop::collection::vec((prop::collection::vec(any::<u8>(), 0..40), 0_u64..3_000_000), 0..12),
    ) {
        with(&[], |line| {
            for (bytes, pause_ns) in &pieces {
                line.write(bytes);
                let now_ns = line.servos.now_ns();
                line.run_until(now_ns + pause_ns);
            }
            all(line, 20_000);
            assert_eq!(line.next_ns(), None);
            // The random bytes may have changed an id, with a probability of about 2^-24; a broadcast still reaches the
            // servo.
            line.write(&ping(254));
            assert_eq!(all(line, 20_000).len(), 3 * 14);
        });
    }
}
