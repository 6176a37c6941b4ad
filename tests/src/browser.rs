//! Chromium, driven over WebDriver, for the pages of the web console.
//!
//! Nothing here waits for a time: a test asks for a condition of the page until it holds.

use std::io::{BufRead as _, BufReader, Write as _};
use std::net::TcpStream;
use std::process::Command;
use std::time::{Duration, Instant};

use fantoccini::actions::{
    InputSource as _, MOUSE_BUTTON_LEFT, MOUSE_BUTTON_RIGHT, MouseActions, PointerAction,
    TouchActions,
};
use fantoccini::{Client, ClientBuilder, Locator};
use hyper_util::client::legacy::connect::HttpConnector;
use serde_json::{Map, Value, json};
use tempfile::TempDir;
use tokio::runtime::Runtime;

use crate::WATCHDOG;
use crate::command::Running;

/// What installs what is missing.
const MISSING: &str = "the tests of the web console drive Chromium: `apt-get install chromium \
                       chromium-driver`, or name a chromedriver in CHROMEDRIVER";

/// A browser with a profile of its own; it ends when it is dropped.
#[derive(Debug)]
pub struct Browser {
    runtime: Runtime,
    client: Client,
    /// Address of the driver.
    port: u16,
    _driver: Running,
    _profile: TempDir,
}

impl Browser {
    /// Starts a browser whose window has this size, in pixels.
    ///
    /// # Panics
    /// There is no Chromium or chromedriver: the message says how to install them.
    #[must_use]
    #[track_caller]
    pub fn start(width: u32, height: u32, options: &[&str]) -> Self {
        let profile = TempDir::new().expect("a directory can be made");
        let program = std::env::var("CHROMEDRIVER").unwrap_or_else(|_| "chromedriver".to_owned());
        let found = Command::new(&program).arg("--version").output();
        assert!(found.is_ok_and(|found| found.status.success()), "no {program}: {MISSING}");
        let mut command = Command::new(program);
        command.arg("--port=0").env("HOME", profile.path()).env("TMPDIR", profile.path());
        // The driver takes a port that is free in IPv6, and then the same one in IPv4. If somebody else
        // has it there it says so and ends: the next one takes another port.
        let taken = "port not available";
        let (driver, line) = (0..5)
            .find_map(|_| {
                let driver = Running::start(&mut command);
                let line = driver.line_where(|line| {
                    line.contains("started successfully on port") || line.contains(taken)
                });
                (!line.contains(taken)).then_some((driver, line))
            })
            .expect("a port that is free in IPv4 and in IPv6");
        let digits = |c: char| !c.is_ascii_digit();
        let port = line.trim_end_matches(digits).rsplit(digits).next().expect("a port");
        let port: u16 = port.parse().expect("a port");
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(1)
            .enable_all()
            .build()
            .expect("a runtime");
        let size = format!("--window-size={width},{height}");
        let data = format!("--user-data-dir={}", profile.path().join("profile").display());
        // Tests may run as root, and in containers with little shared memory.
        let usual = ["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"];
        // A window is not as narrow as a telephone.
        let telephone = json!({ "deviceMetrics": { "width": width, "height": height } });
        let arguments: Vec<_> =
            usual.iter().chain(options).copied().chain([&*size, &*data]).collect();
        let mut wanted = Map::new();
        let mut chrome = json!({ "args": arguments });
        if width < 500 {
            chrome["mobileEmulation"] = telephone;
        }
        wanted.insert("goog:chromeOptions".to_owned(), chrome);
        let connecting = async {
            let mut builder = ClientBuilder::new(HttpConnector::new());
            builder.capabilities(wanted).connect(&format!("http://127.0.0.1:{port}")).await
        };
        let client = runtime.block_on(connecting);
        let client = client.unwrap_or_else(|error| panic!("no browser: {error}; {MISSING}"));
        Self { runtime, client, port, _driver: driver, _profile: profile }
    }

    /// Opens an address.
    #[track_caller]
    pub fn open(&self, url: &str) {
        self.runtime.block_on(self.client.goto(url)).expect("the address opens");
    }

    /// What a function body returns in the page.
    #[track_caller]
    pub fn ask(&self, script: &str) -> Value {
        self.with(script, Vec::new())
    }

    /// The same with arguments.
    #[track_caller]
    pub fn with(&self, script: &str, arguments: Vec<Value>) -> Value {
        self.runtime.block_on(self.client.execute(script, arguments)).expect("the script runs")
    }

    /// Asks until an expression of the page is true; `what` names it.
    #[track_caller]
    pub fn until(&self, what: &str, expression: &str) {
        let (end, script) = (Instant::now() + WATCHDOG, format!("return Boolean({expression})"));
        while self.ask(&script) != json!(true) {
            assert!(
                Instant::now() < end,
                "{what}: this does not come to be. The page:\n{}",
                self.text()
            );
        }
    }

    /// Asks until the page shows this text.
    #[track_caller]
    pub fn until_shown(&self, text: &str) {
        let text = json!(text);
        self.until(
            &format!("{text} is shown"),
            &format!("document.body.innerText.includes({text})"),
        );
    }

    /// The text of the page.
    #[track_caller]
    pub fn text(&self) -> String {
        let text = self.ask("return location.href + '\\n' + document.body.innerText");
        text.as_str().unwrap_or_default().to_owned()
    }

    /// Clicks an element once it is there, as a mouse does.
    #[track_caller]
    pub fn click(&self, css: &str) {
        let clicking = async {
            let element = self.client.wait().for_element(Locator::Css(css)).await?;
            element.click().await
        };
        self.runtime.block_on(clicking).unwrap_or_else(|error| panic!("{css}: {error}"));
    }

    /// Replaces what is written in a field.
    #[track_caller]
    pub fn write(&self, css: &str, text: &str) {
        let writing = async {
            let element = self.client.wait().for_element(Locator::Css(css)).await?;
            element.clear().await?;
            element.send_keys(text).await
        };
        self.runtime.block_on(writing).unwrap_or_else(|error| panic!("{css}: {error}"));
    }

    /// Presses keys on an element; `\u{E007}` is Enter, as WebDriver has it.
    #[track_caller]
    pub fn press(&self, css: &str, keys: &str) {
        // Elements of drawings take keys once they have the focus.
        let pressing = async {
            let element = self.client.wait().for_element(Locator::Css(css)).await?;
            let focus = "document.querySelector(arguments[0]).focus()";
            self.client.execute(focus, vec![json!(css)]).await?;
            element.send_keys(keys).await
        };
        self.runtime.block_on(pressing).unwrap_or_else(|error| panic!("{css}: {error}"));
    }

    /// The middle of an element.
    #[track_caller]
    fn middle(&self, css: &str) -> [f64; 2] {
        let middle = "const box = document.querySelector(arguments[0]).getBoundingClientRect();
            return [box.x + box.width / 2, box.y + box.height / 2].map(Math.round)";
        let at = self.with(middle, vec![json!(css)]);
        [0, 1].map(|axis| at[axis].as_f64().expect("a place"))
    }

    /// Clicks on an element with the right button.
    #[track_caller]
    pub fn click_right(&self, css: &str) {
        let [[x, y]] = self.places([css]);
        let click = MouseActions::new("mouse".to_owned())
            .then(PointerAction::MoveTo { duration: None, x, y })
            .then(PointerAction::Down { button: MOUSE_BUTTON_RIGHT })
            .then(PointerAction::Up { button: MOUSE_BUTTON_RIGHT });
        self.runtime.block_on(self.client.perform_actions(click)).expect("the mouse clicks");
    }

    /// Puts a finger on an element and keeps it there, until [`release`](Self::release).
    #[track_caller]
    pub fn hold(&self, css: &str) {
        let [[x, y]] = self.places([css]);
        let down = TouchActions::new("finger".to_owned())
            .then(PointerAction::MoveTo { duration: None, x, y })
            .then(PointerAction::Down { button: MOUSE_BUTTON_LEFT });
        self.runtime.block_on(self.client.perform_actions(down)).expect("the finger is down");
    }

    /// Lets go of what is held down.
    #[track_caller]
    pub fn release(&self) {
        self.runtime.block_on(self.client.release_actions()).expect("it is let go");
    }

    /// Presses keys on whatever has the focus.
    #[track_caller]
    pub fn type_keys(&self, keys: &str) {
        let typing = async { self.client.active_element().await?.send_keys(keys).await };
        self.runtime.block_on(typing).unwrap_or_else(|error| panic!("{keys:?}: {error}"));
    }

    /// The middles of elements, once all is there that a page waits for and they stand still.
    #[track_caller]
    fn places<const N: usize>(&self, css: [&str; N]) -> [[f64; 2]; N] {
        self.until("nothing is waited for", "!document.querySelector('[aria-busy=true]')");
        let mut places = css.map(|css| self.middle(css));
        let end = Instant::now() + WATCHDOG;
        loop {
            let now = css.map(|css| self.middle(css));
            if now == std::mem::replace(&mut places, now) {
                return places;
            }
            assert!(Instant::now() < end, "{css:?} do not stand still");
        }
    }

    /// Drags from the middle of an element to the middle of another.
    #[track_caller]
    pub fn drag(&self, from: &str, to: &str) {
        self.drag_after(Duration::ZERO, from, to);
    }

    /// The same, with the button held for a time before the mouse moves.
    #[track_caller]
    pub fn drag_after(&self, duration: Duration, from: &str, to: &str) {
        let [from, to] = self.places([from, to]);
        let to_point = |[x, y]: [f64; 2]| PointerAction::MoveTo { duration: None, x, y };
        let half = [0, 1].map(|axis| f64::midpoint(from[axis], to[axis]).round());
        let drag = MouseActions::new("mouse".to_owned())
            .then(to_point(from))
            .then(PointerAction::Down { button: MOUSE_BUTTON_LEFT })
            .then(PointerAction::Pause { duration })
            .then(to_point(half))
            .then(to_point(to))
            .then(PointerAction::Up { button: MOUSE_BUTTON_LEFT });
        self.runtime.block_on(self.client.perform_actions(drag)).expect("the mouse moves");
    }

    /// A picture of the window, as PNG.
    #[track_caller]
    pub fn picture(&self) -> Vec<u8> {
        self.runtime.block_on(self.client.screenshot()).expect("a picture")
    }

    /// Has a page another size, in pixels, and a light or dark scheme of colours.
    #[track_caller]
    pub fn look(&self, width: u32, height: u32, dark: bool) {
        let scheme = if dark { "dark" } else { "light" };
        let size =
            json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": false });
        self.order("Emulation.setDeviceMetricsOverride", &size);
        let features = json!([{ "name": "prefers-color-scheme", "value": scheme }]);
        self.order("Emulation.setEmulatedMedia", &json!({ "features": features }));
    }

    /// Forgets all files of pages that were loaded.
    #[track_caller]
    pub fn forget_files(&self) {
        self.order("Network.clearBrowserCache", &json!({}));
    }

    /// Gives an order of Chromium's own protocol, which WebDriver does not have.
    #[track_caller]
    fn order(&self, order: &str, parameters: &Value) {
        let session = self.runtime.block_on(self.client.session_id()).expect("a session");
        let session = session.expect("a session");
        let body = json!({ "cmd": order, "params": parameters }).to_string();
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).expect("the driver listens");
        stream.set_read_timeout(Some(WATCHDOG)).expect("a time-out can be set");
        let (port, length) = (self.port, body.len());
        let request = format!(
            "POST /session/{session}/goog/cdp/execute HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\
             Content-Type: application/json\r\n\
             Content-Length: {length}\r\n\r\n{body}"
        );
        stream.write_all(request.as_bytes()).expect("the driver takes orders");
        // The driver keeps the connection, whatever was asked.
        let mut reply = String::new();
        let mut lines = BufReader::new(stream);
        while !reply.ends_with("\r\n\r\n") {
            let read = lines.read_line(&mut reply).expect("the driver replies");
            assert_ne!(read, 0, "{order}: {reply}");
        }
        assert!(reply.starts_with("HTTP/1.1 200"), "{order}: {reply}");
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        // Ends the browser; its driver ends with this value.
        let _ = self.runtime.block_on(self.client.clone().close());
    }
}
