//! What a trace keeps of the draft that its label began with, where that draft is known. Without it, a draft is
//! recognized by the framework's phrasings (`crate::draft::is_draft`): not one whose components or decision were
//! changed, or whose words depend on something that the label does not state.

/// Marks at the beginning of the drafts of this program up to version 0.1; a trace that has one was not written by a
/// person.
const DRAFT_MARKS: [&str; 2] = ["【草稿】", "[DRAFT]"];

/// What is left of a draft.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kept {
    /// All of it.
    Trace,
    /// Its reason, whatever is stated as the decision.
    Reason,
}

/// What `trace` keeps of the trace `drafted`.
pub(super) fn kept(drafted: &str, trace: &str) -> Option<Kept> {
    let drafted = without_draft_mark(drafted);
    if drafted.is_empty() {
        return None;
    }
    if drafted == trace {
        return Some(Kept::Trace);
    }
    let of = |text| reason(text).map(bare).filter(|reason| !reason.is_empty());
    let reason = of(drafted)?;
    (of(trace)? == reason).then_some(Kept::Reason)
}

/// The trace without a draft mark at its beginning.
pub(super) fn without_draft_mark(trace: &str) -> &str {
    let text = trace.trim_start();
    DRAFT_MARKS.iter().find_map(|m| text.strip_prefix(m)).map_or(trace, str::trim_start)
}

/// The letters and digits of a text, in lower case: what remains when punctuation is changed.
pub(crate) fn bare(text: &str) -> String {
    text.chars().filter(|c| c.is_alphanumeric()).map(|c| c.to_ascii_lowercase()).collect()
}

/// The part of a trace between its state and its decision, as the page divides it.
fn reason(trace: &str) -> Option<&str> {
    let joints = ["因此", "所以", "故而", " therefore ", ", so ", " hence "];
    let before = &trace[..joints.iter().filter_map(|joint| trace.rfind(joint)).max()?];
    if let Some((_, reason)) = before.split_once(['；', ';']) {
        return Some(reason);
    }
    let sentences = before.trim_end_matches(|c: char| !c.is_alphanumeric());
    let ends = ["。", ". "].iter().filter_map(|end| sentences.rfind(end).map(|at| at + end.len()));
    ends.max().map(|at| &sentences[at..])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drafted_reason_stays_one_beside_another_decision() {
        // Patterns of `traces` in schema/draft_texts.yaml, and the text that the page writes of the same parts.
        let zh = "【草稿】前车减速。车距不足，需要拉开间距，所以自车跟车。";
        assert_eq!(kept(zh, "前车减速。车距不足，需要拉开间距，所以自车跟车。"), Some(Kept::Trace));
        for of_reason in [
            "前车减速。车距不足，需要拉开间距，所以自车停车。",
            "前车减速；车距不足，需要拉开间距，因此自车让行。",
            "别的状态；车距不足，需要拉开间距，因此停车。",
        ] {
            assert_eq!(kept(zh, of_reason), Some(Kept::Reason), "{of_reason}");
        }
        for written in ["前车减速；再不减速会追尾，因此自车跟车。", "前车减速。", "", "因此自车让行。"]
        {
            assert_eq!(kept(zh, written), None, "{written}");
        }
        let en = "The lead brakes. The gap is too short, so the ego follows it.";
        let other = "The lead brakes; the gap is too short, therefore the ego yields.";
        assert_eq!(kept(en, other), Some(Kept::Reason));
        assert_eq!(kept(en, "The lead brakes; it would be hit, therefore the ego yields."), None);
        assert_eq!(
            kept("前车减速，因此自车跟车。", "前车减速，因此自车让行。"),
            None,
            "a draft without a reason"
        );
        assert_eq!((kept("", ""), kept("[DRAFT] ", "")), (None, None), "no draft");
    }
}
