//! The files of a framework folder as bytes: those that are text, and findings about the others, so that one file in
//! another encoding costs what it holds and nothing else.

use super::Framework;
use std::collections::BTreeMap;
use whyroad_model::{Bilingual, Diagnostic, Location};

/// The files of a framework folder.
#[derive(Clone, Debug, Default)]
pub struct FrameworkFiles {
    /// Texts by relative path (`schema/...yaml`, `scenarios/...yaml`, `prompts/...yaml`).
    pub texts: BTreeMap<String, String>,
    /// One finding for each file that is not UTF-8; it is not among `texts`.
    pub not_text: Vec<Diagnostic>,
}

impl FrameworkFiles {
    /// The files that are built into this program.
    pub fn bundled() -> Self {
        Self { texts: Framework::bundled_files(), not_text: Vec::new() }
    }

    /// Adds a file.
    pub fn add(&mut self, path: String, bytes: Vec<u8>) {
        match utf8_text(&path, bytes) {
            Ok(text) => drop(self.texts.insert(path, text)),
            Err(finding) => self.not_text.push(*finding),
        }
    }

    /// The framework, with all errors: [`Framework::from_files`], but a file that is not text is not also missing.
    pub fn load(&self) -> (Option<Framework>, Vec<Diagnostic>) {
        let (framework, found) = Framework::from_files(&self.texts);
        let is_there = |d: &Diagnostic| self.not_text.iter().any(|n| n.location.file == d.location.file);
        let is_repeated = |d: &Diagnostic| d.code.ends_with(".file.missing") && is_there(d);
        let others = found.into_iter().filter(|d| !is_repeated(d));
        (framework, self.not_text.iter().cloned().chain(others).collect())
    }
}

/// The content of a file as text.
///
/// # Errors
/// The finding for a file that is not UTF-8, at its first wrong byte.
pub fn utf8_text(file: &str, bytes: Vec<u8>) -> Result<String, Box<Diagnostic>> {
    String::from_utf8(bytes).map_err(|e| {
        let at = e.utf8_error().valid_up_to();
        let byte = e.as_bytes()[at];
        let good = String::from_utf8_lossy(&e.as_bytes()[..at]).into_owned();
        let line = good.rsplit('\n').next().unwrap_or_default().trim_start_matches('\u{feff}');
        let message = Bilingual::new(
            format!("文件不是 UTF-8 文本：第 {} 字节（0x{byte:02X}）不合法；整个文件未使用", at + 1),
            format!(
                "the file is not UTF-8 text: byte {} (0x{byte:02X}) is invalid; the file is not used",
                at + 1
            ),
        );
        let hint = Bilingual::new(
            "在编辑器中另存为 UTF-8；Windows 上常见的编码是 GB18030（GBK、ANSI）",
            "save it as UTF-8 in your editor; on Chinese Windows the encoding is often GB18030 (GBK, ANSI)",
        );
        let location = Location {
            file: Some(file.to_owned()),
            line: Some(good.matches('\n').count() + 1),
            column: Some(line.chars().count() + 1),
            snippet: Some(line.to_owned()),
            span: 1,
            ..Location::default()
        };
        Box::new(Diagnostic::error("framework.encoding", message).with_hint(hint).at(location))
    })
}
