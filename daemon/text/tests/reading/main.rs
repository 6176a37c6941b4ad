//! Reading files: preprocessor and lexer, seen from outside.

mod directives;
mod drawing;
mod inputs;
mod lexer;
#[cfg(test)]
mod limits;
mod macros;
#[cfg(test)]
mod packages;
mod support;
