//! `whyroad dataset export`: a view of a release for a trainer or another tool.

use super::refused;
use crate::output::DataFormat;
use crate::output::reason::stop;
use crate::{Global, output};
use std::path::PathBuf;
use std::process::{Command, ExitCode, Stdio};
use whyroad_dataset::export::{ExportFormat, ExportOptions, Exported, TraceLanguage, export, reason_text};
use whyroad_dataset::{Release, SplitName};
use whyroad_model::Lang;

/// Arguments of `whyroad dataset export`.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Format
    #[arg(value_name = "FORMAT", value_parser = format_names())]
    to: String,
    /// The release
    #[arg(value_name = "RELEASE")]
    release: PathBuf,
    /// Folder for the export; must be missing or empty
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Language of traces and prompts; `both` writes one record per language
    #[arg(long, value_name = "LANG", default_value = "both", value_parser = ["zh", "en", "both"])]
    traces: String,
    /// Only this split
    #[arg(long, value_name = "SPLIT", value_parser = ["train", "val", "test"])]
    split: Option<String>,
    /// How to print the summary
    #[arg(long, value_enum, default_value = "text")]
    format: DataFormat,
}

fn format_names() -> Vec<&'static str> {
    ExportFormat::ALL.map(ExportFormat::name).to_vec()
}

pub(super) fn run(global: &Global, a: &Args) -> anyhow::Result<ExitCode> {
    let Some(to) = ExportFormat::from_name(&a.to) else {
        return Err(stop(format!("“{}”不是导出格式", a.to), format!("'{}' is not an export format", a.to)));
    };
    let release = match Release::open(&a.release) {
        Ok(release) => release,
        Err(e) => return Ok(refused(global, &e)),
    };
    let options = ExportOptions {
        language: match a.traces.as_str() {
            "zh" => TraceLanguage::Chinese,
            "en" => TraceLanguage::English,
            _ => TraceLanguage::Both,
        },
        split: a.split.as_deref().and_then(SplitName::of_name),
        // Only this format has videos.
        ffmpeg: (to == ExportFormat::Alpamayo).then(ffmpeg).flatten(),
    };
    let bar = output::progress(release.manifest.counts.samples);
    let exported = export(&release, to, &a.out, &options, &mut || bar.inc(1));
    bar.finish_and_clear();
    match exported {
        Ok(exported) => {
            output::put(&match a.format {
                DataFormat::Json => format!("{:#}\n", serde_json::to_value(&exported)?),
                DataFormat::Text => text(&exported, global.lang),
            });
            Ok(output::FINE)
        }
        Err(e) => Ok(refused(global, &e)),
    }
}

/// The machine's ffmpeg, where it is installed.
fn ffmpeg() -> Option<PathBuf> {
    let program = PathBuf::from("ffmpeg");
    let found = Command::new(&program).arg("-version").stdout(Stdio::null()).stderr(Stdio::null()).status();
    found.is_ok_and(|s| s.success()).then_some(program)
}

fn text(e: &Exported, lang: Lang) -> String {
    let mut out = match lang {
        Lang::Zh => format!("{} 个样本，{} 条记录，{} 个文件\n", e.samples, e.records, e.files),
        Lang::En => format!("{} samples, {} records, {} files\n", e.samples, e.records, e.files),
    };
    for (reason, samples) in &e.left_out {
        out += &match lang {
            Lang::Zh => {
                format!("未导出 {} 个：{}（export.json 列出编号）\n", samples.len(), reason_text(reason).zh)
            }
            Lang::En => format!("{} left out: {reason} (ids in export.json)\n", samples.len()),
        };
    }
    for note in &e.notes {
        out += &format!("{}\n", note.get(lang));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use whyroad_model::Bilingual;

    #[test]
    fn notes_and_reasons_are_in_the_language_of_the_reader() {
        let exported = Exported {
            left_out: [("another rate than the samples before".to_owned(), vec!["s1".to_owned()])].into(),
            notes: vec![Bilingual::new("未来不足 6.4 s", "less than 6.4 s of future")],
            ..Exported::default()
        };
        let zh = text(&exported, Lang::Zh);
        assert!(zh.contains("频率与前面的样本不同") && zh.contains("未来不足 6.4 s"), "{zh}");
        assert!(!zh.contains("rate") && !zh.contains("future"), "{zh}");
        let en = text(&exported, Lang::En);
        assert!(en.contains("another rate") && en.contains("less than 6.4 s of future"), "{en}");
    }
}
