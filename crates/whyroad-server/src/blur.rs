//! Blurs faces and plates in camera images before an image leaves the service, with a program of the operator that runs
//! once per image. Its output is kept; if it fails, no image is shown.

use crate::problem::{Answer, Problem};
use crate::secret;
use crate::store::private;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::{Condvar, Mutex};
use std::time::{Duration, Instant, UNIX_EPOCH};

/// Maximum time of the program for one image.
const TIME: Duration = Duration::from_secs(60);
/// Interval for checking whether it has ended.
const LOOK_EVERY: Duration = Duration::from_millis(15);
/// Maximum number of programs that run at once.
const AT_ONCE: usize = 2;
/// Maximum number of requests that wait for a turn. Each occupies one of the service's requests in work, so that others
/// would wait for a program that is slow or hangs.
const MOST_WAITING: usize = 64;
/// Age from which a file that a run left behind is removed.
const LEFT_BEHIND: Duration = TIME.saturating_mul(2);

/// The program, and the folder of its output.
#[derive(Debug)]
pub struct Blur {
    program: PathBuf,
    cache: PathBuf,
    turns: Mutex<Turns>,
    ended: Condvar,
}

/// Programs that run, and requests that wait for one to end.
#[derive(Debug, Default)]
struct Turns {
    running: usize,
    waiting: usize,
}

impl Blur {
    /// `program` is called as `program INPUT OUTPUT` and exits with 0 when OUTPUT is the image to show, in the same
    /// format. Images are kept in `cache`, a folder that only its owner can access.
    pub fn new(program: PathBuf, cache: PathBuf) -> std::io::Result<Self> {
        private::folder(&cache)?;
        remove_left_behind(&cache)?;
        Ok(Self { program, cache, turns: Mutex::default(), ended: Condvar::new() })
    }

    /// The image to show instead of `file`.
    pub fn image(&self, file: &Path) -> Answer<PathBuf> {
        let about = std::fs::metadata(file).map_err(|_| Problem::missing())?;
        let changed =
            about.modified().ok().and_then(|t| t.duration_since(UNIX_EPOCH).ok()).map_or(0, |d| d.as_nanos());
        // Another program or a changed image gives another result.
        let key = format!("{}\n{}\n{changed}\n{}", self.program.display(), file.display(), about.len());
        self.once(&key, extension(file), |kept| self.make(file, kept))
    }

    /// The image to show instead of one in an object store, which `read` fetches. The original is not kept.
    pub fn stored_image(&self, name: &str, read: impl FnOnce() -> Answer<Vec<u8>>) -> Answer<PathBuf> {
        let extension = extension(Path::new(name));
        let content = read()?;
        let key = format!("{}\n{}", self.program.display(), secret::hash_bytes(&content));
        self.once(&key, extension, |kept| {
            let file = self.cache.join(format!("{}.in.{extension}", secret::id()?));
            let written = std::fs::write(&file, content).map_err(|e| failed(&e.to_string()));
            let made = written.and_then(|()| self.make(&file, kept));
            let _ = std::fs::remove_file(&file);
            made
        })
    }

    /// The image kept under `key`; created by `make` if it does not exist when its turn comes.
    fn once(&self, key: &str, extension: &str, make: impl FnOnce(&Path) -> Answer<()>) -> Answer<PathBuf> {
        let kept = self.cache.join(format!("{}.{extension}", secret::hash(key)));
        if kept.is_file() {
            return Ok(kept);
        }
        let turn = self.turn()?;
        let made = if kept.is_file() { Ok(()) } else { make(&kept) };
        drop(turn);
        made.map(|()| kept)
    }

    fn make(&self, file: &Path, kept: &Path) -> Answer<()> {
        let aside = self.cache.join(format!("{}.part.{}", secret::id()?, extension(file)));
        let made = self.run(file, &aside);
        let done = made.and_then(|()| {
            if std::fs::metadata(&aside).is_ok_and(|m| m.len() > 0) && same_format(file, &aside) {
                std::fs::rename(&aside, kept).map_err(|e| failed(&e.to_string()))
            } else {
                Err(failed("it did not write an image in the same format"))
            }
        });
        // Nothing is kept after a failure.
        let _ = std::fs::remove_file(&aside);
        done
    }

    fn run(&self, file: &Path, out: &Path) -> Answer<()> {
        let mut child = crate::memory::without_limit(&mut Command::new(&self.program))
            .arg(file)
            .arg(out)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .map_err(|e| failed(&e.to_string()))?;
        let begun = Instant::now();
        loop {
            match child.try_wait() {
                Ok(Some(status)) if status.success() => return Ok(()),
                Ok(Some(status)) => return Err(failed(&status.to_string())),
                Ok(None) if begun.elapsed() < TIME => std::thread::sleep(LOOK_EVERY),
                Ok(None) => {
                    let _ = child.kill();
                    let _ = child.wait();
                    return Err(failed("it took too long"));
                }
                Err(e) => return Err(failed(&e.to_string())),
            }
        }
    }

    fn turn(&self) -> Answer<Turn<'_>> {
        let mut turns = self.turns.lock().map_err(Problem::store)?;
        if turns.waiting >= MOST_WAITING {
            return Err(Problem::new(
                503,
                "media.busy",
                "正在处理的图片过多，请稍后再试",
                "too many images are being processed: try again later",
            ));
        }
        turns.waiting += 1;
        while turns.running >= AT_ONCE {
            turns = self.ended.wait(turns).map_err(Problem::store)?;
        }
        turns.waiting -= 1;
        turns.running += 1;
        Ok(Turn(self))
    }
}

fn extension(file: &Path) -> &str {
    file.extension().and_then(|e| e.to_str()).unwrap_or("img")
}

/// Removes what runs left behind that ended with the service: their unfinished output, and copies of originals.
fn remove_left_behind(cache: &Path) -> std::io::Result<()> {
    for entry in std::fs::read_dir(cache)? {
        let entry = entry?;
        let name = entry.file_name();
        // The folder also has every image that was blurred: only the names of those are read.
        if !name.to_str().is_some_and(|n| n.contains(".part.") || n.contains(".in.")) {
            continue;
        }
        let age = entry.metadata().and_then(|m| m.modified()).ok().and_then(|at| at.elapsed().ok());
        if age.is_some_and(|age| age > LEFT_BEHIND) {
            match std::fs::remove_file(entry.path()) {
                // Another service that starts has removed it.
                Err(e) if e.kind() == std::io::ErrorKind::NotFound => {}
                removed => removed?,
            }
        }
    }
    Ok(())
}

/// Permission to run one program.
struct Turn<'b>(&'b Blur);

impl Drop for Turn<'_> {
    fn drop(&mut self) {
        if let Ok(mut turns) = self.0.turns.lock() {
            turns.running -= 1;
        }
        self.0.ended.notify_one();
    }
}

/// Both files start with the signature of the same image format.
fn same_format(a: &Path, b: &Path) -> bool {
    let kind = |path: &Path| {
        let mut head = [0; 12];
        let mut file = std::fs::File::open(path).ok()?;
        std::io::Read::read_exact(&mut file, &mut head).ok()?;
        Some(match head {
            [0xff, 0xd8, ..] => 1,
            [0x89, b'P', b'N', b'G', ..] => 2,
            [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P'] => 3,
            _ => return None,
        })
    };
    kind(a).is_some_and(|k| kind(b) == Some(k))
}

fn failed(why: &str) -> Problem {
    Problem::new(
        503,
        "media.blur",
        format!("图片未能脱敏，因此不显示：{why}"),
        format!("the image could not be blurred and is not shown: {why}"),
    )
}

#[cfg(all(test, unix))]
#[allow(clippy::unwrap_used, reason = "a test says what went wrong by failing")]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt as _;

    const PNG: &[u8] = b"\x89PNG\r\n\x1a\n0000 face";

    fn blur(dir: &Path, script: &str) -> Blur {
        let program = dir.join("blur.sh");
        std::fs::write(&program, format!("#!/bin/sh\n{script}\n")).unwrap();
        std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o755)).unwrap();
        Blur::new(program, dir.join("cache")).unwrap()
    }

    #[test]
    fn an_image_is_blurred_once_and_again_when_it_changes() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("a.png");
        std::fs::write(&file, PNG).unwrap();
        let blur = blur(
            dir.path(),
            &format!("echo x >> {}/calls; sed s/face/xxxx/ \"$1\" > \"$2\"", dir.path().display()),
        );
        let shown = blur.image(&file).unwrap();
        assert!(std::fs::read(&shown).unwrap().ends_with(b"xxxx"));
        assert_eq!(blur.image(&file).unwrap(), shown);
        std::fs::write(&file, [PNG, b" face"].concat()).unwrap();
        assert_ne!(blur.image(&file).unwrap(), shown);
        assert_eq!(std::fs::read_to_string(dir.path().join("calls")).unwrap(), "x\nx\n");
    }

    #[test]
    fn a_program_that_hangs_does_not_take_all_requests() {
        let dir = tempfile::tempdir().unwrap();
        let go_on = dir.path().join("go_on");
        let script = format!("until [ -e {} ]; do sleep 0.02; done; cp \"$1\" \"$2\"", go_on.display());
        let blur = blur(dir.path(), &script);
        let asked = AT_ONCE + MOST_WAITING + 10;
        let files: Vec<PathBuf> = (0..asked).map(|i| dir.path().join(format!("{i}.png"))).collect();
        files.iter().for_each(|file| std::fs::write(file, PNG).unwrap());
        let (done, outcomes) = std::sync::mpsc::channel();
        std::thread::scope(|scope| {
            for file in &files {
                let (blur, done) = (&blur, done.clone());
                scope.spawn(move || done.send(blur.image(file).err().map(|e| e.code)).unwrap());
            }
            // Those beyond the limit are refused while the program still runs.
            let refused: Vec<_> = outcomes.iter().take(10).collect();
            std::fs::write(&go_on, "").unwrap();
            assert_eq!(refused, [Some("media.busy"); 10]);
        });
        drop(done);
        assert!(outcomes.iter().all(|outcome| outcome.is_none()), "the others get their image");
    }

    #[test]
    fn what_an_interrupted_run_left_is_removed() {
        let dir = tempfile::tempdir().unwrap();
        let kept = blur(dir.path(), "exit 1").cache.join("kept.png");
        let left = ["a.part.png", "a.in.png"].map(|name| kept.with_file_name(name));
        let new = kept.with_file_name("b.part.png");
        let old = std::time::SystemTime::now() - LEFT_BEHIND * 2;
        for file in left.iter().chain([&kept, &new]) {
            let file_of = std::fs::File::create(file).unwrap();
            if *file != new {
                file_of.set_modified(old).unwrap();
            }
        }
        drop(blur(dir.path(), "exit 1"));
        assert_eq!([&left[0], &left[1], &kept, &new].map(|f| f.exists()), [false, false, true, true]);
    }

    #[test]
    fn where_it_fails_nothing_is_shown_and_nothing_is_kept() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("a.png");
        std::fs::write(&file, PNG).unwrap();
        for script in
            ["exit 3", "true", ": > \"$2\"", "cp \"$1\" \"$2\"; exit 1", "echo no image at all > \"$2\""]
        {
            let blur = blur(dir.path(), script);
            assert_eq!(blur.image(&file).unwrap_err().code, "media.blur", "{script}");
            assert_eq!(std::fs::read_dir(dir.path().join("cache")).unwrap().count(), 0, "{script}");
        }
        let gone = Blur::new(dir.path().join("no-program"), dir.path().join("cache")).unwrap();
        assert_eq!(gone.image(&file).unwrap_err().code, "media.blur");
    }
}
