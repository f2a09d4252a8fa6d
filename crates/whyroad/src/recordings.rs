//! What the labelling service needs of the rest: drives out of a lake, signals derived from them, drafts, mined folders,
//! pictures. Glue only: each answer is one call of the crate that knows.

use anyhow::{Context as _, bail};
use std::collections::{BTreeMap, VecDeque};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use whyroad_framework::Framework;
use whyroad_label::draft;
use whyroad_lake::{Lake, Stamp};
use whyroad_model::messages::{CocLabel, EpisodeRecord};
use whyroad_model::scene::MediaFrame;
use whyroad_model::{Drive, DriveId, Lang, SignalTable};
use whyroad_report::mined;
use whyroad_server::domain::scene::{SignalAbout, SignalKind};
use whyroad_server::recordings::Recordings;
use whyroad_signals::{Catalogue, SignalKind as Kind};

/// Drives kept in memory: people who work at the same time mostly work on the same drives.
const KEPT: usize = 12;
/// What mining calls its list of episodes.
const EPISODES: &str = "episodes.jsonl";
/// Pictures that browsers show.
const PICTURES: &[&str] = &["jpg", "jpeg", "png", "webp"];

/// Recordings of one lake. Drives, pictures and mined folders that come while the service runs are seen at once.
pub(crate) struct LakeRecordings {
    lake: Lake,
    framework: &'static Framework,
    mined: Vec<PathBuf>,
    media: Vec<PathBuf>,
    kept: Mutex<VecDeque<Kept>>,
}

/// A drive in memory, with the stamp that it had on disk before it was read.
struct Kept {
    id: DriveId,
    stamp: Stamp,
    drive: Arc<Drive>,
}

impl LakeRecordings {
    /// Drives of `lake`; `mined` are folders that `whyroad mine` wrote, or folders of such folders; `media` are folders
    /// in which the pictures lie that the lake names.
    pub(crate) fn open(
        lake: Lake,
        framework: &'static Framework,
        mined: &[PathBuf],
        media: &[PathBuf],
    ) -> anyhow::Result<Self> {
        for dir in mined {
            if mined_folders(dir)?.is_empty() {
                bail!("{} has no {EPISODES}; `whyroad mine --out DIR` writes it", dir.display());
            }
        }
        let own = lake.dir().join("media");
        let media = media.iter().chain([&own]).cloned().collect();
        Ok(Self { lake, framework, mined: mined.to_vec(), media, kept: Mutex::default() })
    }

    /// Mined folders by name, as they are now. One that cannot be read at the moment has none.
    fn folders(&self) -> BTreeMap<String, PathBuf> {
        self.mined.iter().filter_map(|dir| mined_folders(dir).ok()).flatten().collect()
    }

    /// The drives in memory. What is in there stays whole even when a thread that held it has died.
    fn kept(&self) -> MutexGuard<'_, VecDeque<Kept>> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Name and folder of the mining results at or directly below `dir`.
fn mined_folders(dir: &Path) -> anyhow::Result<BTreeMap<String, PathBuf>> {
    let named = |path: PathBuf| {
        let real = path.canonicalize().unwrap_or_else(|_| path.clone());
        (real.file_name().unwrap_or_default().to_string_lossy().into_owned(), path)
    };
    if dir.join(EPISODES).is_file() {
        return Ok([named(dir.to_owned())].into());
    }
    let entries = std::fs::read_dir(dir).with_context(|| format!("cannot read {}", dir.display()))?;
    Ok(entries.flatten().map(|e| e.path()).filter(|p| p.join(EPISODES).is_file()).map(named).collect())
}

impl Recordings for LakeRecordings {
    fn drive(&self, id: &DriveId) -> Result<Arc<Drive>, String> {
        let stamp = self.lake.stamp(id).map_err(|e| e.to_string())?;
        if let Some(kept) = self.kept().iter().find(|k| k.id == *id && k.stamp == stamp) {
            return Ok(Arc::clone(&kept.drive));
        }
        let drive = Arc::new(self.lake.read_drive(id).map_err(|e| e.to_string())?);
        let mut kept = self.kept();
        kept.retain(|k| k.id != *id);
        kept.push_front(Kept { id: id.clone(), stamp, drive: Arc::clone(&drive) });
        kept.truncate(KEPT);
        Ok(drive)
    }

    fn version(&self, id: &DriveId) -> String {
        // A drive that is not to be had says so when it is asked for.
        self.lake.stamp(id).map_or_else(|_| String::new(), |stamp| format!("{stamp:?}"))
    }

    fn signals(&self, drive: &Drive) -> SignalTable {
        // Never the lake's stored tables: those were derived from the whole drive and look ahead.
        whyroad_signals::derive(drive)
    }

    fn about(&self, name: &str) -> Option<SignalAbout> {
        let def = Catalogue::bundled().get(name)?;
        let (kind, unit) = match &def.kind {
            // Columns hold base units, whatever the catalogue writes.
            Kind::Number(dimension) => (SignalKind::Number, dimension.base().symbol),
            Kind::Flag => (SignalKind::Flag, ""),
            Kind::Category(_) => (SignalKind::Category, ""),
        };
        let unit = (!unit.is_empty()).then(|| unit.to_owned());
        Some(SignalAbout { kind, unit, meaning: def.meaning.clone() })
    }

    fn draft(&self, drive: &Drive, signals: &SignalTable, episode: &EpisodeRecord, lang: Lang) -> CocLabel {
        draft::draft(self.framework, drive, signals, episode, lang).label
    }

    fn mined(&self) -> Vec<String> {
        self.folders().into_keys().collect()
    }

    fn episodes(&self, name: &str) -> Option<Vec<EpisodeRecord>> {
        let path = self.folders().get(name)?.join(EPISODES);
        let text = std::fs::read_to_string(&path).ok()?;
        let (episodes, problems) = mined::read_episodes(&text, &path.display().to_string());
        for d in &problems {
            tell!("{}", crate::output::render_text(d, Lang::En));
        }
        Some(episodes)
    }

    fn media(&self, drive: &DriveId, frame: &MediaFrame) -> Option<PathBuf> {
        let extension = Path::new(&frame.uri).extension()?.to_string_lossy().to_lowercase();
        if !PICTURES.contains(&extension.as_str()) {
            return None;
        }
        // As the log names it: from its own folder, or from the folder of all logs.
        let places = |root: &PathBuf| [root.join(drive.as_str()).join(&frame.uri), root.join(&frame.uri)];
        // Looked up each time: the lake's own folder comes with the first `whyroad media add --copy`.
        let roots: Vec<PathBuf> = self.media.iter().filter_map(|d| d.canonicalize().ok()).collect();
        let found = roots.iter().flat_map(|root| places(root).map(|p| (root, p)));
        // A name with `..` or a link must not lead out of the folder that was opened to the service.
        found
            .filter_map(|(root, path)| Some((root, path.canonicalize().ok()?)))
            .find(|(root, path)| path.starts_with(root) && path.is_file())
            .map(|(_, path)| path)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use whyroad_model::Nanos;

    fn frame(uri: &str) -> MediaFrame {
        MediaFrame { camera: "front".into(), time: Nanos(0), uri: uri.into(), index: 0 }
    }

    #[test]
    fn pictures_are_found_below_the_opened_folders_and_nowhere_else() {
        let dir = tempfile::tempdir().unwrap();
        let at = |p: &str| dir.path().join(p);
        for (path, text) in [
            ("logs/d1/cam/1.jpg", "a"),
            ("logs/samples/2.PNG", "b"),
            ("secret.jpg", "c"),
            ("logs/d1/notes.txt", "d"),
        ] {
            std::fs::create_dir_all(at(path).parent().unwrap()).unwrap();
            std::fs::write(at(path), text).unwrap();
        }
        let lake = Lake::create_or_open(at("lake")).unwrap();
        let recordings = LakeRecordings::open(lake, Framework::bundled(), &[], &[at("logs")]).unwrap();
        let text = |uri: &str| {
            let path = recordings.media(&DriveId::from("d1"), &frame(uri))?;
            Some(std::fs::read_to_string(path).unwrap())
        };
        assert_eq!(text("cam/1.jpg").as_deref(), Some("a"));
        assert_eq!(text("samples/2.PNG").as_deref(), Some("b"));
        let absolute = at("secret.jpg").display().to_string();
        for outside in
            ["../secret.jpg", "../../secret.jpg", &absolute, "notes.txt", "cam/none.jpg", "cam", ""]
        {
            assert_eq!(text(outside), None, "{outside}");
        }
    }

    #[test]
    fn signals_are_told_in_the_unit_of_their_columns() {
        let dir = tempfile::tempdir().unwrap();
        let lake = Lake::create_or_open(dir.path()).unwrap();
        let recordings = LakeRecordings::open(lake, Framework::bundled(), &[], &[]).unwrap();
        let unit = |name: &str| recordings.about(name).map(|a| (a.kind, a.unit));
        // As schema/signals.yaml says; an angle written in degrees there is a column in radians.
        assert_eq!(unit("ego.accel"), Some((SignalKind::Number, Some("m/s2".into()))));
        assert_eq!(unit("map.sight_angle"), Some((SignalKind::Number, Some("rad".into()))));
        assert_eq!(unit("target.visible_share"), Some((SignalKind::Number, None)));
        assert_eq!(unit("target.emerges"), Some((SignalKind::Flag, None)));
        assert_eq!(unit("lead.class"), Some((SignalKind::Category, None)));
        assert_eq!(unit("ego.no_such"), None);
    }

    #[test]
    fn what_comes_while_the_service_runs_is_seen() {
        let dir = tempfile::tempdir().unwrap();
        let at = |p: &str| dir.path().join(p);
        std::fs::create_dir_all(at("mined/week1")).unwrap();
        std::fs::write(at("mined/week1").join(EPISODES), "").unwrap();
        let lake = Lake::create_or_open(at("lake")).unwrap();
        let recordings =
            LakeRecordings::open(lake.clone(), Framework::bundled(), &[at("mined")], &[]).unwrap();
        let id = DriveId::from("d1");
        assert!(recordings.drive(&id).unwrap_err().contains("d1"));

        let mut drive = Drive { times: vec![Nanos(0), Nanos(100_000_000)], ..Drive::default() };
        drive.meta.drive_id = id.clone();
        lake.write_drive(&drive).unwrap();
        let first = recordings.drive(&id).unwrap();
        assert!(first.media.is_none());
        assert!(Arc::ptr_eq(&first, &recordings.drive(&id).unwrap()), "read once");

        let before = recordings.version(&id);
        std::fs::create_dir_all(lake.dir().join("media/d1")).unwrap();
        std::fs::write(lake.dir().join("media/d1/1.jpg"), "picture").unwrap();
        let picture = MediaFrame { time: drive.times[0], ..frame("1.jpg") };
        lake.write_media(&id, std::slice::from_ref(&picture)).unwrap();
        assert_ne!(recordings.version(&id), before);
        assert_eq!(recordings.drive(&id).unwrap().media.as_deref(), Some(&[picture.clone()][..]));
        assert!(recordings.media(&id, &picture).is_some(), "the lake's own folder came later");

        assert_eq!(recordings.mined(), ["week1"]);
        std::fs::create_dir_all(at("mined/week2")).unwrap();
        std::fs::write(at("mined/week2").join(EPISODES), "").unwrap();
        assert_eq!(recordings.mined(), ["week1", "week2"]);
        assert_eq!(recordings.episodes("week2").map(|e| e.len()), Some(0));
    }

    #[test]
    fn mined_folders_are_named_by_their_folder() {
        let dir = tempfile::tempdir().unwrap();
        for name in ["a", "b", "empty"] {
            std::fs::create_dir_all(dir.path().join(name)).unwrap();
        }
        for name in ["a", "b"] {
            std::fs::write(dir.path().join(name).join(EPISODES), "").unwrap();
        }
        let names = |dir: &Path| mined_folders(dir).unwrap().into_keys().collect::<Vec<_>>();
        assert_eq!(names(dir.path()), ["a", "b"]);
        assert_eq!(names(&dir.path().join("b")), ["b"]);
        let lake = || Lake::create_or_open(dir.path().join("lake")).unwrap();
        let empty = LakeRecordings::open(lake(), Framework::bundled(), &[dir.path().join("empty")], &[]);
        assert!(empty.err().unwrap().to_string().contains("episodes.jsonl"));
    }
}
