//! Reading files with preprocessor and lexer, through the public interface.

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
