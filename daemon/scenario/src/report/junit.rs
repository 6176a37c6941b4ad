//! A report as JUnit XML, which programs for continuous integration read.
//!
//! `time` is the time on the stepped clock, in seconds: the same in every run.

use std::borrow::Cow;
use std::io;

use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesText, Event};

use super::{Outcome, Report, ScenarioReport, SuiteReport, Unmet};
use crate::duration::{decimal, seconds};

impl Report {
    /// The report as JUnit XML.
    ///
    /// # Errors
    /// None is known: it is written into memory.
    pub fn junit(&self) -> io::Result<String> {
        let mut writer = Writer::new_with_indent(Vec::new(), b' ', 2);
        writer.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
        let all = || self.files.iter().flat_map(|suite| &suite.scenarios);
        let sums = sums(all());
        let root = writer.create_element("testsuites").with_attribute(("name", "genomctl test"));
        let root = root.with_attributes(sums.iter().map(|(key, value)| (*key, value.as_str())));
        root.write_inner_content(|writer| {
            self.files.iter().try_for_each(|file| suite(writer, file))
        })?;
        let mut text = String::from_utf8_lossy(&writer.into_inner()).into_owned();
        text.push('\n');
        Ok(text)
    }
}

fn sums<'a>(all: impl Iterator<Item = &'a ScenarioReport> + Clone) -> Vec<(&'static str, String)> {
    let failures = all.clone().filter(|one| matches!(one.outcome, Outcome::Failed(_))).count();
    let errors = all.clone().filter(|one| matches!(one.outcome, Outcome::Error(_))).count();
    let time = all.clone().map(|one| one.played.nanoseconds).sum();
    vec![
        ("tests", all.count().to_string()),
        ("failures", failures.to_string()),
        ("errors", errors.to_string()),
        ("time", decimal(time)),
    ]
}

fn suite(writer: &mut Writer<Vec<u8>>, suite: &SuiteReport) -> io::Result<()> {
    let file = suite.file.display().to_string();
    let file = sound(&file);
    let sums = sums(suite.scenarios.iter());
    let element = writer.create_element("testsuite").with_attribute(("name", file.as_ref()));
    let element = element.with_attributes(sums.iter().map(|(key, value)| (*key, value.as_str())));
    element.write_inner_content(|writer| {
        suite.scenarios.iter().try_for_each(|one| case(writer, &file, one))
    })?;
    Ok(())
}

fn case(writer: &mut Writer<Vec<u8>>, file: &str, one: &ScenarioReport) -> io::Result<()> {
    let (name, line, time) = (sound(&one.name), one.line.to_string(), one.played.nanoseconds);
    let time = decimal(time);
    let stem = file.strip_suffix(".toml").or_else(|| file.strip_suffix(".py"));
    let class = stem.unwrap_or(file).replace('/', ".");
    let element = writer.create_element("testcase").with_attributes([
        ("classname", class.trim_start_matches('.')),
        ("name", &name),
        ("file", file),
        ("line", &line),
        ("time", &time),
    ]);
    let (kind, unmet) = match &one.outcome {
        Outcome::Passed => return element.write_empty().map(drop),
        Outcome::Failed(unmet) => ("failure", unmet),
        Outcome::Error(unmet) => ("error", unmet),
    };
    element.write_inner_content(|writer| fault(writer, kind, file, unmet))?;
    Ok(())
}

fn fault(writer: &mut Writer<Vec<u8>>, kind: &str, file: &str, of: &Unmet) -> io::Result<()> {
    let Unmet { line, step, nanoseconds, expected, came, .. } = of;
    let message = format!("expected {expected}, came {came}");
    let text = format!(
        "{file}:{line}: {step}, at {}\nexpected  {expected}\ncame      {came}\n",
        seconds(*nanoseconds)
    );
    let verb = step.split(' ').next().unwrap_or_default();
    let attributes = [("message", sound(&message)), ("type", Cow::from(verb))];
    let attributes = attributes.iter().map(|(key, value)| (*key, value.as_ref()));
    let element = writer.create_element(kind).with_attributes(attributes);
    element.write_text_content(BytesText::new(&sound(&text)))?;
    Ok(())
}

/// The text without characters that XML 1.0 (section 2.2) has not.
fn sound(text: &str) -> Cow<'_, str> {
    let lacks = |c: char| {
        c.is_control() && !matches!(c, '\t' | '\n' | '\r') || matches!(c, '\u{fffe}' | '\u{ffff}')
    };
    match text.contains(lacks) {
        true => Cow::from(text.replace(lacks, "\u{fffd}")),
        false => Cow::from(text),
    }
}
