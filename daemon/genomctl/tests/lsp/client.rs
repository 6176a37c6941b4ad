//! A scripted editor: sends and receives LSP messages over pipes.

use std::collections::VecDeque;
use std::io::{BufReader, Write as _};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::Duration;

use serde_json::{Value, json};

/// Only a hanging test takes this long.
const WATCHDOG: Duration = Duration::from_secs(60);

pub(crate) struct Client {
    child: Child,
    input: Option<ChildStdin>,
    messages: Receiver<Value>,
    /// Notifications received while waiting for something else.
    told: VecDeque<Value>,
    asked: i64,
}

impl Client {
    /// Starts a server and initialises it.
    pub(crate) fn start(arguments: &[&str], options: &Value) -> (Self, Value) {
        let mut child = Command::new(env!("CARGO_BIN_EXE_genomctl"))
            .arg("lsp")
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut output = BufReader::new(child.stdout.take().unwrap());
        let (sender, messages) = channel();
        thread::spawn(move || {
            while let Some(message) = read(&mut output) {
                if sender.send(message).is_err() {
                    break;
                }
            }
        });
        let input = child.stdin.take();
        let mut client = Self { child, input, messages, told: VecDeque::new(), asked: 0 };
        let hello = client.ask(
            "initialize",
            json!({"capabilities": {}, "processId": null, "initializationOptions": options}),
        );
        client.tell("initialized", json!({}));
        (client, hello)
    }

    fn send(&mut self, message: &Value) {
        let text = message.to_string();
        let input = self.input.as_mut().unwrap();
        write!(input, "Content-Length: {}\r\n\r\n{text}", text.len()).unwrap();
        input.flush().unwrap();
    }

    pub(crate) fn tell(&mut self, method: &str, params: Value) {
        self.send(&json!({"jsonrpc": "2.0", "method": method, "params": params}));
    }

    /// The whole reply to a request.
    pub(crate) fn reply(&mut self, method: &str, params: Value) -> Value {
        self.asked += 1;
        let id = self.asked;
        self.send(&json!({"jsonrpc": "2.0", "id": id, "method": method, "params": params}));
        loop {
            let message = self.messages.recv_timeout(WATCHDOG).unwrap();
            if message["id"] == id {
                return message;
            }
            self.told.push_back(message);
        }
    }

    /// The result of a request that must succeed.
    #[track_caller]
    pub(crate) fn ask(&mut self, method: &str, params: Value) -> Value {
        let reply = self.reply(method, params);
        assert!(reply.get("error").is_none(), "{method}: {reply}");
        reply["result"].clone()
    }

    pub(crate) fn open(&mut self, path: &Path, text: &str) {
        let document = json!({"uri": uri(path), "languageId": "genom", "version": 1, "text": text});
        self.tell("textDocument/didOpen", json!({"textDocument": document}));
    }

    pub(crate) fn change(&mut self, path: &Path, version: i32, text: &str) {
        self.tell(
            "textDocument/didChange",
            json!({
                "textDocument": {"uri": uri(path), "version": version},
                "contentChanges": [{"text": text}],
            }),
        );
    }

    /// The next diagnostics published for a file: `LINE:COLUMN code message`, counted from 0 as in
    /// the protocol.
    pub(crate) fn diagnostics(&mut self, path: &Path) -> Vec<String> {
        let published = loop {
            let next = self.told.pop_front();
            let next = next.unwrap_or_else(|| self.messages.recv_timeout(WATCHDOG).unwrap());
            let about = next["params"]["uri"] == uri(path);
            if next["method"] == "textDocument/publishDiagnostics" && about {
                break next;
            }
        };
        let all = published["params"]["diagnostics"].as_array().unwrap().iter();
        let one = |said: &Value| {
            let start = &said["range"]["start"];
            format!(
                "{}:{} {} {}",
                start["line"],
                start["character"],
                said["code"].as_str().unwrap(),
                said["message"].as_str().unwrap()
            )
        };
        all.map(one).collect()
    }

    /// Shuts the server down.
    pub(crate) fn stop(mut self) -> ExitStatus {
        assert_eq!(self.ask("shutdown", Value::Null), Value::Null);
        self.tell("exit", Value::Null);
        self.end()
    }

    /// Closes the pipe and waits for the end.
    pub(crate) fn end(mut self) -> ExitStatus {
        drop(self.input.take());
        // The reading thread ends with the server, or the watchdog expires.
        while self.messages.recv_timeout(WATCHDOG).is_ok() {}
        self.child.wait().unwrap()
    }
}

impl Drop for Client {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn read(output: &mut impl std::io::BufRead) -> Option<Value> {
    let mut length = 0;
    loop {
        let mut line = String::new();
        if output.read_line(&mut line).ok()? == 0 {
            return None;
        }
        match line.trim().split_once(": ") {
            Some(("Content-Length", value)) => length = value.parse().ok()?,
            _ if line.trim().is_empty() => break,
            _ => {}
        }
    }
    let mut text = vec![0; length];
    output.read_exact(&mut text).ok()?;
    serde_json::from_slice(&text).ok()
}

pub(crate) fn uri(path: &Path) -> String {
    format!("file://{}", path.display())
}

/// The position of `|` in `marked`, as a position in `text`, in UTF-16 units.
pub(crate) fn position(text: &str, marked: &str) -> Value {
    let found = text.find(&marked.replace('|', "")).unwrap_or_else(|| panic!("no {marked}"));
    let before = &text[..found + marked.find('|').unwrap()];
    let line = before.matches('\n').count();
    let column = before.rsplit('\n').next().unwrap().encode_utf16().count();
    json!({"line": line, "character": column})
}
