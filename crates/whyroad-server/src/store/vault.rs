//! Sealed secrets in the store: somebody who reads the database or a backup of it, without the key, cannot read them.
//! The key is in a separate file that only its owner can read.
//!
//! A key file has one key per line, 64 hexadecimal digits; the first one seals, all of them open. A key is replaced by
//! adding a new one in front, sealing everything again, and removing the old one ([`Vault::rotate`]).
//!
//! A sealed text is `sealed:v1:<key>:<nonce><ciphertext>`, in hexadecimal, with ChaCha20-Poly1305 (RFC 8439) and the
//! secret's location as additional data: a sealed text that is moved to another location cannot be opened there.

use super::private;
use super::sql::Tx;
use crate::problem::{Answer, Problem};
use crate::{secret, values};
use ring::aead::{Aad, CHACHA20_POLY1305, LessSafeKey, NONCE_LEN, Nonce, UnboundKey};
use std::path::{Path, PathBuf};
use std::sync::RwLock;

/// Prefix of a sealed text.
const SEALED: &str = "sealed:v1:";
/// Bytes of a key.
const KEY_BYTES: usize = 32;

struct Key {
    /// The beginning of its hash: identifies the key that sealed a text.
    name: String,
    text: String,
    key: LessSafeKey,
}

impl Key {
    fn parse(line: &str) -> Option<Self> {
        let bytes = bytes(line).filter(|b| b.len() == KEY_BYTES)?;
        let key = LessSafeKey::new(UnboundKey::new(&CHACHA20_POLY1305, &bytes).ok()?);
        let name = secret::hash_bytes(&bytes).get(..8)?.to_owned();
        Some(Self { name, text: line.to_owned(), key })
    }
}

/// The keys of a store.
pub struct Vault {
    path: PathBuf,
    keys: RwLock<Vec<Key>>,
}

impl std::fmt::Debug for Vault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Vault({})", self.path.display())
    }
}

impl Vault {
    /// The keys in the file at `path`; creates the file with a new key if it does not exist.
    pub(super) fn open(path: &Path) -> Answer<Self> {
        let text = match std::fs::read_to_string(path) {
            Ok(text) => {
                private::only_owner(path).map_err(|e| unusable(path, e))?;
                text
            }
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => {
                let text = format!("{}\n", secret::random(KEY_BYTES)?);
                // Two services may start at once: the key of the first one is used.
                match private::create(path, &text) {
                    Ok(()) => text,
                    Err(e) if e.kind() == std::io::ErrorKind::AlreadyExists => {
                        std::fs::read_to_string(path).map_err(|e| unusable(path, e))?
                    }
                    Err(e) => return Err(unusable(path, e)),
                }
            }
            Err(e) => return Err(unusable(path, e)),
        };
        let vault = Self { path: path.to_owned(), keys: RwLock::new(vec![]) };
        *vault.keys.write().map_err(Problem::store)? = vault.parse(&text)?;
        Ok(vault)
    }

    fn parse(&self, text: &str) -> Answer<Vec<Key>> {
        let lines = text.lines().map(str::trim).filter(|l| !l.is_empty() && !l.starts_with('#'));
        let keys: Option<Vec<Key>> = lines.map(Key::parse).collect();
        keys.filter(|k| !k.is_empty())
            .ok_or_else(|| unusable(&self.path, "a line of it is not 64 hexadecimal digits, or it is empty"))
    }

    /// The key file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// `plain` sealed for `place`, such as `webhook:<id>`.
    pub fn seal(&self, place: &str, plain: &str) -> Answer<String> {
        let keys = self.keys.read().map_err(Problem::store)?;
        let key = keys.first().ok_or_else(|| unusable(&self.path, "no key"))?;
        let mut nonce = [0; NONCE_LEN];
        getrandom::fill(&mut nonce).map_err(Problem::store)?;
        let mut text = plain.as_bytes().to_vec();
        key.key
            .seal_in_place_append_tag(Nonce::assume_unique_for_key(nonce), Aad::from(place), &mut text)
            .map_err(Problem::store)?;
        Ok(format!("{SEALED}{}:{}{}", key.name, secret::hex(&nonce), secret::hex(&text)))
    }

    /// Opens a text that [`Vault::seal`] sealed for the same location. A text from before sealing is returned
    /// unchanged.
    pub fn open_text(&self, place: &str, stored: &str) -> Answer<String> {
        let Some(sealed) = stored.strip_prefix(SEALED) else { return Ok(stored.to_owned()) };
        let cannot = || wrong_key(&self.path);
        let (name, body) = sealed.split_once(':').ok_or_else(cannot)?;
        let keys = self.keys.read().map_err(Problem::store)?;
        let key = keys.iter().find(|k| k.name == name).ok_or_else(cannot)?;
        let mut body = bytes(body).filter(|b| b.len() > NONCE_LEN).ok_or_else(cannot)?;
        let mut text = body.split_off(NONCE_LEN);
        let nonce = Nonce::try_assume_unique_for_key(&body).map_err(|_| cannot())?;
        let plain = key.key.open_in_place(nonce, Aad::from(place), &mut text).map_err(|_| cannot())?;
        String::from_utf8(plain.to_vec()).map_err(|_| cannot())
    }

    /// Seals all secrets that are not sealed with the first key: those of older programs and of older keys. Returns the
    /// number of written secrets.
    pub(super) fn seal_all(&self, tx: &mut dyn Tx) -> Answer<u64> {
        let current = {
            let keys = self.keys.read().map_err(Problem::store)?;
            keys.first().map(|k| format!("{SEALED}{}:", k.name)).unwrap_or_default()
        };
        let mut written = 0;
        for row in tx.rows("SELECT id, secret FROM webhooks", &[])? {
            let (id, stored) = (row.text("id")?, row.text("secret")?);
            if !stored.starts_with(&current) {
                let place = webhook(&id);
                let sealed = self.seal(&place, &self.open_text(&place, &stored)?)?;
                tx.run("UPDATE webhooks SET secret = $1 WHERE id = $2", values![sealed, &id])?;
                written += 1;
            }
        }
        for (name, stored) in sealed_settings(tx)? {
            if !stored.starts_with(&current) {
                let place = setting(&name);
                let sealed = self.seal(&place, &self.open_text(&place, &stored)?)?;
                tx.run("UPDATE settings SET value = $1 WHERE name = $2", values![sealed, &name])?;
                written += 1;
            }
        }
        Ok(written)
    }

    /// Refuses a store whose secrets these keys cannot open.
    pub(super) fn check(&self, tx: &mut dyn Tx) -> Answer<()> {
        for row in tx.rows("SELECT id, secret FROM webhooks", &[])? {
            self.open_text(&webhook(&row.text("id")?), &row.text("secret")?)?;
        }
        for (name, stored) in sealed_settings(tx)? {
            self.open_text(&setting(&name), &stored)?;
        }
        Ok(())
    }

    /// Adds a new key in front of the file, runs `reseal`, and removes the older keys. After a failure in between all
    /// keys are in the file, and a repetition completes the rotation.
    pub(super) fn rotate(&self, reseal: impl FnOnce() -> Answer<u64>) -> Answer<u64> {
        let fresh = secret::random(KEY_BYTES)?;
        let old = {
            let keys = self.keys.read().map_err(Problem::store)?;
            keys.iter().map(|k| k.text.clone()).collect::<Vec<_>>().join("\n")
        };
        self.replace(&format!("{fresh}\n{old}\n"))?;
        let written = reseal()?;
        self.replace(&format!("{fresh}\n"))?;
        Ok(written)
    }

    fn replace(&self, text: &str) -> Answer<()> {
        let keys = self.parse(text)?;
        private::replace(&self.path, text).map_err(|e| unusable(&self.path, e))?;
        *self.keys.write().map_err(Problem::store)? = keys;
        Ok(())
    }
}

/// The location of the CSRF key.
pub const CSRF: &str = "setting:csrf_key";
/// The location of the token that creates the first account.
pub const SETUP_TOKEN: &str = "setting:setup_token";

/// The location of a setting.
fn setting(name: &str) -> String {
    format!("setting:{name}")
}

/// Names and values of the settings that are sealed.
fn sealed_settings(tx: &mut dyn Tx) -> Answer<Vec<(String, String)>> {
    let sql = "SELECT name, value FROM settings WHERE name IN ('csrf_key', 'setup_token') ORDER BY name";
    tx.rows(sql, &[])?.iter().map(|r| Ok((r.text("name")?, r.text("value")?))).collect()
}

/// The location of a webhook's signing key.
pub fn webhook(id: &str) -> String {
    format!("webhook:{id}")
}

fn bytes(hex: &str) -> Option<Vec<u8>> {
    if !hex.len().is_multiple_of(2) || !hex.is_ascii() {
        return None;
    }
    (0..hex.len()).step_by(2).map(|i| u8::from_str_radix(hex.get(i..i + 2)?, 16).ok()).collect()
}

/// Refuses to make a new key for a store with sealed secrets: it could not open them.
pub(super) fn check_there(path: &Path, tx: &mut dyn Tx) -> Answer<()> {
    if path.exists() {
        return Ok(());
    }
    let sealed = |text: &str| text.starts_with(SEALED);
    for row in tx.rows("SELECT secret FROM webhooks", &[])? {
        if sealed(&row.text("secret")?) {
            return Err(wrong_key(path));
        }
    }
    match sealed_settings(tx)?.iter().any(|(_, text)| sealed(text)) {
        true => Err(wrong_key(path)),
        false => Ok(()),
    }
}

fn wrong_key(path: &Path) -> Problem {
    let (path, exists) = (path.display(), path.exists());
    Problem::new(
        503,
        "store.key",
        format!(
            "{}：请用 --data 或 WHYROAD_DATA_DIR 指定服务的数据文件夹，或用 --key-file 或 WHYROAD_KEY_FILE \
             指定其密钥文件；若密钥文件已丢失，请放回写入时的那个",
            if exists {
                format!("存储中的密文无法用密钥文件 {path} 解开")
            } else {
                format!("没有密钥文件 {path}，而存储中有密文")
            },
        ),
        format!(
            "{}: name the data folder of the service with --data or WHYROAD_DATA_DIR, or its key file with --key-file \
             or WHYROAD_KEY_FILE; if the key file is lost, restore the one that sealed them",
            if exists {
                format!("secrets of the store cannot be opened with the key file {path}")
            } else {
                format!("there is no key file {path}, and the store has sealed secrets")
            },
        ),
    )
}

fn unusable(path: &Path, why: impl std::fmt::Display) -> Problem {
    Problem::new(
        503,
        "store.key",
        format!("密钥文件 {} 无法使用：{why}", path.display()),
        format!("the key file {} cannot be used: {why}", path.display()),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_opens_in_its_place_only_and_not_when_it_was_changed() {
        let dir = tempfile::tempdir().unwrap();
        let vault = Vault::open(&dir.path().join("k")).unwrap();
        let sealed = vault.seal("webhook:a", "geheim 秘密").unwrap();
        assert!(!sealed.contains("geheim"));
        assert_ne!(sealed, vault.seal("webhook:a", "geheim 秘密").unwrap(), "a nonce is used once");
        assert_eq!(vault.open_text("webhook:a", &sealed).unwrap(), "geheim 秘密");
        assert_eq!(vault.open_text("webhook:b", &sealed).unwrap_err().code, "store.key");
        let last = if sealed.ends_with('0') { "1" } else { "0" };
        let changed = format!("{}{last}", &sealed[..sealed.len() - 1]);
        assert_eq!(vault.open_text("webhook:a", &changed).unwrap_err().code, "store.key");
        assert_eq!(vault.open_text("webhook:a", "from before").unwrap(), "from before");
    }

    #[test]
    fn another_key_opens_nothing_and_a_replaced_one_all() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("k");
        let vault = Vault::open(&path).unwrap();
        let sealed = vault.seal(CSRF, "x").unwrap();
        assert_eq!(Vault::open(&path).unwrap().open_text(CSRF, &sealed).unwrap(), "x", "after a restart");
        let other = Vault::open(&dir.path().join("other")).unwrap();
        assert_eq!(other.open_text(CSRF, &sealed).unwrap_err().code, "store.key");
        let mut again = String::new();
        vault
            .rotate(|| {
                again = vault.seal(CSRF, &vault.open_text(CSRF, &sealed)?)?;
                Ok(1)
            })
            .unwrap();
        assert_eq!(vault.open_text(CSRF, &again).unwrap(), "x");
        assert!(vault.open_text(CSRF, &sealed).is_err(), "the old key is gone");
        assert_eq!(std::fs::read_to_string(&path).unwrap().lines().count(), 1);
    }

    #[test]
    fn a_broken_key_file_is_refused() {
        let dir = tempfile::tempdir().unwrap();
        for text in ["", "# nothing\n", "abc\n", &"0".repeat(63), &"z".repeat(64)] {
            let path = dir.path().join("k");
            std::fs::write(&path, text).unwrap();
            assert_eq!(Vault::open(&path).unwrap_err().code, "store.key", "{text}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn only_its_owner_reads_the_key() {
        use std::os::unix::fs::PermissionsExt as _;
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("k");
        Vault::open(&path).unwrap();
        assert_eq!(std::fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o600);
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o644)).unwrap();
        Vault::open(&path).unwrap();
        assert_eq!(std::fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o600);
    }
}
