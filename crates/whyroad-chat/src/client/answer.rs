//! The used parts of an endpoint's answer: the model's text or refusal, and the tokens.

use super::budget::Tokens;
use serde::Deserialize;
use serde_json::Value;

/// One completion.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Completion {
    content: String,
    /// Why there is no text, where that is known.
    fault: Option<String>,
    /// The text of the model or filter, where it declined.
    pub refusal: Option<String>,
    /// `None` where the endpoint does not state them as counts.
    pub tokens: Option<Tokens>,
}

#[derive(Deserialize)]
struct Wire {
    #[serde(default)]
    choices: Vec<Choice>,
    /// An aside: whatever it is, it does not decide whether the answer is used.
    #[serde(default)]
    usage: Value,
    #[serde(default)]
    error: Value,
}

#[derive(Deserialize)]
struct Choice {
    message: Said,
    finish_reason: Option<String>,
}

#[derive(Deserialize)]
struct Said {
    #[serde(default)]
    content: Value,
    refusal: Option<String>,
}

/// A count of tokens: some endpoints write it as a float or as text.
fn count(value: &Value) -> Option<u64> {
    let number = value.as_f64().or_else(|| value.as_str()?.trim().parse().ok())?;
    // Above this, integers are not exact; nobody answers with so many.
    (number >= 0.0 && number < 2_f64.powi(53) && number.fract() == 0.0).then_some(number as u64)
}

/// The text of a message: as it is, or of its parts of type `text`.
fn text_of(content: &Value) -> String {
    let parts = content.as_array().into_iter().flatten();
    let parts = parts.filter_map(|part| part.get("text")?.as_str());
    content.as_str().map_or_else(|| parts.collect(), str::to_owned)
}

/// The JSON in what a model said: without its thoughts, the fence around it, and the words around the fence.
fn without_wrapping(said: &str) -> &str {
    let said = said.trim();
    let said =
        said.strip_prefix("<think>").and_then(|s| s.split_once("</think>")).map_or(said, |(_, s)| s.trim());
    if said.starts_with(['{', '[']) {
        return said;
    }
    let fenced = said.split_once("```").and_then(|(_, rest)| rest.rsplit_once("```"));
    fenced.map_or(said, |(inner, _)| inner.strip_prefix("json").unwrap_or(inner).trim())
}

impl Completion {
    /// Reads the body of a 200; an error where it is not one JSON object.
    pub fn read(body: &str) -> Result<Self, String> {
        let wire: Wire =
            serde_json::from_str(body).map_err(|e| format!("the body is not a chat completion: {e}"))?;
        let tokens = || {
            let of = |name: &str| count(wire.usage.get(name)?);
            Some(Tokens { input: of("prompt_tokens")?, output: of("completion_tokens")? })
        };
        let tokens = tokens();
        let Some(choice) = wire.choices.into_iter().next() else {
            let said = wire.error.get("message").unwrap_or(&wire.error).as_str().map(str::to_owned);
            let fault = said.unwrap_or_else(|| "the body has no choice".to_owned());
            return Ok(Self { content: String::new(), fault: Some(fault), refusal: None, tokens });
        };
        let reason = choice.finish_reason.unwrap_or_default();
        let filtered = (reason == "content_filter").then(|| "content_filter".to_owned());
        let refusal = choice.message.refusal.filter(|r| !r.trim().is_empty()).or(filtered);
        let fault = (reason == "length").then(|| "it is cut off at the maximum number of tokens".to_owned());
        Ok(Self { content: text_of(&choice.message.content), fault, refusal, tokens })
    }

    /// The text, without what some models put around JSON; `Err` states why there is none.
    pub fn text(&self) -> Result<String, String> {
        if let Some(fault) = &self.fault {
            return Err(fault.clone());
        }
        let text = without_wrapping(&self.content);
        if text.is_empty() { Err("it is empty".to_owned()) } else { Ok(text.to_owned()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(content: &str, reason: &str) -> Completion {
        let body = serde_json::json!({
            "choices": [{ "message": { "content": content }, "finish_reason": reason }],
            "usage": { "prompt_tokens": 7, "completion_tokens": 2 },
        });
        Completion::read(&body.to_string()).unwrap()
    }

    #[test]
    fn text_refusal_and_tokens_are_told_apart() {
        assert_eq!(read("{}", "stop").text().as_deref(), Ok("{}"));
        assert_eq!(read("```json\n{}\n```", "stop").text().as_deref(), Ok("{}"));
        assert_eq!(read("{}", "stop").tokens, Some(Tokens { input: 7, output: 2 }));
        assert!(read("{", "length").text().is_err());
        assert!(read(" ", "stop").text().is_err());
        assert_eq!(read("", "content_filter").refusal.as_deref(), Some("content_filter"));
        let refused = r#"{"choices": [{"message": {"content": null, "refusal": "I cannot"}}]}"#;
        let refused = Completion::read(refused).unwrap();
        assert_eq!((refused.refusal.as_deref(), refused.tokens), (Some("I cannot"), None));
        for bad in ["", "<html>", "data: {}"] {
            assert!(Completion::read(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn an_answer_counts_whatever_its_form() {
        let body = r#"{"choices": [], "usage": {"prompt_tokens": 1000, "completion_tokens": 100}}"#;
        let empty = Completion::read(body).unwrap();
        assert_eq!(empty.text(), Err("the body has no choice".to_owned()));
        assert_eq!(empty.tokens, Some(Tokens { input: 1000, output: 100 }));
        let failed = Completion::read(r#"{"error": {"message": "overloaded"}}"#).unwrap();
        assert_eq!((failed.text(), failed.tokens), (Err("overloaded".to_owned()), None));
        let parts =
            serde_json::json!([{ "type": "text", "text": "{\"a\": " }, { "type": "text", "text": "1}" }]);
        let body = serde_json::json!({ "choices": [{ "message": { "content": parts } }] }).to_string();
        assert_eq!(Completion::read(&body).unwrap().text().as_deref(), Ok("{\"a\": 1}"));
    }

    #[test]
    fn odd_counts_never_cost_the_answer() {
        let of = |usage: &str| {
            let body = format!(r#"{{"choices": [{{"message": {{"content": "{{}}"}}}}], "usage": {usage}}}"#);
            let read = Completion::read(&body).unwrap();
            assert_eq!(read.text().as_deref(), Ok("{}"), "{usage}");
            read.tokens
        };
        let thousand = Some(Tokens { input: 1000, output: 100 });
        assert_eq!(of(r#"{"prompt_tokens": 1000.0, "completion_tokens": "100"}"#), thousand);
        for unknown in [
            "null",
            "7",
            r#"{"total_tokens": 1100}"#,
            r#"{"prompt_tokens": -5, "completion_tokens": 1}"#,
            r#"{"prompt_tokens": 10.7, "completion_tokens": 1}"#,
            r#"{"prompt_tokens": 18446744073709551615, "completion_tokens": 1}"#,
        ] {
            assert_eq!(of(unknown), None, "{unknown}");
        }
    }

    #[test]
    fn json_is_found_in_thoughts_and_fences() {
        for said in [
            "<think>A car. {no}</think>\n{\"a\": 1}",
            "Here it is:\n```json\n{\"a\": 1}\n```\nDone.",
            "<think>so</think>```\n{\"a\": 1}\n```",
        ] {
            assert_eq!(read(said, "stop").text().as_deref(), Ok("{\"a\": 1}"), "{said}");
        }
        // A fence within the answer is part of it.
        let inner = "{\"a\": \"```x```\"}";
        assert_eq!(read(inner, "stop").text().as_deref(), Ok(inner));
    }
}
