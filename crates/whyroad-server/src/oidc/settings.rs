//! How signing in at a provider is set up: what was written, and what it means. Reads no file and asks nobody.

use crate::domain::workflow::Role;
use crate::problem::{Answer, Problem};
use axum::http::Uri;
use serde::Deserialize;
use serde_json::Value;

/// What was written in a file, in options or in the environment; nothing of it has been looked at.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Written {
    /// Issuer of the provider.
    pub issuer: Option<String>,
    /// What the provider knows this service as.
    pub client_id: Option<String>,
    /// The secret that goes with it; none for a public client.
    pub client_secret: Option<Secret>,
    /// File that holds the secret.
    pub client_secret_file: Option<String>,
    /// The provider's name on the button.
    pub name: Option<String>,
    /// Scopes to ask for; default `openid`, `profile` and `email`.
    pub scopes: Option<Vec<String>>,
    /// Address at which people reach the service.
    pub public_url: Option<String>,
    /// File of certificates (PEM) to trust beside the system's.
    pub ca_file: Option<String>,
    /// Whether people without an account get one.
    #[serde(default)]
    pub accounts: Accounts,
    /// Who may sign in: who meets one of these. Without any, who has an account.
    #[serde(default)]
    pub allow: Vec<Allow>,
    /// What people may do by what the provider says of them.
    #[serde(default)]
    pub grants: Vec<Grant>,
}

/// Whether people without an account get one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Accounts {
    /// No: an administrator makes accounts.
    #[default]
    Existing,
    /// Yes, if they meet a condition of `allow`.
    Made,
}

/// A condition on who signs in.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(untagged, deny_unknown_fields)]
pub enum Allow {
    /// The verified e-mail address is of this domain.
    Domain {
        /// Such as `example.com`; subdomains are others.
        domain: String,
    },
    /// A claim has this value.
    Claim {
        /// Name; with dots the way through objects (`realm_access.roles`).
        claim: String,
        /// Value, or one of the values where the claim is a list.
        value: String,
    },
}

/// What a claim gives its bearer.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Grant {
    /// Name of the claim, as in [`Allow::Claim`].
    pub claim: String,
    /// Its value.
    pub value: String,
    /// Gives administration of the service.
    #[serde(default)]
    pub admin: bool,
    /// Name or id of a project.
    #[serde(default)]
    pub project: Option<String>,
    /// Roles in it.
    #[serde(default)]
    pub roles: Vec<Role>,
}

/// A text that no log and no error shows.
#[derive(Clone, PartialEq, Eq, Deserialize)]
#[serde(transparent)]
pub struct Secret(pub String);

impl std::fmt::Debug for Secret {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Secret(..)")
    }
}

/// A set-up that has been looked at.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Issuer, exactly as the provider writes it.
    pub issuer: String,
    /// Client id.
    pub client_id: String,
    /// Client secret.
    pub client_secret: Option<Secret>,
    /// Name on the button.
    pub name: String,
    /// Scopes, `openid` among them.
    pub scopes: Vec<String>,
    /// Address of the service without a slash at its end.
    pub public_url: String,
    /// Whether people without an account get one.
    pub accounts: Accounts,
    /// Who may sign in.
    pub allow: Vec<Allow>,
    /// What they may do.
    pub grants: Vec<Grant>,
}

impl Settings {
    /// Looks at what was written; none when no issuer is named. Files that it names were read by the caller.
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
                "accounts may be made only for those whom a condition of `allow` names",
            ));
        }
        for grant in &written.grants {
            if grant.project.is_some() == grant.roles.is_empty() || !(grant.admin || grant.project.is_some())
            {
                return Err(wrong(
                    "grants",
                    format!("{}={} 须给出 admin，或 project 与 roles", grant.claim, grant.value),
                    format!("{}={} has to give admin, or a project with roles", grant.claim, grant.value),
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

    /// Where the provider sends people back to.
    pub fn redirect_uri(&self) -> String {
        format!("{}/oidc/callback", self.public_url)
    }
}

fn wrong(what: &str, zh: impl std::fmt::Display, en: impl std::fmt::Display) -> Problem {
    Problem::new(
        500,
        "oidc.settings",
        format!("单点登录设置有误（{what}）：{zh}"),
        format!("sign-in at a provider is set up wrongly ({what}): {en}"),
    )
}

/// The host of an address to which secrets may go: `https`, or this machine itself.
fn check_url(url: &str, what: &str) -> Answer<String> {
    let fault = || {
        wrong(
            what,
            format!("'{url}' 须为 https 网址；只有本机可用 http；不得含查询部分"),
            format!("'{url}' has to be an https address, or http on this machine itself, without a query"),
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

/// True when the claim has the value, or is a list that has it.
pub fn has(claims: &Value, claim: &str, value: &str) -> bool {
    // A name may have dots itself (a URL); as a whole it goes first.
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
