//! The host link: arbitrary bytes as messages, arbitrary messages as bytes, both sides of a session, live frames,
//! telemetry.

use core::hint::black_box;

use sinew_link::message::{
    FaultRecord, Hello, Operator, Pass, Snapshot, SnapshotPart, Stream, Telemetry, TelemetryParts,
    ToController, ToHost,
};
use sinew_link::{
    Coordinate, Decoder, LiveBuffer, LiveSettings, Message, Sender, Session, Window, encode, rate,
};

use super::{slice, slice_mut};

/// Number of coordinates of a rig's pose.
const COORDINATES: usize = 40;

/// Number of frames in the live buffer.
const FRAMES: usize = 16;

/// Returns an arbitrary message.
fn message<M: Message>() -> Option<M> {
    black_box(Decoder::new()).push(black_box(1))
}

fn both_ways<M: Message>() {
    let mut decoder = black_box(Decoder::<M>::new());
    decoder.feed(slice(), |message| {
        black_box(&encode(black_box(&message), slice_mut()));
    });
    black_box((decoder.messages(), decoder.damage().total()));
}

#[inline(never)]
pub(crate) fn frames() {
    both_ways::<ToController>();
    both_ways::<ToHost>();
    black_box(rate::frame_len(black_box(1)));
    black_box(black_box(None::<Pass>).map(|pass| pass.sending_us(black_box(1))));
}

#[inline(never)]
pub(crate) fn controller() {
    let mut session = black_box(Session::new(black_box(1)));
    match message() {
        Some(ToController::Hello(Hello { protocol, nonce })) => {
            if let Some(ToHost::Welcome(welcome)) = message() {
                black_box(welcome.about.protocol.fit(protocol).is_ok());
                let hello = black_box(Hello { protocol, nonce });
                black_box(&session.hello(hello, welcome.about, black_box(true)));
            }
        }
        Some(ToController::Command(command)) => _ = black_box(&session.command(&command)),
        Some(ToController::Stream(item)) => _ = black_box(&session.stream(&item)),
        None => {}
    }
    if let Some(ToHost::Answer(answer)) = message() {
        black_box(&session.answer(answer.session, answer.seq, answer.item));
    }
    black_box((session.id(), session.counts()));
    let mut window = black_box(Window::new());
    black_box((window.take(black_box(1)), window.counts()));
}

#[inline(never)]
pub(crate) fn host() {
    black_box(slice::<FaultRecord>().first().map(FaultRecord::is_warning));
    let mut sender = black_box(Sender::new(black_box(1)));
    if let Some(ToController::Command(command)) = message() {
        black_box(&sender.send(command.item, black_box(1)));
    }
    black_box(sender.stream(black_box(Stream::HoldToRun(Operator(1)))));
    black_box(&sender.poll(black_box(1)));
    if let Some(ToHost::Answer(answer)) = message() {
        black_box(&sender.take(&answer));
    }
}

#[inline(never)]
pub(crate) fn live() {
    let joints = slice::<Coordinate>();
    black_box(joints.iter().any(|joint| joint.len() == 4 || joint.is_empty()));
    let settings = black_box(LiveSettings::DEFAULT);
    let Ok(live) = LiveBuffer::<COORDINATES, FRAMES>::new(joints, settings) else { return };
    let mut live = black_box(live);
    black_box(&live.start(slice()));
    if let Some(ToController::Stream(item)) = message()
        && let Stream::Live(frame) = item.item
    {
        black_box(&live.push(&frame, black_box(1)));
    }
    black_box(&live.step(black_box(1)));
    black_box(live.counts());
}

#[inline(never)]
pub(crate) fn telemetry() {
    let parts = black_box(TelemetryParts::SUMMARY).and(black_box(TelemetryParts::POSE));
    black_box(parts.has(black_box(TelemetryParts::ALL)));
    if let Some(ToHost::Telemetry(Telemetry { part: SnapshotPart::Summary(summary), .. })) =
        message()
    {
        black_box(summary.state.number());
        let (q, dofs, servos) = (slice(), slice(), slice());
        let snapshot = Snapshot { tick: black_box(1), summary: &summary, q, dofs, servos };
        black_box(snapshot.frames(parts));
        black_box(&snapshot.frame(parts, black_box(1), black_box(1)));
    }
    let size = black_box(rate::RigSize { coordinates: 1, dofs: 1, servos: 1 });
    black_box((rate::telemetry_hz(black_box(1), size, parts), rate::snapshot_len(size, parts)));
    black_box(rate::frames_per_second(black_box(1), black_box(1)));
}
