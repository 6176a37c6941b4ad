//! Keys of the configuration set on the command line: `--set rpc.max_body=1024`.

use genom_registry::Sections;
use serde::de::DeserializeOwned;
use toml::{Table, Value};

use crate::error::{ConfigError, SetError};

/// Applies `KEY=VALUE` words to the text of a configuration.
pub(crate) fn set<Config: DeserializeOwned + Default>(
    text: &str,
    words: &[String],
) -> Result<Config, ConfigError> {
    let refuse = |word: &str, why: SetError| ConfigError::Set { word: word.to_owned(), why };
    let mut table: Table =
        text.parse().map_err(|error: toml::de::Error| refuse("", error.into()))?;
    let mut config = Config::default();
    for word in words {
        let Some((key, value)) = word.split_once('=') else {
            return Err(refuse(word, SetError::NoValue));
        };
        put(&mut table, key.trim(), parse(value.trim())).map_err(|why| refuse(word, why))?;
        // Checked after each word, so that an error names the word that caused it.
        let read = table.clone().try_into();
        let read =
            read.and_then(|config: Config| table.clone().try_into::<Sections>().map(|_| config));
        config = read.map_err(|error: toml::de::Error| refuse(word, error.into()))?;
    }
    Ok(config)
}

/// A TOML value; anything that is not one is a string.
fn parse(text: &str) -> Value {
    let document: Result<Table, _> = format!("x = {text}").parse();
    match document.ok().and_then(|mut table| table.remove("x")) {
        Some(value) => value,
        None => Value::String(text.to_owned()),
    }
}

fn put(table: &mut Table, key: &str, value: Value) -> Result<(), SetError> {
    let Some((first, rest)) = key.split_once('.') else {
        table.insert(key.to_owned(), value);
        return Ok(());
    };
    let inner = table.entry(first).or_insert_with(|| Value::Table(Table::new()));
    match inner {
        Value::Table(inner) => put(inner, rest, value),
        other => {
            let (key, ty, member) = (first.to_owned(), other.type_str(), rest.to_owned());
            Err(SetError::NoTable { key, ty, member })
        }
    }
}

#[cfg(test)]
mod tests {
    use serde::Deserialize;

    use super::*;
    use crate::rpc::Rpc;

    #[derive(Debug, Default, Deserialize)]
    #[serde(default, deny_unknown_fields)]
    struct Config {
        backend: String,
        log: String,
        rpc: Rpc,
    }

    #[test]
    fn words_come_over_the_file_and_mistakes_name_the_word() {
        let text = "log = \"info\"\n[rpc]\nmax_body = 7\n";
        let words = ["rpc.max_streams=3", "log=debug", "backend = \"shm\""].map(str::to_owned);
        let config: Config = set(text, &words).unwrap();
        assert_eq!((config.rpc.max_body, config.rpc.max_streams), (7, 3));
        assert_eq!((config.log.as_str(), config.backend.as_str()), ("debug", "shm"));
        for (word, told) in [
            ("rpc.max_bdy=3", "did you mean `max_body`?"),
            ("rpc.max_body=big", "invalid type"),
            ("log.level=3", "log is a string"),
            ("nothing", "KEY=VALUE"),
        ] {
            let error = set::<Config>(text, &[word.to_owned()]).unwrap_err().to_string();
            assert!(error.contains(word) && error.contains(told), "{error}");
        }
    }
}
