//! Signing in at an OpenID provider: authorisation code flow with PKCE (OpenID Connect Core 1.0, RFC 7636, RFC 9207).
//! Says *who* the provider vouches for; which account that is and what it may do is `service::identities`.
//!
//! Nothing is stored for a sign-in that has only begun: `state`, `nonce` and the PKCE verifier are derived from a secret
//! of the service and the browser's cookie, so that strangers cannot fill the store.

pub mod claims;
pub mod flow;
pub mod jws;
pub mod keys;
pub mod provider;
pub mod settings;
pub mod web;

use crate::problem::Problem;

/// The provider cannot be reached or answers what it must not: nobody's fault who signs in.
pub(crate) fn provider_fails(why: impl std::fmt::Display) -> Problem {
    // Some of it may be the provider's own words.
    let why: String = why.to_string().chars().filter(|c| !c.is_control()).take(300).collect();
    Problem::new(
        502,
        "oidc.provider",
        format!("身份提供方不可用或应答有误：{why}"),
        format!("the identity provider is away or answers wrongly: {why}"),
    )
}
