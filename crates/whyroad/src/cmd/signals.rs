//! `whyroad signals`: the catalog of signals that rules can use.

use crate::output::{Print, render_text};
use crate::{Global, framework_folder, output};
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use whyroad_engine::mine::derive_signals;
use whyroad_lake::Lake;
use whyroad_model::{Bilingual, Diagnostic, Lang, Need};
use whyroad_signals::catalog::{Catalog, SignalDef, SignalKind, SignalScope};

/// Arguments of `whyroad signals`.
#[derive(clap::Args)]
pub(crate) struct Args {
    #[command(subcommand)]
    command: SignalsCommand,
}

#[derive(clap::Subcommand)]
enum SignalsCommand {
    /// List all signals: name, type, unit, what they need from a log
    List {
        #[command(flatten)]
        print: Print,
    },
    /// Show one signal, by name or alias
    Show {
        /// Name or alias: target.gap, ttc, target_vehicle.lateral_offset
        name: String,
        #[command(flatten)]
        print: Print,
    },
    /// Derive the signals of all drives of a lake and store them beside the drives, as `mine` does
    Derive {
        /// The lake
        #[arg(long, value_name = "DIR")]
        lake: PathBuf,
        /// Drives processed at once (default: all cores)
        #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
        jobs: Option<u16>,
    },
}

pub(crate) fn run(global: &Global, args: Args) -> anyhow::Result<ExitCode> {
    if let SignalsCommand::Derive { lake, jobs } = &args.command {
        return Ok(derive(lake, jobs.map(usize::from), global.lang));
    }
    let (framework, found) = framework_folder::load(global)?;
    let (catalog, _) = Catalog::parse(&framework.signals_yaml);
    let code = if found.is_empty() { output::FINE } else { output::FINDINGS };
    match args.command {
        SignalsCommand::List { print } => {
            let all: Vec<Value> = catalog.iter().map(as_json).collect();
            print.put(&all, || table(&catalog, global.lang))?;
        }
        SignalsCommand::Show { name, print } => {
            let Some((signal, _)) = catalog.resolve(&name) else {
                tell!("{}", render_text(&unknown(&catalog, &name), global.lang));
                return Ok(output::FINDINGS);
            };
            print.put(&as_json(signal), || page(signal, global.lang))?;
        }
        SignalsCommand::Derive { .. } => {}
    }
    Ok(code)
}

fn derive(lake: &Path, jobs: Option<usize>, lang: Lang) -> ExitCode {
    let lake = match Lake::open(lake) {
        Ok(lake) => lake,
        Err(e) => {
            tell!("{}", render_text(&e.diagnostic(), lang));
            return output::FINDINGS;
        }
    };
    let drives = lake.drive_ids().len();
    let bar = output::progress(drives);
    let (derived, found) = derive_signals(&lake, jobs, |id| {
        bar.set_message(id.to_string());
        bar.inc(1);
    });
    bar.finish_and_clear();
    for d in &found {
        tell!("{}", render_text(d, lang));
    }
    match lang {
        Lang::Zh => say!("{drives} 个行程，其中 {derived} 个新推导了信号"),
        Lang::En => say!("{drives} drives, signals derived for {derived}"),
    }
    if found.is_empty() { output::FINE } else { output::lost_input() }
}

fn unknown(catalog: &Catalog, name: &str) -> Diagnostic {
    let message = Bilingual::new(format!("没有信号 '{name}'"), format!("signal '{name}' not found"));
    let near = catalog.similar(name).join(", ");
    let hint = if near.is_empty() {
        Bilingual::new("用 whyroad signals list 查看全部信号", "whyroad signals list shows them all")
    } else {
        Bilingual::new(format!("是否指 {near}？"), format!("did you mean {near}?"))
    };
    Diagnostic::error("rule.signal.unknown", message).with_hint(hint)
}

fn kind_name(signal: &SignalDef) -> &'static str {
    match signal.kind {
        SignalKind::Number(_) => "number",
        SignalKind::Flag => "flag",
        SignalKind::Category(_) => "category",
    }
}

fn as_json(signal: &SignalDef) -> Value {
    let names = match &signal.kind {
        SignalKind::Category(names) => json!(names.as_ref()),
        _ => Value::Null,
    };
    json!({
        "name": signal.name,
        "aliases": signal.aliases,
        "scope": signal.scope.word(),
        "type": kind_name(signal),
        "values": names,
        "unit": signal.unit_symbol(),
        "meaning": signal.meaning,
        "needs": signal.needs,
        "source": signal.source,
        "scale": signal.scale,
    })
}

fn table(catalog: &Catalog, lang: Lang) -> String {
    let mut out = String::new();
    for s in catalog.iter() {
        let unit = if s.unit_symbol().is_empty() { kind_name(s) } else { s.unit_symbol() };
        let _ = writeln!(out, "{:<30} {:<9} {}", s.name, unit, first_sentence(s.meaning.get(lang)));
    }
    out
}

/// Up to the first full stop that ends a sentence.
fn first_sentence(text: &str) -> &str {
    let english = text.find(". ").map(|i| i + 1);
    let chinese = text.find('。').map(|i| i + '。'.len_utf8());
    let end = english.into_iter().chain(chinese).min().unwrap_or(text.len());
    &text[..end]
}

fn page(s: &SignalDef, lang: Lang) -> String {
    let word = |zh: &'static str, en: &'static str| if lang == Lang::Zh { zh } else { en };
    let mut out = format!("{}\n  {}\n\n", s.name, s.meaning.get(lang));
    let mut line = |name: &str, value: String| {
        if !value.is_empty() {
            let _ = writeln!(out, "  {name}: {value}");
        }
    };
    line(
        word("范围", "one value"),
        match s.scope {
            SignalScope::Frame => word("每帧一个值", "a frame").to_owned(),
            SignalScope::Target => word("每个目标每帧一个值", "a target and frame").to_owned(),
            SignalScope::Object => word(
                "每个对象（含自车）每帧一个值，规则用到时才推导",
                "an object (also the ego) and frame, derived on demand",
            )
            .to_owned(),
            SignalScope::Pair => word(
                "每对相距 50 m 以内的对象每帧一个值，规则用到时才推导",
                "a pair of objects within 50 m and frame, derived on demand",
            )
            .to_owned(),
        },
    );
    line(
        word("类型", "type"),
        match &s.kind {
            SignalKind::Category(names) => names.join(" | "),
            _ => kind_name(s).to_owned(),
        },
    );
    line(word("单位", "unit"), s.unit_symbol().to_owned());
    line(word("日志需要", "needs from the log"), Need::list(&s.needs, lang));
    line(word("出处", "source"), s.source.clone());
    line(word("别名", "aliases"), s.aliases.join(", "));
    out
}
