//! Editors: the language server, the extension for Visual Studio Code, and what the page on editors
//! shows for others.

mod client;
mod page;
mod server;
mod vscode;
