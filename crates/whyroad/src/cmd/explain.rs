//! `whyroad explain`: why a class (or a custom rule) was found in a clip or not, condition by condition over
//! time.

mod chart;
mod json;
mod moments;
mod page;
mod text;

use super::inspect::drive_of;
use super::mine::plan::CustomRule;
use crate::output::reason::cannot_write;
use crate::output::{Print, render_text};
use crate::{Global, framework_folder, output};
use anyhow::{Context as _, bail};
use std::path::PathBuf;
use std::process::ExitCode;
use whyroad_engine::drives::signals_of;
use whyroad_engine::objects::signals_for;
use whyroad_framework::Framework;
use whyroad_framework::taxonomy::{Resolution, class_ambiguous, class_not_found};
use whyroad_lake::Lake;
use whyroad_mining::RuleSet;
use whyroad_mining::explain::{Explanation, Outcome, explain, explain_match, variants};
use whyroad_mining::language::check::nearest;
use whyroad_mining::rule::{OTHER, Rule};
use whyroad_model::scene::FRAME_RATE_HZ;
use whyroad_model::signal::EGO_ID;
use whyroad_model::{Bilingual, ClipId, Diagnostic, Lang, ScenarioId, TrackId};
use whyroad_render::truths;
use whyroad_report::coverage::class_title;
use whyroad_signals::Catalog;

/// Arguments of `whyroad explain`.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Leaf, or L2 that has a rule (full or unambiguous short id); `other` for decision moments
    #[arg(value_name = "CLASS", required_unless_present = "rule")]
    class: Option<String>,
    /// A custom rule instead of a class: its text, or a .yaml file that holds one
    #[arg(long, value_name = "TEXT|FILE", conflicts_with = "class")]
    rule: Option<String>,
    /// Lake that holds the clip
    #[arg(long, value_name = "DIR")]
    lake: PathBuf,
    /// Clip to look at
    #[arg(long, value_name = "ID")]
    clip: String,
    /// Track id of the target [default: the best candidate]
    #[arg(long, value_name = "ID")]
    target: Option<String>,
    /// Also draw it into this file
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    /// Also write a page with the scene at that moment and the conditions over time
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    #[command(flatten)]
    print: Print,
}

/// Contents of both forms of output.
struct Shown<'a> {
    class: &'a ScenarioId,
    /// Displayed name of the class.
    title: Bilingual,
    clip: &'a str,
    /// Seconds of each frame of the clip from its first one. The log can have gaps: they are measured, not counted.
    times_s: &'a [f64],
    explanation: &'a Explanation,
    /// Displayed names of the missing signals because of which it cannot be decided.
    missing: Vec<Bilingual>,
    /// For `other`: the decision moments of the clip.
    moments: Option<moments::Moments>,
    /// For an L2 that matched: the leaves that mining reports instead, with the frames of the clip of their keyframes.
    variants: Vec<Variant>,
}

/// A leaf whose episode takes the place of its L2's.
struct Variant {
    class: ScenarioId,
    title: Bilingual,
    /// Frame of the clip; unset where the keyframe is in another clip.
    frame: Option<usize>,
}

impl Shown<'_> {
    /// Seconds from the start of the clip to this frame of it.
    fn seconds(&self, frame: usize) -> f64 {
        self.times_s.get(frame).copied().unwrap_or_default()
    }

    /// True where frames are missing within the clip.
    fn has_gaps(&self) -> bool {
        self.times_s.windows(2).any(|pair| pair[1] - pair[0] > 1.5 / FRAME_RATE_HZ)
    }
}

/// Displayed name of a class; its id if the taxonomy does not have it.
fn named(framework: &Framework, id: &ScenarioId) -> Bilingual {
    if framework.taxonomy.contains(id) || id.l1 == OTHER {
        return class_title(&framework.taxonomy, id);
    }
    Bilingual::same(id.to_string())
}

pub(crate) fn run(global: &Global, args: Args) -> anyhow::Result<ExitCode> {
    let (framework, _) = framework_folder::load(global)?;
    let (catalog, _) = Catalog::parse(&framework.signals_yaml);
    let rule = match (&args.rule, &args.class) {
        (Some(rule), _) => {
            let custom = CustomRule { rule, name: None, target: None };
            custom.compile(&catalog)?.map(|(rule, _)| (rule, Vec::new()))
        }
        (None, Some(class)) => rule_of(class, &framework, &catalog),
        // clap asks for one of them.
        (None, None) => Err(vec![]),
    };
    let (rule, rules) = match rule {
        Ok(found) => found,
        Err(found) => {
            for d in &found {
                tell!("{}", render_text(d, global.lang));
            }
            return Ok(output::FINDINGS);
        }
    };
    let lake = match Lake::open(&args.lake) {
        Ok(lake) => lake,
        Err(e) => {
            tell!("{}", render_text(&e.diagnostic(), global.lang));
            return Ok(output::FINDINGS);
        }
    };
    let Some(drive) = drive_of(&lake, &args.clip) else {
        bail!(no_clip(&lake, &args.clip, global.lang));
    };
    let drive = match lake.read_drive(&drive) {
        Ok(drive) => drive,
        Err(e) => {
            tell!("{}", render_text(&e.diagnostic(), global.lang));
            return Ok(output::FINDINGS);
        }
    };
    let clip = ClipId(args.clip.clone()).frames(&drive.meta.drive_id, &drive.times).unwrap_or_default();
    let wanted = args.target.as_deref().map(TrackId::from);
    if let Some(id) =
        wanted.as_ref().filter(|id| id.as_str() != EGO_ID && !drive.tracks.iter().any(|t| t.id == **id))
    {
        bail!(match global.lang {
            Lang::Zh => format!("该行程没有名为 '{id}' 的对象"),
            Lang::En => format!("the drive has no track '{id}'"),
        });
    }
    let whole = || signals_of(&lake, &drive.meta.drive_id);
    let table = match signals_for(&rule, || lake.read_drive(&drive.meta.drive_id), whole) {
        Ok(table) => table,
        Err(e) => {
            tell!("{}", render_text(&e.diagnostic(), global.lang));
            return Ok(output::FINDINGS);
        }
    };
    let moments = (args.rule.is_none() && rule.scenario.l1 == OTHER)
        .then(|| moments::Moments::of((&framework, &catalog), &rule, &table, &ClipId(args.clip.clone())));
    // Of the decision moments, one that no class explains.
    let explanation = match moments.as_ref().and_then(|m| m.frames.first()) {
        Some(&frame) => explain_match(&rule, &table, clip, frame),
        None => explain(&rule, &table, clip, wanted.as_ref()),
    };
    let explanation = match &moments {
        Some(moments) if moments.all_explained() => {
            Explanation { parts: Vec::new(), moment: None, ..explanation }
        }
        _ => explanation,
    };
    let times = &drive.times[clip.start..clip.end];
    let times_s: Vec<f64> = times.iter().map(|t| t.seconds_since(times[0])).collect();
    let matched = explanation.moment.filter(|_| explanation.outcome == Outcome::Matched);
    let leaves = matched.map(|frame| variants(&rule, &rules, &table, clip.start + frame));
    let leaves = leaves.into_iter().flatten().map(|leaf| Variant {
        title: named(&framework, &leaf.scenario),
        class: leaf.scenario,
        frame: clip.contains(leaf.keyframe).then(|| leaf.keyframe - clip.start),
    });
    let shown = Shown {
        class: &rule.scenario,
        title: named(&framework, &rule.scenario),
        clip: &args.clip,
        times_s: &times_s,
        explanation: &explanation,
        missing: explanation.missing.iter().map(|name| catalog.title(name)).collect(),
        moments,
        variants: leaves.collect(),
    };
    args.print.put(&json::document(&shown), || text::render(&shown, global.lang))?;
    if let Some(file) = &args.svg {
        std::fs::write(file, truths::render(&chart::chart(&shown, global.lang)))
            .with_context(|| cannot_write(file.display()))?;
    }
    if let Some(file) = &args.html {
        let chart = chart::chart(&shown, global.lang);
        let target = explanation.roles.get(&rule.target_role);
        let scene = |frame: usize, caption| page::Scene { frame, target, caption };
        let left = shown.moments.as_ref().map_or(&[][..], |m| &m.frames);
        let scenes: Vec<page::Scene<'_>> = match left {
            [] => explanation.moment.map(|m| scene(clip.start + m, String::new())).into_iter().collect(),
            all => all.iter().map(|f| scene(*f, format!("{:.1} s", shown.seconds(f - clip.start)))).collect(),
        };
        let text = shown.moments.as_ref().map(|m| m.text(global.lang)).unwrap_or_default();
        let title = match global.lang {
            Lang::Zh => format!("{}，{}", shown.title.zh, args.clip),
            Lang::En => format!("{}, {}", shown.title.en, args.clip),
        };
        let page = page::page(&title, &drive, &scenes, (&chart, &text), global.lang);
        std::fs::write(file, page).with_context(|| cannot_write(file.display()))?;
    }
    Ok(output::FINE)
}

/// The rule of a class of the framework, or the one for decision moments.
/// With all rules.
fn rule_of(
    class: &str,
    framework: &Framework,
    catalog: &Catalog,
) -> Result<(Rule, Vec<Rule>), Vec<Diagnostic>> {
    let (rules, faults) = RuleSet::of_framework(framework, catalog);
    let rules = rules.with_decision_moments(catalog);
    let class = match framework.taxonomy.resolve(class) {
        _ if class == OTHER => ScenarioId { l1: OTHER.to_owned(), l2: None, l3: None },
        Resolution::Found(id) => id,
        Resolution::Ambiguous(ids) => return Err(vec![class_ambiguous(class, &ids)]),
        Resolution::Unknown(near) => {
            let near: Vec<String> = near.iter().map(ToString::to_string).collect();
            return Err(vec![class_not_found(class, &near)]);
        }
    };
    let rule = rules.rules.iter().find(|r| r.scenario == class).cloned();
    rule.map(|rule| (rule, rules.rules)).ok_or_else(|| {
        // A rule with an error is left out: that is why it is missing.
        let is_written =
            framework.rule(&class).is_some_and(|r| class.is_leaf() || r.rule.get("when").is_some());
        let (message, hint) = if is_written && !faults.is_empty() {
            let message = Bilingual::new(
                format!("{class} 的挖掘规则有错误，未使用"),
                format!("the mining rule of {class} has an error and is not used"),
            );
            (message, Bilingual::new("改正下列错误", "correct the errors below"))
        } else {
            let message =
                Bilingual::new(format!("{class} 没有挖掘规则"), format!("{class} has no mining rule"));
            let hint = if class.is_leaf() {
                Bilingual::new(
                    "为它编写 `mining:` 块（docs/reference/rules.md），或用 `mine --rule` 查找",
                    "write a `mining:` block for it (docs/reference/rules.md), or search by `mine --rule`",
                )
            } else {
                Bilingual::new(
                    "请指明其下的某个 L3 场景；`whyroad taxonomy list` 列出全部",
                    "name one of the leaves below it; `whyroad taxonomy list` lists them",
                )
            };
            (message, hint)
        };
        let mut found = vec![Diagnostic::error("mine.scenario.no_rule", message).with_hint(hint)];
        found.extend(faults);
        found
    })
}

fn no_clip(lake: &Lake, written: &str, lang: Lang) -> String {
    let ids = lake.drive_ids();
    let near = nearest(written, ids.iter().map(|id| id.as_str()));
    let hint = match (near, lang) {
        (Some(near), Lang::Zh) => format!("；行程 {near} 的片段从 {near}_000 起"),
        (Some(near), Lang::En) => format!("; the clips of drive {near} begin with {near}_000"),
        (None, _) => String::new(),
    };
    match lang {
        Lang::Zh => format!("数据湖中没有片段 '{written}'{hint}；`whyroad inspect --lake DIR` 列出片段"),
        Lang::En => {
            format!(
                "clip '{written}' not found in the lake{hint}; `whyroad inspect --lake DIR` lists the clips"
            )
        }
    }
}
