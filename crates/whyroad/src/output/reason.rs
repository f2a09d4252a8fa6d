//! Why a command stopped, and its current step, in both languages: errors of the binary's own that `anyhow` keeps and
//! `main` prints. Findings about the user's data are diagnostics, not these.

use std::fmt;
use std::io;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use whyroad_dataset::DatasetError;
use whyroad_lake::LakeError;
use whyroad_lake::storage::StorageUrl;
use whyroad_model::{Bilingual, Diagnostic, Lang};

/// Set once, before the command line is parsed: `anyhow` displays errors without a language parameter.
static ENGLISH: AtomicBool = AtomicBool::new(true);

/// Sets the language of reasons for the whole run.
pub(crate) fn set_lang(lang: Lang) {
    ENGLISH.store(lang == Lang::En, Ordering::Relaxed);
}

/// An error, or the context of one, shown in the user's language.
#[derive(Debug)]
pub(crate) struct Reason(Bilingual);

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.0.get(if ENGLISH.load(Ordering::Relaxed) { Lang::En } else { Lang::Zh }))
    }
}

/// Also the error of an option's value.
impl std::error::Error for Reason {}

impl From<Bilingual> for Reason {
    fn from(text: Bilingual) -> Self {
        Self(text)
    }
}

/// An error with its causes in the user's language: that of a [`Reason`], of a lake, of the operating system; the texts
/// of libraries stay English.
pub(crate) fn told(error: &anyhow::Error, lang: Lang) -> String {
    if lang == Lang::En {
        let mut out = String::new();
        for cause in error.chain().map(ToString::to_string) {
            // Errors of libraries repeat their cause.
            if !out.ends_with(&cause) {
                out = if out.is_empty() { cause } else { format!("{out}: {cause}") };
            }
        }
        return out;
    }
    let mut out: Vec<String> = Vec::new();
    for cause in error.chain() {
        if let Some(of_lake) = cause.downcast_ref::<LakeError>() {
            out.push(of_diagnostic(&of_lake.diagnostic()));
            // Its message holds its causes.
            break;
        }
        if let Some(of_release) = cause.downcast_ref::<DatasetError>()
            && let Some(first) = of_release.diagnostics().first()
        {
            out.push(of_diagnostic(first));
            break;
        }
        if let Some(e) = cause.downcast_ref::<io::Error>() {
            // Errors of libraries repeat their cause.
            if let Some(before) = out.last_mut() {
                *before = before.trim_end_matches(&e.to_string()).trim_end_matches(": ").to_owned();
            }
            out.push(of_system(e));
            continue;
        }
        out.push(cause.to_string());
    }
    out.retain(|text| !text.is_empty());
    out.join("：")
}

fn of_diagnostic(d: &Diagnostic) -> String {
    let at = d.location.file.as_ref().filter(|file| !d.message.zh.contains(file.as_str()));
    let hint = d.hint.as_ref().map(|hint| format!("；{}", hint.zh)).unwrap_or_default();
    format!("{}{}{hint}", at.map(|file| format!("{file}：")).unwrap_or_default(), d.message.zh)
}

fn of_system(e: &io::Error) -> String {
    let text = match e.kind() {
        io::ErrorKind::NotFound => "没有这个文件或文件夹",
        io::ErrorKind::PermissionDenied => "没有权限",
        io::ErrorKind::IsADirectory => "是文件夹，不是文件",
        io::ErrorKind::NotADirectory => "不是文件夹",
        io::ErrorKind::StorageFull => "磁盘已满",
        io::ErrorKind::ReadOnlyFilesystem => "文件系统只读",
        io::ErrorKind::InvalidData if e.to_string().contains("valid UTF-8") => "内容不是 UTF-8 文本",
        _ => return e.to_string(),
    };
    match e.raw_os_error() {
        Some(code) => format!("{text}（os error {code}）"),
        None => text.to_owned(),
    }
}

/// A reason, Chinese first.
pub(crate) fn reason(zh: impl Into<String>, en: impl Into<String>) -> Reason {
    Reason(Bilingual::new(zh, en))
}

/// Refuses the URL of an object store where a command reads or writes folders only.
pub(crate) fn folders_only<'a>(paths: impl IntoIterator<Item = &'a PathBuf>) -> anyhow::Result<()> {
    let Some(path) = paths.into_iter().find(|p| StorageUrl::of(p).is_some()) else { return Ok(()) };
    // It may hold a secret if it is not a valid one.
    let shown = StorageUrl::of(path).and_then(Result::ok).map_or_else(String::new, |url| format!("{url}: "));
    Err(stop(
        format!(
            "{shown}此处只能用文件夹；数据湖（--lake）与 `serve --media` 可用 URL。请先复制，例如 `aws s3 sync URL DIR`"
        ),
        format!(
            "{shown}a folder is needed here; only a lake (--lake) and `serve --media` can be a URL. Copy it first, \
             for example with `aws s3 sync URL DIR`"
        ),
    ))
}

/// A list of the values that an option can have.
pub(crate) fn possible_values(values: &[&str]) -> Reason {
    reason(format!("可用的值：{}", values.join("、")), format!("possible values: {}", values.join(", ")))
}

/// Ends a command with a reason.
pub(crate) fn stop(zh: impl Into<String>, en: impl Into<String>) -> anyhow::Error {
    anyhow::anyhow!(reason(zh, en))
}

/// A file or folder cannot be read.
pub(crate) fn cannot_read(what: impl fmt::Display) -> Reason {
    reason(format!("无法读取 {what}"), format!("cannot read {what}"))
}

/// A file cannot be written.
pub(crate) fn cannot_write(what: impl fmt::Display) -> Reason {
    reason(format!("无法写入 {what}"), format!("cannot write {what}"))
}

/// A folder cannot be made.
pub(crate) fn cannot_make(what: impl fmt::Display) -> Reason {
    reason(format!("无法创建 {what}"), format!("cannot make {what}"))
}

/// A class that the taxonomy does not have.
pub(crate) fn no_class(text: impl fmt::Display) -> anyhow::Error {
    stop(
        format!("没有场景分类“{text}”；`whyroad taxonomy list` 列出所有分类"),
        format!("class '{text}' not found; `whyroad taxonomy list` shows all classes"),
    )
}

/// A file that would be overwritten.
pub(crate) fn exists(what: impl fmt::Display) -> anyhow::Error {
    stop(format!("{what} 已存在"), format!("{what} already exists"))
}

/// A project that the store does not have.
pub(crate) fn no_project(name: &str, existing: &[&str]) -> anyhow::Error {
    stop(
        format!("没有项目“{name}”；现有：{}", existing.join("、")),
        format!("no project '{name}'; existing: {}", existing.join(", ")),
    )
}

/// A folder without a framework that can be used.
pub(crate) fn no_framework(what: impl fmt::Display) -> Reason {
    reason(format!("{what} 中没有可用的框架"), format!("{what} holds no usable framework"))
}

/// An address on which the service cannot listen.
pub(crate) fn cannot_listen(at: impl fmt::Display) -> Reason {
    reason(format!("无法在 {at} 监听"), format!("cannot listen on {at}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use anyhow::Context as _;

    #[test]
    fn causes_are_told_in_chinese_too() {
        let lake: Result<(), _> = Err(LakeError::NotALake("drives".into()));
        let error = lake.with_context(|| reason("无法读取 drives", "cannot read drives")).unwrap_err();
        let zh = told(&error, Lang::Zh);
        assert!(zh.contains("drives 不是数据湖：缺少 whyroad-lake.json；先用"), "{zh}");
        assert!(told(&error, Lang::En).ends_with("drives is not a lake: it has no whyroad-lake.json"));
        let file = std::fs::read("no such file").map_err(anyhow::Error::from).unwrap_err();
        assert_eq!(told(&file, Lang::Zh), "没有这个文件或文件夹（os error 2）");
        let text = format!("cannot write x: {}", file.root_cause());
        let twice = file.context(text);
        assert_eq!(told(&twice, Lang::Zh), "cannot write x：没有这个文件或文件夹（os error 2）");
        assert_eq!(told(&twice, Lang::En), "cannot write x: No such file or directory (os error 2)");
    }
}
