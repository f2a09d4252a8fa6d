//! A mined folder mined again: unchanged drives are not opened, and the files are those of a run without a ledger;
//! changed, replaced, added and deleted drives are seen, in folders and in packs.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use whyroad_engine::again::{self, MinedAgain};
use whyroad_engine::mine::MineOptions;
use whyroad_engine::output::{FolderWriter, Question, Searched};
use whyroad_engine::parts::Request;
use whyroad_framework::Framework;
use whyroad_ingest::{Options as Ingest, find_sources, read};
use whyroad_lake::mined::{Existing, MiningQuestion};
use whyroad_lake::{CompactionOptions, Lake};
use whyroad_mining::RuleSet;
use whyroad_model::{ClipCut, Drive, Lang};
use whyroad_signals::Catalog;

/// A bundled drive.
fn drive() -> Drive {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/drives/back_street");
    let source = find_sources(None, &[folder]).0.remove(0);
    read(&source, &Ingest::default()).0.unwrap()
}

/// What is done to the content of a file.
type Change = fn(Vec<u8>) -> Vec<u8>;

struct Bench {
    dir: tempfile::TempDir,
    lake: Lake,
    drive: Drive,
    rules: RuleSet,
}

impl Bench {
    /// A lake of drives with these ids.
    fn new(ids: &[&str]) -> Self {
        let dir = tempfile::tempdir().unwrap();
        let lake = Lake::create_or_open(dir.path().join("lake")).unwrap();
        let rules = RuleSet::of_framework(Framework::bundled(), Catalog::bundled()).0;
        let bench = Self { dir, lake, drive: drive(), rules };
        ids.iter().for_each(|id| drop(bench.put(&bench.lake, id, 1.0)));
        bench
    }

    /// Writes the drive under an id; `pace` makes another drive of it, of the same number of rows.
    fn put(&self, lake: &Lake, id: &str, pace: f64) -> Drive {
        let mut drive = self.drive.clone();
        drive.meta.drive_id = id.into();
        drive.meta.content_hash = format!("{id}-{pace}");
        for track in &mut drive.tracks {
            track.motion.x.iter_mut().for_each(|x| *x *= pace);
        }
        lake.write_drive(&drive).unwrap();
        drive
    }

    fn mine(&self, out: &str) -> MinedAgain {
        self.mine_as(&self.lake, out, &self.rules, ClipCut::Fixed)
    }

    fn mine_as(&self, lake: &Lake, out: &str, rules: &RuleSet, clips: ClipCut) -> MinedAgain {
        let taxonomy = &Framework::bundled().taxonomy;
        let classes: Vec<_> = rules.rules.iter().map(|r| r.scenario.clone()).collect();
        let question = |id: &whyroad_model::ScenarioId| Question {
            query_id: format!("rules_{id}"),
            scenario: id.clone(),
            limit: None,
        };
        let request = Request {
            asked: MiningQuestion::Framework { scenarios: vec![] },
            questions: classes.iter().map(question).collect(),
            classes,
            searched: Searched::Framework,
            lang: Lang::En,
            clips,
        };
        let dir = self.dir.path().join(out);
        let state = again::state(&request, taxonomy, rules);
        let earlier = again::earlier(&dir, &state);
        let (asked, questions) = (request.asked.clone(), &request.questions);
        let mut folder = FolderWriter::create(
            &dir,
            asked,
            Existing::default(),
            questions,
            &request.classes,
            &rules.precedence,
        )
        .unwrap();
        folder.keep_ledger(&state).unwrap();
        let options = MineOptions { lang: Lang::En, clips, ..MineOptions::default() };
        let of = (lake, rules, &options);
        let mined = again::mine_into(&mut folder, earlier.as_ref(), of, |_| (), |drive| drive).unwrap();
        folder.finish(taxonomy, Searched::Framework).unwrap();
        assert!(mined.diagnostics.is_empty(), "{:?}", mined.diagnostics);
        mined
    }

    /// The files of a folder but its ledger, in which times of files are.
    fn files(&self, out: &str) -> BTreeMap<PathBuf, Vec<u8>> {
        let mut files = BTreeMap::new();
        let dir = self.dir.path().join(out);
        for folder in [dir.clone(), dir.join("mining_results")] {
            for entry in fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                if path.is_file() && !path.ends_with("ledger.jsonl") {
                    files.insert(path.strip_prefix(&dir).unwrap().to_owned(), fs::read(&path).unwrap());
                }
            }
        }
        assert!(!files[Path::new("episodes.jsonl")].is_empty());
        files
    }

    /// The folder is what a run into an empty folder writes; gives the number of drives that were not opened.
    fn same(&self) -> usize {
        let same = self.mine("mined").same;
        let fresh = self.dir.path().join("fresh");
        let _ = fs::remove_dir_all(&fresh);
        assert_eq!(self.mine("fresh").same, 0);
        for (path, content) in self.files("fresh") {
            assert!(self.files("mined")[&path] == content, "{} differs", path.display());
        }
        assert_eq!(self.files("mined").len(), self.files("fresh").len());
        same
    }

    fn kept(&self, id: &str) -> PathBuf {
        self.lake.dir().join("drives").join(id).join("found.json")
    }
}

#[test]
fn only_new_replaced_and_restated_drives_are_opened() {
    let bench = Bench::new(&["b", "d", "f"]);
    assert_eq!((bench.same(), bench.same()), (0, 3));
    // A drive that is not opened does not miss what is kept beside it.
    fs::remove_file(bench.kept("b")).unwrap();
    assert_eq!(bench.mine("mined").same, 3);
    assert!(!bench.kept("b").exists());

    // Before, between and after the others.
    for id in ["a", "c", "g"] {
        bench.put(&bench.lake, id, 1.0);
    }
    assert_eq!(bench.same(), 3);
    bench.put(&bench.lake, "d", 0.5);
    assert_eq!(bench.same(), 5);
    bench.lake.remove_drive(&"c".into()).unwrap();
    assert_eq!(bench.same(), 5);
    // What a drive states, without its tables.
    let path = bench.lake.dir().join("drives/f/drive.json");
    let text = fs::read_to_string(&path).unwrap();
    let at = text.find("\"meta\": {").unwrap() + 9;
    fs::write(&path, format!("{}\n    \"place\": \"Aachen\",{}", &text[..at], &text[at..])).unwrap();
    if !text.contains("\"place\"") {
        assert_eq!(bench.same(), 4);
        let clips = &bench.files("mined")[Path::new("clip_metadata.jsonl")];
        assert!(String::from_utf8_lossy(clips).contains("Aachen"));
    }
}

#[test]
fn a_table_that_was_changed_in_its_place_is_seen() {
    let bench = Bench::new(&["a", "b"]);
    bench.mine("mined");
    // Another lake with the same drive, of which the objects move otherwise.
    let other = Lake::create_or_open(bench.dir.path().join("other")).unwrap();
    for (id, pace) in [("a", 0.5), ("b", 1.0)] {
        bench.put(&other, id, pace);
    }
    bench.mine_as(&other, "expected", &bench.rules, ClipCut::Fixed);
    let table = |lake: &Lake| lake.dir().join("drives/a/tracks.parquet");
    fs::write(table(&bench.lake), fs::read(table(&other)).unwrap()).unwrap();
    assert_eq!(bench.mine("mined").same, 1);
    assert_eq!(bench.files("mined"), bench.files("expected"));
    // What is stored beside it was made again.
    assert_eq!(bench.same(), 2);
}

#[test]
fn a_drive_that_was_packed_is_the_same_drive() {
    let bench = Bench::new(&["a", "b", "c"]);
    bench.mine("mined");
    bench.lake.compact(&CompactionOptions::default(), |_, _| ()).unwrap();
    assert_eq!((bench.same(), bench.same()), (3, 3));
    bench.put(&bench.lake, "bb", 1.0);
    bench.put(&bench.lake, "b", 0.5);
    assert_eq!(bench.same(), 2);
    bench.lake.compact(&CompactionOptions::default(), |_, _| ()).unwrap();
    bench.lake.remove_drive(&"a".into()).unwrap();
    assert_eq!(bench.same(), 3);
    assert_eq!(bench.lake.drive_ids().len(), 3);
}

#[test]
fn a_ledger_of_other_rules_clips_or_files_does_not_count() {
    let bench = Bench::new(&["a", "b"]);
    let mut fewer = bench.rules.clone();
    fewer.rules.pop();
    let again = |rules: &RuleSet, clips| bench.mine_as(&bench.lake, "mined", rules, clips).same;
    assert_eq!([again(&bench.rules, ClipCut::Fixed), again(&bench.rules, ClipCut::Fixed)], [0, 2]);
    assert_eq!([again(&fewer, ClipCut::Fixed), again(&fewer, ClipCut::Fixed)], [0, 2]);
    assert_eq!(again(&fewer, ClipCut::Keyframe), 0);

    let at = |name: &str| bench.dir.path().join("mined").join(name);
    bench.mine("mined");
    assert_eq!(bench.mine("mined").same, 2);
    let damage: [(&str, Change); 4] = [
        // A line of another program; a ledger that was cut short, has lost its seal, or is not JSON.
        ("pre_labels.jsonl", |text| [text, b"{}\n".to_vec()].concat()),
        ("ledger.jsonl", |text| text[..text.len() - 20].to_vec()),
        ("ledger.jsonl", |text| {
            let end = text[..text.len() - 1].iter().rposition(|b| *b == b'\n').unwrap();
            text[..=end].to_vec()
        }),
        ("ledger.jsonl", |_| b"[]\n".to_vec()),
    ];
    for (name, change) in damage {
        let text = fs::read(at(name)).unwrap();
        fs::write(at(name), change(text)).unwrap();
        assert_eq!(bench.same(), 0, "{name}");
        assert_eq!(bench.same(), 2);
    }
    // A run that was killed between its files and its ledger.
    fs::remove_file(at("ledger.jsonl")).unwrap();
    assert_eq!(bench.same(), 0);
}
