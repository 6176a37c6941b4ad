//! Answers to messages, and what takes them to the connections that wait for them.

/// The answer to a message.
pub(crate) enum Reply {
    /// A bottle.
    Bottle(Vec<u8>),
    /// Lines; on a text carrier, as they are.
    Text(String),
}

/// Takes answers to connections.
pub(crate) trait Respond: Send + Sync {
    /// Answers the message for which the connection of this number waits.
    fn respond(&self, token: u64, reply: Reply);
}
