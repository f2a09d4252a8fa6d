//! Answers kept by the content of their request, one file each: an interrupted run continues where it stopped, and a
//! repeated one costs nothing. Usable answers and refusals are kept; the question of an unreadable file is asked again.

use crate::ChatError;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// Version of the files.
const VERSION: u32 = 1;

/// A folder of answers.
#[derive(Debug)]
pub(super) struct Cache {
    dir: PathBuf,
    written: AtomicU64,
}

#[derive(Serialize, Deserialize)]
struct Kept {
    version: u32,
    answer: String,
    /// The answer is the text of a refusal.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    refused: bool,
}

/// Name of the request's file: a hash of the address and of everything that is sent except the key.
pub(super) fn name(url: &str, body: &str) -> String {
    let mut hash = blake3::Hasher::new();
    hash.update(url.as_bytes());
    hash.update(&[0]);
    hash.update(body.as_bytes());
    hash.finalize().to_hex().to_string()
}

impl Cache {
    pub fn open(dir: PathBuf) -> Result<Self, ChatError> {
        std::fs::create_dir_all(&dir).map_err(|e| unwritable(&dir, &e))?;
        Ok(Self { dir, written: AtomicU64::new(0) })
    }

    /// A kept answer; as an error, a refusal.
    pub fn get(&self, name: &str) -> Option<Result<String, String>> {
        let text = std::fs::read_to_string(self.file(name)).ok()?;
        let kept: Kept = serde_json::from_str(&text).ok()?;
        let answer = if kept.refused { Err(kept.answer) } else { Ok(kept.answer) };
        (kept.version == VERSION).then_some(answer)
    }

    /// Written atomically: a killed run leaves no partial file.
    pub fn put(&self, name: &str, answer: Result<&str, &str>) -> Result<(), ChatError> {
        let text = answer.unwrap_or_else(|refusal| refusal).to_owned();
        let kept = Kept { version: VERSION, answer: text, refused: answer.is_err() };
        let text = serde_json::to_string(&kept).map_err(|e| unwritable(&self.dir, &e.into()))?;
        let number = self.written.fetch_add(1, Ordering::Relaxed);
        let half = self.dir.join(format!("{name}.{}.{number}.part", std::process::id()));
        std::fs::write(&half, text)
            .and_then(|()| std::fs::rename(&half, self.file(name)))
            .map_err(|e| unwritable(&half, &e))
    }

    fn file(&self, name: &str) -> PathBuf {
        self.dir.join(format!("{name}.json"))
    }
}

fn unwritable(path: &Path, e: &std::io::Error) -> ChatError {
    ChatError::Cache { path: path.to_owned(), why: e.to_string() }
}
