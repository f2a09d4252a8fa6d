//! The shared files of AWS tools, `~/.aws/credentials` and `~/.aws/config`: keys, region and endpoint of a profile.

use object_store::aws::{AmazonS3Builder, AmazonS3ConfigKey as Key};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Completes settings missing in the environment from the profile (`AWS_PROFILE`, otherwise `default`).
///
/// # Errors
/// When a named profile is in neither file, or gets its keys in an unsupported way.
pub(super) fn complete(builder: &mut AmazonS3Builder) -> Result<(), String> {
    let asked = std::env::var("AWS_PROFILE").ok().filter(|name| !name.is_empty());
    let name = asked.clone().unwrap_or_else(|| "default".to_owned());
    let file = |variable: &str, default: &str| {
        let named = std::env::var_os(variable).filter(|v| !v.is_empty()).map(PathBuf::from);
        let home = std::env::var_os("HOME").or_else(|| std::env::var_os("USERPROFILE")).map(PathBuf::from);
        let path = named.or_else(|| Some(home?.join(".aws").join(default)))?;
        std::fs::read_to_string(path).ok()
    };
    let credentials = file("AWS_SHARED_CREDENTIALS_FILE", "credentials").unwrap_or_default();
    let config = file("AWS_CONFIG_FILE", "config").unwrap_or_default();
    let mut profile =
        section(&config, &if name == "default" { name.clone() } else { format!("profile {name}") });
    profile.extend(section(&credentials, &name));
    if profile.is_empty() {
        let has_keys = builder.get_config_value(&Key::AccessKeyId).is_some();
        return match asked {
            Some(name) if !has_keys => Err(format!("the profile '{name}' of AWS_PROFILE was not found")),
            _ => Ok(()),
        };
    }
    let known =
        |builder: &AmazonS3Builder, keys: &[Key]| keys.iter().any(|k| builder.get_config_value(k).is_some());
    if !known(builder, &[Key::AccessKeyId, Key::SecretAccessKey, Key::WebIdentityTokenFile]) {
        keys(builder, &profile, asked.as_deref())?;
    }
    for (name, key, or) in
        [("region", Key::Region, Key::DefaultRegion), ("endpoint_url", Key::Endpoint, Key::S3Endpoint)]
    {
        if let (Some(value), false) = (profile.get(name), known(builder, &[key, or])) {
            *builder = std::mem::take(builder).with_config(key, value);
        }
    }
    Ok(())
}

fn keys(
    builder: &mut AmazonS3Builder,
    profile: &BTreeMap<String, String>,
    asked: Option<&str>,
) -> Result<(), String> {
    let named = [
        ("aws_access_key_id", Key::AccessKeyId),
        ("aws_secret_access_key", Key::SecretAccessKey),
        ("aws_session_token", Key::Token),
    ];
    for (name, key) in named {
        if let Some(value) = profile.get(name) {
            *builder = std::mem::take(builder).with_config(key, value);
        }
    }
    let other = ["credential_process", "sso_session", "sso_start_url", "role_arn"];
    match (profile.contains_key("aws_access_key_id"), other.iter().find(|n| profile.contains_key(**n))) {
        (false, Some(way)) if asked.is_some() => Err(format!(
            "the profile gets its keys by '{way}', which is not supported; \
             `eval \"$(aws configure export-credentials --format env)\"` puts them into the environment"
        )),
        _ => Ok(()),
    }
}

/// The values of a section; nested ones, which are indented, are not among them.
fn section(text: &str, name: &str) -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    let mut inside = false;
    for line in text.lines() {
        let trimmed = line.trim();
        if let Some(title) = trimmed.strip_prefix('[').and_then(|t| t.strip_suffix(']')) {
            inside = title.split_whitespace().eq(name.split_whitespace());
        } else if inside
            && !line.starts_with([' ', '\t', '#', ';'])
            && let Some((key, value)) = trimmed.split_once('=')
        {
            found.insert(key.trim().to_ascii_lowercase(), value.trim().to_owned());
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sections_are_read_as_aws_tools_read_them() {
        let text = "# mine\n[default]\nregion = eu-west-1\ns3 =\n  endpoint_url = http://nested\n\n\
            [profile  fleet]\naws_access_key_id=AK\nendpoint_url = https://s3.example.org\n; x = y\n";
        assert_eq!(section(text, "default")["region"], "eu-west-1");
        assert!(!section(text, "default").contains_key("endpoint_url"));
        let fleet = section(text, "profile fleet");
        assert_eq!((fleet["aws_access_key_id"].as_str(), fleet.len()), ("AK", 2));
        assert!(section(text, "other").is_empty());
    }
}
