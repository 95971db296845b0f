//! Pages without the token, and pages that break rules. None of their messages reaches the board.

use std::io::{Read as _, Write as _};
use std::net::TcpStream;
use std::thread::sleep;
use std::time::{Duration, Instant};

use serde_json::json;
use sinew_link::message::Command;

use crate::client::{LIMP, Page, exchange, upgrade};
use crate::other_side::OtherSide;

/// Returns whether the board got a command that could move a rig.
fn was_moved(console: &OtherSide) -> bool {
    let told = console.told.lock().unwrap();
    let moves = |command: &Command| {
        matches!(command, Command::Arm | Command::Play(_) | Command::Stop | Command::EStop)
    };
    told.commands.iter().any(moves) || !told.jogs.is_empty()
}

#[test]
fn strangers_are_refused() {
    let console = OtherSide::start(false);
    let host = &console.host;
    let own = format!("http://{host}");
    let page = exchange(host, &format!("GET / HTTP/1.1\r\nHost: {host}\r\n\r\n"));
    assert!(page.starts_with("HTTP/1.1 200 ") && page.contains("frame-ancestors 'none'"), "{page}");
    let refused = |request: &str, status: &str| {
        let answer = exchange(host, request);
        assert!(answer.starts_with(&format!("HTTP/1.1 {status} ")), "{request}: {answer}");
    };
    refused("GET / HTTP/1.1\r\nHost: evil.example\r\n\r\n", "403");
    refused(&format!("POST /arm HTTP/1.1\r\nHost: {host}\r\nContent-Length: 2\r\n\r\n{{}}"), "405");
    refused(&upgrade(host, None), "403");
    refused(&upgrade(host, Some("http://evil.example")), "403");
    refused(&upgrade("evil.example", Some(&own)), "403");
    for token in ["", "0", &"0".repeat(32), &console.token[1..], &console.token.to_uppercase()] {
        let mut stranger = Page::mute(host);
        stranger.say(&json!({ "type": "hello", "token": token }));
        stranger.hear().unwrap();
        assert_eq!(stranger.texts, [json!({ "type": "closed", "code": 4001 })], "{token}");
    }
    let mut impatient = Page::mute(host);
    impatient.say(&json!({ "type": "estop" }));
    impatient.hear().unwrap();
    assert_eq!(impatient.texts[0]["code"], 4001, "not even a stop without the token");
    assert!(!was_moved(&console));
}

#[test]
fn a_request_of_a_byte_a_second_is_dropped() {
    let console = OtherSide::start(false);
    let begun = Instant::now();
    let mut slow = TcpStream::connect(&console.host).unwrap();
    slow.set_read_timeout(Some(Duration::from_millis(200))).unwrap();
    let mut mute = Page::mute(&console.host);
    let is_open = |stream: &mut TcpStream| {
        let written = stream.write_all(b"G");
        let read = stream.read(&mut [0; 64]);
        written.is_ok()
            && read
                .map_or_else(|error| error.kind() != std::io::ErrorKind::ConnectionReset, |n| n > 0)
    };
    while is_open(&mut slow) {
        assert!(begun.elapsed() < Duration::from_secs(8), "it is still open");
        sleep(Duration::from_millis(300));
    }
    assert!(begun.elapsed() > Duration::from_secs(4));
    // A socket whose token does not come is closed as well.
    while mute.hear().is_ok() {}
    assert!(begun.elapsed() < Duration::from_secs(8));
}

#[test]
fn a_message_that_is_too_long_ends_the_connection() {
    let console = OtherSide::start(false);
    let mut viewer = Page::open(&console);
    for bytes in [5_000_u64, 100 << 20] {
        let mut page = Page::open(&console);
        // The head of a text of this length, and its mask; the text never comes.
        let mut head = vec![0x81, 0xFF];
        head.extend(bytes.to_be_bytes());
        head.extend([0; 4]);
        page.stream().write_all(&head).unwrap();
        while page.hear().is_ok() {}
        let closed = page.texts.iter().find(|text| text["type"] == "closed");
        assert_eq!(closed.map(|text| text["code"].clone()), Some(json!(1009)), "{bytes}");
    }
    // Others see nothing of it.
    viewer.until_state(LIMP);
    assert!(!was_moved(&console));
}

#[test]
fn a_flood_of_connections_leaves_the_page_alone() {
    let console = OtherSide::start(false);
    let mut page = Page::open(&console);
    page.until_state(LIMP);
    let flood: Vec<TcpStream> =
        (0..200).filter_map(|_| TcpStream::connect(&console.host).ok()).collect();
    assert!(flood.len() > 100);
    let begun = Instant::now();
    let (is_done, text) = page.ask(json!({ "type": "hold" }));
    assert!(is_done && begun.elapsed() < Duration::from_millis(500), "{text}");
    drop(flood);
    // New pages come in again.
    let begun = Instant::now();
    while TcpStream::connect(&console.host)
        .and_then(|mut stream| {
            stream.write_all(
                format!("GET / HTTP/1.1\r\nHost: {}\r\n\r\n", console.host).as_bytes(),
            )?;
            stream.read_exact(&mut [0; 12])
        })
        .is_err()
    {
        assert!(begun.elapsed() < Duration::from_secs(8));
        sleep(Duration::from_millis(50));
    }
    Page::open(&console).until_state(LIMP);
}
