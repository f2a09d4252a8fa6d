//! `whyroad taxonomy list`.

use super::ListingFormat;
use crate::{Global, framework_folder, output};
use std::fmt::Write as _;
use std::process::ExitCode;
use whyroad_framework::Framework;
use whyroad_framework::listing::{Row, rows};
use whyroad_framework::taxonomy::{class_not_found, did_you_mean};
use whyroad_model::{Diagnostic, Lang, diagnostic, yaml};

pub(super) fn run(global: &Global, l1: Option<&str>, format: ListingFormat) -> anyhow::Result<ExitCode> {
    let (framework, found) = framework_folder::load(global)?;
    if let Some(id) = l1.filter(|id| framework.taxonomy.l1(id).is_none()) {
        let near = did_you_mean(id, framework.taxonomy.l1.iter().map(|a| a.id.as_str()));
        let near: Vec<String> = match near {
            Some(one) => vec![one.to_owned()],
            None => framework.taxonomy.l1.iter().map(|a| a.id.clone()).collect(),
        };
        tell!("{}", output::render_text(&class_not_found(id, &near), global.lang));
        return Ok(output::FINDINGS);
    }
    let rows = rows(&framework, l1);
    match format {
        ListingFormat::Json => output::put_json(&rows)?,
        ListingFormat::Yaml => output::put(&yaml::to_string(&rows)?),
        ListingFormat::Text => output::put(&text(&framework, &rows, global.lang)),
    }
    Ok(exit_code(&found))
}

/// 3 when the current framework has errors: the output may be incomplete.
pub(super) fn exit_code(found: &[Diagnostic]) -> ExitCode {
    let lost = found.iter().any(|d| d.severity == diagnostic::Severity::Error);
    if lost { output::lost_input() } else { output::FINE }
}

fn text(framework: &Framework, rows: &[Row], lang: Lang) -> String {
    let mut out = String::new();
    let below = |id: &str, level: &str| {
        let prefix = format!("{id}.");
        rows.iter().filter(|r| r.level == level && r.id.starts_with(&prefix)).count()
    };
    for r in rows {
        let short = r.id.rsplit('.').next().unwrap_or(&r.id);
        let name = pick(lang, &r.name_zh, &r.name_en);
        let _ = match r.level {
            "l1" => writeln!(out, "{short}  {name}  [{} L2, {} L3]", below(&r.id, "l2"), below(&r.id, "l3")),
            "l2" => writeln!(out, "  {short}  {name}  [{}]", below(&r.id, "l3")),
            _ => {
                let width =
                    rows.iter().filter(|s| s.parent == r.parent).map(|s| s.id.len()).max().unwrap_or(0);
                let width = width - (r.id.len() - short.len());
                let condition = pick(
                    lang,
                    r.condition_zh.as_deref().unwrap_or(""),
                    r.condition_en.as_deref().unwrap_or(""),
                );
                let colon = if lang == Lang::Zh { "：" } else { ": " };
                writeln!(out, "    {short:width$}  {name}{colon}{condition}")
            }
        };
    }
    let count = |level: &str| rows.iter().filter(|r| r.level == level).count();
    let (l1, l2, l3) = (count("l1"), count("l2"), count("l3"));
    let _ = match lang {
        Lang::En => writeln!(out, "\n{l1} L1, {l2} L2, {l3} L3 (taxonomy {})", framework.taxonomy.version),
        Lang::Zh => {
            writeln!(out, "\n{l1} 个 L1，{l2} 个 L2，{l3} 个 L3（分类体系 {}）", framework.taxonomy.version)
        }
    };
    out
}

pub(super) fn pick<'a>(lang: Lang, zh: &'a str, en: &'a str) -> &'a str {
    match lang {
        Lang::Zh => zh,
        Lang::En => en,
    }
}
