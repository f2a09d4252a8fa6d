//! `whyroad validate --quality`: one report of errors in the causal texts of a file, by kind.

use super::batch::{self, Batch, Step};
use super::input::{Source, Sources, pieces};
use super::{Args, unreadable};
use crate::output::FindingFormat;
use crate::output::reason::stop;
use crate::{Global, output};
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;
use whyroad_engine::label_drives::LabelDrives;
use whyroad_framework::Framework;
use whyroad_framework::check::Document;
use whyroad_label::check::{Checker, Quality, QualityKind};
use whyroad_lake::Lake;
use whyroad_model::messages::CocLabel;
use whyroad_model::{Diagnostic, Lang};

/// Findings of one kind.
#[derive(Default)]
struct OfKind {
    /// The texts, by their number.
    texts: BTreeSet<usize>,
    /// Findings with the place of their text.
    findings: Vec<(String, Diagnostic)>,
}

/// Findings in all texts.
#[derive(Default)]
struct Report {
    /// The file that is read.
    name: String,
    texts: usize,
    unreadable: usize,
    not_in_lake: usize,
    without_action: usize,
    clean: usize,
    kinds: BTreeMap<QualityKind, OfKind>,
    /// Texts by their origin: `tool` of the provenance's `by`, and how many of them have a finding.
    authors: BTreeMap<String, (usize, usize)>,
}

pub(super) fn run(
    global: &Global,
    framework: &Framework,
    args: &Args,
    lake: &Path,
) -> anyhow::Result<ExitCode> {
    if args.print.format == FindingFormat::Sarif {
        return Err(stop(
            "质量报告的格式只有 text 和 json",
            "the quality report has the formats text and json",
        ));
    }
    let lake = match Lake::open(lake) {
        Ok(lake) => lake,
        Err(e) => {
            tell!("{}", output::render_text(&e.diagnostic(), global.lang));
            return Ok(output::FINDINGS);
        }
    };
    let checker = Checker::new(framework).with_recordings(Arc::new(LabelDrives::new(lake, framework)));
    let mut report = Report::default();
    let mut batch = Batch::new(batch::WITH_DRIVES);
    for source in Sources::of(&args.paths) {
        let (name, path, how) = match source {
            Source::File { name, path, how } => (name, path, how),
            Source::Nothing { .. } => continue,
            Source::Unreadable { name, error } => {
                batch.push(Step::Other { name, found: unreadable(&error) });
                continue;
            }
        };
        batch.push(Step::Begin { name, how });
        let read = pieces(path.as_deref(), &mut |piece| {
            batch.piece(&piece);
            if batch.is_full() {
                report.batch(batch.take(), &checker, global.lang);
            }
            true
        });
        batch.push(Step::End(read));
    }
    report.batch(batch, &checker, global.lang);
    match args.print.format {
        FindingFormat::Json => output::put_json(&report.json(args.examples, global.lang))?,
        _ => output::put(&report.text(args.examples, global.lang)),
    }
    let found = !report.kinds.is_empty();
    Ok(match (report.texts, report.unreadable) {
        (0, _) => output::FINDINGS,
        (_, 0) if found => output::FINDINGS,
        (_, 0) => output::FINE,
        _ => output::lost_input(),
    })
}

impl Report {
    /// Adds the texts of a batch.
    fn batch(&mut self, batch: Batch, checker: &Checker<'_>, lang: Lang) {
        let check = |d: &Document<'_>| {
            let label: Option<CocLabel> = serde_json::from_slice(d.bytes).ok();
            label.map(|label| (checker.quality(&label), label))
        };
        for (step, checked) in batch.checked(&check, |c| c.as_ref().map_or(0, |(q, _)| q.findings.len())) {
            let lost = match step {
                Step::Begin { name, .. } => {
                    self.name = name;
                    continue;
                }
                Step::End(Ok(())) => continue,
                Step::End(Err(e)) => Some(unreadable(&e).in_file(self.name.clone())),
                Step::Other { name, found } => Some(found.in_file(name)),
                Step::Problem(..) => None,
                Step::Document { .. } => match checked.flatten() {
                    Some((quality, label)) => {
                        self.add(quality, label);
                        continue;
                    }
                    None => None,
                },
            };
            self.unreadable += 1;
            if let Some(d) = lost {
                tell!("{}", output::render_text(&d, lang));
            }
        }
    }

    /// Adds a text.
    fn add(&mut self, quality: Quality, label: CocLabel) {
        let number = self.texts;
        self.texts += 1;
        let place = format!("{}: {} @ {}", self.name, label.clip_id, label.keyframe.timestamp);
        self.not_in_lake += usize::from(!quality.compared);
        self.without_action += usize::from(!quality.states_action);
        self.clean += usize::from(quality.findings.is_empty());
        let by = label.provenance.and_then(|p| p.by).unwrap_or_else(|| "-".to_owned());
        let author = self.authors.entry(by).or_default();
        author.0 += 1;
        author.1 += usize::from(!quality.findings.is_empty());
        for (kind, d) in quality.findings {
            let OfKind { texts, findings: all } = self.kinds.entry(kind).or_default();
            texts.insert(number);
            all.push((place.clone(), d));
        }
    }

    fn of(&self, kind: QualityKind) -> (usize, &[(String, Diagnostic)]) {
        self.kinds.get(&kind).map_or((0, &[]), |k| (k.texts.len(), k.findings.as_slice()))
    }

    fn json(&self, examples: usize, lang: Lang) -> Value {
        let kind = |kind: QualityKind| {
            let (texts, all) = self.of(kind);
            let mut codes: BTreeMap<&str, usize> = BTreeMap::new();
            all.iter().for_each(|(_, d)| *codes.entry(d.code).or_default() += 1);
            let shown: Vec<Value> = all
                .iter()
                .take(examples)
                .map(|(place, d)| json!({ "label": place, "code": d.code, "message": d.message(lang) }))
                .collect();
            json!({ "kind": kind.id(), "texts": texts, "findings": all.len(), "codes": codes, "examples": shown })
        };
        let authors: BTreeMap<&String, Value> = self
            .authors
            .iter()
            .map(|(by, (texts, with))| (by, json!({ "texts": texts, "with_findings": with })))
            .collect();
        json!({
            "texts": self.texts, "without_findings": self.clean, "not_in_lake": self.not_in_lake,
            "without_action": self.without_action, "unreadable": self.unreadable,
            "kinds": QualityKind::ALL.map(kind), "authors": authors,
        })
    }

    fn text(&self, examples: usize, lang: Lang) -> String {
        let Self { texts, clean, not_in_lake, without_action, unreadable, .. } = self;
        let mut out = String::new();
        let _ = match lang {
            Lang::Zh => writeln!(
                out,
                "{texts} 条因果文本，{clean} 条没有问题；{not_in_lake} 条的行程不在数据湖中，未与记录对照；{without_action} 条没有说自车做什么；{unreadable} 处无法读取\n"
            ),
            Lang::En => writeln!(
                out,
                "{texts} causal texts, {clean} without findings; {not_in_lake} not compared, because their drive is not in the lake; {without_action} state no action of the ego; {unreadable} not readable\n"
            ),
        };
        for kind in QualityKind::ALL {
            let (n, all) = self.of(kind);
            let share = if *texts == 0 { 0.0 } else { 100.0 * n as f64 / *texts as f64 };
            let name = kind.name();
            let _ = writeln!(out, "{:<16} {n:>5}  {share:>5.1} %  {}", kind.id(), name.get(lang));
            for (place, d) in all.iter().take(examples) {
                let _ = writeln!(out, "    {place}\n      {}", d.message(lang));
            }
        }
        if self.authors.len() > 1 {
            out.push('\n');
            for (by, (n, with)) in &self.authors {
                let _ = match lang {
                    Lang::Zh => writeln!(out, "{by}：{n} 条，{with} 条有问题"),
                    Lang::En => writeln!(out, "{by}: {n} texts, {with} with findings"),
                };
            }
        }
        out
    }
}
