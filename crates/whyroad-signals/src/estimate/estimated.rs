//! Estimates the states of a drive: determines the noise of each kind of object, joins ids, and smooths each object
//! unless its measurements are exact and complete.

use super::bicycle::{Bicycle, REAR_TO_CENTER, on_wheels};
use super::course;
use super::deviation;
use super::join::{Candidate, MAX_AWAY_S, joins};
use super::jumps::between_jumps;
use super::noise::{self, LogNoise, Noise};
use super::objects::{Joined, Measured, append, joined, motion_of, track_of};
use super::samples;
use super::smoother::{Deviations, MotionModel, States, smooth};
use super::walking;
use super::{complete_motion, forget_impossible, is_stated};
use std::borrow::Cow;
use whyroad_model::catalog::id;
use whyroad_model::scene::{Ego, FrameOfReference, Motion, Track};
use whyroad_model::{Column, Drive, ObjectClass, SignalTable, Tri};

/// The same where the length is unknown, m.
const REAR_TO_CENTER_M: f64 = 1.2;
/// Minimum number of rows for estimating the noise of one kind of object from that kind alone.
const ENOUGH_ROWS: usize = 300;

/// Minimum number of rows for estimating one object's own noise.
const ENOUGH_OF_ONE: usize = 23;
/// A track that is noisier than its kind by this factor, and by this much in absolute terms, m, is badly tracked: its
/// own noise is used.
const BADLY_TRACKED: f64 = 2.0;
const BADLY_TRACKED_M: f64 = 0.05;
/// The same per second between its rows: over longer steps maneuvers also leave residuals, m/s.
const BADLY_TRACKED_MPS: f64 = 0.5;
/// Rows further apart than this are coarse: a maneuver covers only two or three of them, s.
const COARSE_S: f64 = 0.25;
/// The noise of the kind counts as this many rows of the track.
const EXPECTED_ROWS: f64 = 4.0;
/// A coarse track that is noisier than this, m, and noisier than its kind by this factor, is badly tracked. A stop from
/// 36 km/h at 4 m/s2 leaves 0.10 m at two rows per second.
const COARSE_M: f64 = 0.12;
const COARSE_TIMES: f64 = 1.2;
/// If most of a coarse log consists of straight lines drawn between hand-set boxes, its median residual shows no noise
/// at all: then a track that alternates by this much, m, is badly tracked. One position in twenty that is 0.6 m off
/// alternates by 0.15 m; a stop at 8 m/s2 from 14 km/h by 0.06 m, from higher speeds not at all.
const ALTERNATES_M: f64 = 0.12;
/// ... over this many pairs of neighboring differences: seconds, at two rows each.
const ENOUGH_PAIRS: usize = 4;

/// Noise of the measurements of a drive, estimated from its own residuals.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DriveNoise {
    /// Of the ego's pose.
    pub ego: LogNoise,
    /// Of motor vehicles and two-wheelers.
    pub vehicles: LogNoise,
    /// Of people and everything else.
    pub others: LogNoise,
}

/// Estimates of a drive.
#[derive(Clone, Debug)]
pub struct Estimated<'a> {
    /// The drive with estimated states. It includes rows that were not observed: see `bridged`.
    pub drive: Cow<'a, Drive>,
    /// Standard deviations of the ego's states, one per frame; `None` where they are exact.
    pub ego: Option<Deviations>,
    /// Of each track's states; `None` where they are exact.
    pub tracks: Vec<Option<Deviations>>,
    /// Of each track, the frames between two observations in which it was not observed.
    pub bridged: Vec<Vec<u32>>,
    /// Later ids of objects whose track was interrupted, with the id that the object keeps.
    pub joined: Joined,
    /// Noise of the log.
    pub noise: DriveNoise,
}

/// The noise of a drive's measurements; empty for a drive without a pose of the ego.
pub fn noise(drive: &Drive) -> DriveNoise {
    estimated(drive).noise
}

impl Estimated<'_> {
    fn with_deviations(&self) -> deviation::OfDrive<'_> {
        deviation::OfDrive { drive: &self.drive, ego: self.ego.as_ref(), tracks: &self.tracks }
    }

    /// Adds standard deviations to a table of signals of any object and of pairs.
    pub(crate) fn complete_objects(&self, table: &mut SignalTable) {
        deviation::write_objects(&self.with_deviations(), table);
    }

    /// Completes the signals that were derived from the estimated drive: adds standard deviations, and marks objects as
    /// not observed in bridged rows.
    pub(crate) fn complete(&self, table: &mut SignalTable) {
        deviation::write(&self.with_deviations(), table);
        let spans = table.targets.iter();
        let tracks = self.drive.tracks.iter().zip(&self.bridged).filter(|(t, _)| !t.frames.is_empty());
        let Some(Column::Flag(observed)) = table.target_columns.get_mut(id::TARGET_OBSERVED.id().name())
        else {
            return;
        };
        for (span, (_, bridged)) in spans.zip(tracks) {
            for row in bridged.iter().filter_map(|f| span.row(*f as usize)) {
                observed[row] = Tri::False;
            }
        }
    }
}

/// The states of a drive; see the module `estimate`.
pub fn estimated(drive: &Drive) -> Estimated<'_> {
    estimated_of(drive, |_| true)
}

/// Of [`estimated`] the ego and the tracks that have a row in the last frame.
pub(crate) fn estimated_at_the_end(drive: &Drive) -> Estimated<'_> {
    let last = drive.times.len().checked_sub(1);
    let reaches = |frames: &[u32]| frames.last().map(|f| *f as usize) == last;
    let mut all = estimated_of(drive, |measured| reaches(&measured.frames));
    // If nothing was estimated, all tracks are present.
    let stay: Vec<bool> = all.drive.tracks.iter().map(|t| reaches(&t.frames)).collect();
    let drive = all.drive.to_mut();
    keep(&mut drive.tracks, &stay);
    keep(&mut all.tracks, &stay);
    keep(&mut all.bridged, &stay);
    all
}

fn keep<T>(all: &mut Vec<T>, stay: &[bool]) {
    let mut stay = stay.iter();
    all.retain(|_| stay.next().is_none_or(|s| *s));
}

/// The states of a drive, for its ego and the tracks that are `wanted`; the noise is estimated from all tracks.
/// Headings that the log lacks are those of the way driven or walked.
fn estimated_of(drive: &Drive, wanted: impl Fn(&Measured) -> bool) -> Estimated<'_> {
    if drive.meta.frame_of_reference == FrameOfReference::Ego {
        return none_of(drive);
    }
    let start = drive.times.first().copied().unwrap_or_default();
    let seconds: Vec<f64> = drive.times.iter().map(|t| t.seconds_since(start)).collect();
    let mut out = match course::with_headings(drive, &seconds) {
        None => estimated_from(drive, &seconds, wanted),
        Some(completed) => {
            let out = estimated_from(&completed, &seconds, wanted);
            Estimated { drive: Cow::Owned(out.drive.into_owned()), ..out }
        }
    };
    walking::add_headings(&mut out.drive, &mut out.tracks, &seconds);
    out
}

/// Nothing is estimated.
fn none_of(drive: &Drive) -> Estimated<'_> {
    Estimated {
        drive: Cow::Borrowed(drive),
        ego: None,
        tracks: vec![None; drive.tracks.len()],
        bridged: vec![Vec::new(); drive.tracks.len()],
        joined: Joined::new(),
        noise: DriveNoise::default(),
    }
}

fn estimated_from<'d>(
    drive: &'d Drive,
    seconds: &[f64],
    wanted: impl Fn(&Measured) -> bool,
) -> Estimated<'d> {
    let of = |t: &Track| Measured::new(&t.frames, &t.motion, &t.known_at, &drive.times, seconds, MAX_AWAY_S);
    let mut measured: Vec<Measured> = drive.tracks.iter().map(of).collect();
    let mut only_measured = without_gaps(&measured);
    let of_ego = drive.ego.as_ref().map(|e| {
        let frames: Vec<u32> = (0..e.motion.len() as u32).collect();
        Measured::new(&frames, &e.motion, &e.known_at, &drive.times, seconds, MAX_AWAY_S)
    });
    let noise = noise_of(drive, &only_measured, of_ego.as_ref());
    let kind = |class: ObjectClass| if on_wheels(class) { noise.vehicles } else { noise.others };

    let mut out = Estimated { noise, ..none_of(drive) };
    let mut tracks: Cow<'_, [Track]> = Cow::Borrowed(&drive.tracks);
    let next = next_of(&drive.tracks, &only_measured, kind);
    let exact = |m: &Measured, of: &Motion, class: ObjectClass, noise: &LogNoise| {
        noise.is_negligible() && m.is_complete() && is_stated(of) && !is_restless(class, m)
    };
    if next.iter().all(Option::is_none)
        && of_ego.iter().zip(&drive.ego).all(|(m, e)| exact(m, &e.motion, ObjectClass::Car, &noise.ego))
        && measured.iter().zip(&drive.tracks).all(|(m, t)| exact(m, &t.motion, t.class, &kind(t.class)))
    {
        return out;
    }
    if next.iter().any(Option::is_some) {
        let (whole, ids) = chained(&drive.tracks, &next);
        measured = whole.iter().map(of).collect();
        only_measured = without_gaps(&measured);
        out.joined = ids;
        tracks = Cow::Owned(whole);
    }
    (out.tracks, out.bridged) = (Vec::new(), Vec::new());
    let mut estimated: Vec<Track> = Vec::with_capacity(tracks.len());
    let rows = measured.iter().zip(&only_measured);
    for (track, (measured, only_measured)) in tracks.iter().zip(rows).filter(|(_, (m, _))| wanted(m)) {
        let noise = of_one(kind(track.class), track.class, measured, only_measured);
        if noise.is_negligible() && measured.is_complete() {
            let mut exact = track.clone();
            complete_motion(&mut exact.motion, &measured.times, &track.length_m, track.class);
            estimated.push(exact);
            out.tracks.push(None);
            out.bridged.push(Vec::new());
            continue;
        }
        let mut states = states_of(measured, model_of(track.class, &track.length_m), &noise);
        let mut smoothed = track_of(track, measured, &states);
        if noise.is_negligible() && measured.lacks_only_rows() {
            // Only the values between the rows are estimated.
            let mut exact = track.motion.clone();
            let own: Vec<f64> = track.frames.iter().map(|&f| seconds[f as usize]).collect();
            complete_motion(&mut exact, &own, &track.length_m, track.class);
            keep_rows(&mut smoothed.motion, &mut states.sd, &exact, &measured.source);
            if let Some(last) = measured.source.iter().rposition(Option::is_some) {
                samples::go_on(measured, &track.motion, &mut smoothed.motion, last);
            }
        } else if noise.is_negligible() && on_wheels(track.class) {
            samples::follow(measured, &track.motion, &mut smoothed.motion);
        }
        forget_impossible(track.class, &mut smoothed.motion);
        estimated.push(smoothed);
        out.tracks.push(Some(states.sd));
        out.bridged.push(measured.bridged());
    }
    let ego = drive.ego.as_ref().zip(of_ego).map(|(ego, measured)| {
        let noise = of_one(noise.ego, ObjectClass::Car, &measured, &measured.compact());
        let (ego, sd) = of_the_ego(ego, &measured, &noise);
        out.ego = sd;
        ego
    });
    out.drive = Cow::Owned(Drive {
        meta: drive.meta.clone(),
        times: drive.times.clone(),
        ego,
        tracks: estimated,
        map: drive.map.clone(),
        lights: drive.lights.clone(),
        context: drive.context.clone(),
        media: drive.media.clone(),
    });
    out
}

/// Copies the rows of `exact` where the source has one.
fn keep_rows(to: &mut Motion, sd: &mut Deviations, exact: &Motion, source: &[Option<usize>]) {
    for (i, row) in source.iter().enumerate() {
        let Some(row) = *row else { continue };
        for (to, from) in [
            (&mut to.x, &exact.x),
            (&mut to.y, &exact.y),
            (&mut to.heading, &exact.heading),
            (&mut to.vx, &exact.vx),
            (&mut to.vy, &exact.vy),
            (&mut to.accel, &exact.accel),
            (&mut to.yaw_rate, &exact.yaw_rate),
        ] {
            to[i] = from[row];
        }
        for sd in [&mut sd.position, &mut sd.heading, &mut sd.speed, &mut sd.accel, &mut sd.yaw_rate] {
            sd[i] = 0.0;
        }
    }
}

fn of_the_ego(ego: &Ego, measured: &Measured, noise: &LogNoise) -> (Ego, Option<Deviations>) {
    let lengths = vec![ego.length_m; ego.motion.len()];
    if noise.is_negligible() && measured.is_complete() {
        let mut exact = ego.clone();
        complete_motion(&mut exact.motion, &measured.times, &lengths, ObjectClass::Car);
        return (exact, None);
    }
    let mut states = states_of(measured, model_of(ObjectClass::Car, &lengths), noise);
    let mut motion = motion_of(&states, measured, &ego.motion);
    if noise.is_negligible()
        && measured.x.iter().zip(&ego.motion.x).all(|(x, given)| x.is_nan() == given.is_nan())
    {
        // Only what the log lacks is estimated.
        let mut exact = ego.motion.clone();
        complete_motion(&mut exact, &measured.times, &lengths, ObjectClass::Car);
        let known = |(x, source): (&f64, &Option<usize>)| source.filter(|_| x.is_finite());
        let source: Vec<Option<usize>> = measured.x.iter().zip(&measured.source).map(known).collect();
        keep_rows(&mut motion, &mut states.sd, &exact, &source);
        if let Some(last) = source.iter().rposition(Option::is_some) {
            samples::go_on(measured, &ego.motion, &mut motion, last);
        }
    } else if noise.is_negligible() {
        samples::follow(measured, &ego.motion, &mut motion);
    }
    forget_impossible(ObjectClass::Car, &mut motion);
    (Ego { motion, known_at: Vec::new(), ..ego.clone() }, Some(states.sd))
}

fn model_of(class: ObjectClass, lengths: &[f64]) -> MotionModel {
    if !on_wheels(class) {
        return MotionModel::ConstantVelocity;
    }
    let length = lengths.get(lengths.len() / 2).copied().filter(|l| l.is_finite());
    let rear_to_center_m = length.map_or(REAR_TO_CENTER_M, |l| REAR_TO_CENTER * l);
    MotionModel::Bicycle(Bicycle { rear_to_center_m })
}

fn states_of(measured: &Measured, model: MotionModel, noise: &LogNoise) -> States {
    let mut out = States::default();
    for run in measured.runs() {
        for run in within_reach(measured, run) {
            for part in between_jumps(measured, run, model, noise) {
                append(&mut out, smooth(measured.rows(part), model, noise));
            }
        }
    }
    out
}

/// The ego has a row for every frame: a period without measurements that is too long to be bridged is left unknown, and
/// the motion after it is estimated separately.
fn within_reach(measured: &Measured, run: std::ops::Range<usize>) -> Vec<std::ops::Range<usize>> {
    let mut cuts = vec![run.start];
    let mut last: Option<usize> = None;
    for i in run.clone().filter(|&i| measured.x[i].is_finite()) {
        let from = last.map_or(run.start, |l| l + 1);
        let away = measured.times[i] - measured.times[last.unwrap_or(run.start)];
        if i > from && away > MAX_AWAY_S {
            cuts.extend([from, i]);
        }
        last = Some(i);
    }
    if let Some(l) = last.filter(|l| measured.times[run.end - 1] - measured.times[*l] > MAX_AWAY_S) {
        cuts.push(l + 1);
    }
    cuts.push(run.end);
    cuts.dedup();
    cuts.windows(2).map(|w| w[0]..w[1]).filter(|r| !r.is_empty()).collect()
}

/// Only the measured rows of each object.
fn without_gaps(measured: &[Measured]) -> Vec<Measured> {
    measured.iter().map(|m| if m.is_complete() { m.clone() } else { m.compact() }).collect()
}

/// Noise of each kind of object, from its measured rows; for a rare kind, that of all objects together.
fn noise_of(drive: &Drive, only_measured: &[Measured], ego: Option<&Measured>) -> DriveNoise {
    let all = only_measured.iter().map(|m| m.rows(0..m.times.len()));
    let classes = drive.tracks.iter().map(|t| on_wheels(t.class));
    let of = |wheels: bool| {
        let own = classes.clone().zip(all.clone()).filter(move |(w, _)| *w == wheels).map(|(_, rows)| rows);
        let rows: usize = own.clone().map(|r| r.times.len()).sum();
        if rows >= ENOUGH_ROWS { noise::estimate(own) } else { noise::estimate(all.clone()) }
    };
    let ego = ego.map(Measured::compact);
    DriveNoise {
        ego: noise::estimate(ego.iter().map(|m| m.rows(0..m.times.len()))),
        vehicles: of(true),
        others: of(false),
    }
}

/// The noise of one track: that of its kind, or its own if it is badly tracked (a box that jumps back and forth along a
/// long vehicle, or a distant one that is placed again twice a second). `only_measured` contains only the measured
/// rows.
fn of_one(kind: LogNoise, class: ObjectClass, measured: &Measured, only_measured: &Measured) -> LogNoise {
    let own = of_its_rows(kind, measured, only_measured);
    if own.is_negligible() && is_restless(class, only_measured) { own.noticeable() } else { own }
}

/// True for a vehicle that cannot have moved as it was measured.
fn is_restless(class: ObjectClass, only_measured: &Measured) -> bool {
    on_wheels(class) && noise::jumps_and_returns(only_measured.rows(0..only_measured.times.len()))
}

fn of_its_rows(kind: LogNoise, measured: &Measured, only_measured: &Measured) -> LogNoise {
    let known = measured.x.iter().filter(|x| x.is_finite()).count();
    let (Some(first), Some(last)) = (measured.times.first(), measured.times.last()) else { return kind };
    let step = (last - first) / known as f64;
    if step > COARSE_S {
        return of_coarse(kind, only_measured);
    }
    if known < ENOUGH_OF_ONE {
        return kind;
    }
    let least = BADLY_TRACKED_M.max(BADLY_TRACKED_MPS * step).max(BADLY_TRACKED * kind.position.deviation());
    let own = noise::of_positions_above(only_measured.rows(0..only_measured.times.len()), least);
    own.map_or(kind, |position| LogNoise { position, ..kind })
}

/// The same for a low rate, at which a track has few rows: its residuals are combined with the expected noise of its
/// kind.
fn of_coarse(kind: LogNoise, compact: &Measured) -> LogNoise {
    if kind.position.is_negligible() {
        let (variance, pairs) = noise::alternation(compact.rows(0..compact.times.len()));
        let own = variance.max(0.0).sqrt();
        let bad = pairs >= ENOUGH_PAIRS && own > ALTERNATES_M;
        let position = Noise { white: own, ..kind.position };
        return if bad { LogNoise { position, ..kind } } else { kind };
    }
    let (sum, count) = noise::residuals(compact.rows(0..compact.times.len()));
    let expected = kind.position.deviation();
    let own = ((EXPECTED_ROWS * expected.powi(2) + sum) / (EXPECTED_ROWS + count)).sqrt();
    if own > COARSE_M.max(COARSE_TIMES * expected) {
        let position = Noise { white: own, correlated: 0.0, ..kind.position };
        LogNoise { position, ..kind }
    } else {
        kind
    }
}

fn next_of(
    tracks: &[Track],
    only_measured: &[Measured],
    kind: impl Fn(ObjectClass) -> LogNoise,
) -> Vec<Option<usize>> {
    let middle = |v: &[f64]| v.get(v.len() / 2).copied().unwrap_or(f64::NAN);
    let candidates: Vec<Candidate<'_>> = tracks
        .iter()
        .zip(only_measured)
        .map(|(t, m)| Candidate {
            rows: m.rows(0..m.times.len()),
            class: t.class,
            size: (middle(&t.length_m), middle(&t.width_m)),
        })
        .collect();
    joins(&candidates, |i| kind(tracks[i].class))
}

/// The tracks, with those of one object merged into one, ordered by id.
fn chained(tracks: &[Track], next: &[Option<usize>]) -> (Vec<Track>, Joined) {
    let mut is_later = vec![false; tracks.len()];
    next.iter().flatten().for_each(|&k| is_later[k] = true);
    let (mut out, mut ids) = (Vec::new(), Joined::new());
    for (i, first) in tracks.iter().enumerate().filter(|(i, _)| !is_later[*i]) {
        let mut whole = first.clone();
        let mut last = i;
        while let Some(k) = next[last] {
            ids.insert(tracks[k].id.clone(), first.id.clone());
            whole = joined(&whole, &tracks[k]);
            last = k;
        }
        out.push(whole);
    }
    (out, ids)
}

#[cfg(test)]
mod tests;
