//! The tree of a PhysicalAI-AV download: `features.csv` states where the files of a feature are, `clip_index.parquet`
//! which clip is in which chunk. Only what has been downloaded is there.

use crate::encodings::columns::{Columns, read_parquet, read_parquet_bytes};
use crate::encodings::text::utf8;
use crate::encodings::zip_members::ZipMembers;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::fs::{self, File};
use std::io::BufReader;
use std::path::{Path, PathBuf};

/// The table of features, in the folder of the tree.
pub(super) const FEATURES: &str = "features.csv";
/// The table of clips.
pub(super) const CLIPS: &str = "clip_index.parquet";
const COLLECTION: &str = "metadata/data_collection.parquet";

/// Where the files of a feature are.
pub(super) struct Feature {
    /// Path below the tree, with `{chunk_id:04d}`.
    chunk_path: String,
    /// Names of a clip's files in the archive, with `{clip_id}`, by what they are. Empty for a feature that is one
    /// table.
    files: BTreeMap<String, String>,
}

impl Feature {
    /// Path of a chunk below the tree.
    pub fn chunk_path(&self, chunk: i64) -> String {
        filled(&self.chunk_path, "chunk_id", &Number(chunk))
    }

    /// What files a clip has in the archive.
    pub fn file_names(&self) -> Vec<String> {
        self.files.keys().cloned().collect()
    }
}

/// One clip.
pub(super) struct Clip {
    pub id: String,
    /// The publisher's own verdict; `None` when it is not stated.
    pub is_valid: Option<bool>,
    pub chunk: i64,
}

/// How a clip was recorded; `None` is unknown.
#[derive(Clone, Default)]
pub(super) struct Collection {
    pub country: Option<String>,
    pub platform: Option<String>,
}

/// An archive on disk.
type Archive = ZipMembers<BufReader<File>>;

/// A tree, with the archives that were opened so far.
pub(super) struct Tree {
    root: PathBuf,
    pub features: BTreeMap<String, Feature>,
    pub clips: Vec<Clip>,
    collection: Option<BTreeMap<String, Collection>>,
    archives: BTreeMap<PathBuf, Result<Archive, String>>,
}

/// A clip's file inside an archive.
pub(super) struct Member {
    /// Archive and name, as `camera/a/a.chunk_0000.zip!/b.mp4`.
    pub uri: String,
    /// `None` when the archive has no such member.
    pub content: Result<Option<Vec<u8>>, String>,
}

impl Tree {
    /// Reads both tables; the error names the file.
    pub fn open(root: &Path) -> Result<Self, (PathBuf, String)> {
        let of = |name: &'static str| move |reason| (root.join(name), reason);
        let read = |name: &str| fs::read(root.join(name)).map_err(|e| e.to_string());
        Ok(Self {
            root: root.to_owned(),
            features: read(FEATURES).and_then(|c| features(&c)).map_err(of(FEATURES))?,
            clips: read(CLIPS).and_then(clips).map_err(of(CLIPS))?,
            collection: None,
            archives: BTreeMap::new(),
        })
    }

    /// The file of a chunk, where it has been downloaded.
    pub fn chunk_file(&self, feature: &str, chunk: i64) -> Option<PathBuf> {
        let path = self.root.join(self.features.get(feature)?.chunk_path(chunk));
        path.is_file().then_some(path)
    }

    /// A clip's file of a feature; `None` when the chunk has not been downloaded, or the feature has no such file.
    pub fn member(&mut self, feature: &str, file: &str, clip: &Clip) -> Option<Member> {
        let (archive, uri, name) = self.locate(feature, file, clip)?;
        Some(Member { uri, content: archive.and_then(|a| a.read(&name)) })
    }

    /// Name of a clip's file, when the archive has it; it is not read.
    pub fn member_uri(&mut self, feature: &str, file: &str, clip: &Clip) -> Option<String> {
        let (archive, uri, name) = self.locate(feature, file, clip)?;
        archive.is_ok_and(|a| a.has(&name)).then_some(uri)
    }

    fn locate(
        &mut self,
        feature: &str,
        file: &str,
        clip: &Clip,
    ) -> Option<(Result<&mut Archive, String>, String, String)> {
        let path = self.chunk_file(feature, clip.chunk)?;
        let name = filled(self.features.get(feature)?.files.get(file)?, "clip_id", &Text(&clip.id));
        let shown = path.strip_prefix(&self.root).unwrap_or(&path).display().to_string().replace('\\', "/");
        let archive = match self.archives.entry(path) {
            Entry::Occupied(open) => open.into_mut(),
            Entry::Vacant(new) => {
                let opened = ZipMembers::open(new.key());
                new.insert(opened)
            }
        };
        let archive = archive.as_mut().map_err(|e| e.clone());
        Some((archive, format!("{shown}!/{name}"), name))
    }

    /// The row of a clip in a feature that is one table per chunk.
    pub fn row(&self, feature: &str, clip: &Clip) -> Result<Option<(Columns, usize)>, (PathBuf, String)> {
        let Some(path) = self.chunk_file(feature, clip.chunk) else { return Ok(None) };
        let found = read_parquet(&path).and_then(|table| {
            let row = index_of(&table)?.iter().position(|id| id.as_deref() == Some(&clip.id));
            Ok(row.map(|row| (table, row)))
        });
        found.map_err(|reason| (path, reason))
    }

    /// What `data_collection` states about a clip. An unreadable or missing table is an unknown.
    pub fn collection(&mut self, clip: &Clip) -> Collection {
        let root = &self.root;
        let read = || fs::read(root.join(COLLECTION)).ok().and_then(|c| collection(c).ok());
        let table = self.collection.get_or_insert_with(|| read().unwrap_or_default());
        table.get(&clip.id).cloned().unwrap_or_default()
    }
}

/// The table of features.
pub(super) fn features(content: &[u8]) -> Result<BTreeMap<String, Feature>, String> {
    utf8(content)?;
    let mut reader = csv::Reader::from_reader(content);
    let header = reader.headers().map_err(|e| e.to_string())?.clone();
    let column = |name: &str| {
        header.iter().position(|h| h == name).ok_or_else(|| format!("column '{name}' is missing"))
    };
    let (name, chunk, files) = (column("feature")?, column("chunk_path")?, column("clip_files_in_zip")?);
    let mut out = BTreeMap::new();
    for record in reader.records() {
        let record = record.map_err(|e| e.to_string())?;
        let cell = |i: usize| record.get(i).unwrap_or_default().to_owned();
        let chunk_path = cell(chunk);
        let inside =
            Path::new(&chunk_path).components().all(|c| matches!(c, std::path::Component::Normal(_)));
        if !inside {
            return Err(format!("chunk_path '{chunk_path}' leads out of the folder"));
        }
        let files = match cell(files) {
            empty if empty.is_empty() => BTreeMap::new(),
            json => serde_json::from_str(&json).map_err(|e| format!("clip_files_in_zip '{json}': {e}"))?,
        };
        out.insert(cell(name), Feature { chunk_path, files });
    }
    Ok(out)
}

/// The index of a table written by pandas: a column of its name, or of a made-up one.
fn index_of(table: &Columns) -> Result<Vec<Option<String>>, String> {
    table.texts(if table.has("clip_id") { "clip_id" } else { "__index_level_0__" })
}

/// The index of clips.
pub(super) fn clips(content: Vec<u8>) -> Result<Vec<Clip>, String> {
    let table = read_parquet_bytes(content)?;
    let (ids, chunks) = (index_of(&table)?, table.integers("chunk")?);
    let valid =
        if table.has("clip_is_valid") { table.texts("clip_is_valid")? } else { vec![None; ids.len()] };
    let rows = ids.into_iter().zip(chunks).zip(valid);
    rows.enumerate()
        .map(|(i, ((id, chunk), valid))| {
            let (id, chunk) = id.zip(chunk).ok_or_else(|| format!("row {} has no id or chunk", i + 1))?;
            Ok(Clip { id, chunk, is_valid: valid.and_then(|v| v.parse().ok()) })
        })
        .collect()
}

/// What is known of how clips were recorded.
pub(super) fn collection(content: Vec<u8>) -> Result<BTreeMap<String, Collection>, String> {
    let table = read_parquet_bytes(content)?;
    let ids = index_of(&table)?;
    let texts = |name: &str| if table.has(name) { table.texts(name) } else { Ok(vec![None; ids.len()]) };
    let (countries, platforms) = (texts("country")?, texts("platform_class")?);
    let rows = ids.iter().zip(countries.into_iter().zip(platforms));
    Ok(rows
        .filter_map(|(id, (country, platform))| Some((id.clone()?, Collection { country, platform })))
        .collect())
}

/// What fills a field of a template.
enum Value<'a> {
    Number(i64),
    Text(&'a str),
}
use Value::{Number, Text};

/// `template` with `{name}` or `{name:04d}` filled, as Python's `format` does.
fn filled(template: &str, name: &str, value: &Value<'_>) -> String {
    let (mut out, mut rest) = (String::new(), template);
    while let Some(start) = rest.find(&format!("{{{name}")) {
        let Some(length) = rest[start..].find('}') else { break };
        let field = &rest[start + 1..start + length];
        let width =
            field.split_once(':').and_then(|(_, f)| f.trim_end_matches('d').parse().ok()).unwrap_or(0);
        out.push_str(&rest[..start]);
        match value {
            // The width comes from an untrusted file; 20 digits hold every number.
            Number(n) => out.push_str(&format!("{n:0width$}", width = width.min(20))),
            Text(text) => out.push_str(text),
        }
        rest = &rest[start + length + 1..];
    }
    out + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn templates_are_filled_as_python_does() {
        assert_eq!(filled("a/a.chunk_{chunk_id:04d}.zip", "chunk_id", &Number(7)), "a/a.chunk_0007.zip");
        assert_eq!(filled("{clip_id}.x.{clip_id}", "clip_id", &Text("u")), "u.x.u");
        assert_eq!(filled("{other}", "clip_id", &Text("u")), "{other}");
        assert_eq!(filled("{chunk_id:99999d}", "chunk_id", &Number(1)).len(), 20);
    }
}
