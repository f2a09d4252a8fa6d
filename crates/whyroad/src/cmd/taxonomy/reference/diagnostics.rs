//! The index of diagnostics: every page of `docs/diagnostics/` with its severity and first sentence, in both languages.

use super::cell;
use std::collections::BTreeMap;
use std::fmt::Write as _;

const HEAD: &str =
    "<!-- Written by `whyroad taxonomy docs` from docs/diagnostics/. Change those pages, not this one. -->

# Diagnostics · 诊断代码

Every message of Whyroad has a stable code. `whyroad validate --format json` and `--format sarif` give it too.

Whyroad 的每条提示都有固定的代码；`whyroad validate --format json` 与 `--format sarif` 的输出中也有。
";

/// The page, from code and text of every page; the error names a page that is not in the form
/// `# code`, `Error. ...`, `## 中文`, `错误。...`.
pub(in crate::cmd::taxonomy) fn index(pages: &BTreeMap<String, String>) -> Result<String, String> {
    let mut out = HEAD.to_owned();
    let mut group = "";
    for (code, text) in pages {
        let entry = entry(code, text).ok_or_else(|| code.clone())?;
        let first = code.split('.').next().unwrap_or_default();
        if first != group {
            group = first;
            let _ = write!(out, "\n## {group}\n\n| code | severity | | |\n|---|---|---|---|\n");
        }
        let (severity, en, zh) = entry;
        let _ = writeln!(
            out,
            "| [{code}](../diagnostics/{code}.md) | {severity} | {} | {} |",
            cell(&en),
            cell(&zh)
        );
    }
    Ok(out)
}

/// Severity and first sentence in both languages.
fn entry(code: &str, text: &str) -> Option<(&'static str, String, String)> {
    let (english, chinese) = text.split_once("\n## 中文\n")?;
    let english = english.strip_prefix(&format!("# {code}\n"))?;
    let (severity, en, zh) =
        [("error", "Error. ", "错误。"), ("warning", "Warning. ", "警告。"), ("note", "Note. ", "提示。")]
            .into_iter()
            .find_map(|(name, en, zh)| {
                Some((
                    name,
                    first_paragraph(english, " ").strip_prefix(en)?.to_owned(),
                    first_paragraph(chinese, "").strip_prefix(zh)?.to_owned(),
                ))
            })?;
    // A dot inside a file name or id does not end a sentence: it ends before a space, or with the paragraph.
    let end = en
        .match_indices(". ")
        .find(|(i, _)| en[..*i].matches('`').count() % 2 == 0)
        .map_or(en.len(), |(i, _)| i + 1);
    let end_zh = zh.find('。').map_or(zh.len(), |i| i + '。'.len_utf8());
    Some((severity, en[..end].to_owned(), zh[..end_zh].to_owned()))
}

/// The lines up to the first blank one, joined.
fn first_paragraph(text: &str, joint: &str) -> String {
    let lines = text.trim_start_matches('\n').lines().take_while(|l| !l.trim().is_empty());
    lines.collect::<Vec<_>>().join(joint)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_sentence_is_the_title() {
        let page = "# a.b\n\nWarning. The file `x. y` of v1.2 is\nodd. More.\n\n```\nx\n```\n\n## 中文\n\n警告。文件有误。更多。\n";
        let pages = BTreeMap::from([("a.b".to_owned(), page.to_owned())]);
        let index = index(&pages).unwrap();
        assert!(index.contains(
            "| [a.b](../diagnostics/a.b.md) | warning | The file `x. y` of v1.2 is odd. | 文件有误。 |"
        ));
        let odd = BTreeMap::from([("a.b".to_owned(), page.replace("Warning. ", ""))]);
        assert_eq!(super::index(&odd), Err("a.b".to_owned()));
    }
}
