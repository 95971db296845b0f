//! Every message survives encoding and decoding, and no bytes do harm.

use proptest::prelude::*;
use sinew_link::message::*;
use sinew_link::{BODY_MAX, Decoder, EncodeError, FRAME_MAX, Message, encode};

use crate::common::Random;
use crate::common::messages::{to_controller, to_host};
use crate::common::wire::{body_of, crc32, frame, frame_of, is_finite};

fn decode<M: Message>(bytes: &[u8]) -> (Vec<M>, Decoder<M>) {
    let mut decoder = Decoder::new();
    let mut messages = Vec::new();
    decoder.feed(bytes, |message| messages.push(message));
    (messages, decoder)
}

proptest! {
    #[test]
    fn messages_to_the_controller_round_trip(seed: u64) {
        let message = to_controller(&mut Random(seed));
        prop_assert_eq!(decode::<ToController>(&frame(&message)).0, vec![message]);
    }

    #[test]
    fn messages_to_the_host_round_trip(seed: u64) {
        let message = to_host(&mut Random(seed));
        prop_assert_eq!(decode::<ToHost>(&frame(&message)).0, vec![message]);
    }

    /// Decodes with this test's own COBS and CRC-32.
    #[test]
    fn frames_are_what_the_page_says(seed: u64) {
        let frame = frame(&to_host(&mut Random(seed)));
        prop_assert!(frame.len() <= FRAME_MAX);
        let inside = &frame[1..frame.len() - 1];
        prop_assert!(frame.starts_with(&[0]) && frame.ends_with(&[0]) && !inside.contains(&0));
        prop_assert_eq!(frame_of(&body_of(&frame)), frame);
    }

    #[test]
    fn random_bytes_do_no_harm(bytes in prop::collection::vec(any::<u8>(), 0..2000), seed: u64) {
        let message = to_controller(&mut Random(seed));
        let stream = [bytes, frame(&message)].concat();
        let (messages, decoder) = decode::<ToController>(&stream);
        prop_assert_eq!(messages.last(), Some(&message));
        prop_assert_eq!(decoder.messages() as usize, messages.len());
    }

    /// Flipped bits in a frame leave its neighbours intact.
    #[test]
    fn damage_spoils_its_own_frame_only(seed: u64, flips in prop::collection::vec(any::<u32>(), 1..20)) {
        let mut random = Random(seed);
        let [a, b, c] = [0; 3].map(|_| to_controller(&mut random));
        let mut damaged = frame(&b);
        for flip in flips {
            let bit = flip as usize % (damaged.len() * 8);
            damaged[bit / 8] ^= 1 << (bit % 8);
        }
        let whole = damaged == frame(&b);
        let stream = [frame(&a), damaged, frame(&c)].concat();
        let expected = if whole { vec![a, b, c] } else { vec![a, c] };
        // A changed final zero may leave the frame intact: this is not damage.
        let (messages, _) = decode::<ToController>(&stream);
        prop_assert!(messages == expected || messages.len() == 3);
    }

    /// Any bytes with a correct CRC cause no panic, and give no number that is not finite.
    #[test]
    fn bodies_of_any_bytes_do_no_harm(mut body in prop::collection::vec(any::<u8>(), 1..BODY_MAX), first in 0..4_u8) {
        body[0] = 0x53;
        if let Some(kind) = body.get_mut(1) {
            *kind = first;
        }
        prop_assert!(decode::<ToController>(&frame_of(&body)).0.iter().all(is_finite));
        body[0] = 0x48;
        prop_assert!(decode::<ToHost>(&frame_of(&body)).0.iter().all(is_finite));
    }
}

/// Puts NaN and infinities at every position of every message, with a correct CRC. None of them is accepted.
#[test]
fn no_field_takes_nan_or_infinity() {
    let mut random = Random(1);
    let (mut refused, mut taken) = (0, 0);
    for _ in 0..4000 {
        let (a, b) = (to_controller(&mut random), to_host(&mut random));
        for (body, to_host) in [(body_of(&frame(&a)), false), (body_of(&frame(&b)), true)] {
            let number = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY][random.below(3)];
            for place in 2..body.len().saturating_sub(3) {
                let mut body = body.clone();
                body[place..place + 4].copy_from_slice(&number.to_le_bytes());
                let wire = frame_of(&body);
                let finite = if to_host {
                    decode::<ToHost>(&wire).0.iter().map(is_finite).collect::<Vec<_>>()
                } else {
                    decode::<ToController>(&wire).0.iter().map(is_finite).collect()
                };
                assert!(finite.iter().all(|&finite| finite), "place {place} of {a:?} or {b:?}");
                *(if finite.is_empty() { &mut refused } else { &mut taken }) += 1;
            }
        }
    }
    println!("{refused} refused, {taken} taken as something else");
    assert!(refused > 10_000 && taken > 10_000);
}

#[test]
fn nothing_not_finite_is_sent() {
    let jog = |velocity| {
        let item = Stream::Jog { dof: 1, velocity };
        ToController::Stream(Numbered { session: 1, seq: 0, item })
    };
    for velocity in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        assert_eq!(encode(&jog(velocity), &mut [0; FRAME_MAX]), Err(EncodeError::NotFinite));
    }
    for room in 0..frame(&jog(1.0)).len() {
        let error = encode(&jog(1.0), &mut vec![0; room]).unwrap_err();
        assert_eq!(error, EncodeError::Room { has: room });
    }
}

/// The longest messages fill the longest body, and no message is longer.
#[test]
fn the_longest_message_fits() {
    let block = Block { offset: u32::MAX, bytes: [0; BLOCK_MAX].into_iter().collect() };
    let item = Command::UploadBlock(block);
    let message = ToController::Command(Numbered { session: u16::MAX, seq: u16::MAX, item });
    let wire = frame(&message);
    assert_eq!(body_of(&wire).len(), BODY_MAX);
    assert_eq!(decode::<ToController>(&wire).0, vec![message]);
    // Without a zero in the data, COBS adds the most bytes.
    let block = Block { offset: u32::MAX, bytes: [1; BLOCK_MAX].into_iter().collect() };
    let item = Command::UploadBlock(block);
    let longest = frame(&ToController::Command(Numbered { session: !0, seq: !0, item }));
    assert_eq!(longest.len(), FRAME_MAX);

    let mut random = Random(2);
    for _ in 0..100_000 {
        frame(&to_controller(&mut random));
        frame(&to_host(&mut random));
    }
}

#[test]
fn each_error_has_its_count() {
    let message = ToController::Hello(Hello { protocol: Version::CURRENT, nonce: 5 });
    let wire = frame(&message);
    let body = body_of(&wire);
    let damage = |bytes: &[u8]| decode::<ToController>(bytes).1.damage();

    assert_eq!(damage(&[&wire[..wire.len() - 2], &[0]].concat()).cut, 1);
    assert_eq!(damage(&[&[0], &[1; 300][..], &[0]].concat()).too_long, 1);
    assert_eq!(damage(&[&[0], &[7; 3000][..], &[0]].concat()).too_long, 1);
    assert_eq!(damage(&[0, 3, 1, 1, 0]).too_short, 1);
    let mut flipped = wire.clone();
    flipped[3] ^= 0x40;
    assert_eq!(damage(&flipped).total(), 1);
    assert_eq!(damage(&frame(&to_host(&mut Random(3)))).direction, 1);
    assert_eq!(damage(&frame_of(&[&body[..], &[0]].concat())).message, 1);
    assert_eq!(damage(&frame_of(&body[..body.len() - 1])).message, 1);
    assert_eq!(damage(&frame_of(&[0x53, 9])).message, 1);
    assert_eq!(damage(&[0; 50]).total(), 0);
    assert_eq!(crc32(b"123456789"), 0xCBF4_3926);
}

/// One to four wrong bits of the longest body and its CRC never give a correct CRC.
#[test]
fn any_four_wrong_bits_are_found() {
    // The effect of a bit on the CRC does not depend on other bits, because the CRC is linear.
    let zeros = vec![0; BODY_MAX];
    let of_zeros = crc32(&zeros);
    let in_body = (0..BODY_MAX * 8).map(|bit| {
        let mut body = zeros.clone();
        body[bit / 8] |= 1 << (bit % 8);
        crc32(&body) ^ of_zeros
    });
    let bits: Vec<u32> = in_body.chain((0..32).map(|bit| 1 << bit)).collect();
    let mut pairs: Vec<u32> = Vec::new();
    for (index, a) in bits.iter().enumerate() {
        pairs.extend(bits[..index].iter().map(|b| a ^ b));
    }
    pairs.sort_unstable();
    // Two equal pairs mean four bits, or two that cancel. A pair that equals a bit means three bits.
    assert!(pairs.windows(2).all(|pair| pair[0] != pair[1]));
    assert!(bits.iter().all(|bit| *bit != 0 && pairs.binary_search(bit).is_err()));
    assert!(pairs.binary_search(&0).is_err());
}
