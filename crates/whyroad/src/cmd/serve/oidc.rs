//! Options of `whyroad serve` for signing in at an OpenID provider: from a file, the environment and options, the
//! later over the earlier.

use crate::output::reason::cannot_read;
use crate::store_args;
use anyhow::Context as _;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use whyroad_model::{Lang, yaml};
use whyroad_server::oidc::provider::Provider;
use whyroad_server::oidc::settings::{Allow, Secret, Settings, Written};

/// Environment variable with the secret; not an option, because other users can see a program's options.
const SECRET: &str = "WHYROAD_OIDC_CLIENT_SECRET";

/// Options about signing in at an OpenID provider.
#[derive(clap::Args, Clone, Debug, Default)]
#[command(next_help_heading = "Signing in at an OpenID provider (docs/how-to/set-up-sign-in.md)")]
pub(super) struct OidcArgs {
    /// YAML file with all of this and with settings without an option: grants, conditions on claims
    #[arg(long, value_name = "FILE", env = "WHYROAD_OIDC_CONFIG")]
    oidc_config: Option<PathBuf>,
    /// Issuer, exactly as the provider writes it; people can then sign in there too
    #[arg(long, value_name = "URL", env = "WHYROAD_OIDC_ISSUER")]
    oidc_issuer: Option<String>,
    /// Client id of this service at the provider
    #[arg(long, value_name = "ID", env = "WHYROAD_OIDC_CLIENT_ID")]
    oidc_client_id: Option<String>,
    /// File with the client's secret; or the secret itself in WHYROAD_OIDC_CLIENT_SECRET
    #[arg(long, value_name = "FILE", env = "WHYROAD_OIDC_CLIENT_SECRET_FILE")]
    oidc_client_secret_file: Option<PathBuf>,
    /// Name of the provider on the button
    #[arg(long, value_name = "NAME", env = "WHYROAD_OIDC_NAME")]
    oidc_name: Option<String>,
    /// Scopes to ask for, separated by commas [default: openid,profile,email]
    #[arg(long, value_name = "SCOPES", env = "WHYROAD_OIDC_SCOPES", value_delimiter = ',')]
    oidc_scopes: Vec<String>,
    /// Only people with a verified e-mail address of this domain may sign in there; may be repeated
    #[arg(long, value_name = "DOMAIN", env = "WHYROAD_OIDC_ALLOW_DOMAIN", value_delimiter = ',')]
    oidc_allow_domain: Vec<String>,
    /// Address at which people reach the service; the provider sends them back to URL/oidc/callback
    #[arg(long, value_name = "URL", env = "WHYROAD_PUBLIC_URL")]
    public_url: Option<String>,
}

impl OidcArgs {
    /// The provider, where one is set up. `own` is the address of a service that only its own machine reaches, without
    /// a proxy: then the address is known. Otherwise it must be stated.
    pub(super) fn provider(&self, own: Option<SocketAddr>, lang: Lang) -> anyhow::Result<Option<Provider>> {
        let mut written = self.written()?;
        if let (None, Some(at)) = (&written.public_url, own) {
            written.public_url = Some(format!("http://{at}"));
        }
        let extra = match &written.ca_file {
            Some(file) => Some(std::fs::read(file).with_context(|| cannot_read(file))?),
            None => None,
        };
        let error = |p| store_args::error(&p, lang);
        let Some(settings) = Settings::resolve(written).map_err(error)? else { return Ok(None) };
        Provider::new(settings, extra.as_deref()).map(Some).map_err(error)
    }

    fn written(&self) -> anyhow::Result<Written> {
        let mut written = match &self.oidc_config {
            Some(file) => read(file)?,
            None => Written::default(),
        };
        let over = |old: &mut Option<String>, new: &Option<String>| {
            // An empty environment variable counts as unset.
            if let Some(new) = new.as_ref().filter(|n| !n.is_empty()) {
                *old = Some(new.clone());
            }
        };
        over(&mut written.issuer, &self.oidc_issuer);
        over(&mut written.client_id, &self.oidc_client_id);
        over(&mut written.name, &self.oidc_name);
        over(&mut written.public_url, &self.public_url);
        if !self.oidc_scopes.is_empty() {
            written.scopes = Some(self.oidc_scopes.clone());
        }
        if written.issuer.is_some() {
            let domains = self.oidc_allow_domain.iter().filter(|d| !d.is_empty());
            written.allow.extend(domains.map(|d| Allow::Domain { domain: d.clone() }));
        }
        let given = std::env::var(SECRET).ok().filter(|s| !s.is_empty());
        let in_file = written.client_secret_file.take().map(PathBuf::from);
        let file = match (&self.oidc_client_secret_file, given) {
            (Some(file), _) => Some(file.clone()),
            (None, Some(secret)) => {
                written.client_secret = Some(Secret(secret));
                None
            }
            (None, None) => in_file,
        };
        if let Some(file) = file {
            let secret = std::fs::read_to_string(&file);
            let secret = secret.with_context(|| cannot_read(file.display()))?;
            written.client_secret = Some(Secret(secret.trim().to_owned()));
        }
        Ok(written)
    }
}

/// Reads a set-up file. Files that it names are relative to it.
fn read(file: &Path) -> anyhow::Result<Written> {
    let text = std::fs::read_to_string(file).with_context(|| cannot_read(file.display()))?;
    // The reader's own message would repeat the line, and with it a secret.
    let read = yaml::from_str::<Written>(&text);
    let mut written = read.map_err(|e| {
        let place = e.mark.map_or(String::new(), |m| format!(":{}:{}", m.line, m.column));
        anyhow::anyhow!("{}{place}: not a configuration of an OpenID provider ({})", file.display(), kind(&e))
    })?;
    let beside = file.parent().unwrap_or(Path::new(""));
    for named in [&mut written.client_secret_file, &mut written.ca_file].into_iter().flatten() {
        *named = beside.join(&*named).display().to_string();
    }
    Ok(written)
}

/// The kind of error, without quoting the file.
fn kind(e: &yaml::DecodeError) -> String {
    match e.message.split_once("unknown field ") {
        Some((_, rest)) => format!("unknown field {}", rest),
        None => "wrong form".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use whyroad_server::domain::workflow::Role;
    use whyroad_server::oidc::settings::Accounts;

    const WHOLE: &str = "
issuer: https://id.example.com/realms/town
client_id: whyroad
client_secret_file: secret.txt
name: Town
public_url: https://label.example.com/
accounts: made
allow:
  - domain: example.com
  - { claim: groups, value: labellers }
grants:
  - { claim: groups, value: chiefs, admin: true }
  - { claim: groups, value: labellers, project: cutins, roles: [annotator, checker] }
";

    fn own() -> Option<SocketAddr> {
        Some("127.0.0.1:8080".parse().unwrap())
    }

    #[test]
    fn a_file_says_all_and_options_go_over_it() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("oidc.yaml");
        std::fs::write(&file, WHOLE).unwrap();
        std::fs::write(dir.path().join("secret.txt"), "s3cret\n").unwrap();
        let args = OidcArgs {
            oidc_config: Some(file),
            oidc_client_id: Some("other".into()),
            oidc_allow_domain: vec!["example.org".into(), String::new()],
            oidc_name: Some(String::new()),
            ..OidcArgs::default()
        };
        let settings = Settings::resolve(args.written().unwrap()).unwrap().unwrap();
        assert_eq!((settings.client_id.as_str(), settings.name.as_str()), ("other", "Town"));
        assert_eq!(settings.client_secret, Some(Secret("s3cret".into())));
        assert_eq!(settings.redirect_uri(), "https://label.example.com/oidc/callback");
        assert_eq!((settings.accounts, settings.allow.len()), (Accounts::Made, 3));
        assert_eq!(settings.grants[1].roles, [Role::Annotator, Role::Checker]);
        assert_eq!(settings.scopes, ["openid", "profile", "email"]);
        assert!(!format!("{settings:?}").contains("s3cret"));
    }

    #[test]
    fn without_an_issuer_there_is_none_and_on_ones_own_machine_the_address_is_known() {
        assert!(OidcArgs::default().provider(own(), Lang::En).unwrap().is_none());
        let args = OidcArgs {
            oidc_issuer: Some("http://127.0.0.1:9/".into()),
            oidc_client_id: Some("c".into()),
            ..OidcArgs::default()
        };
        let provider = args.provider(own(), Lang::En).unwrap().unwrap();
        assert_eq!(provider.settings.redirect_uri(), "http://127.0.0.1:8080/oidc/callback");
        assert!(args.provider(None, Lang::En).is_err(), "nobody said how it is reached");
    }

    #[test]
    fn a_fault_in_a_file_is_reported_without_its_text() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("oidc.yaml");
        for text in ["client_secret: [hush]", "client_secret: \"hush", "client_id: x\nclient_secrets: hush"] {
            std::fs::write(&file, text).unwrap();
            let message = format!("{:#}", read(&file).unwrap_err());
            assert!(message.contains("oidc.yaml") && !message.contains("hush"), "{message}");
        }
    }
}
