//! Runs the corpus through all decoders.

use super::{decoders, streams};

fn decode(bytes: &[u8]) {
    for (_, decode) in decoders::DECODERS {
        decode(bytes);
    }
}

#[test]
fn replay() {
    let streams = streams();
    assert!(streams.len() >= 50, "only {} streams", streams.len());
    for stream in &streams {
        decode(stream);
    }
}

/// Runs all decoders on pairs of streams in which a byte is changed, lost or doubled.
#[test]
fn replay_with_changes() {
    let streams = streams();
    let mut seed = 16_u32;
    let mut below = |count: usize| {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        usize::try_from(seed >> 8).unwrap() % count
    };
    for _ in 0..20_000 {
        let mut stream = streams[below(streams.len())].clone();
        stream.truncate(below(stream.len()) + 1);
        stream.extend(&streams[below(streams.len())]);
        let at = below(stream.len());
        match below(4) {
            0 => stream[at] = u8::try_from(below(256)).unwrap(),
            1 => stream[at] ^= 1 << below(8),
            2 => stream.insert(at, stream[at]),
            _ => {
                stream.remove(at);
            }
        }
        decode(&stream);
    }
}
