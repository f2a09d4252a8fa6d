//! Facts about the clips that labels refer to: the fields of `clip_metadata` messages that rules use.

use std::collections::HashMap;
use whyroad_framework::taxonomy::did_you_mean;
use whyroad_model::Nanos;
use whyroad_model::messages::ClipMetadataMessage;

/// Length and rate of one clip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClipFacts {
    /// Time of frame 0.
    pub capture_time: Nanos,
    /// Length, s.
    pub duration_s: f64,
    /// Nominal frames per second; greater than 0.
    pub frame_rate_hz: f64,
    /// Number of frames.
    pub total_frames: u32,
}

/// The clips that labels may refer to.
#[derive(Clone, Debug, Default)]
pub struct ClipIndex {
    clips: HashMap<String, ClipFacts>,
}

impl ClipIndex {
    /// Adds a `clip_metadata` document. Returns false if it is not one, or has no usable frame rate; checking it with
    /// [`super::Checker`] gives the reason. Of two with the same id the later one counts.
    pub fn add(&mut self, document: &[u8]) -> bool {
        let Ok(message) = serde_json::from_slice::<ClipMetadataMessage>(document) else { return false };
        let clip = message.clip_metadata;
        if !(clip.frame_rate > 0.0 && clip.duration_sec >= 0.0) {
            return false;
        }
        let facts = ClipFacts {
            capture_time: clip.capture_time,
            duration_s: clip.duration_sec,
            frame_rate_hz: clip.frame_rate,
            total_frames: clip.total_frames,
        };
        self.clips.insert(clip.clip_id, facts);
        true
    }

    /// The clip with this id.
    pub fn get(&self, id: &str) -> Option<&ClipFacts> {
        self.clips.get(id)
    }

    /// Number of clips.
    pub fn len(&self) -> usize {
        self.clips.len()
    }

    /// True if there are no clips.
    pub fn is_empty(&self) -> bool {
        self.clips.is_empty()
    }

    /// The known id most similar to `id`, if one is similar enough.
    pub(super) fn nearest(&self, id: &str) -> Option<&str> {
        // In a long list some id is similar to any text, and comparing with all of them is slow.
        if self.clips.len() > 10_000 {
            return None;
        }
        let mut ids: Vec<&str> = self.clips.keys().map(String::as_str).collect();
        ids.sort_unstable();
        did_you_mean(id, ids)
    }
}
