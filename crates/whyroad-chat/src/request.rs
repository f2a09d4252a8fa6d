//! One question in the endpoint's format: messages with texts and images, and the JSON Schema of the answer.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

/// Author of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// The instructions.
    System,
    /// The question.
    User,
    /// An earlier answer of the model.
    Assistant,
}

impl Role {
    fn id(self) -> &'static str {
        match self {
            Self::System => "system",
            Self::User => "user",
            Self::Assistant => "assistant",
        }
    }
}

/// Kind of an image's bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageKind {
    /// PNG
    Png,
    /// JPEG
    Jpeg,
}

impl ImageKind {
    fn mime(self) -> &'static str {
        match self {
            Self::Png => "image/png",
            Self::Jpeg => "image/jpeg",
        }
    }
}

/// Part of a message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Part {
    /// Text.
    Text(String),
    /// An image, sent inside the request.
    Image {
        /// Kind of its bytes.
        kind: ImageKind,
        /// The file's bytes.
        bytes: Vec<u8>,
    },
}

/// One message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// The speaker.
    pub role: Role,
    /// In this order.
    pub parts: Vec<Part>,
}

impl Message {
    /// A message that is one text.
    pub fn text(role: Role, text: impl Into<String>) -> Self {
        Self { role, parts: vec![Part::Text(text.into())] }
    }

    fn json(&self) -> Value {
        if let [Part::Text(text)] = self.parts.as_slice() {
            return json!({ "role": self.role.id(), "content": text });
        }
        let part = |p: &Part| match p {
            Part::Text(text) => json!({ "type": "text", "text": text }),
            Part::Image { kind, bytes } => {
                let url = format!("data:{};base64,{}", kind.mime(), STANDARD.encode(bytes));
                json!({ "type": "image_url", "image_url": { "url": url } })
            }
        };
        json!({ "role": self.role.id(), "content": self.parts.iter().map(part).collect::<Vec<_>>() })
    }
}

/// The form that an answer must have.
#[derive(Clone, Debug, PartialEq)]
pub struct AnswerForm {
    /// Name of the form: letters, digits and `_`.
    pub name: &'static str,
    /// JSON Schema. Every object lists all its properties as required and allows no others, as strict endpoints ask.
    pub schema: Value,
}

/// One question.
#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    /// In the order of the conversation.
    pub messages: Vec<Message>,
    /// Form of the answer.
    pub form: AnswerForm,
}

impl Request {
    /// The body that is sent: the same request gives the same bytes.
    pub fn body(&self, model: &str, max_answer_tokens: u32) -> String {
        let messages: Vec<Value> = self.messages.iter().map(Message::json).collect();
        json!({
            "model": model,
            "messages": messages,
            "temperature": 0,
            "max_tokens": max_answer_tokens,
            "response_format": {
                "type": "json_schema",
                "json_schema": { "name": self.form.name, "strict": true, "schema": self.form.schema },
            },
        })
        .to_string()
    }

    /// The same conversation with the model's answer and a reply to it.
    #[must_use]
    pub fn reply(&self, answer: &str, text: impl Into<String>) -> Self {
        let mut next = self.clone();
        next.messages.push(Message::text(Role::Assistant, answer));
        next.messages.push(Message::text(Role::User, text));
        next
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_body_is_what_the_interface_asks_for() {
        // Fields and nesting: OpenAI API reference, "Create chat completion" (messages, image_url, response_format).
        let image = Part::Image { kind: ImageKind::Png, bytes: vec![1, 2, 3] };
        let request = Request {
            messages: vec![
                Message::text(Role::System, "rules"),
                Message { role: Role::User, parts: vec![Part::Text("看".into()), image] },
            ],
            form: AnswerForm { name: "yes_no", schema: json!({ "type": "object" }) },
        };
        let body: Value = serde_json::from_str(&request.body("m", 50)).unwrap();
        assert_eq!(body["messages"][0], json!({ "role": "system", "content": "rules" }));
        assert_eq!(body["messages"][1]["content"][1]["image_url"]["url"], "data:image/png;base64,AQID");
        assert_eq!(body["response_format"]["json_schema"]["schema"], json!({ "type": "object" }));
        assert_eq!((&body["model"], &body["max_tokens"]), (&"m".into(), &50.into()));
        let next = request.reply("{}", "again");
        assert_eq!(next.messages.len(), 4);
        assert_eq!(next.messages[2], Message::text(Role::Assistant, "{}"));
    }
}
