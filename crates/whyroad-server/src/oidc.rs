//! Signing in at an OpenID provider: authorization code flow with PKCE (OpenID Connect Core 1.0, RFC 7636, RFC 9207).
//! Determines *who* signed in according to the provider; `service::identities` decides which account that is and what
//! it may do.
//!
//! Nothing is stored for a sign-in that has only begun: `state`, `nonce` and the PKCE verifier are derived from a
//! secret of the service and the browser's cookie, so that unauthenticated callers cannot fill the store.

pub mod algorithm;
pub mod claims;
pub mod flow;
pub mod jws;
pub mod keys;
pub mod provider;
pub mod settings;
pub mod web;

use crate::problem::Problem;
use serde_json::json;

/// Why a token is refused: a short identifier, which is in `more.reason` of the problem.
pub type Reason = &'static str;

/// The provider cannot be reached or its response is invalid: not an error of the person who signs in.
pub(crate) fn provider_fails(why: impl std::fmt::Display) -> Problem {
    // Part of it may be text from the provider.
    let why: String = why.to_string().chars().filter(|c| !c.is_control()).take(300).collect();
    Problem::new(
        502,
        "oidc.provider",
        format!("身份提供方不可用或应答有误：{why}"),
        format!("the identity provider is unavailable or answers incorrectly: {why}"),
    )
}

/// An ID token is refused.
pub fn refused_token(reason: Reason) -> Problem {
    Problem::new(
        403,
        "oidc.token",
        format!("身份提供方的令牌未通过检查（{reason}），未登录"),
        format!("the identity provider's token did not pass the checks ({reason}): sign-in refused"),
    )
    .with(json!({ "reason": reason }))
}
