//! In which frames objects were observed: those between two messages of each source of objects. A message without
//! objects is an empty road; no message is an unknown one. Not here: in which frames one object was observed
//! (`frames.rs`).

use crate::assemble::resample::linear;
use whyroad_model::scene::FRAME_RATE_HZ;
use whyroad_model::{Bilingual, Diagnostic, Drive, Nanos};

/// Shorter stretches in all are those of sources that start and end at other moments than the ego, s.
const LEAST_S: f64 = 1.0;

/// Frames in which not all of the sources observed: `times` are those of the messages of each, ascending, s; messages
/// further apart than `max_gap_s` leave the frames between them unobserved.
pub(crate) fn unobserved(times: &[Vec<f64>], frames: &[f64], max_gap_s: f64) -> Vec<bool> {
    let mut out = vec![false; frames.len()];
    for times in times {
        let there = linear(times, times, frames, max_gap_s);
        out.iter_mut().zip(there).for_each(|(out, t)| *out |= t.is_nan());
    }
    out
}

/// The first and the last frame of each stretch of these frames.
pub(crate) fn stretches(is_unknown: &[bool], frames: &[Nanos]) -> Vec<[Nanos; 2]> {
    let mut out: Vec<[Nanos; 2]> = Vec::new();
    let mut before = false;
    for (&unknown, &time) in is_unknown.iter().zip(frames) {
        match out.last_mut() {
            Some(stretch) if unknown && before => stretch[1] = time,
            _ if unknown => out.push([time, time]),
            _ => {}
        }
        before = unknown;
    }
    out
}

/// A finding where objects are unknown for longer than a moment.
pub(crate) fn finding(drive: &Drive) -> Option<Diagnostic> {
    let start = *drive.times.first()?;
    let frames = drive.times.iter().filter(|t| drive.meta.are_objects_unknown(**t)).count();
    let (seconds, all) = (frames as f64 / FRAME_RATE_HZ, drive.times.len() as f64 / FRAME_RATE_HZ);
    let long = |[first, last]: &&[Nanos; 2]| last.seconds_since(*first) >= LEAST_S / 2.0;
    let stretches = &drive.meta.objects_unknown;
    let from = stretches.iter().find(long).or(stretches.first())?[0].seconds_since(start);
    let message = Bilingual::new(
        format!(
            "{all:.1} s 中有 {seconds:.1} s 没有目标的消息（自 {from:.1} s 起）：此处目标为未知，并非没有"
        ),
        format!(
            "no message about objects in {seconds:.1} s of {all:.1} s (from {from:.1} s on): objects are unknown there, not \
             absent"
        ),
    );
    let hint = Bilingual::new(
        "没有目标时也应发布空列表；不是感知结果的主题在映射文件中写 `role: ignore`",
        "publish an empty list where nothing is seen; give topics that are not the perception `role: ignore` in a mapping \
         file",
    );
    (seconds >= LEAST_S).then(|| Diagnostic::warning("ingest.objects.unobserved", message).with_hint(hint))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_without_a_message_around_them_are_unobserved() {
        // Frames every 0.1 s; messages every 0.2 s, none between 0.4 s and 1.4 s, none after 1.6 s.
        let frames: Vec<f64> = (0..20).map(|i| f64::from(i) / 10.0).collect();
        let messages = vec![0.0, 0.2, 0.4, 1.4, 1.6];
        let unknown = unobserved(std::slice::from_ref(&messages), &frames, 0.6);
        let found: Vec<usize> = (0..20).filter(|&i| unknown[i]).collect();
        assert_eq!(found, [5, 6, 7, 8, 9, 10, 11, 12, 13, 17, 18, 19]);
        let times: Vec<Nanos> = (0..20).map(|i| Nanos(i * 100_000_000)).collect();
        let ms = |t: i64| Nanos(t * 1_000_000);
        assert_eq!(stretches(&unknown, &times), [[ms(500), ms(1300)], [ms(1700), ms(1900)]]);
        // What one of two sources does not observe is not known.
        let every: Vec<f64> = frames.clone();
        assert_eq!(unobserved(&[every.clone(), messages], &frames, 0.6), unknown);
        assert!(unobserved(&[every], &frames, 0.6).iter().all(|u| !u));
    }
}
