//! YAML files as people write them: a syntax error in both languages, with the remedy, at the line where the fault is.
//! A parser reports where it can no longer go on, which is often a line later. This is not a parser.

use serde::de::DeserializeOwned;
use whyroad_model::suggest::{did_you_mean, suggestion};
use whyroad_model::yaml::{self, DecodeError, FileReport, Mark, Node, SyntaxCause, SyntaxError};
use whyroad_model::{Bilingual, Diagnostic, Location};

/// What is wrong with the syntax of a text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct YamlFault {
    /// What is wrong.
    pub message: Bilingual,
    /// How to fix it.
    pub hint: Option<Bilingual>,
    /// Where.
    pub mark: Mark,
}

/// Parses `text`; a syntax error is reported and yields nothing.
pub fn parse(report: &mut FileReport<'_>, text: &str) -> Option<Node> {
    match yaml::parse(text) {
        Ok(node) => Some(node),
        Err(e) => {
            let fault = fault(text, &e);
            let message = Bilingual::new(
                format!("不是合法的 YAML：{}", fault.message.zh),
                format!("not valid YAML: {}", fault.message.en),
            );
            let finding = Diagnostic { hint: fault.hint, ..Diagnostic::error(report.codes.syntax, message) };
            report.push(finding, fault.mark, "");
            None
        }
    }
}

/// Reads a file of a simple form, with its tree. `what` names its content, as the beginning of a sentence: "the word
/// list".
///
/// # Errors
/// The finding, under `code`, for the first mistake.
pub fn read<T: DeserializeOwned>(
    code: &'static str,
    file: &str,
    text: &str,
    what: Bilingual,
) -> Result<(T, Node), Box<Diagnostic>> {
    let root = yaml::parse(text).map_err(|e| Box::new(syntax(code, file, text, &what, &e)))?;
    match yaml::from_node(&root) {
        Ok(value) => Ok((value, root)),
        Err(e) => Err(Box::new(decoding(code, file, text, what, &e))),
    }
}

/// The finding for a text that is not YAML.
pub fn syntax(code: &'static str, file: &str, text: &str, what: &Bilingual, e: &SyntaxError) -> Diagnostic {
    let fault = fault(text, e);
    let message = Bilingual::new(
        format!("{}无法读取：不是合法的 YAML：{}", what.zh, fault.message.zh),
        format!("{} cannot be read: not valid YAML: {}", what.en, fault.message.en),
    );
    let location = location(file, text, fault.mark);
    Diagnostic { hint: fault.hint, ..Diagnostic::error(code, message).at(location) }
}

/// The finding for a value that does not have the required form, with a suggestion for a misspelled word.
pub fn decoding(code: &'static str, file: &str, text: &str, what: Bilingual, e: &DecodeError) -> Diagnostic {
    let d = e.diagnostic(code, file, what);
    let location = e.mark.map_or_else(|| d.location.clone(), |mark| location(file, text, mark));
    let words: Vec<&str> = e.message.split('`').skip(1).step_by(2).collect();
    let near = match words.split_first() {
        Some((written, known)) if e.message.starts_with("unknown ") => {
            did_you_mean(written, known.iter().copied()).map(suggestion)
        }
        _ => None,
    };
    Diagnostic { hint: d.hint.clone().or(near), ..d.at(location) }
}

/// A position in a file, with its line.
pub fn location(file: &str, text: &str, mark: Mark) -> Location {
    Location {
        file: Some(file.to_owned()),
        line: Some(mark.line),
        column: Some(mark.column),
        snippet: text.lines().nth(mark.line.saturating_sub(1)).map(str::to_owned),
        span: mark.span.max(1),
        ..Location::default()
    }
}

/// What is wrong in `text`, for which the parser reported `e`.
pub fn fault(text: &str, e: &SyntaxError) -> YamlFault {
    let SyntaxCause::Malformed(message) = &e.cause else {
        return YamlFault { message: e.message(), hint: None, mark: e.mark };
    };
    frequent(text, e.mark).unwrap_or_else(|| {
        let (message, hint) = translated(message);
        YamlFault { message, hint, mark: e.mark }
    })
}

/// A frequent fault in the line of the error, or in the line before it.
fn frequent(text: &str, mark: Mark) -> Option<YamlFault> {
    let lines: Vec<&str> = text.lines().collect();
    if let Some(n) = lines.iter().position(|l| l.starts_with("<<<<<<< ")) {
        return Some(YamlFault {
            message: Bilingual::new("此处是未解决的合并冲突", "an unresolved merge conflict"),
            hint: Some(Bilingual::new(
                "保留其中一方的内容，删除 '<<<<<<<'、'=======' 与 '>>>>>>>' 三行",
                "keep one of the two sides, and delete the lines '<<<<<<<', '=======' and '>>>>>>>'",
            )),
            mark: Mark { line: n + 1, column: 1, span: 7 },
        });
    }
    let has_content = |n: &usize| {
        let line = lines[*n].trim();
        !line.is_empty() && !line.starts_with('#')
    };
    let at = mark.line.saturating_sub(1).min(lines.len().checked_sub(1)?);
    let before = (0..at).rev().find(has_content);
    let next = |n: usize| (n + 1..lines.len()).find(has_content).map(|n| lines[n]);
    let of_line = |n: usize| key_fault(lines[n], next(n)).map(|f| f.in_line(n + 1));
    let here = tab(lines[at]).or_else(|| full_width_comma(lines[at]));
    let here = here.map(|f| f.in_line(at + 1));
    here.or_else(|| unclosed(&lines, at)).or_else(|| of_line(at)).or_else(|| before.and_then(of_line))
}

/// A fault in a line: column and length in characters, from 1.
struct LineFault {
    column: usize,
    span: usize,
    message: Bilingual,
    hint: Bilingual,
}

impl LineFault {
    fn in_line(self, line: usize) -> YamlFault {
        let mark = Mark { line, column: self.column, span: self.span };
        YamlFault { message: self.message, hint: Some(self.hint), mark }
    }
}

fn indentation(line: &str) -> usize {
    line.chars().take_while(|c| c.is_whitespace()).count()
}

fn tab(line: &str) -> Option<LineFault> {
    let column = line.chars().take(indentation(line)).position(|c| c == '\t')? + 1;
    Some(LineFault {
        column,
        span: 1,
        message: Bilingual::new("行首用制表符缩进", "a tab in the indentation"),
        hint: Bilingual::new("YAML 只能用空格缩进", "YAML is indented with spaces only"),
    })
}

/// A full-width comma behind a quoted item of a list in brackets.
fn full_width_comma(line: &str) -> Option<LineFault> {
    let mut quote = None;
    let mut last = ' ';
    for (column, c) in line.chars().enumerate() {
        match (quote, c) {
            (None, '#') => return None,
            (None, '，') if matches!(last, '"' | '\'' | ']' | '}') => {
                return Some(LineFault {
                    column: column + 1,
                    span: 1,
                    message: Bilingual::new(
                        "列表各项之间是全角逗号 '，'",
                        "a full-width comma '，' between items",
                    ),
                    hint: Bilingual::new("改为半角逗号和空格：', '", "write a plain comma and a space: ', '"),
                });
            }
            (None, '"' | '\'') => quote = Some(c),
            (Some(open), c) if c == open => quote = None,
            _ => {}
        }
        if !c.is_whitespace() {
            last = c;
        }
    }
    None
}

/// Maximum number of lines from a bracket to where the parser notices that it is not closed.
const MOST_LINES: usize = 50;

/// A bracket that is opened in line `at` or above it and never closed: the parser reports the line that it cannot take
/// as a part of what is in the bracket.
fn unclosed(lines: &[&str], at: usize) -> Option<YamlFault> {
    let is_open = |n: &usize| !still_open(&lines[*n..=*n]).is_empty();
    let first = (at.saturating_sub(MOST_LINES)..=at).rev().find(is_open)?;
    let (_, column, bracket) = *still_open(&lines[first..]).iter().rev().find(|(n, ..)| *n == 0)?;
    let closing = if bracket == '{' { '}' } else { ']' };
    let fault = LineFault {
        column: column + 1,
        span: 1,
        message: Bilingual::new(format!("'{bracket}' 没有闭合"), format!("'{bracket}' is not closed")),
        hint: Bilingual::new(
            format!("在这一项的末尾补上 '{closing}'"),
            format!("add '{closing}' where it ends"),
        ),
    };
    Some(fault.in_line(first + 1))
}

/// The brackets of lists and maps that are open at the end of these lines: line and column, from 0, and the bracket. In
/// quotation marks, in comments and within a word a bracket is text.
fn still_open(lines: &[&str]) -> Vec<(usize, usize, char)> {
    let mut open = Vec::new();
    let mut quote = None;
    for (n, line) in lines.iter().enumerate() {
        // The last character but spaces: where a value can begin, it is none, a comma, a colon, a dash or a bracket.
        let (mut last, mut spaced) = (None, true);
        for (column, c) in line.chars().enumerate() {
            let begins =
                matches!(last, None | Some(',' | '{' | '[')) || (spaced && matches!(last, Some(':' | '-')));
            match (quote, c) {
                (Some(q), c) if c == q => quote = None,
                (Some(_), _) => {}
                (None, '#') if spaced => break,
                (None, '"' | '\'') if begins => quote = Some(c),
                (None, '{' | '[') if begins => open.push((n, column, c)),
                (None, '}' | ']') => drop(open.pop()),
                _ => {}
            }
            spaced = c.is_whitespace();
            if !spaced {
                last = Some(c);
            }
        }
    }
    // A quotation mark that is not closed hides the brackets behind it.
    if quote.is_some() { Vec::new() } else { open }
}

/// A line that begins with a key: what follows the key is wrong. `next` is the next line with content.
fn key_fault(line: &str, next: Option<&str>) -> Option<LineFault> {
    let indent = indentation(line);
    let start = line.trim_start();
    let dash = start.strip_prefix("- ").map_or(0, |rest| 2 + indentation(rest));
    let first = indent + dash;
    let is_key = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '.');
    let key: String = line.chars().skip(first).take_while(|c| is_key(*c)).collect();
    if !key.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_') {
        return None;
    }
    let after = first + key.chars().count();
    let mut rest = line.chars().skip(after);
    let (mark, follows) = (rest.next(), rest.next());
    match (mark, follows) {
        (Some('：'), _) => Some(LineFault {
            column: after + 1,
            span: 1,
            message: Bilingual::new(
                format!("'{key}' 后面是全角冒号 '：'"),
                format!("a full-width colon '：' after '{key}'"),
            ),
            hint: Bilingual::new(
                format!("改为半角冒号和空格：'{key}: '"),
                format!("write a plain colon and a space: '{key}: '"),
            ),
        }),
        (Some(':'), Some(c)) if !c.is_whitespace() && c != '/' => Some(LineFault {
            column: after + 2,
            span: 1,
            message: Bilingual::new(
                format!("'{key}:' 的冒号后面缺少空格"),
                format!("no space after the colon of '{key}:'"),
            ),
            hint: Bilingual::new(format!("写成 '{key}: {c}…'"), format!("write '{key}: {c}...'")),
        }),
        _ => {
            let left: String = line.chars().skip(after).collect();
            let is_alone = left.trim().is_empty() || left.trim_start().starts_with('#');
            let is_above = next.is_some_and(|n| indentation(n) > indent);
            (is_alone && is_above).then(|| LineFault {
                column: after + 1,
                span: 1,
                message: Bilingual::new(format!("'{key}' 后面缺少冒号"), format!("no colon after '{key}'")),
                hint: Bilingual::new(format!("写成 '{key}:'"), format!("write '{key}:'")),
            })
        }
    }
}

/// A message of the parser in Chinese, and the remedy where there is one.
fn translated(message: &str) -> (Bilingual, Option<Bilingual>) {
    let quotes =
        ("补上缺少的引号，或去掉多余的引号", "add the missing quotation mark, or remove the one too many");
    let brackets = (
        "检查括号是否成对、各项之间是否有逗号",
        "check that brackets are paired, and that commas are between the items",
    );
    let indent = ("同一级的行用同样多的空格缩进", "indent lines of one level with the same number of spaces");
    let colon = ("值中含有 ': ' 时，整个值用引号括起来", "put a value that contains ': ' in quotation marks");
    let tabs = ("YAML 只能用空格缩进", "YAML is indented with spaces only");
    let forms = [
        ("simple key expect", "此处应有冒号", Some(indent)),
        ("mapping values are not allowed", "此处不能有“键: 值”", Some(colon)),
        ("mapping keys are not allowed", "此处不能有键", Some(indent)),
        ("while parsing a block mapping", "此处应为一个键", Some(indent)),
        ("while parsing a block collection", "此处应为以 '-' 开头的列表项", Some(indent)),
        ("block sequence entries are not allowed", "此处不能有以 '-' 开头的列表项", Some(indent)),
        ("invalid indentation in quoted", "引号中的文本缩进不足", Some(quotes)),
        ("invalid indentation in flow", "括号中的内容缩进不足", Some(brackets)),
        ("invalid indentation", "缩进不正确", Some(indent)),
        ("wrongly indented line in block scalar", "文本块中有一行缩进不足", Some(indent)),
        ("while parsing a flow mapping", "'{' 之后应为 ',' 或 '}'", Some(brackets)),
        ("while parsing a flow sequence", "'[' 之后应为 ',' 或 ']'", Some(brackets)),
        ("misplaced bracket", "括号的位置不正确", Some(brackets)),
        ("while scanning a quoted scalar", "引号没有闭合", Some(quotes)),
        ("invalid trailing content after double-quoted", "双引号之后有多余的内容", Some(quotes)),
        ("while parsing a quoted scalar", "双引号中的转义写法不正确", None),
        ("tab cannot be used", "行首用制表符缩进", Some(tabs)),
        ("tabs disallowed", "行首用制表符缩进", Some(tabs)),
        ("a block scalar content cannot start with a tab", "文本块以制表符开头", Some(tabs)),
        ("while scanning a plain scalar, found a tab", "文本中有制表符", Some(tabs)),
        ("while scanning a block scalar", "'|' 或 '>' 之后的写法不正确", None),
        ("illegal placement of ':'", "冒号的位置不正确", Some(colon)),
        ("':' ", "冒号的写法不正确", Some(colon)),
        ("'-' must be followed", "'-' 之后必须有空格", None),
        ("plain scalar cannot start", "文本不能以 '-' 加标点开头", None),
        ("comment intercepting the multiline text", "多行文本中间有注释", None),
        ("while parsing a node", "此处缺少值", Some(indent)),
        ("while parsing node, found unknown anchor", "没有定义这个锚点", None),
        ("did not find expected <document", "此处的内容不属于上面的结构", Some(indent)),
        ("did not find expected next token", "此处的内容无法识别", None),
        ("found unprintable character", "有不可见的控制字符", None),
        ("a byte order mark", "文件中间有字节顺序标记（BOM）", None),
        ("recursion limit exceeded", "嵌套太深", None),
        ("unexpected end of plain scalar", "文本在此中断", None),
        ("unexpected eof", "文件在此中断", None),
        ("expected whitespace", "此处应有空格", None),
    ];
    let known = forms.iter().find(|(en, ..)| message.starts_with(en));
    let character = message.strip_prefix("unexpected character: `").and_then(|c| c.strip_suffix('\''));
    let quote_it =
        ("以此字符开头的值用引号括起来", "put a value that begins with this character in quotation marks");
    let (zh, remedy) = match (known, character) {
        (Some((_, zh, remedy)), _) => ((*zh).to_owned(), *remedy),
        (None, Some(c)) => (format!("此处不能有字符 '{c}'"), Some(quote_it)),
        // Tags, directives and anchors: nobody uses them in these files.
        (None, None) => (format!("语法错误（{message}）"), None),
    };
    (Bilingual::new(zh, message), remedy.map(|(zh, en)| Bilingual::new(zh, en)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> YamlFault {
        fault(text, &yaml::parse(text).expect_err(text))
    }

    /// Lines and columns counted by hand.
    #[test]
    fn frequent_faults_are_reported_at_their_own_line() {
        for (text, line, column, zh, en, hint) in [
            (
                "a: 1\nb:\n  min_duration:2 s\n\n  when: x\n",
                3,
                16,
                "缺少空格",
                "no space after",
                "min_duration: 2",
            ),
            ("a:\n  when：x\n  min: 2\n", 2, 7, "全角冒号", "full-width colon", "when: "),
            ("a:\n  - when：x\n    min: 2\n", 2, 9, "全角冒号", "full-width colon", "when: "),
            ("a:\n  b: [\"x\"， \"y\"]\n", 2, 10, "全角逗号", "full-width comma", "plain comma"),
            (
                "a: 1\nb:\n  c: { v: 3 s, w: \"x\"\n  d: 4\n",
                3,
                6,
                "'{' 没有闭合",
                "'{' is not closed",
                "add '}'",
            ),
            (
                "a: 1\nb: [c,\n  d: { e: 1 },\n  \"]\"\nf: 2\n",
                2,
                4,
                "没有闭合",
                "'[' is not closed",
                "add ']'",
            ),
            ("a: 1\nlateral\n  usual: [x]\nb: 2\n", 2, 8, "缺少冒号", "no colon after 'lateral'", "lateral:"),
            ("a:\n\tb: 1\n", 2, 1, "制表符", "a tab", "spaces"),
            (
                "a: 1\n<<<<<<< HEAD\nb: 2\n=======\nb: 3\n>>>>>>> x\n",
                2,
                1,
                "合并冲突",
                "merge conflict",
                "keep one",
            ),
        ] {
            let f = of(text);
            assert_eq!((f.mark.line, f.mark.column), (line, column), "{text}{f:?}");
            assert!(f.message.zh.contains(zh) && f.message.en.contains(en), "{f:?}");
            assert!(f.hint.unwrap().en.contains(hint), "{text}");
        }
    }

    /// Where the line is right, the parser's words are said in Chinese too.
    #[test]
    fn errors_of_the_parser_have_chinese_words_and_a_remedy() {
        for text in [
            "a: [1, 2\nb: 3\n",
            "a: 'x\nb: 3\n",
            "a: \"x\" y\n",
            "a: b: c\n",
            "a:\n    b: 1\n  c: 2\n",
            "a: @x\n",
            "a: {b: 1\n",
        ] {
            let f = of(text);
            assert!(f.message.zh.contains(|c: char| ('\u{4e00}'..='\u{9fff}').contains(&c)), "{text}{f:?}");
            assert!(!f.message.zh.contains("语法错误") && f.hint.is_some(), "{text}{f:?}");
        }
    }

    #[test]
    fn a_misspelled_word_has_a_suggestion_and_its_line() {
        #[derive(Debug, serde::Deserialize)]
        #[serde(deny_unknown_fields)]
        struct Sample {
            #[serde(rename = "level")]
            _level: u8,
        }
        let what = Bilingual::new("样例", "the sample");
        let d = read::<Sample>("spec.yaml", "f.yaml", "# x\nlevl: 1\n", what).unwrap_err();
        assert_eq!(
            (d.location.line, d.location.column, d.location.snippet.as_deref()),
            (Some(2), Some(1), Some("levl: 1"))
        );
        assert!(d.hint.unwrap().en.contains("level") && d.message.zh.contains("没有字段 `levl`"));
    }
}
