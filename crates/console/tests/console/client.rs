//! A page without a browser, for tests.

use std::io::{Read as _, Write as _};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tungstenite::protocol::{Message, Role};
use tungstenite::{Error, WebSocket};

use crate::other_side::OtherSide;

/// Longest wait for the console. An emulated chip is several times slower than real time.
const PATIENCE: Duration = Duration::from_mins(1);

/// A frame: the state of the rig, as a page gets it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Picture {
    pub(crate) state: u8,
    pub(crate) flags: u8,
    pub(crate) measured: f32,
    pub(crate) wanted: f32,
}

pub(crate) const LIMP: u8 = 1;
pub(crate) const HOLDING: u8 = 5;
pub(crate) const PLAYING: u8 = 6;
pub(crate) const LOWERING: u8 = 9;
pub(crate) const FAULTED: u8 = 10;

pub(crate) struct Page {
    socket: WebSocket<TcpStream>,
    commands: u64,
    /// All text messages, and the newest frame.
    pub(crate) texts: Vec<Value>,
    pub(crate) picture: Option<Picture>,
}

/// Sends bytes, and returns all bytes that arrive until the console closes the connection or is silent for 1 s.
pub(crate) fn exchange(host: &str, request: &str) -> String {
    let mut stream = TcpStream::connect(host).unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(1))).unwrap();
    let _ = stream.write_all(request.as_bytes());
    let mut text = Vec::new();
    let _ = stream.read_to_end(&mut text);
    String::from_utf8_lossy(&text).into_owned()
}

/// Returns the head of a request for a WebSocket.
pub(crate) fn upgrade(host: &str, origin: Option<&str>) -> String {
    let origin = origin.map_or(String::new(), |origin| format!("Origin: {origin}\r\n"));
    format!(
        "GET /ws HTTP/1.1\r\nHost: {host}\r\n{origin}Upgrade: websocket\r\nConnection: Upgrade\r\n\
         Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
    )
}

impl Page {
    /// Opens a WebSocket, and sends nothing.
    pub(crate) fn mute(host: &str) -> Self {
        let mut stream = TcpStream::connect(host).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream.write_all(upgrade(host, Some(&format!("http://{host}"))).as_bytes()).unwrap();
        let mut head = Vec::new();
        while !head.ends_with(b"\r\n\r\n") {
            let mut byte = [0];
            stream.read_exact(&mut byte).unwrap();
            head.extend(byte);
        }
        assert!(head.starts_with(b"HTTP/1.1 101 "), "{}", String::from_utf8_lossy(&head));
        let socket = WebSocket::from_raw_socket(stream, Role::Client, None);
        Self { socket, commands: 0, texts: Vec::new(), picture: None }
    }

    /// Opens a page that sends the token, and waits until it has a role.
    pub(crate) fn open(console: &OtherSide) -> Self {
        Self::open_at(&console.host, &console.token)
    }

    pub(crate) fn open_at(host: &str, token: &str) -> Self {
        let mut page = Self::mute(host);
        page.say(&json!({ "type": "hello", "token": token }));
        page.until("a role", |page| page.texts.iter().any(|text| text["type"] == "role"));
        page
    }

    pub(crate) fn stream(&mut self) -> &mut TcpStream {
        self.socket.get_mut()
    }

    pub(crate) fn say(&mut self, message: &Value) {
        self.socket.send(Message::text(message.to_string())).unwrap();
    }

    /// Receives a message.
    pub(crate) fn hear(&mut self) -> Result<(), Error> {
        match self.socket.read()? {
            Message::Text(text) => self.texts.push(serde_json::from_str(&text).unwrap()),
            Message::Binary(bytes) => self.picture = Some(picture(&bytes)),
            Message::Close(close) => {
                let code = close.map_or(0, |close| close.code.into());
                self.texts.push(json!({ "type": "closed", "code": code }));
            }
            _ => {}
        }
        Ok(())
    }

    /// Receives messages until a condition is true, for at most [`PATIENCE`]. Meanwhile sends a ping every second.
    pub(crate) fn until(&mut self, what: &str, is_so: impl Fn(&Self) -> bool) {
        let mut said = Instant::now();
        let end = said + PATIENCE;
        while !is_so(self) {
            self.hear().unwrap();
            assert!(Instant::now() < end, "{what}: {:?}, {:?}", self.picture, self.texts.last());
            if said.elapsed() > Duration::from_secs(1) {
                said = Instant::now();
                self.say(&json!({ "type": "ping", "t": 0 }));
            }
        }
    }

    pub(crate) fn until_state(&mut self, state: u8) {
        self.until("a state", |page| page.picture.is_some_and(|own| own.state == state));
    }

    /// Sends a command, and returns whether it was executed, and the text of the answer.
    pub(crate) fn ask(&mut self, mut command: Value) -> (bool, String) {
        self.commands += 1;
        let id = self.commands;
        command["id"] = id.into();
        self.say(&command);
        let is_answer = |text: &Value| text["type"] == "answer" && text["id"] == id;
        self.until("an answer", |page| page.texts.iter().any(is_answer));
        let answer = self.texts.iter().find(|text| is_answer(text)).unwrap();
        (answer["ok"] == true, answer["text"].as_str().unwrap().to_owned())
    }

    /// Arms the rig, and waits until it holds.
    pub(crate) fn arm(&mut self) {
        self.until_state(LIMP);
        let (is_done, text) = self.ask(json!({ "type": "arm" }));
        assert!(is_done, "{text}");
        self.until_state(HOLDING);
    }

    /// Sends a slider's goal every 50 ms for a time.
    pub(crate) fn slide(&mut self, goal: f32, time: Duration) {
        let end = Instant::now() + time;
        let mut due = Instant::now();
        while Instant::now() < end {
            if Instant::now() >= due {
                due += Duration::from_millis(50);
                self.say(&json!({ "type": "jog", "dof": 0, "goal": goal }));
            }
            // Pictures come every 33 ms.
            self.hear().unwrap();
        }
    }

    pub(crate) fn shown(&self) -> Picture {
        self.picture.unwrap()
    }
}

/// Reads the state, flags, and first measured and wanted coordinates of a frame.
fn picture(bytes: &[u8]) -> Picture {
    let number = |at: usize| f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    let count = usize::from(u16::from_le_bytes([bytes[18], bytes[19]]));
    Picture {
        state: bytes[1],
        flags: bytes[3],
        measured: number(24),
        wanted: number(24 + 4 * count),
    }
}
