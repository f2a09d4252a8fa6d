//! Sessions, users, tokens.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Answer of `GET /session`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Session {
    /// The signed-in user; null if nobody is.
    pub user: Option<User>,
    /// Value for the header `x-csrf-token` of all methods except GET.
    pub csrf: String,
    /// True while there is no user: `POST /setup` creates the first one.
    pub first_run: bool,
    /// True if that needs the token that the service printed when it started.
    #[serde(default)]
    pub setup_token: bool,
    /// Name of the identity provider at which users can also sign in: `POST /oidc/begin`.
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
    /// May create projects and users, and is lead everywhere.
    pub admin: bool,
    /// `zh` or `en`.
    pub lang: String,
    /// May no longer sign in.
    pub disabled: bool,
    /// E-mail address, which links the user to a person of the identity provider; shown to admins and to the user.
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
    /// The token that the service printed at its start, if it listens on more than its own machine.
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
    /// Password, at least 10 characters; absent for users who sign in only at the identity provider, who need an e-mail
    /// address.
    #[serde(default)]
    pub password: Option<String>,
    /// E-mail address: the person of the identity provider with this verified address is this user.
    #[serde(default)]
    pub email: Option<String>,
    /// May create projects and users.
    #[serde(default)]
    pub admin: bool,
    /// `zh` or `en`.
    #[serde(default)]
    pub lang: Option<String>,
}

/// Body of `PATCH /users/{u}`: changes the fields that are given. Users may change their own display name and language,
/// and their password if they give the current one.
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
    /// Current password, if users change their own.
    #[serde(default)]
    pub present_password: Option<String>,
    /// Admin only: e-mail address; empty removes it.
    #[serde(default)]
    pub email: Option<String>,
    /// Admin only.
    #[serde(default)]
    pub admin: Option<bool>,
    /// Admin only.
    #[serde(default)]
    pub disabled: Option<bool>,
}

/// List of users.
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
    /// Scope; default `write`.
    #[serde(default)]
    pub scope: TokenScope,
    /// Days until it expires, 1 to 365; default 90.
    #[serde(default)]
    pub days: Option<u32>,
}

/// Scope of an API token. No token can create tokens, change accounts or unlink identities: that requires a session.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum TokenScope {
    /// Read calls.
    Read,
    /// Everything that its user may do, except for account changes.
    #[default]
    Write,
}

impl TokenScope {
    /// Its value in the store.
    pub fn word(self) -> &'static str {
        match self {
            Self::Read => "read",
            Self::Write => "write",
        }
    }

    /// The scope with this value; an unknown value may only read.
    pub fn from_word(word: &str) -> Self {
        if word == "write" { Self::Write } else { Self::Read }
    }
}

/// An API token; its text is only in the response to its creation.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Token {
    /// Id.
    pub id: String,
    /// What it is for.
    pub name: String,
    /// Its scope.
    pub scope: TokenScope,
    /// When it was created.
    pub created: i64,
    /// When it expires.
    pub expires: i64,
    /// For `authorization: Bearer`; shown once.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub token: Option<String>,
}

/// List of tokens.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Tokens {
    /// Of one user.
    pub items: Vec<Token>,
}

/// Response without data.
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
    /// Additional data: findings, conflicts, seconds to wait.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub more: Option<serde_json::Value>,
}
