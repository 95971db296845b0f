//! States and feeds of the link are the supervisor's, with the same numbers and names.

use sinew_firmware::supervisor::{self, State};
use sinew_link::message;

#[test]
fn states_have_the_same_numbers_and_names() {
    assert_eq!(message::State::ALL.len(), State::COUNT);
    for (told, state) in message::State::ALL.into_iter().zip(State::ALL) {
        assert_eq!((told.number(), told.to_string()), (state.number(), state.to_string()));
    }
}

#[test]
fn feeds_have_the_same_names() {
    use supervisor::Feed::{Jog, Live, Show};
    for feed in [Show, Live, Jog] {
        let told = match feed {
            Show => message::Feed::Show,
            Live => message::Feed::Live,
            Jog => message::Feed::Jog,
        };
        assert_eq!(told.to_string(), feed.to_string());
    }
}
