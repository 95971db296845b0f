//! A browser without a screen, and a page in it.

use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use headless_chrome::protocol::cdp::types::Event;
use headless_chrome::protocol::cdp::{Emulation, Log, Network, Runtime};
use headless_chrome::{Browser, LaunchOptions, Tab};

/// Opens a file, and lets `read` use it. Then nothing must have been complained of, and nothing fetched.
pub(crate) fn with_page(file: &Path, read: impl FnOnce(&Page)) {
    let chromium = std::env::var_os("SINEW_CHROMIUM").expect("SINEW_CHROMIUM names the browser");
    let profile = tempfile::tempdir().unwrap();
    let options = LaunchOptions {
        path: Some(chromium.into()),
        // A container has no sandbox to offer; the page is our own.
        sandbox: false,
        window_size: Some((1280, 900)),
        user_data_dir: Some(profile.path().to_owned()),
        args: ["--disable-quic", "--disable-component-update", "--no-proxy-server"]
            .map(std::ffi::OsStr::new)
            .into(),
        idle_browser_timeout: Duration::from_mins(2),
        ..LaunchOptions::default()
    };
    let browser = Browser::new(options).unwrap();
    let url = format!("file://{}", file.display());
    let page = Page::open(&browser, &url);
    page.resize(1280, 900);
    read(&page);
    assert_eq!(*page.complaints.lock().unwrap(), [""; 0], "the console is silent");
    for request in page.requests.lock().unwrap().iter() {
        assert!(*request == url || request.starts_with("data:"), "fetched: {request}");
    }
}

/// A page in a tab, with what went wrong and what was fetched.
pub(crate) struct Page {
    pub(crate) tab: Arc<Tab>,
    complaints: Arc<Mutex<Vec<String>>>,
    requests: Arc<Mutex<Vec<String>>>,
}

impl Page {
    fn open(browser: &Browser, url: &str) -> Self {
        let tab = browser.new_tab().unwrap();
        let (complaints, requests) = <(Arc<Mutex<Vec<_>>>, Arc<Mutex<Vec<_>>>)>::default();
        let (to_complaints, to_requests) = (Arc::clone(&complaints), Arc::clone(&requests));
        tab.call_method(Log::Enable(None)).unwrap();
        tab.call_method(Runtime::Enable(None)).unwrap();
        tab.call_method(Network::Enable {
            max_total_buffer_size: None,
            max_resource_buffer_size: None,
            max_post_data_size: None,
            report_direct_socket_traffic: None,
            enable_durable_messages: None,
        })
        .unwrap();
        tab.add_event_listener(Arc::new(move |event: &Event| match event {
            Event::LogEntryAdded(event) => {
                to_complaints.lock().unwrap().push(event.params.entry.text.clone());
            }
            Event::RuntimeExceptionThrown(event) => {
                to_complaints.lock().unwrap().push(format!("{:?}", event.params.exception_details));
            }
            Event::RuntimeConsoleAPICalled(event) => {
                to_complaints.lock().unwrap().push(format!("{:?}", event.params.args));
            }
            Event::NetworkRequestWillBeSent(event) => {
                to_requests.lock().unwrap().push(event.params.request.url.clone());
            }
            _ => {}
        }))
        .unwrap();
        tab.navigate_to(url).unwrap().wait_until_navigated().unwrap();
        let page = Self { tab, complaints, requests };
        page.settle();
        page
    }

    /// What an expression is, as JSON; nothing is null.
    pub(crate) fn ask(&self, expression: &str) -> serde_json::Value {
        let json = format!("JSON.stringify({expression}) ?? 'null'");
        let object = self.tab.evaluate(&json, false).unwrap();
        let text = object.value.unwrap_or_else(|| panic!("{expression} has no value"));
        serde_json::from_str(text.as_str().unwrap()).unwrap()
    }

    /// Waits until everything that was asked for is drawn.
    pub(crate) fn settle(&self) {
        let frames =
            "new Promise(r => requestAnimationFrame(() => requestAnimationFrame(() => r(1))))";
        self.tab.evaluate(frames, true).unwrap();
    }

    pub(crate) fn resize(&self, width: u32, height: u32) {
        self.tab
            .call_method(Emulation::SetDeviceMetricsOverride {
                width,
                height,
                device_scale_factor: 1.0,
                mobile: false,
                scale: None,
                screen_width: None,
                screen_height: None,
                position_x: None,
                position_y: None,
                dont_set_visible_size: None,
                screen_orientation: None,
                viewport: None,
                display_feature: None,
                device_posture: None,
            })
            .unwrap();
        self.settle();
    }

    pub(crate) fn emulate(&self, media: &str, scheme: &str) {
        let feature =
            Emulation::MediaFeature { name: "prefers-color-scheme".into(), value: scheme.into() };
        let (media, features) = (Some(media.into()), Some(vec![feature]));
        self.tab.call_method(Emulation::SetEmulatedMedia { media, features }).unwrap();
        self.settle();
    }

    /// All pixels of both views.
    pub(crate) fn pixels(&self) -> serde_json::Value {
        self.ask("[...document.querySelectorAll('canvas')].map(c => c.toDataURL())")
    }

    pub(crate) fn press(&self, key: &str) {
        self.tab.press_key(key).unwrap();
        self.settle();
    }

    /// Whether it fits a width, and nothing is cut off either: what is wider scrolls in its own box.
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
