//! Reading files: preprocessor and lexer, seen from outside.

mod lexer;
mod support;
