//! Errors of the command line in Chinese; in English they are clap's own.

use clap::error::{ContextKind, ContextValue, Error, ErrorFormatter, ErrorKind, RichFormatter};
use std::error::Error as _;
use std::ffi::{OsStr, OsString};
use std::fmt::Write as _;
use whyroad_model::Lang;

/// The language that these arguments ask for, before they are parsed: errors of parsing are shown in it, too.
/// `variable` is the value of `WHYROAD_LANG`.
pub(crate) fn lang_of(arguments: impl IntoIterator<Item = OsString>, variable: Option<&OsStr>) -> Lang {
    let parse = |text: &OsStr| text.to_str().and_then(|t| crate::arguments::lang(t).ok());
    let mut arguments = arguments.into_iter().take_while(|a| a != "--");
    let mut found = None;
    while let Some(argument) = arguments.next() {
        if argument == "--lang" {
            found = arguments.next().and_then(|value| parse(&value)).or(found);
        } else if let Some(value) = argument.to_str().and_then(|a| a.strip_prefix("--lang=")) {
            found = parse(OsStr::new(value)).or(found);
        }
    }
    found.or_else(|| variable.and_then(parse)).unwrap_or_default()
}

/// The message of an error in Chinese. Kinds without a translation keep the text of clap.
pub(crate) struct Chinese;

impl ErrorFormatter for Chinese {
    fn format_error(error: &Error<Self>) -> clap::builder::StyledStr {
        let Some(mut text) = message(error) else { return in_english(error) };
        for (kind, name) in [
            (ContextKind::SuggestedSubcommand, "子命令"),
            (ContextKind::SuggestedArg, "选项"),
            (ContextKind::SuggestedValue, "值"),
        ] {
            let similar = words(error, kind);
            if !similar.is_empty() {
                let _ = write!(text, "\n\n  提示：相近的{name}有 {}", quoted(&similar));
            }
        }
        // Hints of clap are English.
        if let Some(ContextValue::StyledStrs(hints)) = error.get(ContextKind::Suggested) {
            for hint in hints.iter().map(ToString::to_string).filter(|hint| !hint.is_ascii()) {
                let _ = write!(text, "\n\n  提示：{hint}");
            }
        }
        if let Some(ContextValue::StyledStr(usage)) = error.get(ContextKind::Usage) {
            let usage = usage.to_string();
            let usage = usage.strip_prefix("Usage:").map_or(usage.as_str(), str::trim_start);
            // It is there because it was given, also by the environment.
            let usage = usage.replace(" --lang <LANG>", "");
            let _ = write!(text, "\n\n用法：{usage}");
        }
        format!("错误：{text}\n\n详见 '--help'。\n").into()
    }
}

fn in_english(error: &Error<Chinese>) -> clap::builder::StyledStr {
    let mut plain = Error::<RichFormatter>::new(error.kind());
    for (kind, value) in error.context() {
        plain.insert(kind, value.clone());
    }
    plain.render()
}

fn message(error: &Error<Chinese>) -> Option<String> {
    let argument = || words(error, ContextKind::InvalidArg).into_iter().next();
    let value = || words(error, ContextKind::InvalidValue).into_iter().next();
    let number = |kind| match error.get(kind) {
        Some(ContextValue::Number(n)) => Some(*n),
        _ => None,
    };
    Some(match error.kind() {
        ErrorKind::InvalidValue => {
            let (argument, value) = (argument()?, value()?);
            let mut text = if value.is_empty() {
                format!("'{argument}' 需要一个值")
            } else {
                format!("'{argument}' 的值 '{value}' 无效")
            };
            let possible = words(error, ContextKind::ValidValue);
            if !possible.is_empty() {
                let _ = write!(text, "\n  可用的值：{}", possible.join("、"));
            }
            text
        }
        ErrorKind::ValueValidation => {
            let cause = error.source().map(|e| format!("：{}", cause(&e.to_string())));
            format!("'{}' 的值 '{}' 无效{}", argument()?, value()?, cause.unwrap_or_default())
        }
        ErrorKind::UnknownArgument => format!("没有参数 '{}'", argument()?),
        ErrorKind::InvalidSubcommand => {
            format!("没有子命令 '{}'", words(error, ContextKind::InvalidSubcommand).first()?)
        }
        ErrorKind::MissingSubcommand => {
            let of = words(error, ContextKind::InvalidSubcommand);
            let possible = words(error, ContextKind::ValidSubcommand).join("、");
            format!("'{}' 之后需要子命令\n  可用的子命令：{possible}", of.first()?)
        }
        ErrorKind::MissingRequiredArgument => {
            let missing = words(error, ContextKind::InvalidArg);
            format!("缺少必需的参数：\n  {}", missing.join("\n  "))
        }
        ErrorKind::ArgumentConflict => {
            let argument =
                argument().or_else(|| words(error, ContextKind::InvalidSubcommand).into_iter().next())?;
            let others = words(error, ContextKind::PriorArg);
            if others.is_empty() || others == [argument.as_str()] {
                format!("'{argument}' 只能给出一次")
            } else {
                format!("'{argument}' 不能与 {} 同时使用", quoted(&others))
            }
        }
        ErrorKind::NoEquals => format!("'{}' 与值之间需要等号", argument()?),
        ErrorKind::TooManyValues => format!("'{}' 多出一个值 '{}'", argument()?, value()?),
        ErrorKind::TooFewValues => {
            let (least, given) = (number(ContextKind::MinValues)?, number(ContextKind::ActualNumValues)?);
            format!("'{}' 至少需要 {least} 个值，只给出 {given} 个", argument()?)
        }
        ErrorKind::WrongNumberOfValues => {
            let wanted = number(ContextKind::ExpectedNumValues)?;
            format!(
                "'{}' 需要 {wanted} 个值，给出了 {} 个",
                argument()?,
                number(ContextKind::ActualNumValues)?
            )
        }
        ErrorKind::InvalidUtf8 => "参数不是有效的 UTF-8".to_owned(),
        _ => return None,
    })
}

/// Why a value was refused. Errors of our own are in the user's language; those of numbers come from the standard
/// library and from clap.
fn cause(text: &str) -> String {
    if let Some((_, range)) = text.split_once(" is not in ") {
        return format!("应在 {range} 之内");
    }
    match text {
        "invalid socket address syntax" => "不是“地址:端口”",
        "invalid digit found in string" => "不是整数",
        "cannot parse integer from empty string" | "cannot parse float from empty string" => "是空的",
        "invalid float literal" => "不是数",
        "number too large to fit in target type" => "数太大",
        "number too small to fit in target type" => "数太小",
        other => other,
    }
    .to_owned()
}

fn words(error: &Error<Chinese>, kind: ContextKind) -> Vec<String> {
    match error.get(kind) {
        Some(ContextValue::String(text)) => vec![text.clone()],
        Some(ContextValue::Strings(texts)) => texts.clone(),
        _ => Vec::new(),
    }
}

fn quoted(words: &[String]) -> String {
    words.iter().map(|w| format!("'{w}'")).collect::<Vec<_>>().join("、")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn os(text: &str) -> Vec<OsString> {
        text.split_whitespace().map(OsString::from).collect()
    }

    #[test]
    fn the_language_is_read_before_the_arguments_are_parsed() {
        for (arguments, variable, lang) in [
            ("whyroad mine", None, Lang::En),
            ("whyroad --lang zh mine", None, Lang::Zh),
            ("whyroad mine --lang=zh", Some("en"), Lang::Zh),
            ("whyroad mine --lang en", Some("zh"), Lang::En),
            ("whyroad mine --lang fr", Some("zh"), Lang::Zh),
            ("whyroad mine --lang", None, Lang::En),
            ("whyroad mine -- --lang zh", None, Lang::En),
        ] {
            assert_eq!(lang_of(os(arguments), variable.map(OsStr::new)), lang, "{arguments}");
        }
    }

    /// The Chinese message of a wrong command line.
    fn zh(line: &str) -> String {
        let error = crate::command_line().try_get_matches_from(os(line)).expect_err("a wrong command line");
        error.apply::<Chinese>().to_string()
    }

    #[test]
    fn every_common_mistake_has_a_chinese_message() {
        for (line, expected) in [
            ("whyroad mien --lake l", "没有子命令 'mien'"),
            ("whyroad mine --lake l --out o --lakes x", "没有参数 '--lakes'"),
            ("whyroad lake --verbose", "需要子命令"),
            ("whyroad mine", "缺少必需的参数：\n  --lake <DIR>"),
            ("whyroad mine --lake", "'--lake <DIR>' 需要一个值"),
            ("whyroad mine --lake l --jobs 0", "'--jobs <N>' 的值 '0' 无效：应在 1..="),
            ("whyroad mine --lake l --jobs many", "不是整数"),
            ("whyroad inspect --lake l --format xml", "可用的值：text、json"),
            ("whyroad inspect --lake l --format json --format text", "'--format <FORMAT>' 只能给出一次"),
        ] {
            let text = zh(line);
            assert!(text.contains(expected), "{line}: {text}");
            assert!(text.starts_with("错误："), "{line}: {text}");
            for english in ["error:", "Usage", "required", "invalid", "unexpected", "For more"] {
                assert!(!text.contains(english), "{line}: {text}");
            }
        }
    }
}
