//! zenoh's own words, made shorter.

/// A message of zenoh, without ` at /FILE.rs:LINE.` in it.
#[must_use]
pub fn plain(message: &str) -> String {
    let mut rest = message;
    let mut out = String::new();
    while let Some((before, after)) = rest.split_once(" at /") {
        out.push_str(before);
        let place = after.split_once(".rs:").filter(|(file, _)| !file.contains(' '));
        match place {
            Some((_, line)) => {
                let line = line.trim_start_matches(|sign: char| sign.is_ascii_digit());
                rest = line.strip_prefix('.').unwrap_or(line);
            }
            None => {
                out.push_str(" at /");
                rest = after;
            }
        }
    }
    out.push_str(rest);
    out.trim().to_owned()
}

/// What is wrong with the text of a configuration, with its place: zenoh tells it in two ways.
#[must_use]
pub fn mistake(message: &str) -> String {
    let message = plain(message);
    match of_form(&message).or_else(|| of_value(&message)) {
        Some((line, column, what)) => format!("line {line}, column {column}: {what}"),
        None => message,
    }
}

/// ` --> 3:26`, lines of the text, `= expected array`.
fn of_form(message: &str) -> Option<(&str, &str, &str)> {
    let (place, rest) = message.strip_prefix("--> ")?.split_once('\n')?;
    let (line, column) = place.trim().split_once(':')?;
    Some((line, column, rest.rsplit_once("= ")?.1.trim()))
}

/// `Message { msg: "unknown field", location: Some(Location { line: 3, column: 3 }) }`
fn of_value(message: &str) -> Option<(&str, &str, &str)> {
    let (_, rest) = message.split_once("msg: \"")?;
    let (what, place) = rest.split_once("\", location: Some(Location { line: ")?;
    let (line, column) = place.split_once(", column: ")?;
    Some((line, column.split_once(' ')?.0, what))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_in_the_sources_of_zenoh_are_left_out() {
        let told = "Can not open tcp/h:1: [[tcp/h:1: refused (os error 111) at /a/b.rs:300.]] at \
                    /a/c.rs:7.";
        assert_eq!(plain(told), "Can not open tcp/h:1: [[tcp/h:1: refused (os error 111)]]");
        assert_eq!(plain("nobody at /run/x.sock"), "nobody at /run/x.sock");
    }

    #[test]
    fn mistakes_in_a_configuration_have_their_line() {
        let of = |text: &str| {
            let place = tempfile::tempdir().unwrap();
            let file = place.path().join("zenoh.json5");
            std::fs::write(&file, text).unwrap();
            mistake(&zenoh::Config::from_file(file).unwrap_err().to_string())
        };
        let told = of("{\n  mode: 'peer',\n  listen: { endpoints: [ }\n}\n");
        assert!(told.starts_with("line 3, column 26: expected array"), "{told}");
        let told = of("{\n  mode: 'peer',\n  lisen: { endpoints: [] }\n}\n");
        assert!(told.starts_with("line 3, column 3: unknown field `lisen`, expected"), "{told}");
    }
}
