//! Definition of a route: verb, path, access, input and output. The router, the access check before every handler and
//! the OpenAPI document are generated from the one table of routes ([`super::table`]). Special behavior of a route is
//! an attribute of it: nothing else in this crate looks at its path.

use super::call::Call;
use super::reply::Reply;
use crate::problem::Answer;
use schemars::{JsonSchema, Schema, SchemaGenerator};

/// HTTP verb.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Verb {
    /// Reads.
    Get,
    /// Creates or does something.
    Post,
    /// Changes.
    Patch,
    /// Removes.
    Delete,
}

/// Who may call a route. This is checked before the handler runs; a handler can only be stricter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// Everybody.
    Anyone,
    /// Signed-in users.
    SignedIn,
    /// Admins.
    Admin,
    /// Members of project `{p}` and admins.
    Member,
    /// Leads, checkers and auditors of project `{p}`, and admins.
    Staff,
    /// Leads of project `{p}`, and admins.
    Lead,
    /// Users who may see task `{t}`: staff of its project, and users who hold it, are assigned to it or wrote it.
    /// Others get 404.
    TaskReader,
    /// The same, for writing; the workflow and the lease decide the rest.
    TaskWorker,
    /// Leads of the project of task `{t}`.
    TaskLead,
    /// As [`Access::TaskReader`], of the task that comment `{c}` belongs to.
    CommentReader,
    /// Leads of the project that webhook `{w}` belongs to.
    WebhookLead,
}

impl Access {
    /// Its identifier in the OpenAPI document (`x-access`).
    pub fn word(self) -> &'static str {
        match self {
            Self::Anyone => "anyone",
            Self::SignedIn => "signed_in",
            Self::Admin => "admin",
            Self::Member => "member",
            Self::Staff => "staff",
            Self::Lead => "lead",
            Self::TaskReader => "task_reader",
            Self::TaskWorker => "task_worker",
            Self::TaskLead => "task_lead",
            Self::CommentReader => "comment_reader",
            Self::WebhookLead => "webhook_lead",
        }
    }
}

/// A handler. It runs on a thread that may block.
pub type Handler = fn(&Call<'_>) -> Answer<Reply>;

/// Generates a schema.
pub type Shape = fn(&mut SchemaGenerator) -> Schema;

/// Maximum size of a request body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BodySize {
    /// 1 MiB: one label with its comments.
    Usual,
    /// 64 MiB: many tasks at once. Read only after the access check.
    Bulk,
}

impl BodySize {
    /// The maximum size in bytes.
    pub fn bytes(self) -> usize {
        match self {
            Self::Usual => 1024 * 1024,
            Self::Bulk => 64 * 1024 * 1024,
        }
    }
}

/// Media type of JSON.
pub const JSON: &str = "application/json";
/// Media type of JSON lines.
pub const JSON_LINES: &str = "application/x-ndjson";

/// One route.
#[derive(Clone, Copy)]
pub struct Route {
    /// Verb.
    pub verb: Verb,
    /// Path below `/api/v1`, parameters in braces.
    pub path: &'static str,
    /// Who may call it.
    pub access: Access,
    /// What it does, in one sentence.
    pub about: &'static str,
    /// Query parameters with their meaning.
    pub query: &'static [(&'static str, &'static str)],
    /// Schema of the body.
    pub body: Option<Shape>,
    /// Media type of the body.
    pub body_media: &'static str,
    /// How large the body may be.
    pub body_size: BodySize,
    /// Schema of the answer; `None` if it is not JSON.
    pub reply: Option<Shape>,
    /// Media type of an answer that is not JSON.
    pub media: Option<&'static str>,
    /// True if a session is required: API tokens are refused.
    pub session_only: bool,
    /// Meaning of an empty answer (204), if there may be one.
    pub empty: Option<&'static str>,
    /// Answers even where the store hangs: nobody is identified, and it does not wait for other requests.
    pub is_probe: bool,
    /// The handler.
    pub run: Handler,
}

fn shape_of<T: JsonSchema>(generator: &mut SchemaGenerator) -> Schema {
    generator.subschema_for::<T>()
}

impl Route {
    const fn new(verb: Verb, path: &'static str, access: Access, about: &'static str, run: Handler) -> Self {
        Self {
            verb,
            path,
            access,
            about,
            query: &[],
            body: None,
            body_media: JSON,
            body_size: BodySize::Usual,
            reply: None,
            media: None,
            session_only: false,
            empty: None,
            is_probe: false,
            run,
        }
    }
    /// A route that reads.
    pub const fn get(path: &'static str, access: Access, about: &'static str, run: Handler) -> Self {
        Self::new(Verb::Get, path, access, about, run)
    }
    /// A route that creates or does something.
    pub const fn post(path: &'static str, access: Access, about: &'static str, run: Handler) -> Self {
        Self::new(Verb::Post, path, access, about, run)
    }
    /// A route that changes.
    pub const fn patch(path: &'static str, access: Access, about: &'static str, run: Handler) -> Self {
        Self::new(Verb::Patch, path, access, about, run)
    }
    /// A route that removes something.
    pub const fn delete(path: &'static str, access: Access, about: &'static str, run: Handler) -> Self {
        Self::new(Verb::Delete, path, access, about, run)
    }
    /// With these query parameters.
    #[must_use]
    pub const fn query(mut self, query: &'static [(&'static str, &'static str)]) -> Self {
        self.query = query;
        self
    }
    /// Takes a `T` as JSON.
    #[must_use]
    pub const fn takes<T: JsonSchema>(mut self) -> Self {
        self.body = Some(shape_of::<T>);
        self
    }
    /// Takes a body of this media type.
    #[must_use]
    pub const fn takes_media(mut self, media: &'static str) -> Self {
        self.body_media = media;
        self
    }
    /// Takes a body of this size.
    #[must_use]
    pub const fn takes_up_to(mut self, size: BodySize) -> Self {
        self.body_size = size;
        self
    }
    /// Refuses API tokens: a leaked token must not be able to extend its own access.
    #[must_use]
    pub const fn in_session_only(mut self) -> Self {
        self.session_only = true;
        self
    }
    /// May answer with 204 without content, which means `meaning`.
    #[must_use]
    pub const fn empty_when(mut self, meaning: &'static str) -> Self {
        self.empty = Some(meaning);
        self
    }
    /// Does not depend on the store before its handler.
    #[must_use]
    pub const fn as_probe(mut self) -> Self {
        self.is_probe = true;
        self
    }
    /// Answers with a `T` as JSON.
    #[must_use]
    pub const fn gives<T: JsonSchema>(mut self) -> Self {
        self.reply = Some(shape_of::<T>);
        self
    }
    /// Answers with another media type.
    #[must_use]
    pub const fn gives_media(mut self, media: &'static str) -> Self {
        self.media = Some(media);
        self
    }
}
