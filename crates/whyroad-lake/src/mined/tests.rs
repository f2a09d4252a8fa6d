use super::testing::record;
use super::*;
use proptest::prelude::*;
use std::sync::LazyLock;
use whyroad_model::messages::{EpisodeCursor, EpisodeFilter, EpisodeRecord};

fn question() -> MiningQuestion {
    MiningQuestion::Framework { scenarios: vec![] }
}

/// Three drives with 400, 0 and 1,000 episodes, some of which no class explains.
fn records() -> Vec<EpisodeRecord> {
    let one = |drive, i| match i % 7 {
        3 => EpisodeRecord { scenario_id: "other".parse().unwrap(), ..record(drive, i) },
        _ => record(drive, i),
    };
    let of = |drive: &'static str, n| (0..n).map(move |i| one(drive, i));
    of("a", 400).chain(of("c", 1000)).collect()
}

fn written(dir: &Path, records: &[EpisodeRecord]) -> MinedFolder {
    let mut writer = MinedFolderWriter::create(dir, question(), Existing::default()).unwrap();
    for r in records {
        writer.episode(r).unwrap();
    }
    writer.finish().unwrap();
    MinedFolder::open(dir).unwrap()
}

static FOLDER: LazyLock<(tempfile::TempDir, MinedFolder)> = LazyLock::new(|| {
    let dir = tempfile::tempdir().unwrap();
    let folder = written(dir.path(), &records());
    (dir, folder)
});

#[test]
fn a_folder_is_found_by_its_episodes() {
    let dir = tempfile::tempdir().unwrap();
    for name in ["a", "b", "empty"] {
        fs::create_dir_all(dir.path().join(name)).unwrap();
    }
    written(&dir.path().join("a"), &[]);
    written(&dir.path().join("b"), &[]);
    let names = |path: &Path| MinedFolder::find(path).unwrap().into_keys().collect::<Vec<_>>();
    assert_eq!(names(dir.path()), ["a", "b"]);
    assert_eq!(names(&dir.path().join("b")), ["b"]);
    assert!(names(&dir.path().join("empty")).is_empty());
    assert!(MinedFolder::find(&dir.path().join("missing")).is_err());
}

#[test]
fn a_pause_of_the_log_is_not_driving() {
    let dir = tempfile::tempdir().unwrap();
    let mut writer = MinedFolderWriter::create(dir.path(), question(), Existing::default()).unwrap();
    // 200 frames of 0.1 s, with ten minutes between the first half and the second.
    let clip = serde_json::json!({ "clip_metadata": {
        "clip_id": "d_000", "source": "van", "capture_time": "2026-03-01T08:00:00Z", "duration_sec": 620.0,
        "frame_rate": 10.0, "total_frames": 200, "drive_id": "d",
        "data_sources": { "video": [], "sensor": [], "can": false, "map": false },
    } });
    writer.clip(&serde_json::from_value(clip).unwrap()).unwrap();
    writer.finish().unwrap();
    let drives = MinedFolder::open(dir.path()).unwrap().drive_summaries().unwrap();
    assert_eq!(drives[&"d".into()].seconds, 20.0);
}

#[test]
fn what_is_read_is_what_was_written() {
    let all: Vec<EpisodeRecord> = FOLDER.1.episodes().unwrap().map(Result::unwrap).collect();
    assert_eq!(all, records());
    let page = FOLDER.1.index().unwrap().page(&EpisodeFilter::default(), None, usize::MAX).unwrap();
    assert_eq!((page.episodes, page.next), (records(), None));
}

proptest! {
    #[test]
    fn pages_together_are_what_the_filter_accepts(
        class in proptest::option::of(proptest::sample::select(vec![
            "reactive_agent", "reactive_agent.cutin", "reactive_agent.cutin.urgent", "reactive_agent.cut", "vru",
        ])),
        classes in proptest::option::of(proptest::sample::subsequence(
            vec!["reactive_agent.cutin.urgent", "reactive_agent.cutin", "other", "vru.none.such"], 0..4,
        )),
        drive in proptest::option::of(proptest::sample::select(vec!["a", "b", "c"])),
        explained_only: bool,
        primary_only: bool,
        min_score in proptest::option::of(0.0..1.0),
        limit in 50_usize..700,
    ) {
        let filter = EpisodeFilter {
            scenario: class.map(|c| c.parse().unwrap()),
            drive: drive.map(Into::into),
            classes: classes.map(|ids| ids.into_iter().map(str::to_owned).collect()),
            explained_only,
            primary_only,
            min_score,
        };
        let expected: Vec<EpisodeRecord> = records().into_iter().filter(|r| filter.accepts(r)).collect();
        let index = FOLDER.1.index().unwrap();
        prop_assert_eq!(index.count(&filter).unwrap(), expected.len() as u64);
        let (mut found, mut after) = (Vec::new(), None);
        loop {
            let page = index.page(&filter, after, limit).unwrap();
            prop_assert!(page.episodes.len() == limit || page.next.is_none());
            found.extend(page.episodes);
            after = page.next;
            if after.is_none() {
                break;
            }
        }
        prop_assert_eq!(found, expected);
    }
}

#[test]
fn a_cursor_behind_the_end_gives_an_empty_page() {
    let index = FOLDER.1.index().unwrap();
    for row in [1400, 1401, u64::MAX] {
        let page = index.page(&EpisodeFilter::default(), Some(EpisodeCursor(row)), 5).unwrap();
        assert_eq!((page.episodes.len(), page.next), (0, None), "{row}");
    }
}

#[test]
fn a_table_of_other_episodes_is_an_error() {
    let dir = tempfile::tempdir().unwrap();
    let folder = written(dir.path(), &records()[..5]);
    let index = folder.index().unwrap();
    let lines: Vec<String> =
        records()[5..10].iter().map(|r| serde_json::to_string(r).unwrap() + "\n").collect();
    fs::write(folder.path(MinedFile::Episodes), lines.concat()).unwrap();
    let error = index.page(&EpisodeFilter::default(), None, 10).unwrap_err();
    assert!(error.to_string().contains("the folder was changed"), "{error}");
}

#[test]
fn results_of_another_question_are_kept() {
    let dir = tempfile::tempdir().unwrap();
    let folder = written(dir.path(), &records()[..5]);
    let rule = MiningQuestion::Rule {
        scenario: "custom.slow".parse().unwrap(),
        rule: "ego.speed < 1 m/s".into(),
        target: None,
    };
    let create = |question: &MiningQuestion, existing| {
        MinedFolderWriter::create(dir.path(), question.clone(), existing).map(MinedFolderWriter::finish)
    };
    let refused = create(&rule, Existing::ReplaceSameQuestion).err().unwrap();
    assert!(matches!(&refused, MinedWriteError::OtherQuestion { found: Some(f), .. } if **f == question()));
    assert_eq!(folder.index().unwrap().count(&EpisodeFilter::default()).unwrap(), 5);
    assert_eq!(folder.question(), Some(question()));
    create(&rule, Existing::Replace).unwrap().unwrap();
    assert_eq!(folder.question(), Some(rule.clone()));
    assert_eq!(folder.index().unwrap().count(&EpisodeFilter::default()).unwrap(), 0);
    create(&rule, Existing::ReplaceSameQuestion).unwrap().unwrap();
    // A folder that does not record its question is not replaced either.
    fs::remove_file(folder.path(MinedFile::Question)).unwrap();
    let refused = create(&rule, Existing::ReplaceSameQuestion).err().unwrap();
    assert!(matches!(refused, MinedWriteError::OtherQuestion { found: None, .. }));
}

#[test]
fn a_broken_line_does_not_stop_the_rest() {
    let dir = tempfile::tempdir().unwrap();
    let good = serde_json::to_string(&record("d", 0)).unwrap();
    let path = dir.path().join("episodes.jsonl");
    fs::write(&path, format!("{good}\n{{\"episode_id\": 1}}\n\n{good}\n")).unwrap();
    let (good, bad): (Vec<_>, Vec<_>) = EpisodeLines::open(&path).unwrap().partition(Result::is_ok);
    assert_eq!((good.len(), bad.len()), (2, 1));
    let problem = bad[0].as_ref().unwrap_err();
    assert_eq!((problem.code, problem.location.line), ("report.episode.unreadable", Some(2)));
}

#[test]
fn coverage_that_is_cut_off_is_refused_with_its_place() {
    let coverage = Coverage {
        taxonomy_version: "1.0.0".into(),
        drives: vec!["d".into()],
        left_out: vec![],
        leaves: vec![],
        unresolved: vec![],
    };
    let text = serde_json::to_string_pretty(&coverage).unwrap();
    assert_eq!(parse_coverage(&text, "c").unwrap(), coverage);
    let cut = &text[..text.len() / 2];
    let problem = parse_coverage(cut, "c").unwrap_err();
    assert_eq!(problem.code, "report.coverage.unreadable");
    assert_eq!(problem.location.line, Some(cut.lines().count()));
}

#[test]
fn every_code_has_a_page_in_both_languages() {
    for code in CODES {
        let page = format!("{}/../../docs/diagnostics/{code}.md", env!("CARGO_MANIFEST_DIR"));
        let text = fs::read_to_string(&page).unwrap_or_else(|e| panic!("{page}: {e}"));
        assert!(text.contains("## 中文"), "{page}");
    }
}
