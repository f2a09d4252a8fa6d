//! The conversation of a sample, and the common parts of formats for vision-language trainers: a question that contains
//! only what was known at t0, and the answer: the trace, then the decisions. [`ChatWriter`] reads samples and writes
//! their images; a [`ChatFormat`] turns each conversation into records.

use super::{NO_TRACE, Output, SampleWriter, TAG_IN_TEXT, images, traces};
use crate::DatasetError;
use crate::item::SplitName;
use crate::sample::{Image, Rejected, Sample, Trajectory};
use serde_json::{Value, json};
use whyroad_framework::Framework;
use whyroad_model::Lang;
use whyroad_model::decision::{Lateral, LateralDirection, Longitudinal};

/// Beginnings of what trainers read as an image, a video, a sound or a control token, wherever it is in a text.
const TAGS: [&str; 4] = ["<image>", "<video>", "<audio>", "<|"];

/// One conversation about a sample.
pub(super) struct Conversation<'s> {
    /// The sample.
    pub sample: &'s Sample,
    /// Its split.
    pub split: &'static str,
    /// Language of all texts.
    pub lang: Lang,
    /// The trace alone.
    pub trace: &'s str,
    /// Paths of the images, relative to the export.
    pub images: &'s [String],
}

impl Conversation<'_> {
    /// The user's text after one `tag` per image.
    pub fn question(&self, tag: &str) -> String {
        tag.repeat(self.images.len()) + &question(self.sample, self.lang)
    }

    /// The trace and, where they are known, the decisions: what the model should answer.
    pub fn answer(&self) -> String {
        let s = self.sample;
        if !s.states_decision() {
            return self.trace.to_owned();
        }
        let decided = [s.longitudinal.as_deref(), s.lateral.as_deref(), s.lateral_direction.as_deref()];
        format!("{}\n{}", self.trace, decisions(decided, self.lang))
    }

    /// The answer of a returned version; `None` when it is in the other language or identical.
    pub fn rejected_answer(&self, version: &Rejected) -> Option<String> {
        let trace = version.trace.as_deref()?;
        // A version in the other language, or without a text, is not an alternative to this answer.
        if crate::labels::language(trace) != Some(self.lang) || TAGS.iter().any(|tag| trace.contains(tag)) {
            return None;
        }
        let label: Value = serde_json::from_str(&version.label_json).ok()?;
        let decided = ["longitudinal", "lateral", "lateral_direction"]
            .map(|field| label["driving_decision"][field].as_str());
        let text = format!("{trace}\n{}", decisions(decided, self.lang));
        (text != self.answer()).then_some(text)
    }

    /// `record` with the paths of the images under `key`, where there are any.
    pub fn with_images(&self, mut record: Value, key: &str) -> Value {
        if !self.images.is_empty() {
            record[key] = json!(self.images);
        }
        record
    }
}

/// A format of conversations.
pub(super) trait ChatFormat {
    /// Writes the records of one conversation.
    fn add(&mut self, conversation: &Conversation<'_>, out: &mut Output) -> Result<(), DatasetError>;

    /// Writes the files that need all samples.
    fn finish(&mut self, out: &mut Output) -> Result<(), DatasetError> {
        let _ = out;
        Ok(())
    }
}

/// The conversations of all samples in the requested languages.
pub(super) struct ChatWriter<F>(pub F);

impl<F: ChatFormat> SampleWriter for ChatWriter<F> {
    fn add(&mut self, sample: Sample, split: SplitName, out: &mut Output) -> Result<(), DatasetError> {
        let sample = &sample;
        let texts = traces(sample, out.options.language);
        if texts.is_empty() {
            out.report.leave_out(sample, NO_TRACE);
            return Ok(());
        }
        let has_tag = |text: &str| TAGS.iter().any(|tag| text.contains(tag));
        let routes = texts.iter().filter_map(|(lang, _)| super::route_text(sample, *lang));
        if texts.iter().map(|(_, trace)| *trace).chain(routes).any(has_tag) {
            out.report.leave_out(sample, TAG_IN_TEXT);
            return Ok(());
        }
        let images = images::write(sample, out)?;
        for (lang, trace) in texts {
            let conversation = Conversation { sample, split: split.name(), lang, trace, images: &images };
            self.0.add(&conversation, out)?;
        }
        Ok(())
    }

    fn finish(&mut self, out: &mut Output) -> Result<(), DatasetError> {
        self.0.finish(out)
    }
}

/// The question: the images, the ego's motion up to t0, the route; nothing after t0.
fn question(sample: &Sample, lang: Lang) -> String {
    let speeds = speeds(&sample.history, lang);
    let route = super::route_text(sample, lang);
    let mut parts: Vec<String> = Vec::new();
    parts.extend(of_images(&sample.images, lang));
    match lang {
        Lang::Zh => {
            parts.extend(speeds.map(|s| format!("自车车速：{s}。")));
            parts.extend(route.map(|r| format!("导航指令：{r}。")));
            parts.push(if sample.states_decision() {
                "请说明影响决策的关键因素，并给出自车的纵向与横向决策。".to_owned()
            } else {
                "请说明影响决策的关键因素。".to_owned()
            });
        }
        Lang::En => {
            parts.extend(speeds.map(|s| format!("Ego speed: {s}.")));
            parts.extend(route.map(|r| format!("Route: {r}.")));
            parts.push(if sample.states_decision() {
                "Explain what matters for the decision, and state the longitudinal and the lateral decision."
                    .to_owned()
            } else {
                "Explain what matters for the decision.".to_owned()
            });
        }
    }
    parts.join(if lang == Lang::Zh { "" } else { " " })
}

/// What the images are: their order, and of which camera each is where there are several; nothing without images.
fn of_images(images: &[Image], lang: Lang) -> Option<String> {
    let cameras = images.chunk_by(|a, b| a.camera == b.camera).scan(0, |before, run| {
        let (first, last) = (*before + 1, *before + run.len());
        *before = last;
        let numbers = if first == last { first.to_string() } else { format!("{first}-{last}") };
        Some((numbers, run[0].camera.as_str()))
    });
    let cameras: Vec<(String, &str)> = cameras.collect();
    let listed = |of: &dyn Fn(&(String, &str)) -> String, separator| {
        cameras.iter().map(of).collect::<Vec<_>>().join(separator)
    };
    match (cameras.len(), lang) {
        (0, _) => None,
        (1, Lang::Zh) => Some("图像为自车截至当前时刻的观测，按时间先后排列。".to_owned()),
        (1, Lang::En) => {
            Some("The images show what the ego vehicle observed up to now, oldest first.".to_owned())
        }
        (_, Lang::Zh) => Some(format!(
            "图像为自车截至当前时刻的观测：{}，同一相机的图像按时间先后排列。",
            listed(&|(numbers, camera)| format!("第 {numbers} 张来自相机 {camera}"), "，")
        )),
        (_, Lang::En) => Some(format!(
            "The images show what the ego vehicle observed up to now: {}; oldest first per camera.",
            listed(&|(numbers, camera)| format!("{numbers} from camera {camera}"), ", ")
        )),
    }
}

/// Speeds about every 0.5 s up to t0; nothing where none is known.
fn speeds(history: &Trajectory, lang: Lang) -> Option<String> {
    let mut parts = Vec::new();
    let mut last = f32::NEG_INFINITY;
    for (t, speed) in history.t_s.iter().zip(&history.speed) {
        if *t - last < 0.45 && *t < -0.01 {
            continue;
        }
        if let Some(speed) = speed {
            last = *t;
            parts.push(match lang {
                Lang::Zh if *t > -0.01 => format!("当前 {speed:.1} 米/秒"),
                Lang::Zh => format!("{:.1} 秒前 {speed:.1} 米/秒", -t),
                Lang::En if *t > -0.01 => format!("{speed:.1} m/s now"),
                Lang::En => format!("{speed:.1} m/s {:.1} s ago", -t),
            });
        }
    }
    (!parts.is_empty()).then(|| parts.join(if lang == Lang::Zh { "，" } else { ", " }))
}

/// The decisions by name: longitudinal, lateral, direction, as ids. `None` is "no change", which is stated.
fn decisions([longitudinal, lateral, side]: [Option<&str>; 3], lang: Lang) -> String {
    let sets = &Framework::bundled().decisions;
    let longitudinal = longitudinal.and_then(Longitudinal::from_id);
    let lateral = lateral.and_then(Lateral::from_id);
    let side = side.and_then(LateralDirection::from_id);
    let none = if lang == Lang::Zh { "无变化" } else { "no change" };
    let name = |text: Option<&whyroad_framework::decisions::DecisionText>| {
        text.map_or_else(|| none.to_owned(), |t| t.name.get(lang).to_owned())
    };
    let first = name(sets.longitudinal.iter().find(|d| Some(d.id) == longitudinal).map(|d| &d.text));
    let mut second = name(sets.lateral.iter().find(|d| Some(d.id) == lateral).map(|d| &d.text));
    if let Some(side) = side {
        second += &match (side, lang) {
            (LateralDirection::Left, Lang::Zh) => "（左）".to_owned(),
            (LateralDirection::Right, Lang::Zh) => "（右）".to_owned(),
            (LateralDirection::Uturn, Lang::Zh) => "（掉头）".to_owned(),
            (side, Lang::En) => format!(" ({})", side.id()),
        };
    }
    match lang {
        Lang::Zh => format!("纵向决策：{first}；横向决策：{second}。"),
        Lang::En => format!("Longitudinal: {first}. Lateral: {second}."),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_image_has_its_camera_where_there_are_several() {
        let of = |cameras: &[&str], lang| {
            let image = |camera: &&str| Image { camera: (*camera).to_owned(), ..Image::default() };
            of_images(&cameras.iter().map(image).collect::<Vec<_>>(), lang)
        };
        assert_eq!(of(&[], Lang::En), None);
        let one = "The images show what the ego vehicle observed up to now, oldest first.";
        assert_eq!(of(&["bev", "bev"], Lang::En).unwrap(), one);
        let several = "The images show what the ego vehicle observed up to now: 1-2 from camera left, 3 from camera \
                       right; oldest first per camera.";
        assert_eq!(of(&["left", "left", "right"], Lang::En).unwrap(), several);
        let zh = of(&["left", "left", "right"], Lang::Zh).unwrap();
        assert!(zh.contains("第 1-2 张来自相机 left，第 3 张来自相机 right"), "{zh}");
    }

    #[test]
    fn an_unknown_decision_is_neither_asked_nor_answered() {
        let mut sample = Sample::default();
        let question = |sample: &Sample| question(sample, Lang::En);
        assert!(!question(&sample).contains("decision, and state"));
        sample.longitudinal = Some("yield_to_agent".into());
        assert!(question(&sample).contains("state the longitudinal and the lateral decision"));
    }
}
