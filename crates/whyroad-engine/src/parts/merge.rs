//! One mined folder from parts. Nothing is published unless every drive is there exactly once, mined with the same
//! rules, framework and program; exceptions are named. The results of the drives go through the same writer, in the
//! same order, as in one run over the whole lake, so the files are equal byte for byte.

use super::folder::{Failed, Part, PartError, Span, Versions};
use super::plan::plan_id;
use crate::output::{FolderWriter, Summary};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use whyroad_framework::Taxonomy;
use whyroad_lake::Lake;
use whyroad_lake::mined::{Existing, MinedWriteError, Publication, PublishError};
use whyroad_mining::RuleSet;
use whyroad_model::{Bilingual, Diagnostic, DriveId};

/// Maximum number of drives named in a message.
const NAMED: usize = 10;

/// Source of the expected drives.
#[derive(Clone, Copy)]
pub enum Expected<'a> {
    /// The plan to which the work lists belong.
    Plan,
    /// All drives of this lake, with their present content.
    Lake(&'a Lake),
}

/// A merge could not be done at all.
#[derive(Debug, thiserror::Error)]
pub enum MergeError {
    /// A part.
    #[error(transparent)]
    Part(#[from] PartError),
    /// The path of the result.
    #[error(transparent)]
    Publish(#[from] PublishError),
    /// The result.
    #[error(transparent)]
    Write(#[from] MinedWriteError),
}

/// Result of a merge.
pub struct Merged {
    /// Summary of the written folder.
    pub summary: Summary,
    /// Whether questions, classes and the rest were those of this request.
    pub request: super::Request,
    /// Drives that are not among the results, by id: each was set aside by its worker.
    pub failed: Vec<Failed>,
}

/// Merges parts into the mined folder `out`, with the framework and all of its rules. Returns diagnostics instead of a
/// result if drives are missing, doubled or different; then nothing is written. With `replace`, results of another
/// question may be in `out`.
pub fn merge(
    parts: &[PathBuf],
    expected: Expected<'_>,
    (taxonomy, rules): (&Taxonomy, &RuleSet),
    out: &Path,
    replace: bool,
) -> Result<Result<Merged, Vec<Diagnostic>>, MergeError> {
    let (mut parts, mut found) = open(parts);
    let Some(first) = parts.first() else {
        return Ok(Err(found));
    };
    let current = Versions::of(taxonomy, rules, rules);
    let work = first.work.clone();
    for part in &parts {
        found.extend(not_current(part, &current).or_else(|| different(part, &parts[0])));
    }
    let (drives, doubled) = gather(&parts);
    found.extend(doubled);
    found.extend(match expected {
        Expected::Plan => against_plan(&parts),
        Expected::Lake(lake) => against_lake(&drives, lake),
    });
    if !found.is_empty() {
        return Ok(Err(found));
    }

    let request = work.request;
    let place = Publication::begin(out, &request.asked, replace)?;
    let mut folder = FolderWriter::create(
        place.folder(),
        request.asked.clone(),
        Existing::Replace,
        &request.questions,
        &request.classes,
        &rules.precedence,
    )?;
    let mut failed = Vec::new();
    for (id, of_drive) in drives {
        match of_drive.span {
            Some(span) => folder.add(&parts[of_drive.part].mined(span)?)?,
            None => {
                let of_part = parts[of_drive.part].progress.failed.get(&id).cloned();
                failed.extend(of_part.inspect(|f| folder.leave_out(&f.drive_id, &f.code)));
            }
        }
    }
    let summary = folder.finish(taxonomy, request.searched)?;
    place.publish()?;
    Ok(Ok(Merged { summary, request, failed }))
}

/// A drive in a part; without a position it was set aside.
struct InPart {
    part: usize,
    content_hash: String,
    span: Option<Span>,
}

fn open(dirs: &[PathBuf]) -> (Vec<Part>, Vec<Diagnostic>) {
    let (mut parts, mut found) = (Vec::new(), Vec::new());
    for dir in dirs {
        match Part::open(dir) {
            Ok(Some(part)) => parts.push(part),
            Ok(None) => found.push(incomplete(dir)),
            Err(e) => found.push(unreadable(dir, &e)),
        }
    }
    (parts, found)
}

/// Every drive of the parts, and drives that are in two of them.
fn gather(parts: &[Part]) -> (BTreeMap<DriveId, InPart>, Vec<Diagnostic>) {
    let (mut drives, mut doubles) = (BTreeMap::<DriveId, InPart>::new(), BTreeMap::<_, Vec<&DriveId>>::new());
    for (part, opened) in parts.iter().enumerate() {
        let done = opened.progress.done.iter().map(|(id, (hash, span))| (id, hash.clone(), Some(*span)));
        let failed = opened.progress.failed.keys().map(|id| (id, String::new(), None));
        for (id, content_hash, span) in done.chain(failed) {
            match drives.get(id) {
                Some(other) => doubles.entry((other.part, part)).or_default().push(id),
                None => {
                    drives.insert(id.clone(), InPart { part, content_hash, span });
                }
            }
        }
    }
    let found = doubles.iter().map(|((a, b), ids)| doubled(ids, &parts[*a], &parts[*b])).collect();
    (drives, found)
}

/// The merged folder states what this program and its framework would: the parts must have been made by them.
fn not_current(part: &Part, current: &Versions) -> Option<Diagnostic> {
    let of_part = &part.work.versions;
    let program = |v: &Versions| [v.whyroad.clone(), v.signals.clone(), v.mining.clone()];
    let (zh, en) = if program(of_part) != program(current) {
        (
            "由另一版本的程序生成，与合并所用的程序不同",
            "was made by another version of the program than this one",
        )
    } else if of_part.framework != current.framework {
        (
            "所用框架（场景类别、规则或校准）与当前框架不同",
            "was made with another framework (classes, rules or calibration) than the current one",
        )
    } else {
        return None;
    };
    let dir = part.dir.display();
    let message = Bilingual::new(format!("分片 {dir} {zh}"), format!("part {dir} {en}"));
    let hint = Bilingual::new(
        "用生成分片的程序和框架合并（--framework），或重新生成该分片",
        "merge with the program and the framework that made the parts (--framework), or make the part again",
    );
    Some(Diagnostic::error("merge.part.differs", message).with_hint(hint))
}

fn different(part: &Part, first: &Part) -> Option<Diagnostic> {
    let (a, b) = (&part.work, &first.work);
    let (zh, en) = if a.versions.rules != b.versions.rules {
        ("使用了不同的规则", "was made with other rules")
    } else if a.request != b.request {
        ("回答的是不同的查询", "answers another question, or was made with another --limit or --lang")
    } else if a.list.plan != b.list.plan {
        ("属于不同的计划", "belongs to another plan")
    } else {
        return None;
    };
    let message = Bilingual::new(
        format!("分片 {} {zh}（对照 {}）", part.dir.display(), first.dir.display()),
        format!("part {} {en} (compared with {})", part.dir.display(), first.dir.display()),
    );
    Some(Diagnostic::error("merge.part.differs", message))
}

/// The lists of the parts together are the plan, and each part has the contents of its list.
fn against_plan(parts: &[Part]) -> Vec<Diagnostic> {
    let Some(plan) = parts.first().and_then(|p| p.work.list.plan.clone()) else {
        return vec![expected_unknown()];
    };
    let mut found = Vec::new();
    let there: BTreeSet<usize> = parts.iter().map(|p| p.work.list.list).collect();
    let absent: Vec<String> =
        (1..=plan.lists).filter(|i| !there.contains(i)).map(|i| i.to_string()).collect();
    if !absent.is_empty() {
        let (n, absent) = (plan.lists, absent.join(", "));
        let message = Bilingual::new(
            format!("计划共 {n} 个工作清单，缺少第 {absent} 个的分片"),
            format!("of the plan's {n} work lists there is no part of list {absent}"),
        );
        found.push(Diagnostic::error("merge.drive.missing", message));
    }
    let planned: BTreeMap<&DriveId, &str> = parts
        .iter()
        .flat_map(|p| p.work.list.drives.iter().map(|d| (&d.drive_id, d.content_hash.as_str())))
        .collect();
    let id = plan_id(planned.iter().map(|(id, hash)| (*id, *hash)));
    if found.is_empty() && (id != plan.id || planned.len() != plan.drives) {
        let message = Bilingual::new(
            "各工作清单合起来不是计划中的行程：清单被修改过",
            "the work lists together are not the drives of the plan: a list was changed",
        );
        found.push(Diagnostic::error("merge.drive.missing", message));
    }
    for part in parts {
        let of_list: BTreeSet<&DriveId> = part.work.list.drives.iter().map(|d| &d.drive_id).collect();
        let progress = &part.progress;
        let lacks = |id: &&DriveId| !progress.done.contains_key(*id) && !progress.failed.contains_key(*id);
        found.extend(missing(of_list.into_iter().filter(lacks)));
    }
    let changed = parts
        .iter()
        .flat_map(|p| p.progress.done.iter())
        .filter(|(id, (content, _))| planned.get(id).is_some_and(|hash| !hash.is_empty() && hash != content));
    found.extend(changed.map(|(id, _)| drive_changed(id)));
    found
}

/// The drives of the parts are those of the lake, with its contents.
fn against_lake(drives: &BTreeMap<DriveId, InPart>, lake: &Lake) -> Vec<Diagnostic> {
    let ids: BTreeSet<DriveId> = lake.drive_ids().into_iter().collect();
    let mut found: Vec<Diagnostic> =
        missing(ids.iter().filter(|id| !drives.contains_key(id))).into_iter().collect();
    for (id, of_drive) in drives {
        let gone = !ids.contains(id) && of_drive.span.is_some();
        let content = || lake.content_hash(id).unwrap_or_default();
        if gone || (of_drive.span.is_some() && content() != of_drive.content_hash) {
            found.push(drive_changed(id));
        }
    }
    found
}

fn missing<'a>(ids: impl Iterator<Item = &'a DriveId>) -> Option<Diagnostic> {
    let ids: Vec<&DriveId> = ids.collect();
    if ids.is_empty() {
        return None;
    }
    let (n, some) = (ids.len(), some_of(&ids));
    let message = Bilingual::new(
        format!("{n} 个行程不在任何分片中：{some}"),
        format!("{n} drives are in no part: {some}"),
    );
    let hint = Bilingual::new(
        "给出其余的分片，或先挖掘其余的工作清单",
        "name the other parts as well, or mine the other work lists first",
    );
    Some(Diagnostic::error("merge.drive.missing", message).with_hint(hint))
}

/// The first of the drives, and the number of the others.
fn some_of(ids: &[&DriveId]) -> String {
    let named: Vec<&str> = ids.iter().take(NAMED).map(|id| id.as_str()).collect();
    let more = ids.len() - named.len();
    named.join(", ") + &if more > 0 { format!(" (+{more})") } else { String::new() }
}

fn doubled(ids: &[&DriveId], first: &Part, second: &Part) -> Diagnostic {
    let (a, b, n, some) = (first.dir.display(), second.dir.display(), ids.len(), some_of(ids));
    let message = Bilingual::new(
        format!("{n} 个行程同时在分片 {a} 和 {b} 中：{some}"),
        format!("{n} drives are in part {a} and in part {b}: {some}"),
    );
    let list = |part: &Part| part.work.list.plan.as_ref().map(|plan| (plan.id.clone(), part.work.list.list));
    let hint = if list(first).is_some() && list(first) == list(second) {
        let list = first.work.list.list;
        Bilingual::new(
            format!("两者都是第 {list} 个工作清单的分片：只给出其中一个"),
            format!("both are parts of work list {list}: name one of them"),
        )
    } else {
        Bilingual::new("每个行程只能在一个工作清单中", "a drive may be in one work list only")
    };
    Diagnostic::error("merge.drive.doubled", message).with_hint(hint)
}

fn drive_changed(id: &DriveId) -> Diagnostic {
    let message = Bilingual::new(
        format!("行程 {id} 在计划或挖掘之后改变了"),
        format!("drive {id} has changed since it was planned or mined"),
    );
    let hint = Bilingual::new("用 --force 重新挖掘它的工作清单", "mine its work list again with --force");
    Diagnostic::error("merge.drive.changed", message).with_hint(hint)
}

fn incomplete(dir: &Path) -> Diagnostic {
    let dir = dir.display();
    let message = Bilingual::new(format!("分片 {dir} 尚未完成"), format!("part {dir} is not complete"));
    let hint = Bilingual::new(
        "再次运行同一命令，从中断处继续",
        "run the same command again; it continues where it was",
    );
    Diagnostic::error("merge.part.incomplete", message).with_hint(hint)
}

fn unreadable(dir: &Path, e: &PartError) -> Diagnostic {
    let dir = dir.display();
    let message =
        Bilingual::new(format!("分片 {dir} 无法读取：{e}"), format!("part {dir} cannot be read: {e}"));
    let hint = Bilingual::new("用 --force 重新生成该分片", "make the part again with --force");
    Diagnostic::error("merge.part.unreadable", message).with_hint(hint)
}

fn expected_unknown() -> Diagnostic {
    let message = Bilingual::new(
        "分片不属于任何计划，无法判断是否齐全",
        "the parts belong to no plan, so it is unknown which drives have to be there",
    );
    let hint = Bilingual::new("用 --lake 指定数据湖", "name the lake with --lake");
    Diagnostic::error("merge.expected.unknown", message).with_hint(hint)
}
