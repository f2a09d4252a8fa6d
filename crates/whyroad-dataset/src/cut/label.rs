//! The label of a sample: as it was exported, or drafted by rule from an episode.

use super::{Candidate, Cutter};
use crate::item::{Dropped, Stage};
use crate::labels::{LabelRecord, language};
use crate::sample::{Cause, Component, Sample};
use std::collections::BTreeSet;
use whyroad_label::draft::{draft, errors};
use whyroad_model::decision::{Lateral, Longitudinal};
use whyroad_model::messages::{CocLabel, EpisodeRecord};
use whyroad_model::{Lang, Nanos};

/// A label, ready to be written into a sample.
pub(super) struct Resolved {
    label: CocLabel,
    json: String,
    other: Option<(CocLabel, String)>,
    draft: bool,
}

pub(super) fn resolve(cutter: &Cutter<'_>, candidate: &Candidate<'_>) -> Result<Resolved, Dropped> {
    let broken = |e: String| Dropped::with(Stage::Sample, "label_unreadable", e);
    let record = &candidate.label;
    if record.is_episode {
        let episode: EpisodeRecord = serde_json::from_str(&record.json).map_err(|e| broken(e.to_string()))?;
        let Some(signals) = &cutter.signals else { return Err(broken("no signals to draft from".into())) };
        let made = draft(cutter.framework, cutter.drive, signals, &episode, cutter.spec.labels.draft_texts);
        if let Some(doubt) = made.doubt {
            return Err(Dropped::with(
                Stage::Sample,
                "draft_doubt",
                doubt.text().get(cutter.spec.labels.draft_texts).to_owned(),
            ));
        }
        let label = made.label;
        let json = serde_json::to_string(&label).map_err(|e| broken(e.to_string()))?;
        check_draft(cutter, &json)?;
        return Ok(Resolved { label, json, other: None, draft: true });
    }
    let read = |record: &LabelRecord| {
        let label: CocLabel = serde_json::from_str(&record.json).map_err(|e| broken(e.to_string()))?;
        Ok((label, record.json.clone()))
    };
    let (label, json) = read(record)?;
    let other = candidate.other.as_ref().map(read).transpose()?;
    Ok(Resolved { label, json, other, draft: candidate.status == crate::labels::DRAFT })
}

/// A draft by rule may lack records that a person has to fill in; with any other error it is not a sample. Those of
/// people, models and other tools may be unfinished (docs/reference/release.md).
fn check_draft(cutter: &Cutter<'_>, json: &str) -> Result<(), Dropped> {
    let found = cutter.checker.check_text(json);
    let codes: Vec<&str> = errors(&found).map(|d| d.code).collect();
    if codes.is_empty() {
        return Ok(());
    }
    Err(Dropped::with(Stage::Sample, "draft_invalid", codes.join(", ")))
}

impl Resolved {
    /// Tracks that the episode bound or a component names.
    pub fn named_objects(&self, record: &LabelRecord) -> BTreeSet<String> {
        let linked = self.label.critical_components.iter().flat_map(|c| c.linked_objects.iter().cloned());
        linked.chain(record.target_id.clone()).collect()
    }

    /// Position of the decision in its closed set.
    pub fn longitudinal(&self) -> Option<u8> {
        let chosen = self.label.driving_decision.longitudinal?;
        Longitudinal::ALL.iter().position(|d| *d == chosen).map(|i| i as u8)
    }

    /// Position of the decision in its closed set.
    pub fn lateral(&self) -> Option<u8> {
        let chosen = self.label.driving_decision.lateral?;
        Lateral::ALL.iter().position(|d| *d == chosen).map(|i| i as u8)
    }

    /// Fills in the fields of the label.
    pub fn write(self, sample: &mut Sample) {
        let label = self.label;
        let t0 = Nanos(sample.lineage.keyframe_time_ns);
        sample.l1 = label.scenario.l1;
        sample.l2 = label.scenario.l2;
        sample.l3 = label.scenario.l3;
        sample.scenario_id = match &sample.l3 {
            Some(l3) => format!("{}.{}.{l3}", sample.l1, sample.l2),
            None => format!("{}.{}", sample.l1, sample.l2),
        };
        sample.secondary_scenarios = label.secondary_scenarios;
        let decision = label.driving_decision;
        sample.longitudinal = decision.longitudinal.map(|d| d.id().to_owned());
        sample.lateral = decision.lateral.map(|d| d.id().to_owned());
        sample.lateral_direction = decision.lateral_direction.map(|d| d.id().to_owned());
        sample.components = label
            .critical_components
            .into_iter()
            .map(|c| Component {
                id: c.id,
                category: c.category,
                description: c.description,
                uncertainty: c.uncertainty.map(|u| u.id().to_owned()),
                evidence_t_s: c.evidence_times.iter().map(|t| t.seconds_since(t0) as f32).collect(),
                objects: c.linked_objects,
            })
            .collect();
        let cause =
            |c: whyroad_model::messages::Cause| Cause { components: c.components, unobserved: c.unobserved };
        let causes = label.causes.unwrap_or_default();
        sample.cause_longitudinal = causes.longitudinal.map(cause);
        sample.cause_lateral = causes.lateral.map(cause);
        let mut trace = |text: String| match language(&text) {
            Some(Lang::Zh) => sample.trace_zh = Some(text),
            Some(Lang::En) => sample.trace_en = Some(text),
            None => {}
        };
        trace(label.coc_trace);
        if let Some((other, json)) = self.other {
            trace(other.coc_trace);
            sample.label_json_other = Some(json);
        }
        let lineage = &mut sample.lineage;
        lineage.clip_id = label.clip_id;
        lineage.label_version = label.version;
        if let Some(provenance) = label.provenance {
            lineage.label_source = Some(provenance.source.id().to_owned());
            lineage.label_by = provenance.by;
            lineage.taxonomy_version = provenance.versions.get("taxonomy").cloned();
            lineage.rule_version =
                lineage.rule_version.take().or_else(|| provenance.versions.get("rules").cloned());
        }
        debug_assert!(!self.draft || !lineage.checked, "a draft is never checked");
        sample.label_json = self.json;
    }
}
