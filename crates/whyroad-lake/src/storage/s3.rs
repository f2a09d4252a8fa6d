//! S3 and compatible stores, through the crate `object_store`. Credentials come as in every tool of AWS: environment,
//! web identity, shared files ([`profile`]), container, instance. They never appear in a message.

mod http;
mod profile;

use super::{ObjectVersion, Objects, PutOutcome, StorageUrl};
use crate::LakeError;
use futures_util::TryStreamExt as _;
use http::UreqConnector;
use object_store::aws::{AmazonS3, AmazonS3Builder, AmazonS3ConfigKey as Key};
use object_store::path::Path as ObjectPath;
use object_store::signer::{Method, Signer};
use object_store::{
    BackoffConfig, Error, ObjectStore as _, ObjectStoreExt as _, PutMode, PutOptions, PutPayload,
    RetryConfig, UpdateVersion,
};
use std::fmt;
use std::fs::{self, File};
use std::io::{Read as _, Write as _};
use std::path::Path;
use std::sync::OnceLock;
use std::time::{Duration, SystemTime};
use tokio::runtime::{Builder, Runtime};

/// Bytes that are read or written in one call, so that the memory for 16 calls is bounded.
const PART: u64 = 16 * 1024 * 1024;
/// Calls for one request when the store fails or asks to slow down [environment: `AWS_MAX_ATTEMPTS`].
const DEFAULT_ATTEMPTS: usize = 7;
const LONGEST_PAUSE: Duration = Duration::from_secs(3);
const LONGEST_TIME: Duration = Duration::from_secs(120);
/// Longest reason of a store that is shown, characters.
const LONGEST_REASON: usize = 300;

/// A prefix of a bucket.
pub(super) struct S3Objects {
    store: AmazonS3,
    runtime: &'static Runtime,
    url: StorageUrl,
    /// Secrets that must not be shown, whatever the store answers.
    secrets: Vec<String>,
}

/// Without the store: it holds credentials.
impl fmt::Debug for S3Objects {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "S3Objects({})", self.url)
    }
}

impl S3Objects {
    /// No request is made.
    pub fn open(url: &StorageUrl) -> Result<Self, LakeError> {
        let failed = |reason: String| LakeError::Storage { url: url.to_string(), reason };
        let mut builder = AmazonS3Builder::from_env();
        profile::complete(&mut builder).map_err(failed)?;
        let secrets = [Key::SecretAccessKey, Key::Token].map(|key| builder.get_config_value(&key));
        let secrets: Vec<String> = secrets.into_iter().flatten().filter(|s| s.len() > 3).collect();
        let attempts = std::env::var("AWS_MAX_ATTEMPTS").ok().and_then(|n| n.parse().ok());
        let retry = RetryConfig {
            backoff: BackoffConfig { max_backoff: LONGEST_PAUSE, ..BackoffConfig::default() },
            max_retries: attempts.unwrap_or(DEFAULT_ATTEMPTS).saturating_sub(1),
            retry_timeout: LONGEST_TIME,
        };
        let built = builder
            .with_bucket_name(&url.bucket)
            .with_retry(retry)
            .with_http_connector(UreqConnector::default())
            .build();
        let store = built.map_err(|e| failed(reason(&e, &secrets)))?;
        let runtime = runtime().ok_or_else(|| failed("threads cannot be started".to_owned()))?;
        Ok(Self { store, runtime, url: url.clone(), secrets })
    }

    /// Runs a call to its end, from any thread that may block.
    fn wait<F: Future>(&self, call: F) -> F::Output {
        self.runtime.block_on(call)
    }

    fn path(&self, key: &str) -> Result<ObjectPath, LakeError> {
        let prefix = &self.url.prefix;
        let whole = if prefix.is_empty() { key.to_owned() } else { format!("{prefix}/{key}") };
        ObjectPath::parse(&whole).map_err(|e| LakeError::Storage { url: self.url(), reason: e.to_string() })
    }

    fn failed(&self) -> impl Fn(Error) -> LakeError + '_ {
        |e| LakeError::Storage { url: self.url(), reason: reason(&e, &self.secrets) }
    }

    fn upload_parts(&self, from: &Path, key: &str) -> Result<(), LakeError> {
        let path = self.path(key)?;
        let mut file = File::open(from).map_err(LakeError::io(from))?;
        let mut upload = self.wait(self.store.put_multipart(&path)).map_err(self.failed())?;
        loop {
            let mut part = Vec::new();
            (&mut file).take(PART).read_to_end(&mut part).map_err(LakeError::io(from))?;
            if part.is_empty() {
                break;
            }
            if let Err(e) = self.wait(upload.put_part(part.into())) {
                let _ = self.wait(upload.abort());
                return Err(self.failed()(e));
            }
        }
        self.wait(upload.complete()).map(drop).map_err(self.failed())
    }
}

impl Objects for S3Objects {
    fn url(&self) -> String {
        self.url.to_string()
    }

    fn get(&self, key: &str) -> Result<Option<(Vec<u8>, ObjectVersion)>, LakeError> {
        let path = self.path(key)?;
        let read = async {
            let got = self.store.get(&path).await?;
            let version = got.meta.e_tag.clone().unwrap_or_default();
            Ok((got.bytes().await?.to_vec(), ObjectVersion(version)))
        };
        match self.wait(read) {
            Ok(found) => Ok(Some(found)),
            Err(e) if is_missing(&e) => Ok(None),
            Err(e) => Err(self.failed()(e)),
        }
    }

    fn download(&self, key: &str, bytes: u64, to: &Path) -> Result<bool, LakeError> {
        let path = self.path(key)?;
        let mut file = File::create(to).map_err(LakeError::io(to))?;
        let mut start = 0;
        while start < bytes {
            let end = bytes.min(start + PART);
            match self.wait(self.store.get_range(&path, start..end)) {
                Ok(part) => file.write_all(&part).map_err(LakeError::io(to))?,
                Err(e) if is_missing(&e) => return Ok(false),
                Err(e) => return Err(self.failed()(e)),
            }
            start = end;
        }
        Ok(true)
    }

    fn put_if(
        &self,
        key: &str,
        content: Vec<u8>,
        expected: Option<&ObjectVersion>,
    ) -> Result<PutOutcome, LakeError> {
        let path = self.path(key)?;
        let mode = match expected {
            None => PutMode::Create,
            Some(ObjectVersion(tag)) => {
                PutMode::Update(UpdateVersion { e_tag: Some(tag.clone()), version: None })
            }
        };
        let options = PutOptions { mode, ..PutOptions::default() };
        match self.wait(self.store.put_opts(&path, PutPayload::from(content), options)) {
            Ok(done) => Ok(PutOutcome::Done(ObjectVersion(done.e_tag.unwrap_or_default()))),
            Err(Error::AlreadyExists { .. } | Error::Precondition { .. } | Error::NotModified { .. }) => {
                Ok(PutOutcome::Changed)
            }
            Err(e) => Err(self.failed()(e)),
        }
    }

    fn upload(&self, from: &Path, key: &str) -> Result<(), LakeError> {
        if fs::metadata(from).map_err(LakeError::io(from))?.len() > PART {
            return self.upload_parts(from, key);
        }
        let path = self.path(key)?;
        let content = fs::read(from).map_err(LakeError::io(from))?;
        self.wait(self.store.put(&path, PutPayload::from(content))).map(drop).map_err(self.failed())
    }

    fn remove(&self, keys: &[String]) -> Result<(), LakeError> {
        super::in_parallel(keys, |key| match self.wait(self.store.delete(&self.path(key)?)) {
            Ok(()) | Err(Error::NotFound { .. }) => Ok(()),
            Err(e) => Err(self.failed()(e)),
        })
    }

    fn list(&self, prefix: &str) -> Result<Vec<(String, SystemTime)>, LakeError> {
        let path = self.path(prefix)?;
        let found: Vec<_> = self.wait(self.store.list(Some(&path)).try_collect()).map_err(self.failed())?;
        let own = if self.url.prefix.is_empty() { String::new() } else { format!("{}/", self.url.prefix) };
        let one = |object: object_store::ObjectMeta| {
            let key = object.location.as_ref().strip_prefix(&own)?.to_owned();
            Some((key, SystemTime::from(object.last_modified)))
        };
        Ok(found.into_iter().filter_map(one).collect())
    }

    fn exists(&self, key: &str) -> Result<bool, LakeError> {
        match self.wait(self.store.head(&self.path(key)?)) {
            Ok(_) => Ok(true),
            Err(Error::NotFound { .. }) => Ok(false),
            Err(e) => Err(self.failed()(e)),
        }
    }

    fn link(&self, key: &str, lifetime: Duration) -> Result<String, LakeError> {
        let path = self.path(key)?;
        let url = self.wait(self.store.signed_url(Method::GET, &path, lifetime)).map_err(self.failed())?;
        Ok(url.to_string())
    }
}

/// Threads for storage, of the whole process: never shut down, since that would block the last thread.
fn runtime() -> Option<&'static Runtime> {
    static RUNTIME: OnceLock<Option<Runtime>> = OnceLock::new();
    let start =
        || Builder::new_multi_thread().worker_threads(2).enable_time().thread_name("storage").build().ok();
    RUNTIME.get_or_init(start).as_ref()
}

/// Whether the object does not exist; a missing bucket is reported separately.
fn is_missing(e: &Error) -> bool {
    matches!(e, Error::NotFound { .. }) && !e.to_string().contains("NoSuchBucket")
}

/// The store's answer, shortened. An answer can repeat a session token.
fn reason(e: &Error, secrets: &[String]) -> String {
    let text = e.to_string();
    let element = |name: &str| {
        let (_, rest) = text.split_once(&format!("<{name}>"))?;
        rest.split_once(&format!("</{name}>")).map(|(value, _)| value.trim().to_owned())
    };
    let mut short = match (element("Code"), element("Message")) {
        (Some(code), Some(message)) => format!("{code}: {message}"),
        (Some(code), None) => code,
        // Without the body, if it has an unknown form.
        _ => text.split('<').next().unwrap_or_default().trim().trim_end_matches(':').to_owned(),
    };
    for secret in secrets {
        short = short.replace(secret.as_str(), "***");
    }
    short.chars().take(LONGEST_REASON).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reason_is_short_and_repeats_no_secret() {
        let of = |text: &str| {
            let e = Error::Generic { store: "S3", source: text.to_owned().into() };
            reason(&e, &["hunter2-token".to_owned()])
        };
        let body = "403: <Error><Code>ExpiredToken</Code><Message>The token hunter2-token has expired</Message>\
            <Token-0>hunter2-token</Token-0></Error>";
        assert_eq!(of(body), "ExpiredToken: The token *** has expired");
        assert_eq!(of("status 500: <html>hunter2-token</html>"), "Generic S3 error: status 500");
        assert!(of(&"x".repeat(9999)).len() < 400);
    }
}
