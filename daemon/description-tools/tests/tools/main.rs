//! What is generated from a description: headers, formatted text, diagrams, descriptions.

#[cfg(test)]
mod format;
#[cfg(test)]
mod headers;
#[cfg(test)]
mod pictures;
#[cfg(test)]
mod support;
