//! Results of mining and labeling: coverage over all leaves, the report that shows it, and episodes evaluated against
//! ground truth.
//!
//! Nothing here finds episodes or derives signals: both are passed in, because this crate must not depend on the crates
//! that make them. Nothing here writes a file; callers store what is returned.

pub mod analytics;
pub mod calibration;
pub mod comparison;
pub mod coverage;
pub mod evaluation;
pub mod report;
pub mod robustness;
mod shares;
pub mod unexplained;
pub mod verdicts;

/// Codes of the diagnostics of this crate; each has a page in the documentation.
pub const CODES: &[&str] = &["evaluate.truth.line", "evaluate.sequence.line", "evaluate.verdicts.line"];

/// Style sheet of pages with scenes and charts.
pub const STYLE: &str = include_str!("../assets/report.css");

#[cfg(test)]
#[path = "../../whyroad-model/testing/hand_drive.rs"]
mod fixture;

#[cfg(test)]
mod tests {
    #[test]
    fn every_code_has_a_page_in_both_languages() {
        for code in super::CODES {
            let page = format!("{}/../../docs/diagnostics/{code}.md", env!("CARGO_MANIFEST_DIR"));
            let text = std::fs::read_to_string(&page).unwrap_or_else(|e| panic!("{page}: {e}"));
            assert!(text.contains("## 中文"), "{page}");
        }
    }
}
