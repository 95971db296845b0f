//! A headless browser with a page.

use std::cell::RefCell;
use std::path::Path;

use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use serde_json::{Value, json};

use crate::devtools::Browser;

/// Opens a file, and calls `read` with its page. Then checks that there was no error message and no network request.
pub(crate) fn with_page(file: &Path, read: impl FnOnce(&Page)) {
    let url = format!("file://{}", file.display());
    with_url("", &url, |request| request == url, read);
}

/// Opens an address, and calls `read` with its page. Then checks that there was no error message, and no network
/// request except those that `is_own` accepts. A script, if it is not empty, runs before those of the page, and may do
/// what the page's security policy forbids.
pub(crate) fn with_url(
    script: &str,
    url: &str,
    is_own: impl Fn(&str) -> bool,
    read: impl FnOnce(&Page),
) {
    let profile = tempfile::tempdir().unwrap();
    let page = Page::open(Browser::start(profile.path()), script, url);
    page.resize(1280, 900);
    read(&page);
    for event in &page.browser.into_inner().events {
        let told = &event["params"];
        match event["method"].as_str() {
            Some("Log.entryAdded" | "Runtime.exceptionThrown" | "Runtime.consoleAPICalled") => {
                panic!("the console is not silent: {told}")
            }
            Some("Network.requestWillBeSent") => {
                let request = told["request"]["url"].as_str().unwrap();
                assert!(is_own(request) || request.starts_with("data:"), "fetched: {request}");
            }
            _ => {}
        }
    }
}

/// A page in a tab, with its errors and network requests.
pub(crate) struct Page {
    browser: RefCell<Browser>,
}

impl Page {
    fn open(mut browser: Browser, script: &str, url: &str) -> Self {
        for domain in ["Log", "Runtime", "Network", "Page"] {
            browser.call(&format!("{domain}.enable"), &json!({}));
        }
        if !script.is_empty() {
            let source = json!({ "source": script });
            browser.call("Page.addScriptToEvaluateOnNewDocument", &source);
            browser.call("Page.setBypassCSP", &json!({ "enabled": true }));
        }
        browser.call("Page.navigate", &json!({ "url": url }));
        browser.wait_for("Page.loadEventFired");
        let page = Self { browser: RefCell::new(browser) };
        page.settle();
        page
    }

    fn call(&self, method: &str, parameters: &Value) -> Value {
        self.browser.borrow_mut().call(method, parameters)
    }

    /// Returns the value of an expression. Waits if it is a promise.
    fn evaluate(&self, expression: &str) -> Value {
        let asked =
            json!({ "expression": expression, "awaitPromise": true, "returnByValue": true });
        let mut answer = self.call("Runtime.evaluate", &asked);
        let exception = &answer["exceptionDetails"];
        assert!(exception.is_null(), "{expression}: {exception}");
        answer["result"]["value"].take()
    }

    /// Returns the value of an expression as JSON; `undefined` becomes null.
    pub(crate) fn ask(&self, expression: &str) -> serde_json::Value {
        let json = format!("JSON.stringify({expression}) ?? 'null'");
        let text = self.evaluate(&json);
        let text = text.as_str().unwrap_or_else(|| panic!("{expression} has no value"));
        serde_json::from_str(text).unwrap()
    }

    /// Runs the page for `time_ms` milliseconds.
    pub(crate) fn wait_ms(&self, time_ms: u32) {
        self.evaluate(&format!("new Promise(r => setTimeout(() => r(1), {time_ms}))"));
    }

    /// Waits until all pending drawing is done.
    pub(crate) fn settle(&self) {
        let frames =
            "new Promise(r => requestAnimationFrame(() => requestAnimationFrame(() => r(1))))";
        self.evaluate(frames);
    }

    pub(crate) fn resize(&self, width: u32, height: u32) {
        let metrics =
            json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": false });
        self.call("Emulation.setDeviceMetricsOverride", &metrics);
        self.settle();
    }

    pub(crate) fn emulate(&self, media: &str, scheme: &str) {
        let feature = json!({ "name": "prefers-color-scheme", "value": scheme });
        self.call("Emulation.setEmulatedMedia", &json!({ "media": media, "features": [feature] }));
        self.settle();
    }

    /// Returns all pixels of both views.
    pub(crate) fn pixels(&self) -> serde_json::Value {
        self.ask("[...document.querySelectorAll('canvas')].map(c => c.toDataURL())")
    }

    /// Returns a place in an element, at a share of its width.
    fn place(&self, selector: &str, share: f64) -> [f64; 2] {
        let place = format!(
            "(() => {{ const e = document.querySelector('{selector}'); e.scrollIntoView({{ block: 'center' }});
                const r = e.getBoundingClientRect();
                return [r.left + {share} * r.width, r.top + r.height / 2]; }})()"
        );
        serde_json::from_value(self.ask(&place)).unwrap()
    }

    fn mouse(&self, kind: &str, [x, y]: [f64; 2]) {
        let buttons = u8::from(kind != "mouseReleased");
        let event = json!({
            "type": kind, "x": x, "y": y, "button": "left", "buttons": buttons, "clickCount": 1,
        });
        self.call("Input.dispatchMouseEvent", &event);
    }

    /// Presses the pointer on an element for `time_ms` milliseconds.
    pub(crate) fn hold(&self, selector: &str, time_ms: u32) {
        let place = self.place(selector, 0.5);
        self.mouse("mousePressed", place);
        self.wait_ms(time_ms);
        self.mouse("mouseReleased", place);
    }

    /// Drags the pointer along an element between two shares of its width, waits, and calls `read` before the pointer
    /// is released.
    pub(crate) fn drag(&self, selector: &str, [from, to]: [f64; 2], read: impl FnOnce()) {
        self.mouse("mousePressed", self.place(selector, from));
        let end = self.place(selector, to);
        self.mouse("mouseMoved", end);
        read();
        self.mouse("mouseReleased", end);
    }

    pub(crate) fn press(&self, key: &str) {
        // The Windows code of each key, and the text that it types.
        let (code, text) = match key {
            "Enter" => (13, "\r"),
            "Escape" => (27, ""),
            " " => (32, key),
            "End" => (35, ""),
            "Home" => (36, ""),
            "ArrowLeft" => (37, ""),
            "ArrowUp" => (38, ""),
            "ArrowRight" => (39, ""),
            "+" => (187, key),
            "-" => (189, key),
            _ => panic!("{key:?} is not known here"),
        };
        for kind in [if text.is_empty() { "rawKeyDown" } else { "keyDown" }, "keyUp"] {
            let mut event = json!({ "type": kind, "key": key, "windowsVirtualKeyCode": code });
            if kind == "keyDown" {
                event["text"] = json!(text);
            }
            self.call("Input.dispatchKeyEvent", &event);
        }
        self.settle();
    }

    /// Returns the page as a PDF.
    pub(crate) fn pdf(&self) -> Vec<u8> {
        let printed = self.call("Page.printToPDF", &json!({}));
        BASE64_STANDARD.decode(printed["data"].as_str().unwrap()).unwrap()
    }

    /// Writes the visible part of the page as `NAME.png` into the folder in the environment variable `SINEW_PICTURES`,
    /// for a person who looks at it. Without this variable, does nothing.
    pub(crate) fn picture(&self, name: &str) {
        let Some(folder) = std::env::var_os("SINEW_PICTURES") else { return };
        let shot = self.call("Page.captureScreenshot", &json!({ "format": "png" }));
        let png = BASE64_STANDARD.decode(shot["data"].as_str().unwrap()).unwrap();
        std::fs::write(Path::new(&folder).join(name).with_extension("png"), png).unwrap();
    }

    /// Checks that the page fits a width: only boxes of their own may scroll sideways.
    pub(crate) fn assert_fits(&self, width: u32) {
        self.resize(width, 800);
        let wide = self.ask("document.documentElement.scrollWidth").as_u64().unwrap();
        assert!(wide <= u64::from(width), "{wide} on a screen of {width}");
        let cut = self.ask(&format!(
            "[...document.querySelectorAll('body *')].filter(e => !e.closest('.scroll, svg, .visually-hidden, .skip')
                && e.getBoundingClientRect().right > {width}.5).map(e => e.outerHTML.slice(0, 80))",
        ));
        assert_eq!(cut, serde_json::json!([]));
    }
}
