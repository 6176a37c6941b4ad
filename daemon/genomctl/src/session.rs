//! What every verb works with: the daemon, and where the answer goes.

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

/// A wait that is longer is shown on the terminal.
const LONG: Duration = Duration::from_secs(1);

/// A reply of the daemon.
#[derive(Clone, Debug)]
pub(crate) struct Reply<R> {
    /// As it was sent; with `--json`, which alone prints it.
    pub(crate) sent: Value,
    /// As its type. Without `--json`, what a terminal would obey in its texts is escaped.
    pub(crate) content: R,
}

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

    /// Asks for what takes no body.
    pub(crate) async fn ask<R: DeserializeOwned, Q>(
        &self,
        route: Route<R, Q>,
    ) -> Result<Reply<R>, Failure> {
        let sent = self.whole(&route, Vec::new()).await?;
        self.reply(sent)
    }

    /// Asks with a body.
    pub(crate) async fn send<R: DeserializeOwned, Q, B: Serialize>(
        &self,
        route: Route<R, Q, B>,
        body: &B,
    ) -> Result<Reply<R>, Failure> {
        // None of the bodies can fail to be JSON.
        let body = serde_json::to_vec(body).unwrap_or_default();
        let sent = self.whole(&route, body).await?;
        self.reply(sent)
    }

    /// Asks; what takes long is seen to take long.
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

    /// A reply as the type that its route answers.
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

    /// Prints a reply: as it was sent with `--json`, else as `render` words it.
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

    /// Prints a reply as a table that fits the terminal, or as it was sent with `--json`.
    pub(crate) fn show_table<R>(
        &self,
        reply: &Reply<R>,
        table: impl FnOnce(&R) -> Table,
    ) -> Result<(), Failure> {
        self.show(reply, |reply| table(reply).text(self.terminal))
    }

    /// Prints what genomctl itself has to say: as JSON with `--json`, else as a table.
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

    /// Writes on standard output, at once: the reader may be a pipe that follows a stream.
    pub(crate) fn print(&self, text: &str) -> Result<(), Failure> {
        let mut out = io::stdout().lock();
        let text = if self.json { escape::json(text) } else { text.to_owned() };
        out.write_all(text.as_bytes())?;
        out.flush()?;
        Ok(())
    }
}
