//! Prompts of language models (`prompts/*.yaml`): instructions, question, and the reply when an answer has errors, in
//! both languages, with placeholders for data. Sends nothing.

use crate::yaml_text;
use serde::Deserialize;
use std::collections::BTreeMap;
use whyroad_model::{Bilingual, Diagnostic, Lang};

/// Codes of prompts; each has a page in `docs/diagnostics/`.
pub const PROMPT_CODES: &[&str] = &["prompt.placeholder", "prompt.syntax", "prompt.unknown"];

/// A prompt by its task.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum PromptName {
    /// Components from the history.
    DraftHistory,
    /// Decision and trace, with the future.
    DraftFuture,
    /// True or false.
    Judge,
    /// A rule for a question.
    Ask,
}

impl PromptName {
    /// All.
    pub const ALL: [Self; 4] = [Self::DraftHistory, Self::DraftFuture, Self::Judge, Self::Ask];

    /// Its file without the ending.
    pub fn id(self) -> &'static str {
        match self {
            Self::DraftHistory => "draft_history",
            Self::DraftFuture => "draft_future",
            Self::Judge => "judge",
            Self::Ask => "ask",
        }
    }

    /// `prompts/<id>.yaml`
    pub fn file(self) -> String {
        format!("prompts/{}.yaml", self.id())
    }

    /// Placeholders that each part must have, and no others: system, user, again.
    fn placeholders(self) -> [&'static [&'static str]; 3] {
        match self {
            Self::DraftHistory => [&[], &["scene"], &["findings"]],
            Self::DraftFuture => [&[], &["class", "decisions", "components", "motion"], &["findings"]],
            Self::Judge => [&[], &["label", "scene", "motion", "questions"], &[]],
            Self::Ask => [&["signals"], &["question"], &["findings"]],
        }
    }
}

/// One prompt.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Prompt {
    /// Version of the text, `major.minor.patch`: recorded with its results.
    pub version: String,
    /// Instructions.
    pub system: Bilingual,
    /// The question.
    pub user: Bilingual,
    /// Reply when the answer has errors; unset where it is not sent back.
    #[serde(default)]
    pub again: Option<Bilingual>,
}

impl Prompt {
    /// The instructions, with `values` in place of their names.
    pub fn system(&self, lang: Lang, values: &[(&str, &str)]) -> String {
        fill(self.system.get(lang), values)
    }

    /// The question.
    pub fn user(&self, lang: Lang, values: &[(&str, &str)]) -> String {
        fill(self.user.get(lang), values)
    }

    /// The reply to `findings`.
    pub fn again(&self, lang: Lang, findings: &str) -> String {
        self.again.as_ref().map_or_else(String::new, |a| fill(a.get(lang), &[("findings", findings)]))
    }
}

/// All prompts.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Prompts(BTreeMap<PromptName, Prompt>);

impl Prompts {
    /// The prompt; empty where the framework has none.
    pub fn get(&self, name: PromptName) -> Prompt {
        self.0.get(&name).cloned().unwrap_or_default()
    }

    /// From the texts of `prompts/` among `files`. A prompt whose file is absent is taken from `otherwise`: older
    /// frameworks have no prompts.
    pub fn read(
        files: &BTreeMap<String, String>,
        otherwise: &BTreeMap<String, String>,
    ) -> (Self, Vec<Diagnostic>) {
        let (mut all, mut found) = (Self::default(), Vec::new());
        for name in PromptName::ALL {
            let file = name.file();
            let Some(text) = files.get(&file).or_else(|| otherwise.get(&file)) else { continue };
            match parse(name, &file, text) {
                Ok((prompt, faults)) => {
                    found.extend(faults);
                    all.0.insert(name, prompt);
                }
                Err(d) => found.push(*d),
            }
        }
        let known = |file: &str| PromptName::ALL.iter().any(|n| n.file() == file);
        for file in files.keys().filter(|f| f.starts_with("prompts/") && !known(f)) {
            let names = PromptName::ALL.map(PromptName::id).join(", ");
            let message = Bilingual::new(
                format!("没有名为 '{file}' 的提示词"),
                format!("no task has a prompt '{file}'"),
            );
            let hint = Bilingual::new(format!("可用的名称：{names}"), format!("the names are: {names}"));
            found.push(Diagnostic::error("prompt.unknown", message).with_hint(hint).in_file(file));
        }
        (all, found)
    }
}

fn parse(name: PromptName, file: &str, text: &str) -> Result<(Prompt, Vec<Diagnostic>), Box<Diagnostic>> {
    let what = Bilingual::new("提示词", "the prompt");
    let (prompt, _): (Prompt, _) = yaml_text::read("prompt.syntax", file, text, what)?;
    let mut found = Vec::new();
    let [system, user, again] = name.placeholders();
    let parts = [
        ("system", Some(&prompt.system), system),
        ("user", Some(&prompt.user), user),
        ("again", prompt.again.as_ref(), again),
    ];
    for (part, text, expected) in parts {
        for lang in [Lang::Zh, Lang::En] {
            let there = placeholders(text.map_or("", |t| t.get(lang)));
            let lacks = expected.iter().filter(|p| !there.contains(p)).map(|p| (*p, false));
            let odd = there.iter().filter(|p| !expected.contains(p)).map(|p| (*p, true));
            for (placeholder, is_odd) in lacks.chain(odd) {
                found.push(wrong_placeholder(file, part, lang, placeholder, is_odd));
            }
        }
    }
    Ok((prompt, found))
}

fn wrong_placeholder(file: &str, part: &str, lang: Lang, placeholder: &str, is_odd: bool) -> Diagnostic {
    let lang = if lang == Lang::Zh { "zh" } else { "en" };
    let message = if is_odd {
        Bilingual::new(
            format!("{part}.{lang} 中的占位符 {{{{{placeholder}}}}} 没有对应的内容"),
            format!("there is no value for the placeholder {{{{{placeholder}}}}} in {part}.{lang}"),
        )
    } else {
        Bilingual::new(
            format!("{part}.{lang} 缺少占位符 {{{{{placeholder}}}}}"),
            format!("{part}.{lang} lacks the placeholder {{{{{placeholder}}}}}"),
        )
    };
    Diagnostic::error("prompt.placeholder", message).in_file(file)
}

/// The text in parts: plain text, and names between `{{` and `}}`.
fn pieces(text: &str) -> Vec<(&str, Option<&str>)> {
    let (mut out, mut rest) = (Vec::new(), text);
    while let Some((before, after)) = rest.split_once("{{") {
        let Some((name, tail)) = after.split_once("}}") else { break };
        out.push((before, Some(name.trim())));
        rest = tail;
    }
    out.push((rest, None));
    out
}

fn placeholders(text: &str) -> Vec<&str> {
    pieces(text).into_iter().filter_map(|(_, name)| name).collect()
}

/// Replaces names by values in one pass: a value that contains a placeholder is not changed.
fn fill(text: &str, values: &[(&str, &str)]) -> String {
    let mut out = String::new();
    for (plain, name) in pieces(text) {
        out.push_str(plain);
        let value = name.and_then(|n| values.iter().find(|(k, _)| *k == n));
        out.push_str(value.map_or("", |(_, v)| v));
    }
    out.trim_end().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Framework;

    #[test]
    fn the_built_in_prompts_are_whole() {
        let prompts = &Framework::bundled().prompts;
        for name in PromptName::ALL {
            let prompt = prompts.get(name);
            assert!(!prompt.version.is_empty(), "{name:?}");
            assert!(!prompt.system.zh.is_ascii() && prompt.system.en.is_ascii(), "{name:?}");
        }
    }

    #[test]
    fn values_are_put_in_once() {
        let said = fill("a {{x}} b {{y}}\n", &[("x", "{{y}}"), ("y", "2")]);
        assert_eq!(said, "a {{y}} b 2");
    }

    #[test]
    fn faults_are_found_and_absent_files_are_ours() {
        let ours = Framework::bundled_files();
        let judge = ours["prompts/judge.yaml"].replace("{{label}}", "{{lable}}");
        let files = BTreeMap::from([
            ("prompts/judge.yaml".to_owned(), judge),
            ("prompts/ask.yaml".to_owned(), "version: 1\nsystem: x\n".to_owned()),
            ("prompts/rank.yaml".to_owned(), String::new()),
        ]);
        let (prompts, found) = Prompts::read(&files, &ours);
        let codes: Vec<_> = found.iter().map(|d| d.code).collect();
        // One is missing and one is unknown, in each language.
        assert_eq!(codes[..4], ["prompt.placeholder"; 4]);
        assert_eq!(codes[4..], ["prompt.syntax", "prompt.unknown"]);
        assert!(found[0].message.en.contains("{{label}}") && found[1].message.en.contains("{{lable}}"));
        assert!(!prompts.get(PromptName::DraftHistory).version.is_empty());
    }

    #[test]
    fn every_code_has_a_page() {
        let docs = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/diagnostics");
        for code in PROMPT_CODES {
            assert!(docs.join(format!("{code}.md")).is_file(), "docs/diagnostics/{code}.md is missing");
        }
    }
}
