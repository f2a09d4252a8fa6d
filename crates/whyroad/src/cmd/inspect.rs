//! `whyroad inspect`: contents of a lake, by drive, or for one clip.

use crate::output::reason::stop;
use crate::output::{Print, render_text};
use crate::text_table::wrapped;
use crate::{Global, output};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::ExitCode;
use whyroad_engine::drives::map_drives;
use whyroad_engine::inspect::{DriveSummary, LakeSummary, NoiseOf, SignalShare};
use whyroad_lake::Lake;
use whyroad_model::{Bilingual, ClipId, DriveId, Lang, Need, counted};

/// Arguments of `whyroad inspect`.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Lake to inspect
    #[arg(long, value_name = "DIR")]
    lake: PathBuf,
    /// Only this drive, with the names of the signals that it does not support
    #[arg(long, value_name = "ID", conflicts_with = "clip")]
    drive: Option<String>,
    /// Only this clip, with the known share of every signal
    #[arg(long, value_name = "ID")]
    clip: Option<String>,
    #[command(flatten)]
    print: Print,
}

pub(crate) fn run(global: &Global, args: Args) -> anyhow::Result<ExitCode> {
    let lake = match Lake::open(&args.lake) {
        Ok(lake) => lake,
        Err(e) => {
            tell!("{}", render_text(&e.diagnostic(), global.lang));
            return Ok(output::FINDINGS);
        }
    };
    let drives = match (&args.drive, &args.clip) {
        (None, None) => lake.drive_ids(),
        (Some(id), _) => lake.drive_ids().into_iter().filter(|drive| drive.as_str() == id).collect(),
        (None, Some(clip)) => drive_of(&lake, clip).into_iter().collect(),
    };
    if let (true, Some(id)) = (drives.is_empty(), args.drive.as_ref().or(args.clip.as_ref())) {
        let (zh, en) = if args.drive.is_some() { ("行程", "drive") } else { ("片段", "clip") };
        return Err(stop(
            format!("数据湖中没有{zh}“{id}”；`whyroad inspect --lake DIR` 列出所有{zh}"),
            format!("{en} '{id}' not found in the lake; `whyroad inspect --lake DIR` lists the {en}s"),
        ));
    }
    let (mut lake_summary, mut summaries, mut broken) = (LakeSummary::default(), Vec::new(), false);
    let clip = args.clip.as_deref();
    map_drives(
        &drives,
        None,
        |id| DriveSummary::read(&lake, id, clip),
        |read| {
            match read {
                Ok(summary) => {
                    lake_summary.add(&summary);
                    summaries.push(summary);
                }
                Err(e) => {
                    tell!("{}", render_text(&e.diagnostic(), global.lang));
                    broken = true;
                }
            }
            anyhow::Ok(())
        },
    )?;
    keep(&lake, global);
    args.print.put(&summaries, || {
        let mut text = String::new();
        // The lists of signals are much the same for all drives: those of several are printed once.
        let detail = match (clip, &summaries[..]) {
            (Some(_), _) => Detail::Shares,
            (None, [_]) => Detail::Names,
            (None, _) => Detail::Counts,
        };
        if args.drive.is_none() && clip.is_none() {
            text += &lake_text(&lake_summary, &summaries, global.lang);
        }
        if detail == Detail::Counts {
            text += &unobservable_text(&summaries, global.lang);
        }
        for s in &summaries {
            text.push('\n');
            text += &drive_text(s, detail, global.lang);
        }
        text
    })?;
    Ok(match (broken, summaries.is_empty()) {
        (false, _) => output::FINE,
        (true, true) => output::FINDINGS,
        (true, false) => output::lost_input(),
    })
}

/// Publishes the signals that were derived for this, where the lake is in an object store; without them, the next call
/// derives them again.
pub(crate) fn keep(lake: &Lake, global: &Global) {
    if let Err(e) = lake.publish() {
        tell!("{}", render_text(&e.diagnostic(), global.lang));
    }
}

pub(crate) fn drive_of(lake: &Lake, clip: &str) -> Option<DriveId> {
    let clip = ClipId(clip.to_owned());
    let drive = clip.drive()?;
    let outline = lake.outline(&drive).ok()?;
    clip.frames(&drive, &outline.times).map(|_| drive)
}

/// How much is said of the signals of one drive.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Detail {
    /// How many are known.
    Counts,
    /// And the names of those that are not.
    Names,
    /// And the known share of each.
    Shares,
}

/// The signals that drives do not support, once for all drives that lack the same.
fn unobservable_text(drives: &[DriveSummary], lang: Lang) -> String {
    let mut without: BTreeMap<(&[Need], &str), Vec<usize>> = BTreeMap::new();
    for (i, drive) in drives.iter().enumerate() {
        for (name, needs) in &drive.unavailable {
            without.entry((needs, name)).or_default().push(i);
        }
    }
    let mut groups: BTreeMap<(&[Need], Vec<usize>), Vec<&str>> = BTreeMap::new();
    for ((needs, name), of) in without {
        groups.entry((needs, of)).or_default().push(name);
    }
    let mut groups: Vec<_> = groups.into_iter().collect();
    groups.sort_by_key(|((_, of), _)| std::cmp::Reverse(of.len()));
    let all = drives.len();
    let lines = groups.into_iter().map(|((needs, of), names)| {
        let (n, why, names) = (of.len(), why(needs, lang), names.join(", "));
        let line = match lang {
            Lang::Zh => format!("    {all} 个行程中的 {n} 个（{why}）：{names}"),
            Lang::En => format!("    {n} of {all} drives ({why}): {names}"),
        };
        wrapped(&line, 6)
    });
    let lines: String = lines.collect();
    let head = Bilingual::new(
        "  不可观测的信号（单个行程的：`--drive ID`）：\n",
        "  signals that are not observable (those of one drive: `--drive ID`):\n",
    );
    if lines.is_empty() { lines } else { format!("{}{lines}", head.get(lang)) }
}

/// Why signals are not observable.
fn why(needs: &[Need], lang: Lang) -> String {
    match needs {
        [] => label("too little", lang),
        _ => Bilingual::new("缺少", "needs ").get(lang).to_owned() + &Need::list(needs, lang),
    }
}

/// The lake as a whole, in a few lines.
fn lake_text(s: &LakeSummary, of_drives: &[DriveSummary], lang: Lang) -> String {
    let counts = |counts: Vec<(&str, usize)>| {
        counts.iter().map(|(name, n)| format!("{name} {n}")).collect::<Vec<_>>().join(", ")
    };
    let formats = counts(s.formats.iter().map(|(k, n)| (k.as_str(), *n)).collect());
    let mut sources: BTreeMap<&str, usize> = BTreeMap::new();
    of_drives.iter().for_each(|drive| *sources.entry(source(drive)).or_default() += 1);
    let sources = counts(sources.into_iter().collect());
    let objects = counts(s.objects.iter().map(|(k, c)| (k.as_str(), c.objects)).collect());
    let tables = counts(s.tables.iter().map(|(k, n)| (*k, *n)).collect());
    let (drives, clips, hours) = (s.drives, s.clips, s.hours);
    let lines = match lang {
        Lang::Zh => [
            format!("{drives} 个行程，{clips} 个片段，{hours:.2} 小时"),
            format!("  格式：{formats}"),
            format!("  来源：{sources}"),
            format!("  轨迹：{objects}"),
            format!("  有该数据表的行程：{tables}"),
        ],
        Lang::En => [
            format!("{}, {}, {hours:.2} h", counted(drives, "drive"), counted(clips, "clip")),
            format!("  formats: {formats}"),
            format!("  sources: {sources}"),
            format!("  tracks: {objects}"),
            format!("  drives with the table: {tables}"),
        ],
    };
    lines.iter().filter(|l| !l.ends_with([' ', '：'])).map(|l| wrapped(l, 4)).collect()
}

/// The source that the clips of a drive state: what `select.sources` in the spec of a data set takes.
fn source(drive: &DriveSummary) -> &str {
    drive.clips.first().map_or("", |clip| &clip.source)
}

/// Labels of the listing.
fn label(key: &str, lang: Lang) -> String {
    let (zh, en) = match key {
        "source" => ("来源", "source"),
        "ego" => ("自车", "ego"),
        "no_ego" => ("没有自车位姿：位置相对于自车", "no ego pose: positions are relative to the ego"),
        "noise" => ("噪声", "noise"),
        "vehicles" => ("车辆", "vehicles"),
        "others" => ("其他目标", "others"),
        "exact" => ("视为精确", "exact"),
        "no date" => ("无日期", "no date"),
        "tracks" => ("轨迹", "tracks"),
        "rows" => ("行", "rows"),
        "frames" => ("帧", "frames"),
        "map" => ("地图", "map"),
        "map layers" => ("地图图层", "map layers"),
        "tables" => ("数据表", "tables"),
        "missing" => ("日志中没有", "not in the log"),
        "signals" => ("信号", "signals"),
        "too little" => {
            ("日志中各项都有一部分，但不足以得出", "the log has a part of what it needs, but too little")
        }
        "unobservable" => ("不可观测", "not observable"),
        "in part" => ("仅在能证明处已知", "known only where other data proves it"),
        "no value" => ("日志支持，但没有值", "supported by the log, but without a value here"),
        "lanes" => ("车道", "lanes"),
        "lanes in junctions" => ("路口内车道", "lanes in junctions"),
        "crosswalks" => ("人行横道", "crosswalks"),
        "junctions" => ("路口", "junctions"),
        "drivable areas" => ("可行驶区域", "drivable areas"),
        "stop lines" => ("停止线", "stop lines"),
        "signs" => ("标志", "signs"),
        "facilities" => ("设施", "facilities"),
        "facilities/speed_bump" => ("减速带", "speed bumps"),
        "facilities/toll_etc" => ("ETC 车道", "electronic toll lanes"),
        "facilities/toll_manual" => ("人工收费车道", "manual toll lanes"),
        "facilities/toll_plaza" => ("收费广场", "toll plazas"),
        "facilities/gate" => ("道闸", "gates"),
        "facilities/tunnel" => ("隧道", "tunnels"),
        "facilities/roundabout" => ("环岛", "roundabouts"),
        "facilities/construction" => ("施工区", "construction sites"),
        "facilities/building" => ("建筑", "buildings"),
        "facilities/barrier_gap" => ("护栏开口", "gaps in barriers"),
        "facilities/waiting_area" => ("待转区", "waiting areas"),
        "facilities/accident" => ("事故现场", "accident sites"),
        "facilities/bridge" => ("桥梁", "bridges"),
        "facilities/parking" => ("停车场", "parking areas"),
        "facilities/driveway" => ("出入口", "driveways"),
        "facilities/traffic_light" => ("信号灯", "traffic lights"),
        _ => (key, key),
    };
    Bilingual::new(zh, en).get(lang).to_owned()
}

fn counts_text(counts: &BTreeMap<String, usize>, lang: Lang) -> String {
    let part = |k: &str, n: usize| format!("{} {n}", label(k, lang));
    let parts = counts.iter().filter(|(k, _)| !k.contains('/')).map(|(k, n)| {
        let kinds = counts.iter().filter(|(other, _)| other.split_once('/').is_some_and(|(of, _)| of == *k));
        let kinds: Vec<String> = kinds.map(|(other, n)| part(other, *n)).collect();
        if kinds.is_empty() { part(k, *n) } else { format!("{} ({})", part(k, *n), kinds.join(", ")) }
    });
    parts.collect::<Vec<_>>().join(", ")
}

fn drive_text(s: &DriveSummary, detail: Detail, lang: Lang) -> String {
    let l = |key| label(key, lang);
    let facts: Vec<&str> =
        [Some(s.format.as_str()), s.place.as_deref(), s.licence.as_deref()].into_iter().flatten().collect();
    let mut out = format!("{} ({})\n", s.drive_id, facts.join(", "));
    out += &format!("  {}: {}\n", l("source"), source(s));
    // Without dates in the log the times are those that `ingest` counts from.
    let dated = !s.missing.contains(&Need::Date);
    for c in &s.clips {
        out += &format!(
            "  {}  {}  {:.1} s  {} {}\n",
            c.clip_id,
            if dated { c.capture_time.to_string() } else { l("no date") },
            c.duration_sec,
            c.total_frames,
            l("frames")
        );
    }
    out += &match &s.ego {
        Some(e) => format!(
            "  {}: {:.2} x {:.2} m, {:.1} - {:.1} m/s\n",
            l("ego"),
            e.length_m,
            e.width_m,
            e.min_speed_mps,
            e.max_speed_mps
        ),
        None => format!("  {}\n", l("no_ego")),
    };
    if let Some(noise) = &s.noise {
        for (kind, of) in [
            ("ego", noise.ego.as_ref()),
            ("vehicles", Some(&noise.vehicles)),
            ("others", Some(&noise.others)),
        ] {
            out += &of.map_or(String::new(), |of| noise_text(kind, of, lang));
        }
    }
    let (objects, rows) = s.objects.values().fold((0, 0), |(o, r), c| (o + c.objects, r + c.rows));
    let joined = s.joined_objects;
    let joined = match lang {
        Lang::Zh => format!("合并中断的轨迹后 {joined} 个目标"),
        Lang::En => format!("{} after joining tracks that break off", counted(joined, "object")),
    };
    out += &format!("  {}: {objects}, {rows} {}; {joined}\n", l("tracks"), l("rows"));
    for (class, c) in &s.objects {
        out += &format!("    {class:<18} {:>5} {:>8} {}\n", c.objects, c.rows, l("rows"));
    }
    if let Some(map) = &s.map {
        out += &format!("  {}: {}\n", l("map"), counts_text(map, lang));
        let layers = s.map_layers.iter();
        let layers: Vec<String> =
            layers.map(|(of, state)| format!("{} {}", of.name().get(lang), state.name().get(lang))).collect();
        if !layers.is_empty() {
            out += &wrapped(&format!("  {}: {}", l("map layers"), layers.join(", ")), 4);
        }
    }
    out += &format!("  {}: {}\n", l("tables"), s.tables.join(", "));
    if !s.missing.is_empty() {
        out += &format!("  {}: {}\n", l("missing"), Need::list(&s.missing, lang));
    }
    out + &signals_text(s, detail, lang)
}

/// Noise of one kind of object: independent, and correlated over a second where there is some.
fn noise_text(kind: &str, of: &NoiseOf, lang: Lang) -> String {
    let both = |[white, correlated]: [f64; 2], digits: usize, unit: &str| {
        let slow = if correlated > 0.0 { format!(" + {correlated:.digits$}") } else { String::new() };
        format!("{white:.digits$}{slow} {unit}")
    };
    let figures =
        [both(of.position_m, 3, "m"), both(of.heading_deg, 2, "deg"), both(of.velocity_mps, 2, "m/s")];
    let exact = if of.exact { format!(" ({})", label("exact", lang)) } else { String::new() };
    format!("  {} {}: {}{exact}\n", label("noise", lang), label(kind, lang), figures.join(", "))
}

fn signals_text(s: &DriveSummary, detail: Detail, lang: Lang) -> String {
    let total = s.signals.len() + s.unavailable.len();
    let known = s.signals.values().filter(|v| v.known > 0).count();
    let without_value: Vec<&str> =
        s.signals.iter().filter(|(_, v)| v.known == 0).map(|(name, _)| name.as_str()).collect();
    let (blind, silent) = (s.unavailable.len(), without_value.len());
    let mut out = match lang {
        Lang::Zh => format!(
            "  {}：{total} 个中 {known} 个已知，{blind} 个不可观测，{silent} 个没有值\n",
            label("signals", lang),
        ),
        Lang::En => format!(
            "  {}: {known} of {total} known, {blind} not observable, {silent} without a value\n",
            label("signals", lang),
        ),
    };
    if detail == Detail::Shares {
        for (name, SignalShare { known, rows }) in &s.signals {
            let percent = if *rows == 0 { 0.0 } else { *known as f64 / *rows as f64 * 100.0 };
            out += &format!("    {name:<32} {percent:>5.1} %  {known} / {rows}\n");
        }
    }
    if detail == Detail::Counts {
        return out;
    }
    // Signals are grouped by the reason why they are unavailable: the reason is what can be fixed.
    let mut by_need: BTreeMap<&[Need], Vec<&str>> = BTreeMap::new();
    for (name, needs) in &s.unavailable {
        by_need.entry(needs).or_default().push(name);
    }
    for (needs, names) in by_need {
        let why = why(needs, lang);
        out += &format!("    {} ({why}): {}\n", label("unobservable", lang), names.join(", "));
    }
    let mut in_part: BTreeMap<&[Need], Vec<&str>> = BTreeMap::new();
    for (name, needs) in &s.partial {
        in_part.entry(needs).or_default().push(name);
    }
    for (needs, names) in in_part {
        let why = why(needs, lang);
        out += &format!("    {} ({why}): {}\n", label("in part", lang), names.join(", "));
    }
    if !without_value.is_empty() {
        out += &format!("    {}: {}\n", label("no value", lang), without_value.join(", "));
    }
    out
}
