//! What browsers load: plain modules, a style sheet and one page, part of the program.

use std::sync::LazyLock;

use axum::extract::Path;
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};

use crate::secret;

/// A file.
struct Asset {
    name: &'static str,
    media: &'static str,
    content: &'static str,
}

const INDEX: &str = include_str!("../assets/index.html");
const SCRIPT: &str = "text/javascript; charset=utf-8";

macro_rules! assets {
    ($($name:literal $media:expr;)*) => {
        &[$(Asset {
            name: $name,
            media: $media,
            content: include_str!(concat!("../assets/", $name)),
        }),*]
    };
}

const ALL: &[Asset] = assets! {
    "index.html" "text/html; charset=utf-8";
    "style.css" "text/css; charset=utf-8";
    "icon.svg" "image/svg+xml";
    "main.js" SCRIPT;
    "dom.js" SCRIPT;
    "api.js" SCRIPT;
    "live.js" SCRIPT;
    "units.js" SCRIPT;
    "overview.js" SCRIPT;
    "component.js" SCRIPT;
    "service.js" SCRIPT;
    "form.js" SCRIPT;
    "machine.js" SCRIPT;
    "port.js" SCRIPT;
    "rules.js" SCRIPT;
    "plot.js" SCRIPT;
    "image.js" SCRIPT;
    "table.js" SCRIPT;
    "heat.js" SCRIPT;
    "spent.js" SCRIPT;
    "timeline.js" SCRIPT;
    "lanes.js" SCRIPT;
    "mcap.js" SCRIPT;
    "graph.js" SCRIPT;
    "scene.js" SCRIPT;
    "peers.js" SCRIPT;
    "drawing.js" SCRIPT;
    "layout.js" SCRIPT;
    "level.js" SCRIPT;
    "wires.js" SCRIPT;
    "view.js" SCRIPT;
    "gestures.js" SCRIPT;
    "ends.js" SCRIPT;
    "rates.js" SCRIPT;
    "wiring.js" SCRIPT;
    "dialog.js" SCRIPT;
    "menu.js" SCRIPT;
    "logs.js" SCRIPT;
    "doctor.js" SCRIPT;
    "fleet.js" SCRIPT;
    "deployment.js" SCRIPT;
    "recordings.js" SCRIPT;
};

/// Modules of pages that are loaded when they are first shown.
const LATER: [&str; 6] =
    ["timeline.js", "lanes.js", "mcap.js", "doctor.js", "deployment.js", "recordings.js"];

/// The modules that are loaded with the page, whichever it is.
fn modules() -> impl Iterator<Item = &'static Asset> {
    ALL.iter().filter(|one| one.media == SCRIPT && !LATER.contains(&one.name))
}

/// The page, which names these modules: a browser would find them only one after the other, each
/// where another one imports it.
static PAGE: LazyLock<String> = LazyLock::new(|| {
    let links = modules()
        .map(|one| format!("<link rel=\"modulepreload\" href=\"/assets/{}\">\n", one.name));
    let (head, rest) = INDEX.split_once("</head>").unwrap_or((INDEX, ""));
    format!("{head}{}</head>{rest}", links.collect::<String>())
});

/// Tells of each file whether a browser has it already.
static TAGS: LazyLock<Vec<String>> =
    LazyLock::new(|| ALL.iter().map(|one| format!("\"{}\"", secret::digest(one.text()))).collect());

impl Asset {
    fn text(&self) -> &'static str {
        if self.content == INDEX { &PAGE } else { self.content }
    }
}

/// The page that all addresses of the console show.
pub(crate) async fn page(headers: HeaderMap) -> Response {
    of("index.html", &headers)
}

/// A file.
pub(crate) async fn file(Path(name): Path<String>, headers: HeaderMap) -> Response {
    of(&name, &headers)
}

fn of(name: &str, headers: &HeaderMap) -> Response {
    let found = ALL.iter().zip(&*TAGS).find(|(one, _)| one.name == name);
    let Some((asset, tag)) = found else { return StatusCode::NOT_FOUND.into_response() };
    let about = [(header::ETAG, tag.as_str()), (header::CACHE_CONTROL, "no-cache")];
    if headers.get(header::IF_NONE_MATCH).is_some_and(|known| known == tag.as_str()) {
        return (StatusCode::NOT_MODIFIED, about).into_response();
    }
    (about, [(header::CONTENT_TYPE, asset.media)], asset.text()).into_response()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_files_together_are_small_and_each_is_served() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/assets");
        let mut there: Vec<_> = std::fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        there.sort();
        let mut served: Vec<_> = ALL.iter().map(|one| one.name).collect();
        served.sort_unstable();
        assert_eq!(there, served);
        let size: usize = ALL.iter().map(|one| one.content.len()).sum();
        assert!(size < 400_000, "{size} bytes");
    }

    #[test]
    fn the_page_names_each_module_once_but_for_those_that_are_loaded_later() {
        for one in ALL.iter().filter(|one| one.media == SCRIPT) {
            let link = format!("<link rel=\"modulepreload\" href=\"/assets/{}\">", one.name);
            let times = usize::from(!LATER.contains(&one.name));
            assert_eq!(PAGE.matches(&link).count(), times, "{}", one.name);
        }
        assert!(PAGE.ends_with("</html>\n"));
    }

    #[test]
    fn values_reach_pages_as_text_only() {
        for one in ALL.iter().filter(|one| one.media == SCRIPT) {
            for way in ["innerHTML", "outerHTML", "insertAdjacentHTML", "document.write", "eval("] {
                assert!(!one.content.contains(way), "{}: {way}", one.name);
            }
        }
    }
}
