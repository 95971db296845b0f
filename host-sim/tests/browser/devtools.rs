//! A headless browser, driven through the protocol of its developer tools: commands and events as JSON, on one
//! WebSocket. Crates with the whole protocol are generated code that compiles for a minute; these tests use about
//! twelve methods.

use std::io::{self, BufRead as _, BufReader, Read as _, Write as _};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use serde_json::{Value, json};
use tungstenite::protocol::Role;
use tungstenite::{Message, WebSocket};

/// Longest duration of a command. A test that waits longer fails instead of hanging.
const PATIENCE: Duration = Duration::from_mins(2);

/// A browser with one tab.
pub(crate) struct Browser {
    process: Child,
    socket: WebSocket<TcpStream>,
    /// Session of the tab; empty until there is a tab.
    session: String,
    commands: u64,
    /// Events of the tab, in order.
    pub(crate) events: Vec<Value>,
}

impl Browser {
    /// Starts the browser, with an empty tab.
    pub(crate) fn start(profile: &Path) -> Self {
        let chromium =
            std::env::var_os("SINEW_CHROMIUM").expect("SINEW_CHROMIUM names the browser");
        let mut process = Command::new(chromium)
            // A container has no sandbox; the page is trusted.
            .args(["--headless", "--no-sandbox", "--disable-dev-shm-usage", "--no-first-run"])
            .args(["--disable-background-networking", "--disable-component-update"])
            .args(["--disable-extensions", "--disable-quic", "--no-proxy-server"])
            .args(["--remote-debugging-port=0", "--window-size=1280,900"])
            .arg(format!("--user-data-dir={}", profile.display()))
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the browser starts");
        let mut lines = BufReader::new(process.stderr.take().expect("it is piped"));
        let url = loop {
            let mut line = String::new();
            assert!(lines.read_line(&mut line).unwrap() > 0, "the browser ended");
            if let Some(url) = line.strip_prefix("DevTools listening on ") {
                break url.trim().to_owned();
            }
        };
        // The browser continues to log, and would block on a full pipe.
        std::thread::spawn(move || io::copy(&mut lines, &mut io::sink()));
        let address = url.split('/').nth(2).expect("ws://HOST:PORT/PATH");
        let stream = TcpStream::connect(address).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let socket = upgrade(stream, &url);
        let mut browser =
            Self { process, socket, session: String::new(), commands: 0, events: Vec::new() };
        let tab = browser.call("Target.createTarget", &json!({ "url": "about:blank" }));
        let attach = json!({ "targetId": tab["targetId"], "flatten": true });
        let session = browser.call("Target.attachToTarget", &attach);
        session["sessionId"].as_str().expect("a session").clone_into(&mut browser.session);
        browser
    }

    /// Calls a method, and returns its result.
    pub(crate) fn call(&mut self, method: &str, parameters: &Value) -> Value {
        self.commands += 1;
        let mut command = json!({ "id": self.commands, "method": method, "params": parameters });
        if !self.session.is_empty() {
            command["sessionId"] = json!(self.session);
        }
        self.socket.send(Message::text(command.to_string())).unwrap();
        loop {
            let mut message = self.next();
            if message["id"] == self.commands {
                assert!(message.get("error").is_none(), "{method}: {message}");
                return message["result"].take();
            }
            self.events.push(message);
        }
    }

    /// Waits for an event.
    pub(crate) fn wait_for(&mut self, event: &str) {
        while !self.events.iter().any(|message| message["method"] == event) {
            let message = self.next();
            self.events.push(message);
        }
    }

    fn next(&mut self) -> Value {
        loop {
            if let Message::Text(text) = self.socket.read().expect("the browser answers") {
                return serde_json::from_str(&text).unwrap();
            }
        }
    }
}

/// Turns a connection into a WebSocket. The browser's answer to the key is not checked, because that feature of
/// tungstenite needs ten more crates.
fn upgrade(mut stream: TcpStream, url: &str) -> WebSocket<TcpStream> {
    let (host, path) =
        url.trim_start_matches("ws://").split_once('/').expect("ws://HOST:PORT/PATH");
    let request = format!(
        "GET /{path} HTTP/1.1\r\nHost: {host}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n\
         Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
    );
    stream.write_all(request.as_bytes()).unwrap();
    // Reads up to the empty line and no byte more: messages follow.
    let mut answer = Vec::new();
    while !answer.ends_with(b"\r\n\r\n") {
        let mut byte = [0];
        stream.read_exact(&mut byte).expect("the browser answers");
        answer.extend(byte);
    }
    assert!(answer.starts_with(b"HTTP/1.1 101 "), "{}", String::from_utf8_lossy(&answer));
    WebSocket::from_raw_socket(stream, Role::Client, None)
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
