//! Signing in at an identity provider.

use crate::oidc::flow::Purpose;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Body of `POST /oidc/begin`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BeginAtProvider {
    /// `sign_in`, or `link` for a signed-in user who wants to sign in this way, too.
    pub purpose: Purpose,
}

/// Where the browser must go.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct ProviderAddress {
    /// Address at the provider. It sends the browser back to `/oidc/callback` of this service, whose query goes to
    /// `POST /oidc/finish`.
    pub url: String,
}

/// Answer of `DELETE /session`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct SignedOut {
    /// Always true.
    pub done: bool,
    /// Address for signing out at the identity provider, too, if the session began there; otherwise the next person at
    /// this computer can sign in there as the same user.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub provider_sign_out: Option<String>,
}

/// A person of an identity provider who is linked to a user here.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Identity {
    /// Id.
    pub id: String,
    /// The provider.
    pub issuer: String,
    /// The verified e-mail address there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub email: Option<String>,
    /// When they were linked.
    pub created: i64,
    /// When the person signed in last.
    pub seen: i64,
}

/// List of identities.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Identities {
    /// By when they were linked.
    pub items: Vec<Identity>,
}
