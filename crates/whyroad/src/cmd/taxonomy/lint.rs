//! `whyroad taxonomy lint`.

use crate::output::FindingFormat;
use crate::output::reason::{cannot_read, stop};
use crate::{Global, framework_folder, output};
use anyhow::Context as _;
use std::path::Path;
use std::process::ExitCode;
use whyroad_framework::calibration::{CALIBRATION_FILE, Calibration};
use whyroad_framework::framework::utf8_text;
use whyroad_framework::markdown::lint_markdown;
use whyroad_framework::taxonomy::read_taxonomy;
use whyroad_framework::{Framework, FrameworkFiles};
use whyroad_mining::cases::CaseRunner;
use whyroad_mining::{RuleSet, rule};
use whyroad_model::diagnostic::{self, Severity};
use whyroad_model::{Bilingual, Diagnostic, Lang};
use whyroad_signals::Catalog;

pub(super) fn run(global: &Global, file: Option<&Path>, format: FindingFormat) -> anyhow::Result<ExitCode> {
    let found = match file {
        None => framework(global)?,
        Some(path) => {
            let bytes = std::fs::read(path).with_context(|| cannot_read(path.display()))?;
            let name = path.display().to_string();
            let text = match utf8_text(&name, bytes) {
                Ok(text) => text,
                Err(finding) => {
                    print(&[*finding], format, global.lang);
                    return Ok(output::FINDINGS);
                }
            };
            match path.extension().and_then(|e| e.to_str()) {
                Some("md") => lint_markdown(&name, &text, Some(&framework_folder::load(global)?.0.taxonomy)),
                Some("yaml" | "yml") => read_taxonomy(&name, &text).1,
                _ => {
                    return Err(stop(
                        format!("{} 既不是 .yaml 也不是 .md", path.display()),
                        format!("{} is neither .yaml nor .md", path.display()),
                    ));
                }
            }
        }
    };
    print(&found, format, global.lang);
    let clean = found.iter().all(|d| d.severity == Severity::Note);
    Ok(if clean { output::FINE } else { output::FINDINGS })
}

fn framework(global: &Global) -> anyhow::Result<Vec<Diagnostic>> {
    let dir = global.framework.as_deref();
    let files = match dir {
        Some(dir) => framework_folder::read_folder(dir)?,
        None => FrameworkFiles::bundled(),
    };
    let (framework, mut found) = files.load();
    let mut cases = 0;
    if let Some(f) = &framework {
        let (catalog, of_signals) = Catalog::parse(&f.signals_yaml);
        found.extend(of_signals);
        found.extend(rule::lint::lint(f, &catalog));
        found.extend(calibrated_but_unknown(f, files.texts.get(CALIBRATION_FILE)));
        let (rules, _) = RuleSet::of_framework(f, &catalog);
        let errors = found.iter().filter(|d| d.severity == Severity::Error);
        let faulty = errors.filter_map(|d| d.location.file.clone()).chain(rules.files_left_out(f)).collect();
        let mut tally =
            CaseRunner { rules: &rules, catalog: &catalog, faulty: &faulty }.run_all(&files.texts);
        cases = tally.cases.values().sum();
        tally.unread.extend(files.not_text.iter().filter_map(|d| d.location.file.clone()));
        found.extend(tally.missing(&rules, f));
        found.extend(tally.failures);
    }
    let found = framework_folder::placed(dir, found);
    if found.is_empty()
        && let Some(f) = framework
    {
        let (l1, l2, l3) = f.taxonomy.counts();
        let (version, specs, rules) = (&f.taxonomy.version, f.specs.len(), f.rules.len());
        match global.lang {
            Lang::En => say!(
                "taxonomy {version}: {l1} L1, {l2} L2, {l3} L3; {specs} labeling specs, {rules} mining rules, {cases} cases"
            ),
            Lang::Zh => say!(
                "分类体系 {version}：{l1} 个 L1，{l2} 个 L2，{l3} 个 L3；{specs} 份标注规格，{rules} 条挖掘规则，{cases} 个用例"
            ),
        }
    }
    Ok(found)
}

/// Classes of the calibration table that the taxonomy does not have: renamed or retired ones.
fn calibrated_but_unknown(framework: &Framework, text: Option<&String>) -> Vec<Diagnostic> {
    let unknown = framework.calibration.classes.iter().filter(|c| !framework.taxonomy.contains(&c.id));
    let each = unknown.map(|class| {
        let id = &class.id;
        let message = Bilingual::new(
            format!("分类体系中没有类别 '{id}'，其校准不起作用"),
            format!("the taxonomy has no class '{id}', so its calibration has no effect"),
        );
        let hint = Bilingual::new(
            "类别改名的，在此处同样改名；类别取消的，删除该条目",
            "where the class was renamed, rename it here too; where it was retired, delete its entry",
        );
        let d = Diagnostic::warning("calibration.class", message).with_hint(hint).in_file(CALIBRATION_FILE);
        let at = text.and_then(|text| Calibration::place(CALIBRATION_FILE, text, id));
        at.into_iter().fold(d, Diagnostic::at)
    });
    each.collect()
}

pub(crate) fn print(found: &[Diagnostic], format: FindingFormat, lang: Lang) {
    match format {
        FindingFormat::Json => output::put(&format!("{:#}\n", diagnostic::render_json(found, lang))),
        FindingFormat::Sarif => output::put(&format!("{:#}\n", diagnostic::render_sarif(found, lang))),
        FindingFormat::Text => {
            let found = &folded(found);
            let texts: Vec<String> = found.iter().map(|d| output::render_text(d, lang)).collect();
            output::put(&texts.join("\n"));
            let count = |s: Severity| found.iter().filter(|d| d.severity == s).count();
            say!("{}", diagnostic::summary(count(Severity::Error), count(Severity::Warning), lang));
        }
    }
}

/// Maximum number of places that a finding names.
const PLACES: usize = 3;

/// One finding for all that say the same of different places, as of a class that many files name: the first place, and
/// the others in its message. For people; programs get each.
fn folded(found: &[Diagnostic]) -> Vec<Diagnostic> {
    let mut out: Vec<(Diagnostic, Vec<String>)> = Vec::new();
    for d in found {
        let says = |o: &Diagnostic| {
            (o.code, o.severity, &o.message, &o.hint) == (d.code, d.severity, &d.message, &d.hint)
        };
        let place = || {
            let file = d.location.file.as_deref().unwrap_or_default();
            d.location.line.map_or_else(|| file.to_owned(), |line| format!("{file}:{line}"))
        };
        match out.iter_mut().find(|(first, _)| says(first)) {
            Some((_, others)) => others.push(place()),
            None => out.push((d.clone(), Vec::new())),
        }
    }
    let with_places = |(d, others): (Diagnostic, Vec<String>)| {
        let n = others.len();
        if n == 0 {
            return d;
        }
        let named = others.iter().take(PLACES).cloned().collect::<Vec<_>>().join(", ");
        let more = if n > PLACES { ", ..." } else { "" };
        let message = Bilingual::new(
            format!("{}（另有 {n} 处：{named}{more}）", d.message.zh),
            format!("{} (and at {n} more: {named}{more})", d.message.en),
        );
        Diagnostic { message, ..d }
    };
    out.into_iter().map(with_places).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use whyroad_model::Location;

    #[test]
    fn what_is_said_of_many_places_is_said_once() {
        let at = |code, message: &str, line| {
            let place = Location { file: Some("f.yaml".into()), line: Some(line), ..Location::default() };
            Diagnostic::error(code, Bilingual::same(message)).at(place)
        };
        let found = [at("a", "x", 3), at("b", "x", 4), at("a", "x", 5), at("a", "y", 6), at("a", "x", 7)];
        let shown = folded(&found);
        let messages: Vec<&str> = shown.iter().map(|d| d.message.en.as_str()).collect();
        assert_eq!(messages, ["x (and at 2 more: f.yaml:5, f.yaml:7)", "x", "y"]);
        assert_eq!(shown[0].location.line, Some(3));
    }
}
