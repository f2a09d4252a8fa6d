//! A lake: each drive's signals read from its store (derived and stored where there are none), its episodes found, on
//! all cores. The only module that does I/O besides [`crate::output`]. The result depends neither on the number of
//! threads nor on stored or kept results of earlier runs; an interrupted run continues where it stopped.

mod kept;
mod prefilter;
mod stored;

pub use crate::drives::{derive_signals, signals_of};
pub use kept::key as rule_key;
pub use stored::{find_stored, read as read_columns};

use crate::drives::{derived_signals, map_drives, unreadable};
use crate::objects::signals_for;
use crate::output::record::{MinedEpisode, write_down};
use kept::Kept;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::panic::AssertUnwindSafe;
use std::sync::atomic::{AtomicBool, Ordering};
use whyroad_lake::{Lake, LakeError, Outline, cut_clip};
use whyroad_mining::Rule;
use whyroad_mining::drive::{DriveEpisodes, arbitrated};
use whyroad_mining::episode::{Found, find};
use whyroad_mining::fast::{Plan, Search, Signals, find_all};
use whyroad_mining::rule::RuleSet;
use whyroad_model::messages::ClipMetadata;
use whyroad_model::{
    Bilingual, ClipCut, ClipId, Diagnostic, Drive, DriveId, Lang, Nanos, ScenarioId, SignalTable,
};
use whyroad_signals::Wanted;

/// One drive's contribution.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MinedDrive {
    /// The drive.
    pub drive_id: DriveId,
    /// Its clips, without pre-labels.
    pub clips: Vec<ClipMetadata>,
    /// Episodes, in order of keyframe, class, target.
    pub episodes: Vec<MinedEpisode>,
    /// For each rule, by its class: the missing signals without which it cannot be decided (none: it was searched for).
    pub missing: BTreeMap<ScenarioId, Vec<String>>,
}

/// Results of a run over a lake.
#[derive(Clone, Debug, Default)]
pub struct MinedLake {
    /// Drives that could be read, by id.
    pub drives: Vec<MinedDrive>,
    /// One error for each drive that could not.
    pub diagnostics: Vec<Diagnostic>,
}

/// Which evaluator runs the rules. Results are identical.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Evaluator {
    /// The fast one, with all stored and kept results.
    #[default]
    Fast,
    /// The plain interpreter, from newly derived signals, keeping nothing: for comparison.
    Reference,
}

/// How to run.
#[derive(Clone, Copy, Debug, Default)]
pub struct MineOptions {
    /// Maximum number of drives in work at once, which bounds memory; `None` means all cores.
    pub jobs: Option<usize>,
    /// Which evaluator.
    pub evaluator: Evaluator,
    /// Language of texts in messages.
    pub lang: Lang,
    /// How clips are cut for episodes. The regular clips are always listed, so that lengths add up.
    pub clips: ClipCut,
    /// Where no signals of a drive are stored, derive only those that the rules use and store none: cheaper for one
    /// question, but not for the next one.
    pub once: bool,
}

/// Mines every drive of the lake. `done` is called after each drive, from any thread; texts in messages are in
/// `lang`.
pub fn mine_lake(lake: &Lake, rules: &RuleSet, lang: Lang, done: impl Fn(&DriveId) + Sync) -> MinedLake {
    mine_lake_with(lake, rules, &MineOptions { lang, ..MineOptions::default() }, done)
}

/// Mines every drive of the lake as the options say, and keeps all results in memory.
pub fn mine_lake_with(
    lake: &Lake,
    rules: &RuleSet,
    options: &MineOptions,
    done: impl Fn(&DriveId) + Sync,
) -> MinedLake {
    let mut drives = Vec::new();
    let kept: Result<_, std::convert::Infallible> = mine_each(lake, rules, options, done, |drive| {
        drives.push(drive);
        Ok(())
    });
    let Ok(diagnostics) = kept;
    MinedLake { drives, diagnostics }
}

/// Mines these drives of the lake in this order, and keeps all results in memory.
pub fn mine_drives(lake: &Lake, rules: &RuleSet, options: &MineOptions, ids: &[DriveId]) -> MinedLake {
    let miner = Miner::new(lake, rules, options);
    let mut out = MinedLake::default();
    let kept: Result<(), std::convert::Infallible> = map_drives(
        ids,
        options.jobs,
        |id| miner.drive(id),
        |mined| {
            match mined {
                Ok(drive) => out.drives.push(drive),
                Err(d) => out.diagnostics.push(*d),
            }
            Ok(())
        },
    );
    let Ok(()) = kept;
    out.diagnostics.extend(miner.published().or_else(|| miner.unwritable()));
    out
}

/// Mines every drive of the lake as the options say, and passes its results to `each`, in the order of their ids; an
/// error of `each` stops it. Returns an error for each drive that could not be read.
pub fn mine_each<E: Send>(
    lake: &Lake,
    rules: &RuleSet,
    options: &MineOptions,
    done: impl Fn(&DriveId) + Sync,
    mut each: impl FnMut(MinedDrive) -> Result<(), E>,
) -> Result<Vec<Diagnostic>, E> {
    let ids = lake.drive_ids();
    let miner = Miner::new(lake, rules, options);
    let one = |id: &DriveId| {
        let mined = miner.drive(id);
        done(id);
        mined
    };
    let mut diagnostics = Vec::new();
    map_drives(&ids, options.jobs, one, |mined: Result<MinedDrive, Box<Diagnostic>>| match mined {
        Ok(drive) => each(drive),
        Err(d) => {
            diagnostics.push(*d);
            Ok(())
        }
    })?;
    diagnostics.extend(miner.published().or_else(|| miner.unwritable()));
    Ok(diagnostics)
}

/// The episodes of a drive in memory: derived, searched and arbitrated now; nothing is read or stored. `plan` is that
/// of `rules`.
pub fn episodes_of(drive: &Drive, rules: &RuleSet, plan: &Plan<'_>) -> DriveEpisodes {
    let table = whyroad_signals::derive(drive);
    arbitrated(rules, &drive.meta.drive_id, &drive.times, found_of(drive, &table, rules, plan))
}

/// Results of each rule on a drive with its signals.
fn found_of(drive: &Drive, table: &SignalTable, rules: &RuleSet, plan: &Plan<'_>) -> Vec<Found> {
    let ordinary: Vec<usize> =
        (0..rules.rules.len()).filter(|i| rules.rules[*i].on_demand().is_none()).collect();
    let mut found = vec![Found::default(); rules.rules.len()];
    let signals = Signals::of_table(table);
    for (i, of_rule) in ordinary.iter().zip(Search::new(plan, &signals, ordinary.iter().copied()).found()) {
        found[*i] = of_rule;
    }
    for (i, rule) in rules.rules.iter().enumerate().filter(|(i, _)| !ordinary.contains(i)) {
        let own = signals_for(rule, || Ok(drive.clone()), || Ok(table.clone()));
        found[i] = own.map(|own| found_in(rule, &own)).unwrap_or_default();
    }
    found
}

/// Results of one rule on available signals, by the fast evaluator.
fn found_in(rule: &Rule, table: &SignalTable) -> Found {
    find_all(&Plan::of_rules([rule]), &Signals::of_table(table)).pop().unwrap_or_default()
}

/// Runs each rule on a drive.
type Find<'a> = fn(&Miner<'a>, &DriveId, &Outline) -> Result<Vec<Found>, LakeError>;

/// Mines single drives; holds what all drives of one run share. [`mine_each`] is a loop around it, and so is every
/// other engine that spreads drives over workers.
pub struct Miner<'a> {
    lake: &'a Lake,
    rules: &'a RuleSet,
    plan: Plan<'a>,
    /// Hash of each rule.
    keys: Vec<String>,
    options: &'a MineOptions,
    unwritable: AtomicBool,
}

impl<'a> Miner<'a> {
    /// A run with these rules.
    pub fn new(lake: &'a Lake, rules: &'a RuleSet, options: &'a MineOptions) -> Self {
        let keys = rules.rules.iter().map(kept::key).collect();
        Self { lake, rules, plan: Plan::of(rules), keys, options, unwritable: AtomicBool::new(false) }
    }

    /// The results of a drive. A drive that cannot be read, or on which the program panics, is an error of its own.
    pub fn drive(&self, id: &DriveId) -> Result<MinedDrive, Box<Diagnostic>> {
        self.guarded(id, Self::found)
    }

    /// [`Miner::drive`] of a drive whose tables were changed in place: its stored results are made again.
    pub fn drive_afresh(&self, id: &DriveId) -> Result<MinedDrive, Box<Diagnostic>> {
        self.guarded(id, Self::found_afresh)
    }

    fn guarded(&self, id: &DriveId, fast: Find<'a>) -> Result<MinedDrive, Box<Diagnostic>> {
        let mined = std::panic::catch_unwind(AssertUnwindSafe(|| self.mine_one(id, fast)));
        mined.unwrap_or_else(|_| Err(Box::new(crashed(id))))
    }

    /// Publishes the kept results, where it is in an object store; a warning where that fails.
    pub fn published(&self) -> Option<Diagnostic> {
        let e = self.lake.publish().err()?;
        let of_lake = e.diagnostic();
        Some(Diagnostic { severity: whyroad_model::Severity::Warning, ..of_lake })
    }

    /// A warning where the lake could not keep results.
    pub fn unwritable(&self) -> Option<Diagnostic> {
        self.unwritable.load(Ordering::Relaxed).then(|| unwritable(self.lake))
    }

    /// `fast` runs each rule where the fast evaluator is requested.
    fn mine_one(&self, id: &DriveId, fast: Find<'a>) -> Result<MinedDrive, Box<Diagnostic>> {
        let unreadable = |e: LakeError| unreadable(id, &e);
        let outline = self.lake.outline(id).map_err(unreadable)?;
        let found = match self.options.evaluator {
            Evaluator::Fast => fast(self, id, &outline).map_err(unreadable)?,
            Evaluator::Reference => {
                let table = derived_signals(self.lake, id).map_err(unreadable)?;
                let one = |rule: &Rule| {
                    let own = signals_for(rule, || self.lake.read_drive(id), || Ok(table.clone()));
                    own.map(|own| find(rule, &own))
                };
                self.rules.rules.iter().map(one).collect::<Result<_, _>>().map_err(unreadable)?
            }
        };
        Ok(self.written_down(id, outline, found))
    }

    /// A drive's results, from those of each rule.
    fn written_down(&self, id: &DriveId, outline: Outline, found: Vec<Found>) -> MinedDrive {
        let DriveEpisodes { episodes, missing, .. } = arbitrated(self.rules, id, &outline.times, found);
        let Outline { times, mut clips, .. } = outline;
        let mut episodes = write_down(&episodes, id, &times, self.options.clips, self.options.lang);
        for e in &mut episodes {
            e.record.rule_version = self.rule_version(&e.record.scenario_id);
        }
        if self.options.clips == ClipCut::Keyframe {
            clips.extend(around_keyframes(&episodes, &clips, &times, id));
        }
        MinedDrive { drive_id: id.clone(), clips, episodes, missing }
    }

    /// The version of the rule of a class: its hash, shortened. A class without a rule of its own (`other`) has none.
    fn rule_version(&self, class: &ScenarioId) -> Option<String> {
        let at = self.rules.rules.iter().position(|rule| rule.scenario == *class)?;
        self.keys.get(at).map(|key| key.chars().take(12).collect())
    }

    /// The results of each rule: kept from an earlier run, or computed now and kept.
    fn found(&self, id: &DriveId, outline: &Outline) -> Result<Vec<Found>, LakeError> {
        let hash = &outline.meta.content_hash;
        // Without a hash, equal content cannot be established.
        let content = self.lake.note(id, kept::FILE).filter(|_| !hash.is_empty());
        let mut kept = Kept::parse(content, &kept::state(hash));
        let mut found: Vec<Option<Found>> =
            self.keys.iter().zip(&self.rules.rules).map(|(key, rule)| kept.get(key, rule)).collect();
        let new: Vec<usize> = (0..found.len()).filter(|i| found[*i].is_none()).collect();
        if !new.is_empty() {
            for (i, of_rule) in new.iter().zip(self.run(id, &new)?) {
                kept.put(self.keys[*i].clone(), &of_rule);
                found[*i] = Some(of_rule);
            }
            let content = kept.content(&self.keys);
            self.note(self.lake.write_note(id, kept::FILE, &content));
        }
        Ok(found.into_iter().map(Option::unwrap_or_default).collect())
    }

    /// The results of each rule, computed from signals that are derived now; signals and results are kept.
    fn found_afresh(&self, id: &DriveId, outline: &Outline) -> Result<Vec<Found>, LakeError> {
        let drive = self.lake.read_drive(id)?;
        let table = whyroad_signals::derive(&drive);
        self.note(self.lake.write_signals(id, whyroad_signals::VERSION, &table));
        let found = found_of(&drive, &table, self.rules, &self.plan);
        let mut kept = Kept::parse(None, &kept::state(&outline.meta.content_hash));
        for (key, found) in self.keys.iter().zip(&found) {
            kept.put(key.clone(), found);
        }
        self.note(self.lake.write_note(id, kept::FILE, &kept.content(&self.keys)));
        Ok(found)
    }

    /// Runs these rules: those about any object on signals that are derived for them.
    fn run(&self, id: &DriveId, rules: &[usize]) -> Result<Vec<Found>, LakeError> {
        let of = |i: usize| &self.rules.rules[i];
        let stored: Vec<usize> = rules.iter().copied().filter(|i| of(*i).on_demand().is_none()).collect();
        let mut found =
            if stored.is_empty() { Vec::new() } else { self.run_stored(id, &stored)? }.into_iter();
        let one = |i: &usize| match of(*i).on_demand() {
            None => Ok(found.next().unwrap_or_default()),
            Some(_) => {
                let whole = || signals_of(self.lake, id);
                let own = signals_for(of(*i), || self.lake.read_drive(id), whole)?;
                Ok(found_in(of(*i), &own))
            }
        };
        rules.iter().map(one).collect()
    }

    /// Runs these rules on the stored signals; where there are none, derives and stores them, or derives only those
    /// that the rules use ([`MineOptions::once`]) and stores nothing: a store has all signals.
    fn run_stored(&self, id: &DriveId, rules: &[usize]) -> Result<Vec<Found>, LakeError> {
        if let Some(file) = self.lake.signals(id, whyroad_signals::VERSION)?
            && let Ok(found) = find_stored(&self.plan, &file, 0, rules)
        {
            return Ok(found);
        }
        // Missing, or unreadable: derived (again).
        let table = if self.options.once {
            let asked: BTreeSet<&str> = rules.iter().flat_map(|i| self.plan.rules[*i].names()).collect();
            whyroad_signals::derive_wanted(&self.lake.read_drive(id)?, &Wanted::only(asked))
        } else {
            let table = derived_signals(self.lake, id)?;
            self.note(self.lake.write_signals(id, whyroad_signals::VERSION, &table));
            table
        };
        Ok(Search::new(&self.plan, &Signals::of_table(&table), rules.iter().copied()).found())
    }

    /// A lake that cannot be written is still mined.
    fn note(&self, written: Result<(), LakeError>) {
        if written.is_err() {
            self.unwritable.store(true, Ordering::Relaxed);
        }
    }
}

/// The clips of the episodes that were cut around keyframes, in the order of their first frames.
fn around_keyframes(
    episodes: &[MinedEpisode],
    clips: &[ClipMetadata],
    times: &[Nanos],
    drive: &DriveId,
) -> Vec<ClipMetadata> {
    let ids: BTreeSet<&ClipId> = episodes.iter().map(|e| &e.record.clip_id).collect();
    let one = |id: &&ClipId| Some(cut_clip(clips.first()?, times, id, id.frames(drive, times)?));
    let mut out: Vec<ClipMetadata> = ids.iter().filter_map(one).collect();
    out.sort_by_key(|c| c.capture_time);
    out
}

fn crashed(id: &DriveId) -> Diagnostic {
    let message = Bilingual::new(
        format!("处理行程 {id} 时程序出错，已跳过"),
        format!("the program failed on drive {id}, which is left out"),
    );
    let hint = Bilingual::new(
        "这是程序缺陷：请附上标准错误中的 panic 信息报告",
        "this is a bug in the program: report it with the panic message on stderr",
    );
    Diagnostic::error("mine.drive.crashed", message).with_hint(hint)
}

fn unwritable(lake: &Lake) -> Diagnostic {
    let message = Bilingual::new(
        "数据湖不可写：信号与结果未保存，下次须重新计算",
        "the lake cannot be written: signals and findings are not kept and will be computed again next time",
    );
    let hint =
        Bilingual::new("检查该文件夹的写权限与磁盘空间", "check the folder's permissions and free space");
    Diagnostic::warning("mine.store.unwritable", message).in_file(lake.name()).with_hint(hint)
}
