//! Views of a release for trainers and other tools: one file of code per format. An export never changes a release; it
//! reads samples in their order and writes what its consumer's own library reads. `docs/reference/exports.md` describes
//! every format with its source.

mod alpamayo;
mod chat;
mod huggingface;
mod images;
mod jsonl;
mod lerobot;
mod llama_factory;
mod ms_swift;
mod openlabel;
mod parquet_file;
mod qwen;
mod webdataset;

use crate::aside::empty_partial;
use crate::item::SplitName;
use crate::release::is_inside;
use crate::sample::Sample;
use crate::spec::Reference;
use crate::{DatasetError, Release};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::mpsc;
use whyroad_model::{Bilingual, Lang};

/// A format that releases are exported to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ExportFormat {
    /// One JSON object per sample, images beside them.
    Jsonl,
    /// ms-swift: SFT, DPO and GRPO files.
    MsSwift,
    /// LLaMA-Factory with `dataset_info.json`.
    LlamaFactory,
    /// Qwen-VL conversations.
    Qwen,
    /// LeRobot v3 with language columns.
    Lerobot,
    /// Hugging Face Parquet with a card.
    HuggingFace,
    /// WebDataset shards.
    WebDataset,
    /// The tree that the Alpamayo recipes read.
    Alpamayo,
    /// ASAM OpenLABEL 1.0.
    OpenLabel,
}

impl ExportFormat {
    /// All formats, in the order of the documentation.
    pub const ALL: [Self; 9] = [
        Self::Alpamayo,
        Self::MsSwift,
        Self::LlamaFactory,
        Self::Qwen,
        Self::Lerobot,
        Self::HuggingFace,
        Self::WebDataset,
        Self::OpenLabel,
        Self::Jsonl,
    ];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Jsonl => "jsonl",
            Self::MsSwift => "ms-swift",
            Self::LlamaFactory => "llama-factory",
            Self::Qwen => "qwen",
            Self::Lerobot => "lerobot",
            Self::HuggingFace => "huggingface",
            Self::WebDataset => "webdataset",
            Self::Alpamayo => "alpamayo",
            Self::OpenLabel => "openlabel",
        }
    }

    /// The format of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|f| f.name() == name)
    }
}

/// In which language traces and prompts are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TraceLanguage {
    /// Chinese; samples without a Chinese trace are left out and counted.
    Chinese,
    /// English; samples without an English trace are left out and counted.
    English,
    /// One record per language that a sample has.
    #[default]
    Both,
}

/// How to export.
#[derive(Clone, Debug, Default)]
pub struct ExportOptions {
    /// Language of traces and prompts.
    pub language: TraceLanguage,
    /// Only this split.
    pub split: Option<SplitName>,
    /// The `ffmpeg` program, where it is installed: formats that need videos encode them with it.
    pub ffmpeg: Option<PathBuf>,
}

impl ExportOptions {
    /// The splits that are exported, in their order.
    fn splits(&self) -> Vec<SplitName> {
        self.split.map_or_else(|| SplitName::ALL.to_vec(), |split| vec![split])
    }
}

/// Files and samples that an export wrote and left out.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Exported {
    /// Samples that were read.
    pub samples: usize,
    /// Records that were written (a sample may give several: one per language, one per rejected version).
    pub records: usize,
    /// Files that were written.
    pub files: usize,
    /// Samples that are not in the export, or that the consumer's loader would drop, by reason.
    pub left_out: BTreeMap<String, Vec<String>>,
    /// Notes for the user: options to set, data that the format cannot hold.
    pub notes: Vec<Bilingual>,
}

impl TraceLanguage {
    /// The languages, in the order of the records.
    pub fn languages(self) -> &'static [Lang] {
        match self {
            Self::Chinese => &[Lang::Zh],
            Self::English => &[Lang::En],
            Self::Both => &[Lang::Zh, Lang::En],
        }
    }
}

/// Reason for leaving out a sample for which [`traces`] returns nothing.
const NO_TRACE: &str = "no trace in this language";

/// A trainer would read it as an image or as the end of a message.
const TAG_IN_TEXT: &str = "a text contains a tag of trainers, such as <image>";

/// Reasons for leaving out a sample, in Chinese.
const REASONS: &[(&str, &str)] = &[
    (NO_TRACE, "没有这种语言的因果描述"),
    (TAG_IN_TEXT, "文字中含有训练框架的标签，如 <image>"),
    (
        "a pose, speed, acceleration or yaw rate of the ego is unknown",
        "自车的位姿、速度、加速度或横摆角速度未知",
    ),
    (
        "a frame's pose, speed, acceleration or yaw rate is unknown",
        "某一帧的位姿、速度、加速度或横摆角速度未知",
    ),
    ("another rate than the samples before", "频率与前面的样本不同"),
    ("images: ffmpeg is not installed", "图像：没有安装 ffmpeg"),
    ("images: ffmpeg could not encode them", "图像：ffmpeg 无法编码"),
];

/// A reason of [`Exported::left_out`] for people.
pub fn reason_text(reason: &str) -> Bilingual {
    let zh = REASONS.iter().find(|(en, _)| *en == reason).map_or(reason, |(_, zh)| *zh);
    Bilingual::new(zh, reason)
}

/// The traces of a sample in the requested languages.
fn traces(sample: &Sample, choice: TraceLanguage) -> Vec<(Lang, &str)> {
    let of = |lang: &Lang| match lang {
        Lang::Zh => Some((*lang, sample.trace_zh.as_deref()?)),
        Lang::En => Some((*lang, sample.trace_en.as_deref()?)),
    };
    choice.languages().iter().filter_map(of).collect()
}

/// The route instruction of a sample in a language.
fn route_text(sample: &Sample, lang: Lang) -> Option<&str> {
    match lang {
        Lang::Zh => sample.route_text_zh.as_deref(),
        Lang::En => sample.route_text_en.as_deref(),
    }
}

/// A number of a sample as JSON shows it: 0.1 and not 0.10000000149011612.
fn number(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(f64::from(value))
}

impl Exported {
    fn leave_out(&mut self, sample: &Sample, reason: &str) {
        self.left_out.entry(reason.to_owned()).or_default().push(sample.sample_id.clone());
    }
}

/// Writes `release` in `format` into the new folder `out`, which appears when it is complete. `progress` is called
/// after each sample.
///
/// # Errors
/// When `out` exists and is not empty, when a file cannot be written, or when the release is damaged.
pub fn export(
    release: &Release,
    format: ExportFormat,
    out: &Path,
    options: &ExportOptions,
    progress: &mut dyn FnMut(),
) -> Result<Exported, DatasetError> {
    if out.read_dir().is_ok_and(|mut entries| entries.next().is_some()) {
        return Err(DatasetError::Exists(out.to_owned()));
    }
    // The caller's folder may be a mount point, to which nothing can be renamed: it is filled in place.
    if out.exists() {
        return write(release, format, out, options, progress);
    }
    let aside = empty_partial(out)?;
    let exported = write(release, format, &aside, options, progress);
    if exported.is_ok() {
        fs::rename(&aside, out).map_err(DatasetError::io(out))?;
    }
    exported
}

/// The same into a folder that exists or is created.
fn write(
    release: &Release,
    format: ExportFormat,
    out: &Path,
    options: &ExportOptions,
    progress: &mut dyn FnMut(),
) -> Result<Exported, DatasetError> {
    fs::create_dir_all(out).map_err(DatasetError::io(out))?;
    let report = Exported::default();
    let mut output = Output {
        root: out.to_owned(),
        lines: BTreeMap::new(),
        options: options.clone(),
        reference: release.manifest.spec.sample.reference,
        report,
    };
    let mut writer: Box<dyn SampleWriter> = match format {
        ExportFormat::Jsonl => Box::new(jsonl::Writer),
        ExportFormat::MsSwift => Box::new(chat::ChatWriter(ms_swift::MsSwift::default())),
        ExportFormat::LlamaFactory => Box::new(chat::ChatWriter(llama_factory::LlamaFactory::new(release))),
        ExportFormat::Qwen => Box::new(chat::ChatWriter(qwen::Qwen)),
        ExportFormat::Lerobot => Box::new(lerobot::Writer::default()),
        ExportFormat::HuggingFace => {
            huggingface::write(release, &mut output, progress)?;
            return finish(output);
        }
        ExportFormat::WebDataset => Box::new(webdataset::Writer::new(release)),
        ExportFormat::Alpamayo => Box::new(alpamayo::Writer::default()),
        ExportFormat::OpenLabel => Box::new(openlabel::Writer::default()),
    };
    for split in options.splits() {
        each_sample(release, split, &mut |sample| {
            output.report.samples += 1;
            writer.add(sample, split, &mut output)?;
            progress();
            Ok(())
        })?;
    }
    writer.finish(&mut output)?;
    finish(output)
}

/// Calls `each` with the samples of a split in order; the next row group is decoded in parallel.
fn each_sample(
    release: &Release,
    split: SplitName,
    each: &mut dyn FnMut(Sample) -> Result<(), DatasetError>,
) -> Result<(), DatasetError> {
    std::thread::scope(|scope| {
        let (send, receive) = mpsc::sync_channel(1);
        let reading = move || {
            for samples in release.groups(Some(split)) {
                let failed = samples.is_err();
                if send.send(samples).is_err() || failed {
                    break;
                }
            }
        };
        std::thread::Builder::new().spawn_scoped(scope, reading).map_err(DatasetError::io(release.dir()))?;
        for samples in receive {
            samples?.into_iter().try_for_each(&mut *each)?;
        }
        Ok(())
    })
}

/// Closes the files and writes the summary.
fn finish(mut output: Output) -> Result<Exported, DatasetError> {
    output.finish()?;
    let path = output.root.join("export.json");
    let summary = serde_json::to_string_pretty(&output.report).map_err(|e| DatasetError::broken(&path, e))?;
    fs::write(&path, summary + "\n").map_err(DatasetError::io(&path))?;
    Ok(output.report)
}

/// A format: takes the samples one by one.
trait SampleWriter {
    fn add(&mut self, sample: Sample, split: SplitName, out: &mut Output) -> Result<(), DatasetError>;

    /// Writes the files that need all samples.
    fn finish(&mut self, out: &mut Output) -> Result<(), DatasetError> {
        let _ = out;
        Ok(())
    }
}

/// The folder of an export: files of JSON lines stay open, others are written at once.
struct Output {
    root: PathBuf,
    lines: BTreeMap<String, BufWriter<File>>,
    options: ExportOptions,
    /// The reference point that the spec asks for.
    reference: Reference,
    /// The report, which every format completes.
    report: Exported,
}

impl Output {
    /// The path of a file of the export; its folder is created. Refused if it leads out of the export: ids and formats
    /// of a release that comes from others become parts of names.
    fn path(&self, name: &str) -> Result<PathBuf, DatasetError> {
        if !is_inside(name) {
            return Err(DatasetError::broken(&self.root, format!("'{name}' leads out of the export")));
        }
        let path = self.root.join(name);
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent).map_err(DatasetError::io(parent))?;
        }
        Ok(path)
    }

    /// The name of a file within an archive of the export. Refused if a program that unpacks the archive could write it
    /// elsewhere, on any system: ids of a release that comes from others become parts of names.
    fn member<'n>(&self, name: &'n str) -> Result<&'n str, DatasetError> {
        let is_drive = name.as_bytes().get(1) == Some(&b':');
        let is_odd = name.contains(|c: char| c == '\\' || c.is_control());
        if is_inside(name) && !is_drive && !is_odd {
            return Ok(name);
        }
        Err(DatasetError::broken(&self.root, format!("{name:?} is not a name for a file of an archive")))
    }

    /// Creates a file that the caller writes.
    fn create(&mut self, name: &str) -> Result<File, DatasetError> {
        let path = self.path(name)?;
        self.report.files += 1;
        File::create(&path).map_err(DatasetError::io(&path))
    }

    /// Appends one JSON line.
    fn line(&mut self, name: &str, record: &impl Serialize) -> Result<(), DatasetError> {
        let path = self.root.join(name);
        if !self.lines.contains_key(name) {
            let file = self.create(name)?;
            self.lines.insert(name.to_owned(), BufWriter::new(file));
        }
        let text = serde_json::to_string(record).map_err(|e| DatasetError::broken(&path, e))?;
        match self.lines.get_mut(name) {
            Some(file) => writeln!(file, "{text}").map_err(DatasetError::io(&path)),
            None => Ok(()),
        }
    }

    /// Writes a whole file.
    fn write(&mut self, name: &str, content: &[u8]) -> Result<(), DatasetError> {
        let path = self.path(name)?;
        self.report.files += 1;
        fs::write(&path, content).map_err(DatasetError::io(&path))
    }

    /// Writes a whole file as indented JSON.
    fn json(&mut self, name: &str, value: &impl Serialize) -> Result<(), DatasetError> {
        let text = serde_json::to_string_pretty(value)
            .map_err(|e| DatasetError::broken(&self.root.join(name), e))?;
        self.write(name, (text + "\n").as_bytes())
    }

    fn finish(&mut self) -> Result<(), DatasetError> {
        for (name, file) in &mut self.lines {
            file.flush().map_err(DatasetError::io(&self.root.join(name)))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn output(root: &Path) -> Output {
        Output {
            root: root.to_owned(),
            lines: BTreeMap::new(),
            options: ExportOptions::default(),
            reference: Reference::RearAxle,
            report: Exported::default(),
        }
    }

    /// Names that unpacking programs follow out of their folder (Zip Slip; APPNOTE.TXT 4.4.17.1: a name must not
    /// contain a drive or device letter or a leading slash, and all slashes must be forward slashes).
    #[test]
    fn no_member_of_an_archive_leads_out_of_it() {
        let dir = tempfile::tempdir().unwrap();
        let out = output(dir.path());
        for name in [
            "",
            "/etc/x",
            "../x",
            "a/../../x",
            "..\\x",
            "a\\..\\x",
            "C:x",
            "C:/x",
            "\\\\host\\x",
            "a\0",
            "a\nb",
        ] {
            assert!(matches!(out.member(name), Err(DatasetError::Broken { .. })), "{name:?}");
        }
        for name in ["0123456789abcdef-zh.egomotion.parquet", "a/b.mp4", "事件.json"] {
            assert_eq!(out.member(name).unwrap(), name);
        }
    }

    /// A release may come from others: ids of samples and formats of pictures become parts of file names.
    #[test]
    fn no_file_of_an_export_is_outside_of_it() {
        let dir = tempfile::tempdir().unwrap();
        let root = dir.path().join("a/b/export");
        let mut out = output(&root);
        for name in ["images/a/0.x/../../../../keys", "../up.json", "/tmp/whyroad-absolute", "", "a/.."] {
            assert!(matches!(out.create(name), Err(DatasetError::Broken { .. })), "{name}");
        }
        assert!(!dir.path().join("a/keys").exists() && !dir.path().join("a/b/up.json").exists());
        out.create("images/a/0.jpg").unwrap();
        assert!(root.join("images/a/0.jpg").is_file());
    }
}
