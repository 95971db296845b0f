//! A hostile host sends intact frames with random fields, and random bytes.

use sinew_link::message::{Numbered, ToController};

use crate::common::Random;
use crate::common::messages::{to_controller, to_host};
use crate::common::wire::{body_of, frame};
use crate::decoders;

/// Returns the body of a random message without its direction, with some bytes changed, lost or added.
fn bent(random: &mut Random) -> Vec<u8> {
    let wire = if random.chance(0.7) {
        let mut message = to_controller(random);
        // Most messages belong to the session of a new controller.
        if let ToController::Command(Numbered { session, seq, .. }) = &mut message
            && random.chance(0.8)
        {
            (*session, *seq) = (1, *seq % 64);
        }
        frame(&message)
    } else {
        frame(&to_host(random))
    };
    let mut body = body_of(&wire).split_off(1);
    for _ in 0..random.below(4) {
        let place = random.below(body.len().max(1));
        match random.below(4) {
            0 if place < body.len() => drop(body.remove(place)),
            1 => body.insert(place.min(body.len()), random.bits().to_le_bytes()[0]),
            // The highest byte of a number that is not finite.
            2 if place + 1 < body.len() => (body[place], body[place + 1]) = (0x80, 0x7F),
            _ if place < body.len() => body[place] ^= 1 << random.below(8),
            _ => {}
        }
    }
    body
}

#[test]
fn bent_messages() {
    let mut random = Random(50);
    for _ in 0..100_000 {
        decoders::body(&bent(&mut random));
    }
}

#[test]
fn bent_conversations() {
    let mut random = Random(51);
    for _ in 0..3000 {
        let mut bytes = Vec::new();
        for _ in 0..30 {
            let body = bent(&mut random);
            let Ok(len) = u8::try_from(body.len()) else { continue };
            bytes.push(len);
            bytes.extend(body);
        }
        decoders::controller(&bytes);
    }
}

#[test]
fn random_streams() {
    let mut random = Random(52);
    for _ in 0..20_000 {
        let bytes = random.bytes::<400>();
        decoders::stream(&bytes);
        decoders::controller(&bytes);
    }
}
