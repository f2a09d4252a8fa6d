//! Publishing what a process has written: objects first, then one conditional put of the manifest. If the process is
//! killed before that put, nothing has changed; after it, everything has. Repeating it changes nothing.

use super::manifest::{self, Manifest};
use super::mirror::Mirror;
use super::rebase::{Change, Changes, rebase};
use super::{Intent, ObjectVersion, PutOutcome, in_parallel};
use crate::LakeError;
use crate::packs::fingerprint::identity;
use std::path::PathBuf;
use std::thread::sleep;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// How long the objects of replaced files are kept for those who are reading them.
const GRACE: Duration = Duration::from_secs(3600);
/// Objects that a killed process uploaded and never published are removed after this time.
const ABANDONED: Duration = Duration::from_secs(24 * 3600);
/// Maximum number of puts that lose against another writer, and of calls that fail after the store's own retries.
const MOST_PUTS: u64 = 100;
const MOST_FAILURES: u64 = 4;
const FIRST_PAUSE_MS: u64 = if cfg!(test) { 1 } else { 20 };

impl Mirror {
    /// Publishes what this process has changed since the last time.
    ///
    /// # Errors
    /// [`LakeError::ChangedMeanwhile`] names the drives that another writer changed at the same time: these were not
    /// published; all others were. After any other error it is unknown whether the changes were published; repeating
    /// the call is safe in both cases.
    pub(crate) fn publish(&self, intent: Intent) -> Result<(), LakeError> {
        self.publish_images()?;
        let (changes, uploads) = self.changes()?;
        if !changes.is_empty() {
            in_parallel(&uploads, |upload| self.objects.upload(&upload.from, &upload.key))?;
            let conflicts = self.commit(&changes, intent)?;
            if !conflicts.is_empty() {
                return Err(LakeError::ChangedMeanwhile { url: self.url(), what: conflicts });
            }
        }
        if intent == Intent::Delete {
            self.remove_leftovers_of_removed()?;
            let state = self.state();
            self.cache.retain(&state.base.files.values().map(|file| file.blake3.as_str()).collect())?;
        }
        self.purge()?;
        if intent == Intent::Compact {
            self.remove_abandoned()?;
        }
        Ok(())
    }

    /// Puts the manifest with the changes; returns what could not be applied.
    fn commit(&self, changes: &Changes, intent: Intent) -> Result<Vec<String>, LakeError> {
        let (base, mut current, mut version) = {
            let state = self.state();
            (state.base.clone(), state.base.clone(), state.version.clone())
        };
        let (mut puts, mut failures) = (0, 0);
        loop {
            let done = rebase(&base, &current, changes, intent, now());
            let put = if done.manifest == current {
                version.clone().map(PutOutcome::Done).ok_or_else(|| self.no_manifest())
            } else {
                self.objects.put_if(manifest::KEY, done.manifest.to_bytes(), version.as_ref())
            };
            match put {
                Ok(PutOutcome::Done(version)) => {
                    self.keep(&base, changes, done.manifest, version)?;
                    return Ok(done.conflicts);
                }
                Ok(PutOutcome::Changed) if puts < MOST_PUTS => puts += 1,
                Ok(PutOutcome::Changed) => {
                    let what = vec![manifest::KEY.to_owned()];
                    return Err(LakeError::ChangedMeanwhile { url: self.url(), what });
                }
                // The write may have succeeded although the answer was lost: the current content decides.
                Err(_) if failures < MOST_FAILURES => failures += 1,
                Err(e) => return Err(e),
            }
            sleep(pause(puts + 4 * failures, &self.run));
            (current, version) = match self.read() {
                Ok((current, version)) => (current, Some(version)),
                Err(_) if failures < MOST_FAILURES => {
                    failures += 1;
                    continue;
                }
                Err(e) => return Err(e),
            };
        }
    }

    /// From now on, the folder is based on what was published.
    fn keep(
        &self,
        base: &Manifest,
        changes: &Changes,
        published: Manifest,
        version: ObjectVersion,
    ) -> Result<(), LakeError> {
        let mut mine = base.clone();
        {
            let mut state = self.state();
            for (path, change) in changes {
                match change {
                    Change::Put(file) => {
                        let at = self.dir().join(path);
                        if path.contains('/') {
                            self.cache.keep(&at, &file.blake3);
                        }
                        state.known.insert(path.clone(), identity(&at));
                        mine.files.insert(path.clone(), file.clone());
                    }
                    Change::Remove => {
                        state.known.remove(path);
                        mine.files.remove(path);
                    }
                }
            }
        }
        self.follow(&mine, published, version)
    }

    /// The manifest as it is now.
    pub(super) fn read(&self) -> Result<(Manifest, ObjectVersion), LakeError> {
        let (text, version) = self.objects.get(manifest::KEY)?.ok_or_else(|| self.no_manifest())?;
        Ok((Manifest::parse(&text, &self.url())?, version))
    }

    fn no_manifest(&self) -> LakeError {
        LakeError::NotALake(PathBuf::from(self.url()))
    }

    /// Removes objects that have been unused for long enough, then their entries. If it is killed in between, the next
    /// run repeats it.
    fn purge(&self) -> Result<(), LakeError> {
        let due = |m: &Manifest| -> Vec<String> {
            let is_due = |at: u64| at + GRACE.as_secs() <= now();
            m.retired.iter().filter(|r| is_due(r.at)).map(|r| r.key.clone()).collect()
        };
        if due(&self.state().base).is_empty() {
            return Ok(());
        }
        for _ in 0..MOST_PUTS {
            let (mut current, version) = self.read()?;
            let due = due(&current);
            self.objects.remove(&due)?;
            current.retired.retain(|r| !due.contains(&r.key));
            let put = self.objects.put_if(manifest::KEY, current.to_bytes(), Some(&version))?;
            if let PutOutcome::Done(version) = put {
                let known = self.state().base.clone();
                return self.follow(&known, current, version);
            }
        }
        // The next writer does it.
        Ok(())
    }

    /// Images of removed drives, and what killed processes uploaded for them.
    fn remove_leftovers_of_removed(&self) -> Result<(), LakeError> {
        let removed = std::mem::take(&mut self.state().removed);
        for id in removed {
            let mut keys = Vec::new();
            for prefix in [format!("media/{id}/"), format!("drives/{id}/")] {
                keys.extend(self.objects.list(&prefix)?.into_iter().map(|(key, _)| key));
            }
            let (current, _) = self.read()?;
            keys.retain(|key| current.files.values().all(|f| f.key != *key));
            self.objects.remove(&keys)?;
        }
        Ok(())
    }

    /// Objects that no manifest names and no process is about to publish.
    fn remove_abandoned(&self) -> Result<(), LakeError> {
        let before = SystemTime::now() - ABANDONED;
        let mut keys = Vec::new();
        for prefix in ["drives/", "packs/"] {
            keys.extend(
                self.objects.list(prefix)?.into_iter().filter(|(_, at)| *at < before).map(|(k, _)| k),
            );
        }
        let (current, _) = self.read()?;
        let files = current.files.values().map(|f| f.key.as_str());
        let named: std::collections::BTreeSet<&str> =
            files.chain(current.retired.iter().map(|r| r.key.as_str())).collect();
        keys.retain(|key| !named.contains(key.as_str()));
        self.objects.remove(&keys)
    }
}

fn now() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs())
}

/// Longer each time, and not the same for two writers.
fn pause(tries: u64, run: &str) -> Duration {
    let own = run.bytes().fold(tries, |sum, b| sum.wrapping_mul(31).wrapping_add(u64::from(b)));
    let most = FIRST_PAUSE_MS.saturating_mul(1 << tries.min(5));
    Duration::from_millis(most / 2 + own % (most / 2 + 1))
}
