//! Rules for the files of this repository.

mod arrows;
mod backend_page;
mod circles;
mod citations;
mod errors;
mod names;
mod printed;
mod readme;
mod reference;
mod replies;
mod stops;
mod tidy;
mod unsafe_code;
mod uses;
