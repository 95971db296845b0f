//! Computes how often flipped bits leave Feetech's sum right and change the position. The result is computed, not
//! simulated.
//!
//! A few flips differ from random damage, of which one packet in 256 passes: two flips of the same bit in two bytes,
//! one up and one down, always pass.

/// Number of reply bytes before the status.
const ADDRESS: usize = 4;
/// Bytes of the position in a reply.
const POSITION: std::ops::Range<usize> = 5..7;
/// Maximum number of bits that [`Random::damage`](super::random::Random::damage) flips.
const MOST: usize = 8;

/// Number of ways to flip a given number of bits (outer index) that change the sum by a given amount (inner index).
type Ways = Vec<[f64; 256]>;

/// Returns the probability that the sum stays right and the bytes before the status stay unchanged, if one to eight
/// random bits of a reply are flipped (each number is equally likely). Each case is weighted by how often its
/// position would be believed.
pub(crate) fn believed(reply: &[u8], weight: impl Fn([u8; 2]) -> f64) -> f64 {
    let bits = reply.len() * 8;
    let positions = ways_of_position([reply[POSITION.start], reply[POSITION.start + 1]], weight);
    let others = ways_of_others(reply);
    let mut total = 0.0;
    let mut odd = [0.0; MOST + 2];
    odd[0] = 1.0;
    for _ in 0..MOST {
        odd = after_a_flip(odd, bits);
        for flipped in 1..=MOST {
            let right: f64 = (1..=flipped)
                .map(|of_position| {
                    let (position, other) =
                        (&positions[of_position], &others[flipped - of_position]);
                    (0..256).map(|sum| position[sum] * other[(256 - sum) % 256]).sum::<f64>()
                })
                .sum();
            total += odd[flipped] * right / choices(bits, flipped);
        }
    }
    total / MOST as f64
}

/// Returns the probabilities of the number of changed bits after one more flip of a random bit.
fn after_a_flip(before: [f64; MOST + 2], bits: usize) -> [f64; MOST + 2] {
    let mut after = [0.0; MOST + 2];
    for odd in 0..=MOST {
        let back = odd as f64 / bits as f64;
        after[odd + 1] += before[odd] * (1.0 - back);
        if odd > 0 {
            after[odd - 1] += before[odd] * back;
        }
    }
    after
}

fn choices(bits: usize, count: usize) -> f64 {
    (0..count).map(|nth| (bits - nth) as f64 / (nth + 1) as f64).product()
}

fn ways_of_position(bytes: [u8; 2], weight: impl Fn([u8; 2]) -> f64) -> Ways {
    let mut ways = vec![[0.0; 256]; MOST + 1];
    for change in 1..=u16::MAX {
        let [a, b] = change.to_le_bytes();
        let changed = [bytes[0] ^ a, bytes[1] ^ b];
        let sum = |bytes: [u8; 2]| bytes[0].wrapping_add(bytes[1]);
        let flipped = change.count_ones() as usize;
        if flipped <= MOST {
            let by = sum(changed).wrapping_sub(sum(bytes));
            ways[flipped][usize::from(by)] += weight(changed);
        }
    }
    ways
}

fn ways_of_others(reply: &[u8]) -> Ways {
    let mut ways = vec![[0.0; 256]; MOST + 1];
    ways[0][0] = 1.0;
    for (at, byte) in reply.iter().enumerate().skip(ADDRESS) {
        if POSITION.contains(&at) {
            continue;
        }
        for bit in 0..8 {
            let changed = byte ^ (1 << bit);
            let by = usize::from(changed.wrapping_sub(*byte));
            for flipped in (1..=MOST).rev() {
                for sum in 0..256 {
                    ways[flipped][(sum + by) % 256] += ways[flipped - 1][sum];
                }
            }
        }
    }
    ways
}
