//! An object store in memory for the tests of the protocol: several processes share it, and it can fail at any call.

use super::{ObjectVersion, Objects, PutOutcome};
use crate::LakeError;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::{Duration, SystemTime};

/// What all processes see.
#[derive(Debug, Default)]
pub(crate) struct Shared {
    pub objects: BTreeMap<String, (Vec<u8>, u64)>,
    count: u64,
}

/// One process's access.
#[derive(Clone, Debug)]
pub(crate) struct MemoryObjects {
    pub shared: Arc<Mutex<Shared>>,
    /// Writing calls that still work; `None`: all.
    pub left: Arc<Mutex<Option<u64>>>,
    /// Writing calls so far.
    pub calls: Arc<Mutex<u64>>,
    /// The failing call is carried out: only its answer is lost.
    pub loses_answers: bool,
    /// Conditions are ignored.
    pub unconditional: bool,
}

impl MemoryObjects {
    pub fn new() -> Self {
        Self {
            shared: Arc::default(),
            left: Arc::default(),
            calls: Arc::default(),
            loses_answers: false,
            unconditional: false,
        }
    }

    /// Another process, which fails after a given number of writing calls.
    pub fn failing_after(&self, calls: u64, loses_answers: bool) -> Self {
        let left = Arc::new(Mutex::new(Some(calls)));
        Self { left, loses_answers, calls: Arc::default(), ..self.clone() }
    }

    pub fn keys(&self) -> Vec<String> {
        self.shared.lock().unwrap().objects.keys().cloned().collect()
    }

    fn writing<T>(&self, change: impl FnOnce(&mut Shared) -> T) -> Result<T, LakeError> {
        *self.calls.lock().unwrap() += 1;
        let mut left = self.left.lock().unwrap();
        let works = left.is_none_or(|n| n > 0);
        *left = left.map(|n| n.saturating_sub(1));
        let failed = || LakeError::Storage { url: self.url(), reason: "cut".to_owned() };
        if !works && !self.loses_answers {
            return Err(failed());
        }
        let done = change(&mut self.shared.lock().unwrap());
        if works { Ok(done) } else { Err(failed()) }
    }
}

impl Shared {
    fn put(&mut self, key: &str, content: Vec<u8>) -> ObjectVersion {
        self.count += 1;
        self.objects.insert(key.to_owned(), (content, self.count));
        ObjectVersion(self.count.to_string())
    }
}

impl Objects for MemoryObjects {
    fn url(&self) -> String {
        "s3://memory/lake".to_owned()
    }

    fn get(&self, key: &str) -> Result<Option<(Vec<u8>, ObjectVersion)>, LakeError> {
        let shared = self.shared.lock().unwrap();
        Ok(shared.objects.get(key).map(|(c, v)| (c.clone(), ObjectVersion(v.to_string()))))
    }

    fn download(&self, key: &str, bytes: u64, to: &Path) -> Result<bool, LakeError> {
        let Some((content, _)) = self.get(key)? else { return Ok(false) };
        assert_eq!(content.len() as u64, bytes);
        std::fs::write(to, content).map_err(LakeError::io(to)).map(|()| true)
    }

    fn put_if(
        &self,
        key: &str,
        content: Vec<u8>,
        expected: Option<&ObjectVersion>,
    ) -> Result<PutOutcome, LakeError> {
        self.writing(|shared| {
            let held = shared.objects.get(key).map(|(_, v)| ObjectVersion(v.to_string()));
            if held.as_ref() != expected && !self.unconditional {
                return PutOutcome::Changed;
            }
            PutOutcome::Done(shared.put(key, content))
        })
    }

    fn upload(&self, from: &Path, key: &str) -> Result<(), LakeError> {
        let content = std::fs::read(from).map_err(LakeError::io(from))?;
        self.writing(|shared| drop(shared.put(key, content)))
    }

    fn remove(&self, keys: &[String]) -> Result<(), LakeError> {
        self.writing(|shared| keys.iter().for_each(|key| drop(shared.objects.remove(key))))
    }

    fn list(&self, prefix: &str) -> Result<Vec<(String, SystemTime)>, LakeError> {
        let keys = self.keys().into_iter().filter(|k| k.starts_with(prefix));
        Ok(keys.map(|k| (k, SystemTime::now())).collect())
    }

    fn exists(&self, key: &str) -> Result<bool, LakeError> {
        Ok(self.get(key)?.is_some())
    }

    fn link(&self, key: &str, lifetime: Duration) -> Result<String, LakeError> {
        Ok(format!("memory:{key}?{}", lifetime.as_secs()))
    }
}
