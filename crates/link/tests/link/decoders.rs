//! Properties that hold for any bytes, used by the hostile host of the tests and by the fuzz targets in `tests/fuzz`.

use sinew_link::message::*;
use sinew_link::{
    Coordinate, Decoder, FRAME_MAX, Intake, LiveBuffer, LiveSettings, Message, Session, encode,
};

use super::common::wire::{frame_of, is_finite};

/// Feeds a stream of any bytes to both decoders.
pub(crate) fn stream(bytes: &[u8]) {
    any::<ToController>(bytes);
    any::<ToHost>(bytes);
}

/// Feeds a body of any bytes, with a correct CRC, to both decoders.
pub(crate) fn body(bytes: &[u8]) {
    any::<ToController>(&frame_of(&[&[0x53], bytes].concat()));
    any::<ToHost>(&frame_of(&[&[0x48], bytes].concat()));
}

/// Checks that a decoded message has only finite numbers, and survives writing and reading unchanged.
fn any<M: Message + PartialEq + std::fmt::Debug>(bytes: &[u8]) {
    let mut decoder = Decoder::<M>::new();
    decoder.feed(bytes, |message| {
        assert!(is_finite(&message), "{message:?}");
        let mut out = [0; FRAME_MAX];
        let wire = encode(&message, &mut out).expect("what was read can be written");
        let mut again = Decoder::<M>::new();
        assert_eq!(wire.iter().find_map(|&byte| again.push(byte)), Some(message));
    });
}

const SPEED: f32 = 2.0;

/// Feeds bodies of any bytes, each after its length, to a session and its live buffer, like a hostile host.
pub(crate) fn controller(bytes: &[u8]) {
    let about = About {
        protocol: Version::CURRENT,
        firmware: Release { major: 0, minor: 0, patch: 0 },
        rig: 0,
        capacities: Capacities {
            bodies: 1,
            coordinates: 1,
            dofs: 1,
            servos: 1,
            slots: 0,
            slot_bytes: 0,
        },
    };
    let mut session = Session::new(0);
    session.hello(Hello { protocol: Version::CURRENT, nonce: 0 }, about, false);
    let joints = [Coordinate::Scalar { speed: SPEED }; 2];
    let settings = LiveSettings::DEFAULT;
    let mut live = LiveBuffer::<4, 4>::new(&joints, settings).expect("the settings can be");
    let mut decoder = Decoder::<ToController>::new();
    let (mut rest, mut now_us) = (bytes, 0_u64);
    while let Some((&len, behind)) = rest.split_first() {
        let (body, behind) = behind.split_at(behind.len().min(usize::from(len)));
        rest = behind;
        now_us += u64::from(len) * 100;
        decoder.feed(&frame_of(&[&[0x53], body].concat()), |message| match message {
            ToController::Hello(hello) => {
                let before = session.id();
                let welcome = session.hello(hello, about, hello.nonce % 2 == 0);
                let told = if welcome.verdict.is_ok() { session.id() } else { Some(0) };
                assert_eq!(told, Some(welcome.session));
                assert!(welcome.verdict.is_ok() || session.id() == before);
            }
            ToController::Command(command) => match session.command(&command) {
                Intake::Execute => {
                    let ours = session.id() == Some(command.session);
                    assert!(ours || matches!(command.item, Command::EStop | Command::Stop));
                    let (seq, done) = (command.seq, Outcome::Applied(Applied::Done));
                    let answer = session.answer(command.session, seq, done);
                    // The message arrived; it must now count as a duplicate.
                    let again = session.command(&command);
                    assert!(
                        !ours || command.item == Command::EStop || again == Intake::Answer(answer)
                    );
                }
                Intake::Answer(answer) => {
                    assert_eq!((answer.session, answer.seq), (command.session, command.seq));
                }
            },
            ToController::Stream(message) => {
                let order = session.stream(&message);
                assert_eq!(order.is_some(), session.id() == Some(message.session));
                if let Stream::Live(frame) = message.item {
                    let _ = live.push(&frame, now_us);
                }
            }
        });
        let before = live.step(now_us).q.to_vec();
        let after = live.step(now_us + 2_000).q;
        for (before, after) in before.iter().zip(after) {
            // Tolerance: f32 rounding of numbers up to 10⁶.
            let most = SPEED * settings.tick_s + 1e-7 * before.abs();
            assert!((after - before).abs() <= most, "{before} to {after}");
        }
    }
}
