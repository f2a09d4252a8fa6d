//! Why a line of JSON cannot be read, in both languages. serde_json decides; this words its errors.

use crate::check::json;
use whyroad_model::Bilingual;
use whyroad_model::serde_text::in_chinese;

/// What is wrong with `text`, for which serde_json reported `e`. The position is that of `e`.
pub fn message(text: &str, e: &serde_json::Error) -> Bilingual {
    if let (true, Err(syntax)) = (e.is_syntax() || e.is_eof(), json::parse(text)) {
        return syntax.message;
    }
    let whole = e.to_string();
    let what = whole.rsplit_once(" at line ").map_or(whole.as_str(), |(what, _)| what);
    Bilingual::new(in_chinese(what), what)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Sample {
        #[serde(rename = "level")]
        _level: u8,
    }

    #[test]
    fn errors_of_both_kinds_have_chinese_words() {
        for (text, zh, en) in [
            (r#"{"levl": 1}"#, "没有字段 `levl`，可用：`level`", "unknown field `levl`"),
            (r#"{"level": 1"#, "中断", "ends here"),
            (r#"{"level" 1}"#, "此处应为 ':'", "expected ':'"),
        ] {
            let m = message(text, &serde_json::from_str::<Sample>(text).expect_err("a wrong line"));
            assert!(m.zh.contains(zh) && m.en.contains(en), "{text}: {m:?}");
            assert!(!m.en.contains(" at line "), "{m:?}");
        }
    }
}
