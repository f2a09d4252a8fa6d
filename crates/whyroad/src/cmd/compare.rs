//! `whyroad compare A B`: what changed between two mined folders, two frameworks over one lake, or two releases.

mod sides;

use crate::output::reason::{cannot_make, cannot_read, cannot_write, no_class, stop};
use crate::output::{self, Print};
use crate::store_args::KeyArgs;
use crate::{Global, analytics, framework_folder};
use anyhow::Context as _;
use sides::{Kind, Side, name_targets};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use whyroad_label::facts::TaskFacts;
use whyroad_model::messages::{CocLabel, Provenance, ProvenanceSource};
use whyroad_model::{DriveId, Lang, ScenarioId};
use whyroad_report::comparison::{AcceptedMoment, PageHead, SharedClasses, compare, render, render_page};
use whyroad_report::verdicts::{self, VerdictLine};

/// Arguments of `whyroad compare`.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Before the change: a mined folder, a framework folder (or `bundled`), or a release
    #[arg(value_name = "A")]
    before: PathBuf,
    /// After the change: the same kind, or a framework folder against a mined folder
    #[arg(value_name = "B")]
    after: PathBuf,
    /// Lake that frameworks are run over
    #[arg(long, value_name = "DIR")]
    lake: Option<PathBuf>,
    /// Accepted labels that judge the changes: JSON Lines from `tasks export`, verdicts on mined episodes, or the
    /// store (labels.db, the folder with it, postgres://...)
    #[arg(long, value_name = "FILE|STORE")]
    labels: Option<String>,
    #[command(flatten)]
    key: KeyArgs,
    /// Only this class: an L1, L2 or leaf
    #[arg(long, value_name = "ID")]
    scenario: Option<String>,
    /// Name changed episodes, up to five per class and change
    #[arg(long)]
    examples: bool,
    /// Write a page with classes and examples
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    #[command(flatten)]
    print: Print,
}

pub(crate) fn run(global: &Global, args: Args) -> anyhow::Result<ExitCode> {
    let (framework, _) = framework_folder::load(global)?;
    let class = match &args.scenario {
        Some(text) => match framework.taxonomy.resolve(text) {
            whyroad_framework::Resolution::Found(id) => Some(id),
            _ => return Err(no_class(text)),
        },
        None => None,
    };
    let kinds = (Kind::of(&args.before)?, Kind::of(&args.after)?);
    if (kinds.0 == Kind::Release) != (kinds.1 == Kind::Release) {
        return Err(stop("数据集只能与数据集比较", "a release can only be compared with a release"));
    }
    let read = |path: &Path, kind| Side::read(global, path, kind, args.lake.as_deref(), class.as_ref());
    let (mut before, mut after) = (read(&args.before, kinds.0)?, read(&args.after, kinds.1)?);
    if kinds.0 == Kind::Release {
        name_targets(&mut before.episodes, &after.episodes);
        name_targets(&mut after.episodes, &before.episodes);
    }
    let is_custom =
        |side: &Side| side.classes.as_ref().is_some_and(|all| all.iter().all(|c| c.custom_name().is_some()));
    if is_custom(&before) && is_custom(&after) {
        // Two custom rules are compared whatever their names are.
        (before.classes, after.classes) = (None, None);
    }
    let drives: BTreeSet<&DriveId> = before.drives.iter().chain(&after.drives).collect();
    let accepted = args.labels.as_deref().map(|s| accepted((s, &args.key), &drives, global)).transpose()?;
    let comparison = compare(before.searched(), after.searched(), accepted.as_deref());
    if let Some(out) = &args.out {
        let names = (args.before.display().to_string(), args.after.display().to_string());
        // Classes that only the later framework has are in its taxonomy, the others in the earlier one's.
        let taxonomies: Vec<_> = [&after.taxonomy, &before.taxonomy, &Some(framework.taxonomy.clone())]
            .into_iter()
            .flatten()
            .cloned()
            .collect();
        let head = PageHead { before: &names.0, after: &names.1, taxonomies: &taxonomies, lang: global.lang };
        if let Some(dir) = out.parent().filter(|d| !d.as_os_str().is_empty()) {
            std::fs::create_dir_all(dir).with_context(|| cannot_make(dir.display()))?;
        }
        std::fs::write(out, render_page(&comparison, &head)).with_context(|| cannot_write(out.display()))?;
        say!("{}", out.display());
    }
    args.print.put(&comparison, || render(&comparison, global.lang, args.examples))?;
    let is_nothing = |of: &SharedClasses| of.compared.is_empty();
    if comparison.classes_of_both.as_ref().is_some_and(is_nothing) {
        return Ok(output::FINDINGS);
    }
    Ok(if before.lost || after.lost { output::lost_input() } else { output::FINE })
}

/// Accepted labels, of the drives that are compared.
fn accepted(
    (source, key): (&str, &KeyArgs),
    drives: &BTreeSet<&DriveId>,
    global: &Global,
) -> anyhow::Result<Vec<AcceptedMoment>> {
    let path = Path::new(source);
    let is_store = source.contains("://")
        || path.is_dir()
        || path.extension().is_some_and(|e| e == "db" || e == "sqlite");
    if is_store {
        let tasks = analytics::labelling((source, key), None, global.lang)?.tasks;
        let moments = tasks.into_iter().filter(TaskFacts::is_accepted);
        return Ok(moments
            .filter(|t| drives.contains(&t.drive))
            .filter_map(|t| {
                let label = t.label?;
                Some(AcceptedMoment { drive: t.drive, scenario: label.scenario?, keyframe: label.keyframe? })
            })
            .collect());
    }
    let text = std::fs::read_to_string(path).with_context(|| cannot_read(source))?;
    if verdicts::is_export(&text) {
        let (verdicts, problems) = verdicts::read(&text, source);
        for d in &problems {
            tell!("{}", output::render_text(d, global.lang));
        }
        let moments = verdicts.iter().filter_map(VerdictLine::moment);
        return Ok(moments.filter(|m| drives.contains(&m.drive)).collect());
    }
    let (mut out, mut drafts) = (Vec::new(), 0);
    for (i, line) in text.lines().enumerate().filter(|(_, l)| !l.trim().is_empty()) {
        let label: CocLabel = serde_json::from_str(line).with_context(|| format!("{source}:{}", i + 1))?;
        // A draft is accepted by nobody.
        let by_program =
            |p: &Provenance| matches!(p.source, ProvenanceSource::Rule | ProvenanceSource::Model);
        if label.provenance.as_ref().is_some_and(by_program) {
            drafts += 1;
            continue;
        }
        let of = label.scenario;
        // A clip is named by its drive and a number: <drive>_000.
        let drive = label.clip_id.rsplit_once('_').map(|(drive, _)| DriveId::from(drive));
        if let Some(drive) = drive.filter(|d| drives.contains(d)) {
            let scenario = ScenarioId { l1: of.l1, l2: Some(of.l2), l3: of.l3 };
            out.push(AcceptedMoment { drive, scenario, keyframe: label.keyframe.timestamp });
        }
    }
    if drafts > 0 {
        match global.lang {
            Lang::Zh => say!("{source}：{drafts} 个草稿未经人工接受，不用于比较"),
            Lang::En => say!(
                "{source}: {} accepted by nobody and not used",
                if drafts == 1 { "1 draft was".to_owned() } else { format!("{drafts} drafts were") }
            ),
        }
    }
    Ok(out)
}
