//! What every verb works with: the daemon, and where the answer goes.

use std::io::{self, Write as _};
use std::time::Duration;

use hyper::Method;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use crate::client::Client;
use crate::connection::Connection;
use crate::escape;
use crate::failure::Failure;
use crate::table::Table;
use crate::terminal::{Progress, Terminal};

/// From then on, a wait is shown.
const LONG: Duration = Duration::from_secs(1);

/// One run of `genomctl`.
#[derive(Debug)]
pub(crate) struct Session {
    /// The daemon to ask.
    pub(crate) client: Client,
    /// What the command line said of it.
    pub(crate) given: Connection,
    /// `--json`: replies as the daemon sent them.
    pub(crate) json: bool,
    /// Where text goes.
    pub(crate) terminal: Terminal,
}

impl Session {
    /// A session with the daemon named on the command line; nothing is sent yet.
    pub(crate) fn new(given: Connection, json: bool) -> Self {
        let client = Client::new(given.clone());
        Self { client, given, json, terminal: Terminal::of_output() }
    }

    /// `GET path`.
    pub(crate) async fn get(&self, path: &str) -> Result<Value, Failure> {
        self.ask(Method::GET, path, None).await
    }

    /// `POST path` with a JSON body.
    pub(crate) async fn post(&self, path: &str, body: &Value) -> Result<Value, Failure> {
        self.ask(Method::POST, path, Some(body)).await
    }

    /// `PUT path` with a JSON body.
    pub(crate) async fn put(&self, path: &str, body: &Value) -> Result<Value, Failure> {
        self.ask(Method::PUT, path, Some(body)).await
    }

    /// `DELETE path`.
    pub(crate) async fn delete(&self, path: &str) -> Result<Value, Failure> {
        self.ask(Method::DELETE, path, None).await
    }

    /// Asks; what takes long is seen to take long.
    async fn ask(
        &self,
        method: Method,
        path: &str,
        body: Option<&Value>,
    ) -> Result<Value, Failure> {
        let mut progress = Progress::default();
        let asking = self.client.request(method, path, body);
        if self.json || !progress.seen() {
            return asking.await;
        }
        tokio::pin!(asking);
        let begin = tokio::time::Instant::now();
        let mut ticks = tokio::time::interval_at(begin + LONG, LONG);
        loop {
            tokio::select! {
                reply = &mut asking => return reply,
                _ = ticks.tick() => {
                    progress.show(&format!("waiting for genomd, {} s", begin.elapsed().as_secs()));
                }
            }
        }
    }

    /// Prints a reply: as it is with `--json`, else as `render` words it.
    pub(crate) fn show<R: DeserializeOwned>(
        &self,
        reply: Value,
        render: impl FnOnce(&R) -> String,
    ) -> Result<(), Failure> {
        if self.json {
            return self.print(&format!("{reply}\n"));
        }
        self.print(&render(&self.read(reply)?))
    }

    /// Prints a reply as a table that fits the terminal, or as it is with `--json`.
    pub(crate) fn show_table<R: DeserializeOwned>(
        &self,
        reply: Value,
        table: impl FnOnce(&R) -> Table,
    ) -> Result<(), Failure> {
        self.show(reply, |reply| table(reply).text(self.terminal))
    }

    /// Prints a text that no daemon sent; with `--json` as the one member of an object.
    pub(crate) fn print_text(&self, name: &str, text: &str) -> Result<(), Failure> {
        if self.json {
            return self.print(&format!("{}\n", json!({ name: text })));
        }
        self.print(text)
    }

    /// Says something to whoever sits there; not data.
    pub(crate) fn tell(&self, text: &str) -> Result<(), Failure> {
        if !self.json {
            // Over the progress that may stand there.
            let clear = if Progress::default().seen() { "\r\x1b[2K" } else { "" };
            io::stderr().lock().write_all(format!("{clear}{text}\n").as_bytes())?;
        }
        Ok(())
    }

    /// The reply as the type a verb expects, with its texts as they may be shown.
    pub(crate) fn read<R: DeserializeOwned>(&self, mut reply: Value) -> Result<R, Failure> {
        escape::all(&mut reply);
        serde_json::from_value(reply).map_err(|error| self.client.misread(error.to_string()))
    }

    /// Writes on standard output, at once: the reader may be a pipe that follows a stream.
    pub(crate) fn print(&self, text: &str) -> Result<(), Failure> {
        let mut out = io::stdout().lock();
        let text = if self.json { escape::json(text) } else { text.to_owned() };
        out.write_all(text.as_bytes())?;
        out.flush()?;
        Ok(())
    }
}
