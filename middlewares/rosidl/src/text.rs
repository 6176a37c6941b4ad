//! Prints interfaces as `.msg`, `.srv` and `.action` text.

use std::fmt::{self, Write as _};

use crate::interface::{Interface, Message};

/// Prints the fields and constants of one part, one per line.
fn part(message: &Message, out: &mut String) -> fmt::Result {
    if let Some(comment) = &message.comment {
        writeln!(out, "# {comment}")?;
    }
    for constant in &message.constants {
        writeln!(out, "{} {}={}", constant.base, constant.name, constant.value)?;
    }
    for field in &message.fields {
        write!(out, "{}{} {}", field.base, field.shape, field.name)?;
        if let Some(comment) = &field.comment {
            write!(out, "  # {comment}")?;
        }
        out.push('\n');
    }
    Ok(())
}

impl fmt::Display for Message {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut text = String::new();
        part(self, &mut text)?;
        f.write_str(&text)
    }
}

impl fmt::Display for Interface {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (rank, message) in self.parts().enumerate() {
            if rank > 0 {
                f.write_str("---\n")?;
            }
            message.fmt(f)?;
        }
        Ok(())
    }
}
