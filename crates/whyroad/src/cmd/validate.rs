//! `whyroad validate`: reads files, folders and standard input piece by piece and prints the checker's findings.

mod batch;
mod input;
mod printer;
mod quality;

use crate::output::PrintFindings;
use crate::{Global, framework_folder, output};
use batch::{Batch, Step};
use input::{How, Source, Sources};
use printer::Printer;
use std::io;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use whyroad_engine::label_drives::LabelDrives;
use whyroad_framework::check::{Document, MessageKind, Piece, Verdict, problem};
use whyroad_label::check::{Checker, ClipIndex};
use whyroad_lake::Lake;
use whyroad_mining::rule::query::{compile_query, parse_query};
use whyroad_model::{Bilingual, Diagnostic, Lang, Severity, counted};
use whyroad_signals::Catalog;

/// Arguments of `whyroad validate`.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// JSON and JSON Lines files, folders (all .json, .jsonl and .ndjson in them), or - for standard input
    #[arg(required = true, value_name = "PATH")]
    paths: Vec<PathBuf>,
    #[command(flatten)]
    print: PrintFindings,
    /// Clip metadata (JSON or JSON Lines) to check labels against: known clips, their length, rate and frames
    #[arg(long, value_name = "FILE")]
    clips: Option<PathBuf>,
    /// Lake with the drives of the labels: compares them with the recording
    #[arg(long, value_name = "DIR")]
    lake: Option<PathBuf>,
    /// Fail on warnings too
    #[arg(long)]
    deny_warnings: bool,
    /// Print a quality report of the causal texts instead of single findings: contradictions with motion and route,
    /// late evidence, omissions, by kind; for labels that `labels import` wrote from texts of other tools
    #[arg(long, requires = "lake")]
    quality: bool,
    /// Examples of each kind in the quality report
    #[arg(long, value_name = "N", default_value_t = 3, requires = "quality")]
    examples: usize,
}

/// Counts of checked documents.
#[derive(Clone, Copy, Debug, Default)]
struct Totals {
    documents: usize,
    valid: usize,
    errors: usize,
    warnings: usize,
}

/// State of one run of the command.
struct Run<'o> {
    framework: &'o whyroad_framework::Framework,
    printer: Printer<'o>,
    totals: Totals,
    /// The file that is read.
    name: String,
    /// Documents before it.
    before: usize,
    foreign: Option<Foreign>,
}

/// Verdict and findings of a document.
type Checked = (Verdict, Vec<Diagnostic>);

/// A file from a folder without any known document so far: number of documents, and the first.
struct Foreign {
    documents: usize,
    first: Option<Diagnostic>,
}

pub(crate) fn run(global: &Global, args: Args) -> anyhow::Result<ExitCode> {
    let (framework, _) = framework_folder::load(global)?;
    if let (true, Some(lake)) = (args.quality, &args.lake) {
        return quality::run(global, &framework, &args, lake);
    }
    let stdout = anstream::stdout().lock();
    let mut out = io::BufWriter::with_capacity(1 << 16, stdout);
    let printer = Printer::new(&mut out, args.print.format, global.lang);
    let mut run = Run {
        framework: &framework,
        printer,
        totals: Totals::default(),
        name: String::new(),
        before: 0,
        foreign: None,
    };
    let denied = args.deny_warnings;
    match check_all(&mut run, &framework, &args, global.lang) {
        Ok(()) => {}
        // The reader of the output has closed it.
        Err(e) if e.kind() == io::ErrorKind::BrokenPipe => return Ok(output::FINDINGS),
        Err(e) => return Err(e.into()),
    }
    let t = run.totals;
    say!("{}", summary(t, global.lang));
    let incomplete = framework_folder::is_incomplete(global);
    let findings = incomplete || t.errors > 0 || (denied && t.warnings > 0);
    Ok(if findings { output::FINDINGS } else { output::FINE })
}

fn check_all(
    run: &mut Run<'_>,
    framework: &whyroad_framework::Framework,
    args: &Args,
    lang: Lang,
) -> io::Result<()> {
    let mut checker = Checker::new(framework);
    if let Some(dir) = &args.lake {
        match Lake::open(dir) {
            Ok(lake) => {
                let drives = Arc::new(LabelDrives::new(lake, framework));
                checker = checker.with_recordings(drives).reporting_missing_drives();
            }
            Err(e) => return run.push(e.diagnostic()),
        }
    }
    if let Some(path) = &args.clips {
        let clips = read_clips(run, &checker, path)?;
        checker = checker.with_clips(clips);
    }
    // The clip list is not itself checked: its findings count, its documents do not.
    run.totals = Totals { documents: 0, valid: 0, ..run.totals };
    let mut batch = Batch::new(if args.lake.is_some() { batch::WITH_DRIVES } else { batch::ALONE });
    for source in Sources::of(&args.paths) {
        match source {
            Source::Nothing { name } => batch.push(Step::Other { name, found: empty_folder() }),
            Source::Unreadable { name, error } => {
                batch.push(Step::Other { name, found: unreadable(&error) });
            }
            Source::File { name, path, how } => {
                batch.push(Step::Begin { name, how });
                let mut failed = Ok(());
                let read = input::pieces(path.as_deref(), &mut |piece| {
                    batch.piece(&piece);
                    if batch.is_full() {
                        failed = run.batch(batch.take(), &checker);
                    }
                    failed.is_ok()
                });
                failed?;
                batch.push(Step::End(read));
            }
        }
    }
    run.batch(batch, &checker)?;
    if run.totals.documents == 0 {
        let d = Diagnostic::error(
            "label.input.nothing",
            Bilingual::new("没有任何文档可检查", "no document to check"),
        );
        run.push(d.with_hint(Bilingual::new(
            "文件夹中只读取 .json、.jsonl 和 .ndjson",
            "in folders only .json, .jsonl and .ndjson files are read",
        )))?;
    }
    let t = run.totals;
    run.printer.finish(t.documents, t.valid, t.errors, t.warnings, lang)
}

fn read_clips(run: &mut Run<'_>, checker: &Checker<'_>, path: &std::path::Path) -> io::Result<ClipIndex> {
    let mut clips = ClipIndex::default();
    let name = path.display().to_string();
    let mut failed: io::Result<()> = Ok(());
    let read = input::pieces(Some(path), &mut |piece| {
        let found = match &piece {
            Piece::Document(d) => run.document(&name, d.bytes, check(checker, d)),
            Piece::Problem(p, origin) => run.found(&name, problem(*p, origin)).map(|()| None),
        };
        failed = match (&piece, found) {
            (_, Err(e)) => Err(e),
            (Piece::Document(d), Ok(Some(v))) if !clips.add(d.bytes) && v.valid => {
                let d = Diagnostic::warning(
                    "message.kind",
                    Bilingual::new(
                        "不是 clip_metadata，不作为片段使用",
                        "no clip_metadata, so not used as a clip",
                    ),
                );
                run.found(&name, d)
            }
            _ => Ok(()),
        };
        failed.is_ok()
    });
    failed?;
    if let Err(e) = read {
        run.found(&name, unreadable(&e))?;
    }
    Ok(clips)
}

/// Errors that `whyroad mine --query` reports for a query with a valid form: unknown signals, units that do not match.
fn refused_by_mining(text: &str, name: &str, framework: &whyroad_framework::Framework) -> Vec<Diagnostic> {
    let (catalog, _) = Catalog::parse(&framework.signals_yaml);
    match parse_query(text, name, framework) {
        Ok(query) => compile_query(&query, &catalog, text, name).err().unwrap_or_default(),
        Err(found) => found,
    }
}

impl Run<'_> {
    /// Checks some of the input.
    fn batch(&mut self, batch: Batch, checker: &Checker<'_>) -> io::Result<()> {
        for (step, checked) in batch.checked(&|d| check(checker, d), |(_, found)| found.len()) {
            let name = self.name.clone();
            match (step, checked) {
                (Step::Begin { name, how }, _) => {
                    self.foreign = (how == How::InFolder).then_some(Foreign { documents: 0, first: None });
                    self.before = self.totals.documents;
                    self.name = name;
                }
                (Step::Document { bytes, .. }, Some(checked)) => {
                    self.document(&name, &bytes, checked)?;
                }
                (Step::Document { .. }, None) => {}
                (Step::Problem(p, origin), _) => self.found(&name, problem(p, &origin))?,
                (Step::End(Err(e)), _) => self.found(&name, unreadable(&e))?,
                (Step::End(Ok(())), _) => self.end(&name)?,
                (Step::Other { name, found }, _) => self.found(&name, found)?,
            }
        }
        Ok(())
    }

    /// The end of a file.
    fn end(&mut self, name: &str) -> io::Result<()> {
        if self.close_foreign(name)? || self.totals.documents != self.before {
            return Ok(());
        }
        let d = Diagnostic::warning(
            "label.input.empty",
            Bilingual::new("文件中没有文档", "the file holds no document"),
        );
        self.found(name, d)
    }

    /// Reports a document; its verdict unless it is held back.
    fn document(
        &mut self,
        name: &str,
        bytes: &[u8],
        (mut verdict, mut found): Checked,
    ) -> io::Result<Option<Verdict>> {
        if self.is_foreign(name, verdict, &mut found)? {
            return Ok(None);
        }
        // A query that mining would reject is not valid.
        if verdict.valid && verdict.kind == Some(MessageKind::MiningQuery) {
            let text = String::from_utf8_lossy(bytes);
            found.extend(refused_by_mining(&text, name, self.framework));
            verdict.valid = found.iter().all(|d| d.severity != Severity::Error);
        }
        self.totals.documents += 1;
        self.totals.valid += usize::from(verdict.valid);
        for d in found {
            self.push(d.in_file(name))?;
        }
        Ok(Some(verdict))
    }

    /// Holds back a document of no known kind while its file shows nothing else; releases it once it does.
    fn is_foreign(&mut self, name: &str, verdict: Verdict, found: &mut Vec<Diagnostic>) -> io::Result<bool> {
        let Some(foreign) = &mut self.foreign else { return Ok(false) };
        if verdict.foreign {
            foreign.documents += 1;
            let first = found.drain(..).next();
            foreign.first = foreign.first.take().or(first);
            return Ok(true);
        }
        // The file has a known document, so the others are mistakes, not foreign files.
        let Foreign { documents, first } =
            self.foreign.take().unwrap_or(Foreign { documents: 0, first: None });
        self.totals.documents += documents;
        if let Some(d) = first {
            self.push(d.in_file(name))?;
        }
        Ok(false)
    }

    /// The file has ended: reports it when nothing in it was known.
    fn close_foreign(&mut self, name: &str) -> io::Result<bool> {
        let Some(Foreign { documents: n, first: Some(_) }) = self.foreign.take() else { return Ok(false) };
        let d = Diagnostic::note(
            "label.input.foreign",
            Bilingual::new(
                format!("未检查：文件中的 {n} 个文档都不是标注或交换消息"),
                format!("not checked: of its {} none is a label or message", counted(n, "document")),
            ),
        );
        self.found(name, d)?;
        Ok(true)
    }

    fn found(&mut self, name: &str, d: Diagnostic) -> io::Result<()> {
        self.push(d.in_file(name))
    }

    fn push(&mut self, d: Diagnostic) -> io::Result<()> {
        match d.severity {
            Severity::Error => self.totals.errors += 1,
            Severity::Warning => self.totals.warnings += 1,
            Severity::Note => {}
        }
        self.printer.print(&d)
    }
}

fn check(checker: &Checker<'_>, document: &Document<'_>) -> Checked {
    let mut found = Vec::new();
    let verdict = checker.check(document, &mut found);
    (verdict, found)
}

fn unreadable(e: &io::Error) -> Diagnostic {
    Diagnostic::error(
        "label.file.unreadable",
        Bilingual::new(format!("无法读取：{e}"), format!("cannot be read: {e}")),
    )
}

fn empty_folder() -> Diagnostic {
    Diagnostic::warning(
        "label.input.empty",
        Bilingual::new(
            "文件夹中没有 .json、.jsonl 或 .ndjson 文件",
            "the folder holds no .json, .jsonl or .ndjson file",
        ),
    )
}

fn summary(t: Totals, lang: Lang) -> String {
    let findings = whyroad_model::diagnostic::summary(t.errors, t.warnings, lang);
    match lang {
        Lang::En => format!("checked {}, {} valid: {findings}", counted(t.documents, "document"), t.valid),
        Lang::Zh => format!("检查了 {} 个文档，{} 个有效：{findings}", t.documents, t.valid),
    }
}
