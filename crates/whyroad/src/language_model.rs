//! The language model of the labeling service: `whyroad-chat`, with the drives and images that the service shows,
//! behind the traits that the service knows. The key stays in the client's settings.

use crate::arguments::share;
use crate::model_args::ModelArgs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use whyroad_chat::draft::{Drafter, NoDraft};
use whyroad_chat::judge::{Judge, is_for_people};
use whyroad_chat::scene::Images;
use whyroad_chat::{Client, ImageKind, Settings};
use whyroad_framework::Framework;
use whyroad_label::check::{Checker, Recorded};
use whyroad_label::judged::JudgedLabel;
use whyroad_model::messages::{CocLabel, EpisodeRecord};
use whyroad_model::scene::MediaFrame;
use whyroad_model::{Bilingual, Diagnostic, Drive, DriveId, Lang, ModelSpent};
use whyroad_server::blur::Blur;
use whyroad_server::language_model::{LanguageModel, ModelFailure, ModelSession};
use whyroad_server::problem::Problem;
use whyroad_server::recordings::{CheckedDrives, Recordings};

/// Seed of the choice of labels that people judge, as `whyroad judge` has it by default.
const PEOPLE_SEED: u64 = 1;

/// Options of the service's model.
#[derive(clap::Args, Clone, Debug)]
pub(crate) struct ServiceModelArgs {
    /// Language model at this address (OpenAI-compatible, https://host/v1): leads can have it draft tasks and judge
    /// labels. Limits on requests and tokens are for each run that a lead starts
    #[arg(long, value_name = "URL")]
    model: Option<String>,
    /// Tasks that the model works on at once
    #[arg(long, value_name = "N", default_value_t = 4, requires = "model",
          value_parser = clap::value_parser!(u16).range(1..=64))]
    model_jobs: u16,
    /// Share of the judged labels for which people answer the same questions, 0 to 1
    #[arg(long, value_name = "SHARE", default_value_t = 0.1, requires = "model", value_parser = share)]
    people_share: f64,
    #[command(flatten)]
    how: ModelArgs,
}

impl ServiceModelArgs {
    /// The model that the options name. An error where they cannot be used: the key's variable is unset, or the address
    /// is invalid. Answers are kept in `data`; images are blurred by `blur` before they are sent.
    pub(crate) fn model(
        &self,
        framework: &'static Framework,
        recordings: &Arc<dyn Recordings>,
        (data, blur): (&Path, Option<Arc<Blur>>),
        lang: Lang,
    ) -> anyhow::Result<Option<Arc<dyn LanguageModel>>> {
        let Some(url) = &self.model else { return Ok(None) };
        let settings = self.how.settings(url, data.join("model-answers"), lang)?;
        // Errors in the settings are reported now, not when the first run begins.
        Client::new(settings.clone())
            .map_err(|e| anyhow::anyhow!("{}", e.diagnostic().message(lang).to_owned()))?;
        let checker =
            Checker::new(framework).with_recordings(Arc::new(CheckedDrives(Arc::clone(recordings))));
        Ok(Some(Arc::new(ServiceModel {
            settings,
            at_once: usize::from(self.model_jobs),
            source: Arc::new(Source {
                framework,
                checker,
                recordings: Arc::clone(recordings),
                blur,
                people_share: self.people_share,
            }),
        })))
    }
}

/// Inputs of questions.
struct Source {
    framework: &'static Framework,
    checker: Checker<'static>,
    recordings: Arc<dyn Recordings>,
    blur: Option<Arc<Blur>>,
    people_share: f64,
}

struct ServiceModel {
    settings: Settings,
    at_once: usize,
    source: Arc<Source>,
}

impl LanguageModel for ServiceModel {
    fn name(&self) -> &str {
        &self.settings.model
    }

    fn at_once(&self) -> usize {
        self.at_once
    }

    fn begin(&self, spent: &ModelSpent) -> Result<Arc<dyn ModelSession>, Bilingual> {
        let mut settings = self.settings.clone();
        let budget = &mut settings.budget;
        budget.requests = budget.requests.map(|most| most.saturating_sub(spent.requests));
        let tokens = spent.input_tokens + spent.output_tokens;
        budget.tokens = budget.tokens.map(|most| most.saturating_sub(tokens));
        let client = Client::new(settings).map_err(|e| e.diagnostic().message)?;
        Ok(Arc::new(Session { client, source: Arc::clone(&self.source) }))
    }
}

/// One run.
struct Session {
    client: Client,
    source: Arc<Source>,
}

impl Session {
    /// The drive as measured, and whole with its signals.
    fn drive(&self, id: &DriveId, clip: &str) -> Result<(Arc<Drive>, Arc<Recorded>), ModelFailure> {
        let measured = self.source.recordings.drive(id);
        let measured = measured.map_err(|text| ModelFailure { text, ends_the_run: false })?;
        let recorded = self.source.recordings.recorded(clip).ok_or_else(|| no_drive(id))?;
        Ok((measured, recorded))
    }
}

impl ModelSession for Session {
    fn draft(&self, episode: &EpisodeRecord, lang: Lang) -> Result<CocLabel, ModelFailure> {
        let (measured, recorded) = self.drive(&episode.drive_id, episode.clip_id.as_str())?;
        let Source { framework, checker, .. } = &*self.source;
        let drafter = Drafter { client: &self.client, framework, checker, images: &*self.source, lang };
        match drafter.draft(&measured, &recorded, episode) {
            Ok(made) => Ok(made.label),
            Err(why) => {
                let ends_the_run = matches!(&why, NoDraft::Chat(e) if e.ends_the_run());
                Err(failure(&why.diagnostics(), ends_the_run))
            }
        }
    }

    fn judge(&self, label: &CocLabel, lang: Lang) -> Result<JudgedLabel, ModelFailure> {
        let drive = whyroad_engine::label_drives::drive_of_clip(&label.clip_id);
        let drive = drive.ok_or_else(|| no_drive(&label.clip_id.clone().into()))?;
        let (measured, recorded) = self.drive(&drive, &label.clip_id)?;
        let judge =
            Judge { client: &self.client, framework: self.source.framework, images: &*self.source, lang };
        let for_people = is_for_people(label, self.source.people_share, PEOPLE_SEED);
        match judge.judge(&measured, &recorded, label, for_people) {
            Ok(Some(judged)) => Ok(judged),
            Ok(None) => Err(ModelFailure {
                text: Bilingual::new(
                    "行程中没有关键帧时刻的自车位姿",
                    "the drive has no pose of the ego at the keyframe",
                ),
                ends_the_run: false,
            }),
            Err(e) => Err(failure(&[e.diagnostic()], e.ends_the_run())),
        }
    }

    fn spent(&self) -> ModelSpent {
        self.client.spent()
    }
}

fn failure(found: &[Diagnostic], ends_the_run: bool) -> ModelFailure {
    let all =
        |lang: Lang, between: &str| found.iter().map(|d| d.message(lang)).collect::<Vec<_>>().join(between);
    ModelFailure { text: Bilingual::new(all(Lang::Zh, "；"), all(Lang::En, "; ")), ends_the_run }
}

fn no_drive(id: &DriveId) -> ModelFailure {
    ModelFailure {
        text: Bilingual::new(
            format!("数据湖中没有行程 {id}，或无法读取"),
            format!("the lake has no drive {id}, or it cannot be read"),
        ),
        ends_the_run: false,
    }
}

/// Camera images as the service shows them: where faces and plates are made unreadable for people, they also are for
/// the model, too.
impl Images for Source {
    fn image(&self, drive: &Drive, frame: &MediaFrame) -> Option<(ImageKind, Vec<u8>)> {
        let id = &drive.meta.drive_id;
        if let Some(path) = self.recordings.media(id, frame) {
            let kind = image_kind(&path)?;
            let shown: PathBuf = match &self.blur {
                Some(blur) => blur.image(&path).ok()?,
                None => path,
            };
            return Some((kind, std::fs::read(shown).ok()?));
        }
        let stored = self.recordings.stored_image(id, frame).ok()??;
        let kind = image_kind(Path::new(stored.name()))?;
        let bytes = match &self.blur {
            Some(blur) => {
                let read = || stored.read().ok().flatten().ok_or_else(Problem::missing);
                std::fs::read(blur.stored_image(stored.name(), read).ok()?).ok()?
            }
            None => stored.read().ok()??,
        };
        Some((kind, bytes))
    }
}

/// By the file extension; `None` for types that are not sent to models.
pub(crate) fn image_kind(path: &Path) -> Option<ImageKind> {
    match path.extension()?.to_str()?.to_lowercase().as_str() {
        "png" => Some(ImageKind::Png),
        "jpg" | "jpeg" => Some(ImageKind::Jpeg),
        _ => None,
    }
}
