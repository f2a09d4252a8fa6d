//! The `Scenario` message, limited to what scene tables need. Field numbers: `scenario.proto` and `map.proto` of the
//! Waymo Open Dataset (motion, 1.0 to 1.3).

use crate::assemble::feature_map::{Boundary, CenterLane, Feature, Neighbor};
use crate::assemble::frames::Sample;
use crate::encodings::protobuf::{Field, Fields, ProtoError};
use whyroad_model::road_map::{Lane, LaneKind, LaneMark, Point3};

const MPS_PER_MPH: f64 = 0.44704;
const TYPE_FREEWAY: i64 = 1;
const TYPE_BIKE_LANE: i64 = 3;

/// A scenario.
#[derive(Default)]
pub(super) struct Scenario {
    pub id: String,
    /// s
    pub times: Vec<f64>,
    pub tracks: Vec<ObjectTrack>,
    pub sdc_track_index: Option<usize>,
    /// For each step, what was seen of the lights.
    pub lights: Vec<Vec<LaneState>>,
    pub features: Vec<(String, Result<Feature, String>)>,
}

/// An object: one state per step; `None` where it is not valid.
#[derive(Default)]
pub(super) struct ObjectTrack {
    pub id: i64,
    /// `Track.ObjectType`
    pub kind: i64,
    pub states: Vec<Option<Sample>>,
}

/// State of the light of a lane at a step.
#[derive(Clone, Default)]
pub(super) struct LaneState {
    pub lane: String,
    /// `TrafficSignalLaneState.State`
    pub state: i64,
    pub stop_point: Option<Point3>,
}

type Parsed<T> = Result<T, ProtoError>;

pub(super) fn parse(message: &[u8]) -> Parsed<Scenario> {
    let mut s = Scenario::default();
    for field in Fields::new(message) {
        let field = field?;
        match field.number {
            1 => field.doubles(&mut s.times)?,
            2 => s.tracks.push(track(field)?),
            5 => s.id = field.text()?,
            6 => s.sdc_track_index = usize::try_from(field.int()?).ok(),
            7 => {
                let mut states = Vec::new();
                for f in field.fields()? {
                    let f = f?;
                    if f.number == 1 {
                        states.push(lane_state(f)?);
                    }
                }
                s.lights.push(states);
            }
            8 => s.features.extend(feature(field)?),
            // Lidar, camera tokens, what is to be predicted.
            _ => {}
        }
    }
    for track in &mut s.tracks {
        for (state, &time) in track.states.iter_mut().zip(&s.times) {
            if let Some(state) = state {
                state.time = time;
            }
        }
    }
    Ok(s)
}

fn track(field: Field<'_>) -> Parsed<ObjectTrack> {
    let mut t = ObjectTrack::default();
    for f in field.fields()? {
        let f = f?;
        match f.number {
            1 => t.id = f.int()?,
            2 => t.kind = f.int()?,
            3 => t.states.push(state(f)?),
            _ => {}
        }
    }
    Ok(t)
}

fn state(field: Field<'_>) -> Parsed<Option<Sample>> {
    // A field absent from a proto2 message is zero, and not valid.
    let mut v = [0.0; 12];
    let mut valid = false;
    for f in field.fields()? {
        let f = f?;
        match f.number {
            2..=10 => v[f.number as usize] = f.number()?,
            11 => valid = f.int()? != 0,
            _ => {}
        }
    }
    Ok(valid.then_some(Sample {
        time: f64::NAN,
        position: [v[2], v[3], v[4]],
        heading: v[8],
        velocity: [v[9], v[10]],
        size: [v[5], v[6], v[7]],
        ..Sample::UNKNOWN
    }))
}

fn lane_state(field: Field<'_>) -> Parsed<LaneState> {
    let mut s = LaneState::default();
    for f in field.fields()? {
        let f = f?;
        match f.number {
            1 => s.lane = f.int()?.to_string(),
            2 => s.state = f.int()?,
            3 => s.stop_point = Some(point(f)?),
            _ => {}
        }
    }
    Ok(s)
}

fn point(field: Field<'_>) -> Parsed<Point3> {
    let mut p = Point3::default();
    for f in field.fields()? {
        let f = f?;
        match f.number {
            1 => p.x = f.number()?,
            2 => p.y = f.number()?,
            3 => p.z = f.number()?,
            _ => {}
        }
    }
    Ok(p)
}

/// All points under field `number`.
fn points(field: Field<'_>, number: u32) -> Parsed<Vec<Point3>> {
    field.fields()?.filter(|f| !matches!(f, Ok(f) if f.number != number)).map(|f| point(f?)).collect()
}

/// `None` for a kind of feature that is newer than this reader.
fn feature(field: Field<'_>) -> Parsed<Option<(String, Result<Feature, String>)>> {
    let (mut id, mut what) = (0, None);
    for f in field.fields()? {
        let f = f?;
        what = Some(match f.number {
            1 => {
                id = f.int()?;
                continue;
            }
            3 => Feature::Lane(Box::new(lane(f)?)),
            4 | 5 => Feature::Line(points(f, 2)?),
            7 => stop_sign(f)?,
            8 => Feature::Crosswalk(points(f, 1)?),
            9 => Feature::Facility("speed_bump", points(f, 1)?),
            10 => Feature::Facility("driveway", points(f, 1)?),
            _ => continue,
        });
    }
    Ok(what.map(|what| (id.to_string(), Ok(what))))
}

fn stop_sign(field: Field<'_>) -> Parsed<Feature> {
    let (mut lanes, mut position) = (Vec::new(), Point3::default());
    for f in field.fields()? {
        let f = f?;
        match f.number {
            1 => f.ints(&mut lanes)?,
            2 => position = point(f)?,
            _ => {}
        }
    }
    Ok(Feature::StopSign { position, lanes: texts(&lanes) })
}

fn texts(ids: &[i64]) -> Vec<String> {
    ids.iter().map(i64::to_string).collect()
}

fn lane(field: Field<'_>) -> Parsed<CenterLane> {
    let mut l = CenterLane::default();
    let (mut kind, mut interpolating) = (0, false);
    let (mut entries, mut exits) = (Vec::new(), Vec::new());
    for f in field.fields()? {
        let f = f?;
        match f.number {
            1 => l.lane.speed_limit_mps = Some(f.number()? * MPS_PER_MPH).filter(|v| *v > 0.0),
            2 => kind = f.int()?,
            3 => interpolating = f.int()? != 0,
            8 => l.lane.center.push(point(f)?),
            9 => f.ints(&mut entries)?,
            10 => f.ints(&mut exits)?,
            11 | 12 => l.neighbors[(f.number - 11) as usize].push(neighbor(f)?),
            13 | 14 => l.boundaries[(f.number - 13) as usize].push(boundary(f)?),
            _ => {}
        }
    }
    l.lane = Lane {
        kind: if kind == TYPE_BIKE_LANE { LaneKind::Bike } else { LaneKind::Vehicle },
        // Lanes made between two others are the paths across junctions; on freeways they are splits and merges.
        in_junction: interpolating && kind != TYPE_FREEWAY,
        predecessors: texts(&entries),
        successors: texts(&exits),
        ..l.lane
    };
    Ok(l)
}

/// The integer fields 1 to 4 of a message; absent ones are 0.
fn four(field: Field<'_>) -> Parsed<[i64; 5]> {
    let mut v = [0; 5];
    for f in field.fields()? {
        let f = f?;
        if (1..=4).contains(&f.number) {
            v[f.number as usize] = f.int()?;
        }
    }
    Ok(v)
}

fn boundary(field: Field<'_>) -> Parsed<Boundary> {
    let [_, start, end, feature, kind] = four(field)?;
    // RoadLineType. Which side of a passing line (8) is solid is not stated; 0 is a road edge.
    let mark = match kind {
        1 | 4 => LaneMark::Dashed,
        2 | 6 => LaneMark::Solid,
        3 | 7 => LaneMark::DoubleSolid,
        5 => LaneMark::DoubleDashed,
        _ => LaneMark::Unknown,
    };
    Ok(Boundary {
        start: start.max(0) as usize,
        end: end.max(0) as usize,
        feature: feature.to_string(),
        mark,
    })
}

fn neighbor(field: Field<'_>) -> Parsed<Neighbor> {
    let [_, lane, start, end, _] = four(field)?;
    Ok(Neighbor { start: start.max(0) as usize, end: end.max(0) as usize, lane: lane.to_string() })
}
