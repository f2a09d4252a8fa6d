//! Configuration of signing in at a provider: the raw values, and the checked ones. Reads no file and makes no request.

use crate::domain::workflow::Role;
use crate::problem::{Answer, Problem};
use axum::http::Uri;
use serde::Deserialize;
use serde_json::Value;

/// Raw values from a file, options or the environment; nothing is checked yet.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Written {
    /// Issuer of the provider.
    pub issuer: Option<String>,
    /// Client id of this service at the provider.
    pub client_id: Option<String>,
    /// The client secret; absent for a public client.
    pub client_secret: Option<Secret>,
    /// File that contains the secret.
    pub client_secret_file: Option<String>,
    /// The provider's name on the button.
    pub name: Option<String>,
    /// Scopes to request; default `openid`, `profile` and `email`.
    pub scopes: Option<Vec<String>>,
    /// Public address of the service.
    pub public_url: Option<String>,
    /// File of certificates (PEM) to trust in addition to the system's.
    pub ca_file: Option<String>,
    /// Whether people without an account get one.
    #[serde(default)]
    pub accounts: Accounts,
    /// Who may sign in: people who meet one of these. If empty, people who have an account.
    #[serde(default)]
    pub allow: Vec<Allow>,
    /// Permissions by claims.
    #[serde(default)]
    pub grants: Vec<Grant>,
}

/// Whether people without an account get one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Accounts {
    /// No: an administrator creates accounts.
    #[default]
    Existing,
    /// Yes, if they meet a condition of `allow`.
    Made,
}

/// A condition on the person who signs in.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(untagged, deny_unknown_fields)]
pub enum Allow {
    /// The verified e-mail address is of this domain.
    Domain {
        /// Such as `example.com`; subdomains do not match.
        domain: String,
    },
    /// A claim has this value.
    Claim {
        /// Name; dots separate the keys of nested objects (`realm_access.roles`).
        claim: String,
        /// Value, or one of the values where the claim is a list.
        value: String,
    },
}

/// Permissions from a claim.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Grant {
    /// Name of the claim, as in [`Allow::Claim`].
    pub claim: String,
    /// Its value.
    pub value: String,
    /// Makes the user an administrator of the service.
    #[serde(default)]
    pub admin: bool,
    /// Name or id of a project.
    #[serde(default)]
    pub project: Option<String>,
    /// Roles in it.
    #[serde(default)]
    pub roles: Vec<Role>,
}

/// A text that is not shown in any log or error.
#[derive(Clone, PartialEq, Eq, Deserialize)]
#[serde(transparent)]
pub struct Secret(pub String);

impl std::fmt::Debug for Secret {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Secret(..)")
    }
}

/// A checked configuration.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Issuer, exactly as in the provider's document.
    pub issuer: String,
    /// Client id.
    pub client_id: String,
    /// Client secret.
    pub client_secret: Option<Secret>,
    /// Name on the button.
    pub name: String,
    /// Scopes, including `openid`.
    pub scopes: Vec<String>,
    /// Address of the service without a slash at its end.
    pub public_url: String,
    /// Whether people without an account get one.
    pub accounts: Accounts,
    /// Who may sign in.
    pub allow: Vec<Allow>,
    /// Permissions by claims.
    pub grants: Vec<Grant>,
}

impl Settings {
    /// Checks the raw values; `None` if they name no issuer. The caller has read the files that they name.
    pub fn resolve(written: Written) -> Answer<Option<Self>> {
        let Some(issuer) = written.issuer.filter(|i| !i.is_empty()) else {
            let rest = written.client_id.is_some() || !written.allow.is_empty() || !written.grants.is_empty();
            return if rest {
                Err(wrong("issuer", "缺少 issuer", "the issuer is missing"))
            } else {
                Ok(None)
            };
        };
        let host = check_url(&issuer, "issuer")?;
        let public_url = written.public_url.unwrap_or_default();
        check_url(&public_url, "public_url")?;
        let Some(client_id) = written.client_id.filter(|c| !c.is_empty()) else {
            return Err(wrong("client_id", "缺少 client id", "the client id is missing"));
        };
        if written.accounts == Accounts::Made && written.allow.is_empty() {
            return Err(wrong(
                "accounts",
                "自动建立账号必须用 allow 限定可登录的人",
                "creating accounts automatically requires a condition in `allow`",
            ));
        }
        for grant in &written.grants {
            if grant.project.is_some() == grant.roles.is_empty() || !(grant.admin || grant.project.is_some())
            {
                return Err(wrong(
                    "grants",
                    format!("{}={} 须给出 admin，或 project 与 roles", grant.claim, grant.value),
                    format!("{}={} must give admin, or a project with roles", grant.claim, grant.value),
                ));
            }
        }
        let mut scopes = written.scopes.unwrap_or_else(|| vec!["profile".to_owned(), "email".to_owned()]);
        if !scopes.iter().any(|s| s == "openid") {
            scopes.insert(0, "openid".to_owned());
        }
        Ok(Some(Self {
            issuer,
            client_id,
            client_secret: written.client_secret.filter(|s| !s.0.is_empty()),
            name: written.name.filter(|n| !n.trim().is_empty()).unwrap_or(host),
            scopes,
            public_url: public_url.trim_end_matches('/').to_owned(),
            accounts: written.accounts,
            allow: written.allow,
            grants: written.grants,
        }))
    }

    /// Address to which the provider redirects people.
    pub fn redirect_uri(&self) -> String {
        format!("{}/oidc/callback", self.public_url)
    }
}

fn wrong(what: &str, zh: impl std::fmt::Display, en: impl std::fmt::Display) -> Problem {
    Problem::new(
        500,
        "oidc.settings",
        format!("单点登录设置有误（{what}）：{zh}"),
        format!("the configuration of single sign-on is invalid ({what}): {en}"),
    )
}

/// The host of an address to which secrets may be sent: `https`, or this machine itself.
fn check_url(url: &str, what: &str) -> Answer<String> {
    let fault = || {
        wrong(
            what,
            format!("'{url}' 须为 https 网址；只有本机可用 http；不得含查询部分"),
            format!("'{url}' must be an https address, or http on this machine itself, without a query"),
        )
    };
    let uri: Uri = url.parse().map_err(|_| fault())?;
    let host = uri.host().ok_or_else(fault)?.to_owned();
    if is_safe(url) && uri.query().is_none() && !url.contains(['#', '@']) { Ok(host) } else { Err(fault()) }
}

/// True for `https` addresses, and for `http` ones of this machine itself.
pub fn is_safe(url: &str) -> bool {
    let Ok(uri) = url.parse::<Uri>() else { return false };
    match (uri.scheme_str(), uri.host()) {
        (Some("https"), Some(_)) => true,
        (Some("http"), Some(host)) => is_own(host),
        _ => false,
    }
}

fn is_own(host: &str) -> bool {
    let ip = host.trim_matches(['[', ']']).parse::<std::net::IpAddr>();
    host == "localhost" || ip.is_ok_and(|ip| ip.is_loopback())
}

impl Allow {
    /// True when the claims meet it. `email` is the verified address.
    pub fn is_met(&self, claims: &Value, email: Option<&str>) -> bool {
        match self {
            Self::Domain { domain } => {
                let of = email.and_then(|e| e.rsplit_once('@')).map(|(_, d)| d);
                of.is_some_and(|d| d.eq_ignore_ascii_case(domain))
            }
            Self::Claim { claim, value } => has(claims, claim, value),
        }
    }
}

/// True when the claim has the value, or is a list that contains it.
pub fn has(claims: &Value, claim: &str, value: &str) -> bool {
    // A name may contain dots itself (a URL); the complete name has priority.
    let found = claims.get(claim).or_else(|| {
        let mut parts = claim.split('.');
        parts.try_fold(claims, |at, part| at.get(part))
    });
    let is = |v: &Value| match v {
        Value::String(text) => text == value,
        Value::Bool(yes) => value == if *yes { "true" } else { "false" },
        Value::Number(number) => number.to_string() == value,
        _ => false,
    };
    match found {
        Some(Value::Array(list)) => list.iter().any(is),
        Some(v) => is(v),
        None => false,
    }
}

#[cfg(test)]
mod tests;
