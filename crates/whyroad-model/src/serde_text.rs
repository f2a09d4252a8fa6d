//! Errors of serde in Chinese. Its messages have fixed forms; what it quotes stays as it is.

/// The message in Chinese; unchanged where its form is not known.
pub fn in_chinese(message: &str) -> String {
    let expected = |rest: &str| {
        let list = rest.trim_start_matches("one of ").replace(" or ", "、").replace(", ", "、");
        match rest {
            "there are no fields" | "there are no variants" => "此处不能有内容".to_owned(),
            _ if rest.starts_with('`') || rest.starts_with("one of ") => format!("可用：{list}"),
            _ => spaced("应为", &kind(rest)),
        }
    };
    let (what, wanted) = match message.split_once(", expected ") {
        Some((what, rest)) => (what, Some(expected(rest))),
        None => match message.split_once(", there are no ") {
            Some((what, _)) => (what, Some(expected("there are no fields"))),
            None => (message, None),
        },
    };
    let forms = [
        ("unknown variant ", "没有取值"),
        ("unknown field ", "没有字段"),
        ("missing field ", "缺少字段"),
        ("duplicate field ", "字段重复："),
        ("invalid type: ", "类型不对：给出了"),
        ("invalid value: ", "取值不对：给出了"),
        ("invalid length ", "长度不对："),
    ];
    let Some(known) = forms.iter().find_map(|(en, zh)| Some(spaced(zh, &kind(what.strip_prefix(en)?))))
    else {
        return message.to_owned();
    };
    wanted.into_iter().fold(known, |all, wanted| format!("{all}，{wanted}"))
}

/// Chinese text before another text, with a space before Latin letters, digits and quotes.
fn spaced(zh: &str, text: &str) -> String {
    let is_apart = !zh.ends_with('：') && text.starts_with(|c: char| c.is_ascii());
    format!("{zh}{}{text}", if is_apart { " " } else { "" })
}

/// A type, as serde calls it.
fn kind(text: &str) -> String {
    let types = [
        ("string ", "字符串 "),
        ("integer ", "整数 "),
        ("floating point ", "小数 "),
        ("boolean ", "布尔值 "),
    ];
    let whole = [
        ("a string", "字符串"),
        ("a boolean", "布尔值"),
        ("a sequence", "列表"),
        ("sequence", "列表"),
        ("a map", "映射"),
        ("map", "映射"),
        ("null", "空值"),
        ("unit value", "空值"),
        ("f64", "数"),
        ("u64", "不小于 0 的整数"),
        ("u32", "不小于 0 的整数"),
        ("usize", "不小于 0 的整数"),
        ("i64", "整数"),
    ];
    if let Some((_, zh)) = whole.iter().find(|(en, _)| *en == text) {
        return (*zh).to_owned();
    }
    let typed = types.iter().find_map(|(en, zh)| Some(format!("{zh}{}", text.strip_prefix(en)?)));
    typed.unwrap_or_else(|| text.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Sample {
        #[serde(rename = "level")]
        _level: Level,
        #[serde(rename = "limit")]
        _limit: f64,
    }

    #[derive(Debug, Deserialize)]
    #[serde(rename_all = "snake_case")]
    enum Level {
        Low,
        High,
    }

    #[test]
    fn the_forms_of_serde_are_told_in_chinese() {
        for (json, expected) in [
            (r#"{"level": "hgh", "limit": 1}"#, "没有取值 `hgh`，可用：`low`、`high`"),
            (r#"{"level": "low", "lmt": 1}"#, "没有字段 `lmt`，可用：`level`、`limit`"),
            (r#"{"level": "low"}"#, "缺少字段 `limit`"),
            (r#"{"level": "low", "limit": "x"}"#, "类型不对：给出了字符串 \"x\"，应为数"),
        ] {
            let error = serde_json::from_str::<Sample>(json).expect_err("a wrong document").to_string();
            let (message, _) = error.split_once(" at line ").expect("a place");
            assert_eq!(in_chinese(message), expected, "{message}");
        }
        assert_eq!(in_chinese("the tire is flat"), "the tire is flat");
    }
}
