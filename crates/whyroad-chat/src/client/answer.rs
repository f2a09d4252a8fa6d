//! The used parts of an endpoint's answer: the model's text or refusal, and the tokens.

use super::budget::Tokens;
use serde::Deserialize;

/// One completion.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Completion {
    content: String,
    cut_off: bool,
    /// The text of the model or filter, where it declined.
    pub refusal: Option<String>,
    /// `None` where the endpoint does not state it.
    pub tokens: Option<Tokens>,
}

#[derive(Deserialize)]
struct Wire {
    choices: Vec<Choice>,
    usage: Option<Usage>,
}

#[derive(Deserialize)]
struct Choice {
    message: Said,
    finish_reason: Option<String>,
}

#[derive(Deserialize)]
struct Said {
    content: Option<String>,
    refusal: Option<String>,
}

#[derive(Deserialize)]
struct Usage {
    prompt_tokens: u64,
    completion_tokens: u64,
}

impl Completion {
    /// Reads the body of a 200.
    pub fn read(body: &str) -> Result<Self, String> {
        let wire: Wire =
            serde_json::from_str(body).map_err(|e| format!("the body is not a chat completion: {e}"))?;
        let tokens = wire.usage.map(|u| Tokens { input: u.prompt_tokens, output: u.completion_tokens });
        let Some(choice) = wire.choices.into_iter().next() else {
            return Err("the body has no choice".to_owned());
        };
        let reason = choice.finish_reason.unwrap_or_default();
        let filtered = (reason == "content_filter").then(|| "content_filter".to_owned());
        let refusal = choice.message.refusal.filter(|r| !r.trim().is_empty()).or(filtered);
        let content = choice.message.content.unwrap_or_default();
        Ok(Self { content, cut_off: reason == "length", refusal, tokens })
    }

    /// The text, without the fence that some models put around JSON; `Err` states why there is none.
    pub fn text(&self) -> Result<String, String> {
        if self.cut_off {
            return Err("it is cut off at the maximum number of tokens".to_owned());
        }
        let text = self.content.trim();
        let inner = text.strip_prefix("```json").or_else(|| text.strip_prefix("```"));
        let text = inner.and_then(|t| t.strip_suffix("```")).unwrap_or(text).trim();
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
        for bad in ["", "<html>", "{}", r#"{"choices": []}"#] {
            assert!(Completion::read(bad).is_err(), "{bad}");
        }
    }
}
