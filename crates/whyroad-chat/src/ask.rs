//! A question in words becomes a rule of the rule language through a model. Errors in the rule are sent back a few
//! times; a rule that compiles is returned with its text and the model's assumptions. Finding episodes is mining's
//! work.

use crate::{AnswerForm, ChatError, Client, Message, Request, Role};
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::fmt::Write as _;
use whyroad_framework::{Framework, PromptName};
use whyroad_mining::language::Subject;
use whyroad_mining::rule::Rule;
use whyroad_mining::rule::text::compile_text;
use whyroad_model::diagnostic::render_text;
use whyroad_model::{Diagnostic, Lang, ScenarioId};
use whyroad_signals::{Catalog, SignalKind};

/// Longest rule, characters.
const LONGEST_RULE: usize = 2000;
/// What a target can be; `none` for rules about the ego alone.
const TARGETS: [&str; 5] = ["none", "any", "vehicle", "large_vehicle", "vru"];

/// A rule from the model, and its errors.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Attempt {
    /// The rule's text.
    pub rule: String,
    /// What its target can be.
    pub target: Option<String>,
    /// In words.
    pub explanation: String,
    /// Faults; empty for the last attempt of a success.
    pub faults: Vec<Diagnostic>,
}

/// The result of a question.
#[derive(Clone, Debug)]
pub struct Asked {
    /// In order; the last one is the answer.
    pub attempts: Vec<Attempt>,
    /// The last attempt's rule, where it compiles.
    pub rule: Option<Rule>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Answer {
    rule: String,
    target: String,
    explanation: String,
}

/// Asks for the rule of `question`; `scenario` is the class of what it finds. Faults go back at most `corrections`
/// times.
pub fn ask(
    client: &Client,
    (framework, catalog): (&Framework, &Catalog),
    question: &str,
    scenario: &ScenarioId,
    lang: Lang,
    corrections: u32,
) -> Result<Asked, ChatError> {
    let prompt = framework.prompts.get(PromptName::Ask);
    let mut request = Request {
        messages: vec![
            Message::text(Role::System, prompt.system(lang, &[("signals", &signals(catalog, lang))])),
            Message::text(Role::User, prompt.user(lang, &[("question", question)])),
        ],
        form: form(),
    };
    let mut attempts = Vec::new();
    loop {
        let said = client.ask(&request, read)?;
        let Answer { rule: text, target, explanation } = said.value;
        let target = Some(target).filter(|t| t != "none");
        let subject = target.as_deref().and_then(Subject::from_word);
        let compiled = compile_text(&text, subject, scenario, catalog, "rule");
        let faults: Vec<Diagnostic> = compiled.as_ref().err().map(|d| (**d).clone()).into_iter().collect();
        let list = faults.iter().map(|d| render_text(d, lang)).collect::<Vec<_>>().join("\n");
        attempts.push(Attempt { rule: text, target, explanation, faults });
        match compiled {
            Ok(rule) => return Ok(Asked { attempts, rule: Some(rule) }),
            Err(_) if attempts.len() > corrections as usize => return Ok(Asked { attempts, rule: None }),
            Err(_) => request = request.reply(&said.text, prompt.again(lang, &list)),
        }
    }
}

fn form() -> AnswerForm {
    let schema = json!({
        "type": "object", "additionalProperties": false, "required": ["rule", "target", "explanation"],
        "properties": {
            "rule": { "type": "string" },
            "target": { "type": "string", "enum": TARGETS },
            "explanation": { "type": "string" },
        },
    });
    AnswerForm { name: "rule", schema }
}

fn read(text: &str) -> Result<Answer, String> {
    let answer: Answer = serde_json::from_str(text).map_err(|e| e.to_string())?;
    let rule = answer.rule.trim().to_owned();
    let length = rule.chars().count();
    if !(1..=LONGEST_RULE).contains(&length) {
        return Err(format!("the rule has {length} characters"));
    }
    if !TARGETS.contains(&answer.target.as_str()) {
        return Err("the target is not one of those listed".to_owned());
    }
    Ok(Answer { rule, ..answer })
}

/// One line per signal.
fn signals(catalog: &Catalog, lang: Lang) -> String {
    let mut out = String::new();
    for s in catalog.iter() {
        let kind = match &s.kind {
            SignalKind::Number(_) => format!("number {}", s.unit_symbol()),
            SignalKind::Flag => "flag".to_owned(),
            SignalKind::Category(members) => format!("one of {}", members.join(", ")),
        };
        let _ = writeln!(out, "{}: {kind}: {}", s.name, s.meaning.get(lang));
    }
    out
}
