//! `s3://bucket/prefix`: parsed strictly, so that it cannot contain credentials.

use crate::LakeError;
use std::fmt;
use std::path::Path;
use whyroad_model::Bilingual;

/// Where a lake or images are in an object store.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StorageUrl {
    /// The bucket.
    pub bucket: String,
    /// Without a slash at either end; may be empty.
    pub prefix: String,
}

impl fmt::Display for StorageUrl {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "s3://{}", self.bucket)?;
        if self.prefix.is_empty() { Ok(()) } else { write!(f, "/{}", self.prefix) }
    }
}

impl StorageUrl {
    /// The URL that was given where a folder could be; `None` for a folder.
    ///
    /// # Errors
    /// For another scheme than `s3`, and for anything in the URL but a bucket and a prefix. The message does not repeat
    /// it: it may hold a secret.
    pub fn of(path: &Path) -> Option<Result<Self, LakeError>> {
        let (scheme, rest) = path.to_str()?.split_once("://")?;
        let is_scheme = scheme.len() > 1 && scheme.chars().all(|c| c.is_ascii_alphanumeric() || c == '+');
        is_scheme.then(|| Self::parse(scheme, rest).map_err(LakeError::Url))
    }

    fn parse(scheme: &str, rest: &str) -> Result<Self, Bilingual> {
        if !scheme.eq_ignore_ascii_case("s3") {
            return Err(Bilingual::new(
                format!("不支持协议“{scheme}://”"),
                format!("the scheme '{scheme}://' is not supported"),
            ));
        }
        let (bucket, prefix) = rest.split_once('/').unwrap_or((rest, ""));
        let fits = |c: char| c.is_ascii_alphanumeric() || ".-_".contains(c);
        if bucket.len() < 3 || bucket.len() > 63 || !bucket.chars().all(fits) {
            return Err(Bilingual::new(
                "“s3://”之后应为存储桶名称（3 至 63 个字母、数字、“.”、“-”、“_”）",
                "'s3://' must be followed by the name of a bucket (3 to 63 letters, digits, '.', '-', '_')",
            ));
        }
        let prefix = prefix.trim_end_matches('/');
        let bad = |part: &str| {
            part.is_empty() || part == "." || part == ".." || part.contains(['?', '#', '\\', '%', '*'])
        };
        if !prefix.is_empty() && prefix.split('/').any(bad) {
            return Err(Bilingual::new(
                "存储桶之后的前缀有空段、“..”或“?”“#”“%”“*”",
                "the prefix after the bucket has an empty part, '..', or one of '?', '#', '%', '*'",
            ));
        }
        Ok(Self { bucket: bucket.to_owned(), prefix: prefix.to_owned() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Option<Result<StorageUrl, LakeError>> {
        StorageUrl::of(Path::new(text))
    }

    #[test]
    fn a_bucket_and_a_prefix_and_nothing_else() {
        for (given, shown) in [
            ("s3://fleet/lakes/a", "s3://fleet/lakes/a"),
            ("S3://fleet/lakes/a/", "s3://fleet/lakes/a"),
            ("s3://fleet", "s3://fleet"),
            ("s3://fleet/", "s3://fleet"),
        ] {
            assert_eq!(of(given).unwrap().unwrap().to_string(), shown);
        }
        for folder in ["lake", "/data/lake", "./s3:/x", "C://lake", "", "s3:/bucket/x"] {
            assert!(of(folder).is_none(), "{folder}");
        }
        for wrong in [
            "s3://AKIA:hunter2@fleet/x",
            "s3://fleet/x?X-Amz-Signature=hunter2",
            "s3:///x",
            "s3://fleet/../x",
            "s3://fleet//x",
            "gs://fleet/x",
            "https://user:hunter2@host/x",
        ] {
            let e = of(wrong).unwrap().unwrap_err();
            assert_eq!(e.code(), "lake.url", "{wrong}");
            let said = format!("{e} {e:?} {:?}", e.diagnostic());
            assert!(!said.contains("hunter2"), "{said}");
        }
    }
}
