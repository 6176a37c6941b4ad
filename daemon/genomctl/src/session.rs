//! What every verb uses: the client of the daemon, and the output.

use std::io::{self, Write as _};
use std::time::Duration;

use genom_protocol::routes::Route;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use crate::client::Client;
use crate::connection::Connection;
use crate::escape;
use crate::failure::Failure;
use crate::table::Table;
use crate::terminal::{Progress, Terminal};

/// Waits longer than this are shown on the terminal.
const LONG: Duration = Duration::from_secs(1);

/// A reply of the daemon.
#[derive(Clone, Debug)]
pub(crate) struct Reply<R> {
    /// The JSON as sent; printed with `--json` only.
    pub(crate) sent: Value,
    /// The reply as its type. Without `--json`, control characters in its texts are escaped.
    pub(crate) content: R,
}

/// One run of `genomctl`.
#[derive(Debug)]
pub(crate) struct Session {
    /// Client of the daemon.
    pub(crate) client: Client,
    /// The options that select the daemon.
    pub(crate) given: Connection,
    /// `--json`: print replies as the daemon sent them.
    pub(crate) json: bool,
    /// Standard output.
    pub(crate) terminal: Terminal,
}

impl Session {
    /// A session with the daemon that the command line selects; nothing is sent yet.
    pub(crate) fn new(given: Connection, json: bool) -> Self {
        let client = Client::new(given.clone());
        Self { client, given, json, terminal: Terminal::of_output() }
    }

    /// Makes a request without a body.
    pub(crate) async fn ask<R: DeserializeOwned, Q>(
        &self,
        route: Route<R, Q>,
    ) -> Result<Reply<R>, Failure> {
        let sent = self.whole(&route, Vec::new()).await?;
        self.reply(sent)
    }

    /// Makes a request with a body.
    pub(crate) async fn send<R: DeserializeOwned, Q, B: Serialize>(
        &self,
        route: Route<R, Q, B>,
        body: &B,
    ) -> Result<Reply<R>, Failure> {
        // None of the bodies can fail to serialise.
        let body = serde_json::to_vec(body).unwrap_or_default();
        let sent = self.whole(&route, body).await?;
        self.reply(sent)
    }

    /// Makes a request, and shows on the terminal if it takes long.
    async fn whole<R, Q, B>(
        &self,
        route: &Route<R, Q, B>,
        body: Vec<u8>,
    ) -> Result<Value, Failure> {
        let mut progress = Progress::default();
        let asking = self.client.request(route, body);
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

    /// Converts a reply to the type of its route.
    pub(crate) fn reply<R: DeserializeOwned>(&self, sent: Value) -> Result<Reply<R>, Failure> {
        let kept = if self.json { sent.clone() } else { Value::Null };
        let mut read = sent;
        if !self.json {
            escape::all(&mut read);
        }
        let content =
            serde_json::from_value(read).map_err(|error| self.client.misread(error.to_string()))?;
        Ok(Reply { sent: kept, content })
    }

    /// Prints a reply: as sent with `--json`, else as formatted by `render`.
    pub(crate) fn show<R>(
        &self,
        reply: &Reply<R>,
        render: impl FnOnce(&R) -> String,
    ) -> Result<(), Failure> {
        if self.json {
            return self.print(&format!("{}\n", reply.sent));
        }
        self.print(&render(&reply.content))
    }

    /// Prints a reply as a table fitted to the terminal; as sent with `--json`.
    pub(crate) fn show_table<R>(
        &self,
        reply: &Reply<R>,
        table: impl FnOnce(&R) -> Table,
    ) -> Result<(), Failure> {
        self.show(reply, |reply| table(reply).text(self.terminal))
    }

    /// Prints data that did not come from a daemon: as JSON with `--json`, else as a table.
    pub(crate) fn show_own(
        &self,
        data: &impl Serialize,
        table: impl FnOnce() -> Table,
    ) -> Result<(), Failure> {
        if self.json {
            return self.print(&format!("{}\n", json!(data)));
        }
        self.print(&table().text(self.terminal))
    }

    /// Prints a text that did not come from a daemon; with `--json` as the only member of an
    /// object.
    pub(crate) fn print_text(&self, name: &str, text: &str) -> Result<(), Failure> {
        if self.json {
            return self.print(&format!("{}\n", json!({ name: text })));
        }
        self.print(text)
    }

    /// Prints a message for the user on standard error.
    pub(crate) fn tell(&self, text: &str) -> Result<(), Failure> {
        if !self.json {
            // Clears the line of progress that may be there.
            let clear = if Progress::default().seen() { "\r\x1b[2K" } else { "" };
            io::stderr().lock().write_all(format!("{clear}{text}\n").as_bytes())?;
        }
        Ok(())
    }

    /// Writes to standard output and flushes: the reader may be a pipe that follows a stream.
    pub(crate) fn print(&self, text: &str) -> Result<(), Failure> {
        let mut out = io::stdout().lock();
        let text = if self.json { escape::json(text) } else { text.to_owned() };
        out.write_all(text.as_bytes())?;
        out.flush()?;
        Ok(())
    }
}
