//! Diagnostics as people and machines read them: rustc-like text, JSON lines' array, SARIF 2.1.0.

use super::quotation::shortened;
use super::{Diagnostic, Severity};
use crate::{Lang, counted};
use serde_json::json;
use std::fmt::Write as _;

/// Text form, legible without color:
///
/// ```text
/// error[label.enum.longitudinal]: 'brake' is not a longitudinal decision
///   --> labels.jsonl:3:41 (/driving_decision/longitudinal)
///    |
///  3 | ...
///    | ^^^^
///    = hint: did you mean 'stop_for_obstacle'?
/// ```
pub fn render_text(d: &Diagnostic, lang: Lang) -> String {
    render(d, lang, Style::PLAIN)
}

/// The same with ANSI colors: severity and code, location, marker and hint. The words are those of [`render_text`].
pub fn render_ansi(d: &Diagnostic, lang: Lang) -> String {
    let severity = match d.severity {
        Severity::Error => "\x1b[1;31m",
        Severity::Warning => "\x1b[1;33m",
        Severity::Note => "\x1b[1;36m",
    };
    render(d, lang, Style { severity, frame: "\x1b[1;34m", hint: "\x1b[1;32m", reset: "\x1b[0m" })
}

/// Escape sequences that open a part of the text; all are empty for plain text.
struct Style {
    severity: &'static str,
    frame: &'static str,
    hint: &'static str,
    reset: &'static str,
}

impl Style {
    const PLAIN: Self = Self { severity: "", frame: "", hint: "", reset: "" };
}

fn render(d: &Diagnostic, lang: Lang, style: Style) -> String {
    let Style { severity, frame, hint: hint_style, reset } = style;
    let mut out = String::new();
    let word = match (d.severity, lang) {
        (Severity::Error, Lang::En) => "error",
        (Severity::Error, Lang::Zh) => "错误",
        (Severity::Warning, Lang::En) => "warning",
        (Severity::Warning, Lang::Zh) => "警告",
        (Severity::Note, Lang::En) => "note",
        (Severity::Note, Lang::Zh) => "提示",
    };
    let _ = writeln!(out, "{severity}{word}[{}]{reset}: {}", d.code, d.message(lang));
    let p = &d.location;
    let mut place = p.file.clone().unwrap_or_default();
    if let Some(line) = p.line {
        let _ = write!(place, ":{line}");
        if let Some(column) = p.column {
            let _ = write!(place, ":{column}");
        }
    }
    if let Some(pointer) = p.pointer.as_deref().filter(|p| !p.is_empty()) {
        let pointer = shortened(pointer.to_owned());
        let _ = write!(place, "{}({pointer})", if place.is_empty() { "" } else { " " });
    }
    if !place.is_empty() {
        let _ = writeln!(out, "  {frame}-->{reset} {place}");
    }
    if let (Some(snippet), Some(line), Some(column)) = (&p.snippet, p.line, p.column) {
        let number = line.to_string();
        let pad = " ".repeat(number.len());
        let (shown, offset, width) = window(snippet, p.snippet_start, column, p.span.max(1));
        let _ = writeln!(out, " {pad} {frame}|{reset}");
        let _ = writeln!(out, " {frame}{number} |{reset} {shown}");
        let _ = writeln!(
            out,
            " {pad} {frame}|{reset} {}{severity}{}{reset}",
            " ".repeat(offset),
            "^".repeat(width)
        );
    }
    if let Some(hint) = &d.hint {
        let word = if lang == Lang::Zh { "建议" } else { "hint" };
        let _ = writeln!(out, "   {frame}={reset} {hint_style}{word}{reset}: {}", hint.get(lang));
    }
    out
}

/// Terminal cells of a character: Chinese ones take two.
fn cells(c: char) -> usize {
    if (c as u32) >= 0x1100 { 2 } else { 1 }
}

/// At most some 100 characters of a long line around `column`, the display offset of the column in it, and
/// the display width of the `span` characters there. `left_out` characters of the line are not in `line`.
fn window(line: &str, left_out: usize, column: usize, span: usize) -> (String, usize, usize) {
    const WIDTH: usize = 100;
    let chars: Vec<char> = line.chars().collect();
    let at = column.saturating_sub(1).saturating_sub(left_out).min(chars.len());
    let start = if chars.len() <= WIDTH || at + span < WIDTH { 0 } else { at.saturating_sub(WIDTH / 3) };
    let end = (start + WIDTH).min(chars.len());
    let mut shown = String::new();
    if start + left_out > 0 {
        shown.push('…');
    }
    let mut offset = usize::from(start + left_out > 0);
    let mut width = 0;
    for (i, &c) in chars[start..end].iter().enumerate() {
        let c = if c == '\t' { ' ' } else { c };
        if start + i < at {
            offset += cells(c);
        } else if start + i < at + span {
            width += cells(c);
        }
        shown.push(c);
    }
    if end < chars.len() {
        shown.push('…');
    }
    (shown, offset, width.max(1))
}

/// One finding as JSON: the message in `lang` under `message`, both languages under `messages`.
pub fn json_row(d: &Diagnostic, lang: Lang) -> serde_json::Value {
    json!({
        "code": d.code,
        "severity": d.severity,
        "message": d.message(lang),
        "messages": d.message,
        "place": d.location,
        "hint": d.hint.as_ref().map(|h| h.get(lang)),
    })
}

/// `{"diagnostics": [...], "errors": n, "warnings": n}`; messages in `lang` under `message`, both under `messages`.
pub fn render_json(all: &[Diagnostic], lang: Lang) -> serde_json::Value {
    let rows: Vec<_> = all.iter().map(|d| json_row(d, lang)).collect();
    let count = |s: Severity| all.iter().filter(|d| d.severity == s).count();
    json!({ "diagnostics": rows, "errors": count(Severity::Error), "warnings": count(Severity::Warning) })
}

/// SARIF 2.1.0, one run, one rule per code.
pub fn render_sarif(all: &[Diagnostic], lang: Lang) -> serde_json::Value {
    let mut codes: Vec<&str> = all.iter().map(|d| d.code).collect();
    codes.sort_unstable();
    codes.dedup();
    let results: Vec<_> = all.iter().map(|d| sarif_result(d, lang)).collect();
    json!({
        "$schema": "https://json.schemastore.org/sarif-2.1.0.json",
        "version": "2.1.0",
        "runs": [{
            "tool": { "driver": {
                "name": "whyroad",
                "version": env!("CARGO_PKG_VERSION"),
                "rules": codes.iter().map(|c| json!({ "id": c, "helpUri": format!("docs/diagnostics/{c}.md") })).collect::<Vec<_>>(),
            } },
            "columnKind": "unicodeCodePoints",
            "results": results,
        }],
    })
}

/// One finding as a SARIF `result`.
pub fn sarif_result(d: &Diagnostic, lang: Lang) -> serde_json::Value {
    let mut text = d.message(lang).to_owned();
    if let Some(h) = &d.hint {
        let _ = write!(text, " ({})", h.get(lang));
    }
    let mut location = json!({});
    if let Some(file) = &d.location.file {
        location["physicalLocation"] = json!({ "artifactLocation": { "uri": file } });
        if let Some(line) = d.location.line {
            let mut region = json!({ "startLine": line });
            if let Some(column) = d.location.column {
                region["startColumn"] = json!(column);
            }
            location["physicalLocation"]["region"] = region;
        }
    }
    if let Some(pointer) = &d.location.pointer {
        location["logicalLocations"] = json!([{ "fullyQualifiedName": pointer }]);
    }
    json!({
        "ruleId": d.code,
        "level": match d.severity { Severity::Error => "error", Severity::Warning => "warning", Severity::Note => "note" },
        "message": { "text": text },
        "locations": [location],
    })
}

/// One line that counts errors and warnings.
pub fn summary(errors: usize, warnings: usize, lang: Lang) -> String {
    match lang {
        Lang::En => format!("{}, {}", counted(errors, "error"), counted(warnings, "warning")),
        Lang::Zh => format!("{errors} 个错误，{warnings} 个警告"),
    }
}
