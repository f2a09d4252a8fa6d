//! Pages that commands write, in a browser: the language that they open in, and whether they fit a narrow window.
//! Without Chromium the tests say so, and fail when `WHYROAD_REQUIRE` names it.

use crate::session::whyroad_in;
use std::path::Path;
use std::process::Command;
use std::sync::LazyLock;
use tempfile::TempDir;

/// Width of the window: the least that Chromium opens.
const NARROW: usize = 500;

/// The document after its scripts ran, in a browser whose user prefers English; `None` without a browser. `probe` is a
/// script at the end of the body, `before` one at its beginning.
fn opened(page: &Path, before: &str, probe: &str) -> Option<String> {
    let text = std::fs::read_to_string(page).unwrap();
    let at = text.find("<body>").unwrap() + "<body>".len();
    let (head, body) = text.split_at(at);
    let body = body.replace("</body>", &format!("<script>{probe}</script></body>"));
    let folder = tempfile::tempdir().unwrap();
    let copy = folder.path().join("page.html");
    std::fs::write(&copy, format!("{head}<script>{before}</script>{body}")).unwrap();
    let profile = format!("--user-data-dir={}", folder.path().join("profile").display());
    let window = format!("--window-size={NARROW},900");
    let output = Command::new("chromium")
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--accept-lang=en-US", &profile, &window])
        .arg("--dump-dom")
        .arg(format!("file://{}", copy.display()))
        .output();
    match output {
        Ok(output) if output.status.success() => Some(String::from_utf8(output.stdout).unwrap()),
        _ => {
            crate::require::skipped("chromium", "no chromium");
            None
        }
    }
}

/// A demo with every kind of page, written with `--lang zh`, and their names.
static PAGES: LazyLock<(TempDir, Vec<&str>)> = LazyLock::new(|| {
    let dir = tempfile::tempdir().unwrap();
    let run = |args: &[&str]| {
        let run = whyroad_in(dir.path(), &[&["--lang", "zh"], args].concat());
        assert!([0, 1, 3].contains(&run.code), "{args:?}: {}{}", run.out, run.err);
        run.out
    };
    run(&["demo", "--out", "demo"]);
    let episodes = std::fs::read_to_string(dir.path().join("demo/mined/episodes.jsonl")).unwrap();
    let first: serde_json::Value = serde_json::from_str(episodes.lines().next().unwrap()).unwrap();
    let (class, clip) = (first["scenario_id"].as_str().unwrap(), first["clip_id"].as_str().unwrap());
    run(&["explain", class, "--lake", "demo/lake", "--clip", clip, "--html", "explain.html"]);
    run(&["mine", "--lake", "demo/lake", "--scenario", "cutin", "--out", "cutins"]);
    run(&["compare", "demo/mined", "cutins", "--out", "compare.html"]);
    run(&["robustness", "--lake", "demo/lake", "--perturbation", "white", "--page", "robustness.html"]);
    std::fs::write(dir.path().join("none.jsonl"), "").unwrap();
    run(&["dataset", "score", "demo/release", "none.jsonl", "--split", "train", "--page", "score.html"]);
    let pages = vec!["demo/report.html", "explain.html", "compare.html", "robustness.html", "score.html"];
    (dir, pages)
});

#[test]
fn a_page_opens_in_the_language_of_its_command_unless_the_reader_chose_another() {
    let (dir, pages) = &*PAGES;
    let lang = |page: &str, before: &str| {
        let probe = "document.documentElement.dataset.visible = \
                     [...document.querySelectorAll('body span[lang]')].filter((s) => s.checkVisibility()).map((s) => s.lang)
                     .filter((l, i, all) => all.indexOf(l) === i).join()";
        let dom = opened(&dir.path().join(page), before, probe)?;
        let root = dom.split("<html").nth(1).unwrap().split('>').next().unwrap().to_owned();
        Some((
            root.contains("lang=\"zh\""),
            root.contains("data-visible=\"zh\""),
            root.contains("data-visible=\"en\""),
        ))
    };
    for page in pages.iter().filter(|p| **p != "explain.html") {
        let Some(found) = lang(page, "") else { return };
        assert_eq!(found, (true, true, false), "{page}");
        let chosen = lang(page, "localStorage.setItem('whyroad.lang', 'en')").unwrap();
        assert_eq!(chosen, (false, false, true), "{page}: the reader's own choice");
    }
}

#[test]
fn pages_fit_a_narrow_window() {
    let (dir, pages) = &*PAGES;
    for page in pages {
        let probe = "document.documentElement.dataset.width = document.documentElement.scrollWidth";
        let Some(dom) = opened(&dir.path().join(page), "", probe) else { return };
        let width = dom.split("data-width=\"").nth(1).unwrap().split('"').next().unwrap();
        assert!(width.parse::<usize>().unwrap() <= NARROW, "{page}: {width} px");
    }
}
