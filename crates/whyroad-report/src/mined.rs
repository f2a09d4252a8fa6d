//! What `whyroad mine` left in its folder, read back: `coverage.json` and `episodes.jsonl`. Takes texts, not
//! paths; a line that cannot be read is named and does not stop the rest.

use whyroad_model::messages::{Coverage, EpisodeRecord};
use whyroad_model::{Bilingual, Diagnostic, Location};

/// Codes of the diagnostics of this crate; each has a page in `docs/diagnostics/`.
pub const CODES: &[&str] = &[
    "report.coverage.unreadable",
    "report.episode.unreadable",
    "evaluate.truth.line",
    "evaluate.sequence.line",
];

/// Reads `coverage.json`.
pub fn read_coverage(text: &str, file: &str) -> Result<Coverage, Box<Diagnostic>> {
    serde_json::from_str(text).map_err(|e| {
        let message =
            Bilingual::new(format!("覆盖统计无法读取：{e}"), format!("the coverage cannot be read: {e}"));
        Box::new(
            Diagnostic::error("report.coverage.unreadable", message)
                .with_hint(mine_again())
                .at(Location { line: Some(e.line()), column: Some(e.column().max(1)), ..Location::default() })
                .in_file(file),
        )
    })
}

/// Reads `episodes.jsonl`: the episodes, and an error for each line that is none.
pub fn read_episodes(text: &str, file: &str) -> (Vec<EpisodeRecord>, Vec<Diagnostic>) {
    let (mut episodes, mut problems) = (Vec::new(), Vec::new());
    for (i, line) in text.lines().enumerate().filter(|(_, l)| !l.trim().is_empty()) {
        match serde_json::from_str(line) {
            Ok(episode) => episodes.push(episode),
            Err(e) => {
                let message = Bilingual::new(
                    format!("该行不是片段记录，已跳过：{e}"),
                    format!("this line is no episode and is left out: {e}"),
                );
                let place =
                    Location { line: Some(i + 1), column: Some(e.column().max(1)), ..Location::default() };
                problems.push(
                    Diagnostic::error("report.episode.unreadable", message)
                        .with_hint(mine_again())
                        .at(place)
                        .in_file(file),
                );
            }
        }
    }
    (episodes, problems)
}

fn mine_again() -> Bilingual {
    Bilingual::new(
        "重新运行 `whyroad mine` 生成该文件夹",
        "run `whyroad mine` again to write the folder anew",
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture;

    #[test]
    fn a_broken_line_does_not_stop_the_rest() {
        let drive = fixture::drive("d");
        let good = serde_json::to_string(&fixture::episode(&drive)).unwrap();
        let text = format!("{good}\n{{\"episode_id\": 1}}\n\n{good}\n");
        let (episodes, problems) = read_episodes(&text, "episodes.jsonl");
        assert_eq!(episodes.len(), 2);
        assert_eq!(problems.len(), 1);
        assert_eq!((problems[0].code, problems[0].location.line), ("report.episode.unreadable", Some(2)));
    }

    #[test]
    fn coverage_that_is_cut_off_is_refused_with_its_place() {
        let text = serde_json::to_string_pretty(&fixture::coverage()).unwrap();
        assert_eq!(read_coverage(&text, "c").unwrap(), fixture::coverage());
        let cut = &text[..text.len() / 2];
        let problem = read_coverage(cut, "c").unwrap_err();
        assert_eq!(problem.code, "report.coverage.unreadable");
        assert_eq!(problem.location.line, Some(cut.lines().count()));
    }

    #[test]
    fn every_code_has_a_page_in_both_languages() {
        for code in CODES {
            let page = format!("{}/../../docs/diagnostics/{code}.md", env!("CARGO_MANIFEST_DIR"));
            let text = std::fs::read_to_string(&page).unwrap_or_else(|e| panic!("{page}: {e}"));
            assert!(text.contains("## 中文"), "{page}");
        }
    }
}
