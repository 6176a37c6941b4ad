//! A scripted editor: sends and receives LSP messages over pipes.

use std::collections::VecDeque;
use std::io::{BufReader, Write as _};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::thread;

use genom_tests::WATCHDOG;
use serde_json::{Value, json};

pub(super) struct Client {
    child: Child,
    input: Option<ChildStdin>,
    messages: Receiver<Value>,
    /// Notifications received while waiting for something else.
    told: VecDeque<Value>,
    asked: i64,
}

impl Client {
    /// Starts a server and initialises it with these parameters, besides those that every editor
    /// has. Returns its reply, too.
    pub(super) fn start(command: &mut Command, parameters: Value) -> (Self, Value) {
        command.stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut child = command.spawn().unwrap_or_else(|error| panic!("{command:?}: {error}"));
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
        let mut hello = json!({"capabilities": {}, "processId": null});
        let more = parameters.as_object().cloned().unwrap_or_default();
        hello.as_object_mut().unwrap().extend(more);
        let hello = client.ask("initialize", hello);
        client.tell("initialized", json!({}));
        (client, hello)
    }

    fn send(&mut self, message: &Value) {
        let text = message.to_string();
        let input = self.input.as_mut().unwrap();
        write!(input, "Content-Length: {}\r\n\r\n{text}", text.len()).unwrap();
        input.flush().unwrap();
    }

    pub(super) fn tell(&mut self, method: &str, params: Value) {
        self.send(&json!({"jsonrpc": "2.0", "method": method, "params": params}));
    }

    /// The whole reply to a request.
    pub(super) fn reply(&mut self, method: &str, params: Value) -> Value {
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
    pub(super) fn ask(&mut self, method: &str, params: Value) -> Value {
        let reply = self.reply(method, params);
        assert!(reply.get("error").is_none(), "{method}: {reply}");
        reply["result"].clone()
    }

    pub(super) fn open(&mut self, path: &Path, text: &str) {
        let document = json!({"uri": uri(path), "languageId": "genom", "version": 1, "text": text});
        self.tell("textDocument/didOpen", json!({"textDocument": document}));
    }

    pub(super) fn change(&mut self, path: &Path, version: i32, text: &str) {
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
    pub(super) fn diagnostics(&mut self, path: &Path) -> Vec<String> {
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
    pub(super) fn stop(mut self) -> ExitStatus {
        assert_eq!(self.ask("shutdown", Value::Null), Value::Null);
        self.tell("exit", Value::Null);
        self.end()
    }

    /// Closes the pipe and waits for the end.
    pub(super) fn end(mut self) -> ExitStatus {
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

pub(super) fn uri(path: &Path) -> String {
    format!("file://{}", path.display())
}

/// The position of `|` in `marked`, as a position in `text`, in UTF-16 units.
pub(super) fn position(text: &str, marked: &str) -> Value {
    let found = text.find(&marked.replace('|', "")).unwrap_or_else(|| panic!("no {marked}"));
    let before = &text[..found + marked.find('|').unwrap()];
    let line = before.matches('\n').count();
    let column = before.rsplit('\n').next().unwrap().encode_utf16().count();
    json!({"line": line, "character": column})
}
