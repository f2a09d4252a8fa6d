//! Files below a folder that no adapter takes, and what cannot be read there, with the reason: nothing is skipped
//! silently.

use crate::adapter::{AdapterRef, SkipReason, Source};
use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use whyroad_model::{Bilingual, Diagnostic};

/// Codes of this module.
pub(crate) const CODES: &[&str] =
    &["ingest.files.skipped", "ingest.file.lfs_pointer", "ingest.path.unreadable"];

/// How far below a named folder files are looked at.
const DEPTH: usize = 10;
/// Folders with more files than this are reported with a count only.
const NAMED_PER_FOLDER: usize = 8;
/// First line of a Git LFS pointer (Git LFS specification, "The Pointer").
const LFS: &[u8] = b"version https://git-lfs.github.com/spec/v1";
/// A pointer is never longer.
const LFS_MAX_BYTES: u64 = 1024;
const MEDIA: &[&str] = &["jpg", "jpeg", "png", "webp", "bmp", "mp4", "mkv", "avi", "mov", "hevc", "h264"];
const TEXTS: &[&str] =
    &["md", "txt", "rst", "pdf", "html", "log", "yaml", "yml", "toml", "py", "sh", "ipynb"];
const MAPS: &[&str] = &["xodr", "osm"];
const ARCHIVES: &[&str] = &["zip", "tar", "tgz", "7z", "rar"];

/// True for the text that Git LFS leaves in place of a file whose content was not downloaded.
fn is_lfs_pointer(path: &Path) -> bool {
    let small = path.metadata().is_ok_and(|m| m.is_file() && m.len() <= LFS_MAX_BYTES);
    let mut head = [0; LFS.len()];
    small && File::open(path).and_then(|mut f| f.read_exact(&mut head)).is_ok() && head == LFS
}

fn extension(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_lowercase()
}

/// What is at or below a path.
#[derive(Default)]
pub(crate) struct Below {
    /// Files, sorted; a hidden folder counts as one entry.
    files: Vec<PathBuf>,
    /// Folders that cannot be listed and links whose target does not exist, with the reason.
    unreadable: Vec<(PathBuf, Bilingual)>,
}

impl Below {
    /// Looks at everything at or below `path`.
    pub(crate) fn of(path: &Path) -> Self {
        let mut below = Self::default();
        below.search(path, DEPTH);
        below
    }

    fn search(&mut self, path: &Path, depth: usize) {
        if path.is_file() {
            self.files.push(path.to_owned());
            return;
        }
        let mut entries: Vec<PathBuf> = match fs::read_dir(path) {
            Ok(entries) => entries.flatten().map(|e| e.path()).collect(),
            Err(e) => return self.unreadable.push((path.to_owned(), refusal(path, &e))),
        };
        entries.sort();
        for entry in entries {
            let hidden = entry.file_name().is_some_and(|n| n.to_string_lossy().starts_with('.'));
            if hidden && entry.is_dir() || depth == 0 {
                self.files.push(entry);
            } else {
                self.search(&entry, depth - 1);
            }
        }
    }
}

/// Why a path cannot be opened.
fn refusal(path: &Path, e: &io::Error) -> Bilingual {
    if path.is_symlink() && e.kind() == io::ErrorKind::NotFound {
        return Bilingual::new("链接的目标不存在", "a link whose target does not exist");
    }
    Bilingual::new(e.to_string(), e.to_string())
}

/// What cannot be read below `path`, one diagnostic per reason. Outside of every source it may be drives, which is an
/// error; inside, the format says what its drive lacks.
pub(crate) fn unreadable(path: &Path, below: &Below, sources: &[Source]) -> Vec<Diagnostic> {
    let mut by_reason = BTreeMap::<(bool, &str), (&Bilingual, Vec<PathBuf>)>::new();
    for (at, reason) in &below.unreadable {
        let is_inside = sources.iter().any(|s| at.starts_with(&s.path));
        let key = (is_inside, reason.en.as_str());
        by_reason.entry(key).or_insert_with(|| (reason, Vec::new())).1.push(at.clone());
    }
    let found = by_reason.into_iter();
    found.map(|((is_inside, _), (reason, paths))| not_read(path, is_inside, reason, &paths)).collect()
}

fn not_read(path: &Path, is_inside: bool, reason: &Bilingual, paths: &[PathBuf]) -> Diagnostic {
    let (zh, en) = listed(path, paths);
    let message = Bilingual::new(
        format!("无法读取（{}）：{zh}", reason.zh),
        format!("cannot be read ({}): {en}", reason.en),
    );
    let make = if is_inside { Diagnostic::warning } else { Diagnostic::error };
    let at = if let [one] = paths { one } else { path };
    make("ingest.path.unreadable", message).in_file(at.display().to_string())
}

/// Takes sources whose files were not downloaded (Git LFS) out of the list, with a diagnostic each.
pub(crate) fn refuse_pointers(sources: &mut Vec<Source>) -> Vec<Diagnostic> {
    let mut pointers: BTreeMap<PathBuf, Vec<PathBuf>> = BTreeMap::new();
    for source in sources.iter() {
        if !pointers.contains_key(&source.path) {
            let mut all = Below::of(&source.path).files;
            all.extend(source.adapter.0.companions(&source.path));
            all.retain(|f| !MEDIA.contains(&extension(f).as_str()) && is_lfs_pointer(f));
            pointers.insert(source.path.clone(), all);
        }
    }
    sources.retain(|s| pointers.get(&s.path).is_none_or(Vec::is_empty));
    pointers
        .into_iter()
        .filter(|(_, files)| !files.is_empty())
        .map(|(at, files)| lfs_pointer(&at, &files))
        .collect()
}

fn lfs_pointer(source: &Path, files: &[PathBuf]) -> Diagnostic {
    let names: Vec<String> = files.iter().map(|f| f.display().to_string()).collect();
    let names = names.join(", ");
    let message = Bilingual::new(
        format!("只有 Git LFS 指针，没有内容，未导入：{names}"),
        format!("only the Git LFS pointer is here, not the content; not ingested: {names}"),
    );
    Diagnostic::error("ingest.file.lfs_pointer", message)
        .with_hint(Bilingual::new("在该仓库中运行 `git lfs pull`", "run `git lfs pull` in that repository"))
        .in_file(source.display().to_string())
}

/// What is below `path` and belongs to no source: a diagnostic per reason, with the files.
pub(crate) fn skipped(
    path: &Path,
    below: &Below,
    sources: &[Source],
    adapters: &[AdapterRef],
) -> Vec<Diagnostic> {
    if !path.is_dir() {
        return Vec::new();
    }
    let taken: BTreeSet<&Path> = sources.iter().map(|s| s.path.as_path()).collect();
    let companions: BTreeSet<PathBuf> =
        sources.iter().flat_map(|s| s.adapter.0.companions(&s.path)).collect();
    let is_taken = |f: &Path| f.ancestors().any(|a| taken.contains(a)) || companions.contains(f);
    let (mut by_reason, mut out) = (BTreeMap::<String, (SkipReason, Vec<PathBuf>)>::new(), Vec::new());
    for file in below.files.iter().filter(|f| !is_taken(f)) {
        if is_lfs_pointer(file) {
            out.push(lfs_pointer(file, std::slice::from_ref(file)));
            continue;
        }
        // Formats that look into files have not seen this one.
        if let Some(e) = File::open(file).err().filter(|_| file.is_file()) {
            out.push(not_read(path, false, &refusal(file, &e), std::slice::from_ref(file)));
            continue;
        }
        let of_adapter = adapters.iter().find_map(|a| a.0.why_skipped(file));
        let reason = of_adapter.unwrap_or_else(|| by_extension(file));
        by_reason.entry(reason.en.clone()).or_insert_with(|| (reason, Vec::new())).1.push(file.clone());
    }
    out.extend(by_reason.into_values().map(|(reason, files)| not_taken(path, &reason, &files)));
    out
}

fn by_extension(file: &Path) -> SkipReason {
    let extension = extension(file);
    let is = |list: &[&str]| list.contains(&extension.as_str());
    if file.is_dir() {
        Bilingual::new("隐藏的或过深的文件夹", "a hidden folder, or one nested too deeply")
    } else if is(MEDIA) {
        Bilingual::new(
            "图像或视频：导入行程后用 `whyroad media add` 附加",
            "image or video: attach it with `whyroad media add` after its drive is in the lake",
        )
    } else if is(ARCHIVES) {
        Bilingual::new("压缩包：请先解压", "an archive: unpack it first")
    } else if is(MAPS) {
        Bilingual::new("地图：用 `--map FILE` 给出", "a map: give it to the drives with `--map FILE`")
    } else if is(TEXTS) || extension.is_empty() || is_licence(file) {
        Bilingual::new("不是行程记录", "not a recording")
    } else {
        Bilingual::new("没有适配器读取这种文件或布局", "no adapter reads this kind of file or layout")
    }
}

/// `LICENSE.MIT`, `NOTICE.md` and the like.
fn is_licence(file: &Path) -> bool {
    let name = file.file_name().unwrap_or_default().to_string_lossy().to_uppercase();
    ["LICENSE", "LICENCE", "NOTICE", "COPYING"].iter().any(|word| name.starts_with(word))
}

fn not_taken(path: &Path, reason: &SkipReason, files: &[PathBuf]) -> Diagnostic {
    let (zh, en) = listed(path, files);
    let message = Bilingual::new(
        format!("未导入（{}）：{zh}", reason.zh),
        format!("not ingested ({}): {en}", reason.en),
    );
    Diagnostic::warning("ingest.files.skipped", message).in_file(path.display().to_string())
}

/// Names of files below `path` in both languages; of many in one folder, their number.
fn listed(path: &Path, files: &[PathBuf]) -> (String, String) {
    let mut by_folder: BTreeMap<&Path, Vec<&Path>> = BTreeMap::new();
    for file in files {
        let inside = file.strip_prefix(path).ok().filter(|p| !p.as_os_str().is_empty()).unwrap_or(file);
        by_folder.entry(inside.parent().unwrap_or(Path::new(""))).or_default().push(inside);
    }
    let (mut zh, mut en) = (Vec::new(), Vec::new());
    for (folder, files) in by_folder {
        if files.len() > NAMED_PER_FOLDER {
            let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder }.display();
            zh.push(format!("{folder}/ 中的 {} 个文件", files.len()));
            en.push(format!("{} files in {folder}/", files.len()));
        } else {
            let names = files.iter().map(|f| f.display().to_string());
            zh.extend(names.clone());
            en.extend(names);
        }
    }
    (zh.join("、"), en.join(", "))
}
