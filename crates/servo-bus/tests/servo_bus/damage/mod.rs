//! A million damaged replies of each protocol: no goal outside of its limits is sent, nothing is believed that did not
//! come whole from the servo that was asked, and a whole reply behind damage is not lost.

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
/// The longest reply that a master reads, bytes.
const MASTER_WINDOW: usize = 32;

/// So many by chance, and three standard deviations more.
fn at_most(expected: f64) -> usize {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "some hundreds")]
    let most = (expected + 3.0 * expected.sqrt()) as usize;
    most
}

/// What holds for Dynamixel, however it is read.
fn check_dynamixel(count: &Count) {
    println!("{count:#?}");
    assert!(count.damaged + count.whole + count.behind_tear >= 1_000_000 && count.goals > 500_000);
    // The CRC finds all damage that is short and 65,535 of 65,536 of the rest; of that, little is a reading that is
    // near.
    assert_eq!((count.wrong, count.foreign, count.doubted), (0, 0, 0));
    // A damaged reply may take the beginning of the next one for its own end, and have a right CRC by chance.
    assert!(count.hidden <= at_most(count.damaged as f64 / 65_536.0));
}

#[test]
fn dynamixel_replies() {
    let wire = Dynamixel::new();
    check_dynamixel(&run(&mut wire.bus(false), &wire, 220_000, 2));
}

/// All in one packet: what is in front of the damage is kept, what is behind it is asked for again.
#[test]
fn fast_replies() {
    let wire = Dynamixel::new();
    let count = run(&mut wire.bus(true), &wire, 180_000, 8);
    check_dynamixel(&count);
    // Each part is told by its own place, and nothing can run into it.
    assert_eq!(count.hidden, 0);
}

/// What holds for Feetech, of either family.
fn check_feetech<const IS_SCS: bool>(wire: &Feetech<IS_SCS>, ticks: usize) -> Count {
    let count = run(&mut wire.bus(), wire, ticks, 2);
    println!("{count:#?}");
    // A reply that names another servo and has a right sum is not near that one's last reading.
    assert_eq!(count.foreign, 0);
    let damaged = count.damaged as f64;
    // Bits are flipped in one of seven damaged replies.
    let flipped = damaged / 7.0 * wire.believed_flips();
    // In three of seven a byte is lost or put in. Of its places, the status' and two of the position's move the
    // position itself; then one sum in 256 is right, and one position in so many near.
    let moved = damaged * 3.0 / 7.0 * wire.moved_share() / 256.0 * wire.near_share();
    println!("wrong positions expected: {flipped:.1} of flipped bits, {moved:.1} of moved bytes");
    assert!(count.wrong_positions <= at_most(flipped + moved));
    // Behind a wrong one a right one may be too far away. The next one confirms it.
    assert!(count.doubted <= count.wrong_positions);
    // A damaged reply may take the beginning of the next one for its own end: then one sum in 256 is right.
    assert!(count.hidden <= at_most(damaged / 256.0));
    count
}

#[test]
fn sts_replies() {
    let count = check_feetech(&Feetech::<false>::new(), 150_000);
    assert!(count.damaged + count.whole >= 1_000_000 && count.goals > 300_000);
}

/// Servos that are asked one by one.
#[test]
fn scs_replies() {
    let count = check_feetech(&Feetech::<true>::new(), 40_000);
    assert!(count.damaged + count.whole >= 150_000 && count.goals > 50_000);
}
