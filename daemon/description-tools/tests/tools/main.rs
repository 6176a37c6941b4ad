//! What is made of a description: headers, formatted text, pictures, descriptions.

#[cfg(test)]
mod format;
#[cfg(test)]
mod headers;
#[cfg(test)]
mod pictures;
#[cfg(test)]
mod support;
