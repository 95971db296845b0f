//! Tests a million damaged replies of each protocol. No goal outside of its limits is sent, the bus believes only
//! replies that arrived whole from the servo that was asked, and a whole reply after damage is not lost.

mod dynamixel;
mod fast;
mod feetech;
mod flips;
mod random;
mod resync;
mod run;

use dynamixel::Dynamixel;
use feetech::Feetech;
use run::{Count, run};
use sinew_servo_bus::Timing;

const TIMING: Timing = Timing { baud: 1_000_000, return_delay_us: 0, turnaround_us: 0 };
/// Length of the longest reply that a master reads, bytes.
const MASTER_WINDOW: usize = 32;

/// Returns the expected number of chance events plus three standard deviations.
fn at_most(expected: f64) -> usize {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "some hundreds")]
    let most = (expected + 3.0 * expected.sqrt()) as usize;
    most
}

/// Checks the counts of a run with Dynamixel, for both kinds of reads.
fn check_dynamixel(count: &Count) {
    println!("{count:#?}");
    assert!(count.damaged + count.whole + count.behind_tear >= 1_000_000 && count.goals > 500_000);
    // The CRC detects all short damage, and 65,535 of 65,536 cases of other damage. Few of the rest give a plausible
    // reading.
    assert_eq!((count.wrong, count.foreign, count.doubted), (0, 0, 0));
    // A damaged reply may use the beginning of the next reply as its own end, and have a right CRC by chance.
    assert!(count.hidden <= at_most(count.damaged as f64 / 65_536.0));
}

#[test]
fn dynamixel_replies() {
    let wire = Dynamixel::new();
    check_dynamixel(&run(&mut wire.bus(false), &wire, 220_000, 2));
}

/// All servos answer in one packet: the parts before the damage are kept, the others are asked for again.
#[test]
fn fast_replies() {
    let wire = Dynamixel::new();
    let count = run(&mut wire.bus(true), &wire, 180_000, 8);
    check_dynamixel(&count);
    // Each part has its own known place, so no other part can be taken for it.
    assert_eq!(count.hidden, 0);
}

/// Runs and checks Feetech, for either family.
fn check_feetech<const IS_SCS: bool>(wire: &Feetech<IS_SCS>, ticks: usize) -> Count {
    let count = run(&mut wire.bus(), wire, ticks, 2);
    println!("{count:#?}");
    // A reply that names another servo and has a right sum is not near the last reading of that servo.
    assert_eq!(count.foreign, 0);
    let damaged = count.damaged as f64;
    // Bits are flipped in one of seven damaged replies.
    let flipped = damaged / 7.0 * wire.believed_flips();
    // In three of seven replies a byte is lost or added. If it is the status or one of the two bytes of the position,
    // the position moves. Then one sum in 256 is right, and `near_share` of the positions are near.
    let moved = damaged * 3.0 / 7.0 * wire.moved_share() / 256.0 * wire.near_share();
    println!("wrong positions expected: {flipped:.1} of flipped bits, {moved:.1} of moved bytes");
    assert!(count.wrong_positions <= at_most(flipped + moved));
    // After a wrong position, a right position may be too far away. The next reading confirms it.
    assert!(count.doubted <= count.wrong_positions);
    // A damaged reply may use the beginning of the next reply as its own end: then one sum in 256 is right.
    assert!(count.hidden <= at_most(damaged / 256.0));
    count
}

#[test]
fn sts_replies() {
    let count = check_feetech(&Feetech::<false>::new(), 150_000);
    assert!(count.damaged + count.whole >= 1_000_000 && count.goals > 300_000);
}

/// Tests servos that are asked one by one.
#[test]
fn scs_replies() {
    let count = check_feetech(&Feetech::<true>::new(), 40_000);
    assert!(count.damaged + count.whole >= 150_000 && count.goals > 50_000);
}
