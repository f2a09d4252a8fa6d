//! The embedded files of the built page. Without them the service answers with instructions for building them.

use super::reply::Reply;
use include_dir::{Dir, include_dir};

static ASSETS: Dir<'static> = include_dir!("$CARGO_MANIFEST_DIR/assets");

/// Files whose names contain a hash of their content (Vite's): they never change.
const HASHED: &str = "assets/";

const NOTICE: &str = "<!doctype html><html lang=\"zh\"><meta charset=\"utf-8\"><title>Whyroad</title>\
<body><h1>Whyroad</h1><p>此程序构建时没有包含网页。接口在 <a href=\"/api/v1/openapi.json\">/api/v1</a>；\
要得到网页，请在 web/ 下运行 npm ci 和 npm run build，然后重新构建程序。</p>\
<p lang=\"en\">This program was built without the page. The API is at <a href=\"/api/v1/openapi.json\">/api/v1</a>; \
for the page run npm ci and npm run build in web/, then build the program again.</p></body></html>";

/// How long a browser may keep an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Keep {
    /// It asks the service each time.
    Ask,
    /// Without a time limit.
    Forever,
}

/// The file for a path outside the API; for every unknown path the page itself, which has its own router.
pub fn page(path: &str) -> (Reply, Keep) {
    let name = path.trim_start_matches('/');
    let file = ASSETS.get_file(name).filter(|_| !name.is_empty() && name != "README.md");
    if let Some(file) = file {
        let keep = if name.starts_with(HASHED) { Keep::Forever } else { Keep::Ask };
        return (Reply::bytes(media(name), file.contents().to_vec()), keep);
    }
    // A missing script must not be answered with the page.
    if name.starts_with(HASHED) {
        return (
            Reply { status: 404, ..Reply::bytes("text/plain; charset=utf-8", b"not found".to_vec()) },
            Keep::Ask,
        );
    }
    let index = ASSETS.get_file("index.html").map_or(NOTICE.as_bytes(), |f| f.contents());
    (Reply::bytes("text/html; charset=utf-8", index.to_vec()), Keep::Ask)
}

fn media(name: &str) -> &'static str {
    match name.rsplit_once('.').map(|(_, ending)| ending) {
        Some("html") => "text/html; charset=utf-8",
        Some("js" | "mjs") => "text/javascript; charset=utf-8",
        Some("css") => "text/css; charset=utf-8",
        Some("svg") => "image/svg+xml",
        Some("png") => "image/png",
        Some("ico") => "image/x-icon",
        Some("json" | "webmanifest") => "application/json",
        Some("woff2") => "font/woff2",
        Some("wasm") => "application/wasm",
        _ => "application/octet-stream",
    }
}
