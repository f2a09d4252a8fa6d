//! Sessions, users, tokens.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Answer of `GET /session`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Session {
    /// Who is signed in; null for nobody.
    pub user: Option<User>,
    /// Value for the header `x-csrf-token` of everything but GET.
    pub csrf: String,
    /// True while there is no user at all: `POST /setup` makes the first one.
    pub first_run: bool,
    /// Name of the identity provider at which one can sign in too: `POST /oidc/begin`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub provider: Option<String>,
}

/// A person with an account.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct User {
    /// Id.
    pub id: String,
    /// Name to sign in with.
    pub name: String,
    /// Name to show.
    pub display: String,
    /// May make projects and users, and is lead everywhere.
    pub admin: bool,
    /// `zh` or `en`.
    pub lang: String,
    /// May no longer sign in.
    pub disabled: bool,
    /// E-mail address, which links to a person of the identity provider; shown to admins and to the user.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub email: Option<String>,
}

/// Body of `POST /session`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SignIn {
    /// Name to sign in with.
    pub name: String,
    /// Password.
    pub password: String,
}

/// Body of `POST /setup`: the first admin.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Setup {
    /// Name to sign in with.
    pub name: String,
    /// Name to show.
    pub display: String,
    /// Password, at least 10 characters.
    pub password: String,
    /// `zh` or `en`.
    #[serde(default)]
    pub lang: Option<String>,
    /// The token that the service printed when it started, where it listens beyond its own machine.
    #[serde(default)]
    pub token: Option<String>,
}

/// Body of `POST /users`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NewUser {
    /// Name to sign in with.
    pub name: String,
    /// Name to show.
    #[serde(default)]
    pub display: Option<String>,
    /// Password, at least 10 characters; none for who signs in at the identity provider only, and then has an e-mail
    /// address.
    #[serde(default)]
    pub password: Option<String>,
    /// E-mail address: the person of the identity provider who has it, verified, is this user.
    #[serde(default)]
    pub email: Option<String>,
    /// May make projects and users.
    #[serde(default)]
    pub admin: bool,
    /// `zh` or `en`.
    #[serde(default)]
    pub lang: Option<String>,
}

/// Body of `PATCH /users/{u}`: what is given is changed. Everybody may change their own display name, language and,
/// with the present one, their password.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UserChange {
    /// Name to show.
    #[serde(default)]
    pub display: Option<String>,
    /// `zh` or `en`.
    #[serde(default)]
    pub lang: Option<String>,
    /// New password; ends all sessions and API tokens of the user.
    #[serde(default)]
    pub password: Option<String>,
    /// Present password, where the user changes their own.
    #[serde(default)]
    pub present_password: Option<String>,
    /// Admin only: e-mail address; empty for none.
    #[serde(default)]
    pub email: Option<String>,
    /// Admin only.
    #[serde(default)]
    pub admin: Option<bool>,
    /// Admin only.
    #[serde(default)]
    pub disabled: Option<bool>,
}

/// Many users.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Users {
    /// By name.
    pub items: Vec<User>,
}

/// Body of `POST /tokens`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NewToken {
    /// What it is for.
    pub name: String,
    /// What it may do; `write` when not given.
    #[serde(default)]
    pub scope: TokenScope,
    /// Days until it expires, 1 to 365; 90 when not given.
    #[serde(default)]
    pub days: Option<u32>,
}

/// What an API token may do. None may make tokens, change accounts or unlink identities: that needs a session.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum TokenScope {
    /// Reading calls.
    Read,
    /// All that its user may do, but for accounts.
    #[default]
    Write,
}

impl TokenScope {
    /// The word that the store has for it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Read => "read",
            Self::Write => "write",
        }
    }

    /// The scope of this word; what is unknown may only read.
    pub fn from_word(word: &str) -> Self {
        if word == "write" { Self::Write } else { Self::Read }
    }
}

/// An API token; its text is only in the answer to its making.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Token {
    /// Id.
    pub id: String,
    /// What it is for.
    pub name: String,
    /// What it may do.
    pub scope: TokenScope,
    /// When it was made.
    pub created: i64,
    /// When it expires.
    pub expires: i64,
    /// For `authorization: Bearer`; shown once.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub token: Option<String>,
}

/// Many tokens.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Tokens {
    /// Of one user.
    pub items: Vec<Token>,
}

/// Nothing else to say.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Done {
    /// Always true.
    pub done: bool,
}

/// An error (RFC 9457), `application/problem+json`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct ProblemBody {
    /// `/problems/<code>`.
    #[serde(rename = "type")]
    pub kind: String,
    /// In English, short.
    pub title: String,
    /// HTTP status.
    pub status: u16,
    /// Stable code.
    pub code: String,
    /// In Chinese.
    pub detail_zh: String,
    /// In English.
    pub detail_en: String,
    /// More that belongs to it: findings, conflicts, seconds to wait.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub more: Option<serde_json::Value>,
}
