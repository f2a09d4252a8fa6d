//! Results of a miner in the challenge's form: for every evaluated frame all objects of the log, each referred to,
//! related, or other. Written as a pickle that the challenge's evaluator loads, or as JSON Lines ([`super::sequence`]).

use super::sequence::{Frame, Label, Object, Sequence};
use std::collections::BTreeMap;

/// Logs with more frames than this are evaluated at every fifth one.
const MOST_FRAMES: usize = 50;
/// ... at every frame of this number (10 Hz to 2 Hz).
const EVERY: usize = 5;

/// One log and one prompt.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MiningResult {
    /// Log (drive).
    pub log_id: String,
    /// The prompt.
    pub prompt: String,
    /// In the order of time.
    pub frames: Vec<ResultFrame>,
}

/// One moment.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ResultFrame {
    /// Time.
    pub timestamp_ns: i64,
    /// Reference point of the ego (the rear axle), m.
    pub ego: [f64; 3],
    /// All objects of the frame.
    pub objects: Vec<ResultObject>,
}

/// One object in one frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ResultObject {
    /// Track.
    pub track_id: String,
    /// Its relation to the prompt.
    pub label: Label,
    /// Box center, m.
    pub center: [f64; 3],
    /// Length, width, height, m.
    pub size: [f64; 3],
    /// Heading, rad.
    pub yaw: f64,
    /// How sure the prediction is.
    pub score: f64,
}

/// Frames of a log with `frames` frames at which the challenge evaluates.
pub fn evaluated_frames(frames: usize) -> impl Iterator<Item = usize> {
    (0..frames).step_by(if frames > MOST_FRAMES { EVERY } else { 1 })
}

impl MiningResult {
    /// The same as a sequence, in the plane.
    pub fn to_sequence(&self) -> Sequence {
        let object = |o: &ResultObject| Object {
            track_id: o.track_id.clone(),
            label: o.label,
            x: o.center[0],
            y: o.center[1],
            score: o.score,
        };
        let frame = |f: &ResultFrame| Frame {
            timestamp_ns: f.timestamp_ns,
            ego: [f.ego[0], f.ego[1]],
            is_positive: None,
            objects: f.objects.iter().map(object).collect(),
        };
        Sequence {
            log_id: self.log_id.clone(),
            prompt: self.prompt.clone(),
            frames: self.frames.iter().map(frame).collect(),
        }
    }
}

/// A pickle (protocol 3) of `{(log_id, prompt): [frame, ...]}` with the keys and NumPy types of the challenge:
/// `seq_id`, `timestamp_ns`, `ego_translation_m`, `description`, `translation_m`, `size`, `yaw`, `label`, `name`,
/// `track_id`, `score`. It names no functions but `numpy.array`, `numpy.reshape`, `numpy.frombuffer` and `numpy.zeros`.
pub fn to_pickle(results: &[MiningResult]) -> Vec<u8> {
    let mut out = Pickle(vec![0x80, 3]);
    out.op(b"}(");
    for result in results {
        let mut numbers: BTreeMap<&str, i32> = BTreeMap::new();
        for o in result.frames.iter().flat_map(|f| &f.objects) {
            let next = numbers.len() as i32;
            numbers.entry(&o.track_id).or_insert(next);
        }
        out.id(result);
        out.op(b"](");
        for frame in &result.frames {
            out.frame(result, frame, &numbers);
        }
        out.op(b"e");
    }
    out.op(b"u.");
    out.0
}

/// Bytes of a pickle under construction.
struct Pickle(Vec<u8>);

impl Pickle {
    fn op(&mut self, code: &[u8]) {
        self.0.extend_from_slice(code);
    }

    fn sized(&mut self, code: u8, bytes: &[u8]) {
        self.0.push(code);
        self.0.extend_from_slice(&(bytes.len() as u32).to_le_bytes());
        self.0.extend_from_slice(bytes);
    }

    fn text(&mut self, text: &str) {
        self.sized(b'X', text.as_bytes());
    }

    fn integer(&mut self, value: i64) {
        self.op(&[0x8a, 8]);
        self.0.extend_from_slice(&value.to_le_bytes());
    }

    fn float(&mut self, value: f64) {
        self.op(b"G");
        self.0.extend_from_slice(&value.to_be_bytes());
    }

    fn id(&mut self, of: &MiningResult) {
        self.text(&of.log_id);
        self.text(&of.prompt);
        self.op(&[0x86]);
    }

    fn function(&mut self, name: &str) {
        self.op(b"cnumpy\n");
        self.op(name.as_bytes());
        self.op(b"\n");
    }

    fn shape(&mut self, shape: &[usize]) {
        self.op(b"(");
        shape.iter().for_each(|n| self.integer(*n as i64));
        self.op(b"t");
    }

    /// A NumPy array that owns its values.
    fn array(&mut self, dtype: &str, shape: &[usize], bytes: &[u8]) {
        if bytes.is_empty() {
            self.function("zeros");
            self.shape(shape);
            self.text(dtype);
            self.op(&[0x86, b'R']);
            return;
        }
        self.function("array");
        self.function("reshape");
        self.function("frombuffer");
        self.sized(b'B', bytes);
        self.text(dtype);
        self.op(&[0x86, b'R']);
        self.shape(shape);
        self.op(&[0x86, b'R', 0x85, b'R']);
    }

    fn frame(&mut self, of: &MiningResult, frame: &ResultFrame, numbers: &BTreeMap<&str, i32>) {
        let (n, objects) = (frame.objects.len(), &frame.objects);
        let code = |o: &ResultObject| match o.label {
            Label::ReferredObject => (0i32, "REFERRED_OBJECT"),
            Label::RelatedObject => (1, "RELATED_OBJECT"),
            Label::OtherObject => (2, "OTHER_OBJECT"),
        };
        let f32s = |f: &dyn Fn(&ResultObject) -> f64| -> Vec<u8> {
            objects.iter().flat_map(|o| (f(o) as f32).to_le_bytes()).collect()
        };
        let i32s = |f: &dyn Fn(&ResultObject) -> i32| -> Vec<u8> {
            objects.iter().flat_map(|o| f(o).to_le_bytes()).collect()
        };
        self.op(b"}(");
        self.text("seq_id");
        self.id(of);
        self.text("timestamp_ns");
        self.integer(frame.timestamp_ns);
        self.text("ego_translation_m");
        self.op(b"](");
        frame.ego.iter().for_each(|x| self.float(*x));
        self.op(b"e");
        self.text("description");
        self.text(&of.prompt);
        self.text("translation_m");
        let centers: Vec<u8> = objects.iter().flat_map(|o| o.center).flat_map(f64::to_le_bytes).collect();
        self.array("<f8", &[n, 3], &centers);
        self.text("size");
        let sizes: Vec<u8> =
            objects.iter().flat_map(|o| o.size).flat_map(|x| (x as f32).to_le_bytes()).collect();
        self.array("<f4", &[n, 3], &sizes);
        self.text("yaw");
        self.array("<f4", &[n], &f32s(&|o| o.yaw));
        self.text("label");
        self.array("<i4", &[n], &i32s(&|o| code(o).0));
        self.text("name");
        let names = objects.iter().flat_map(|o| padded(code(o).1)).collect::<Vec<u8>>();
        self.array("<U31", &[n], &names);
        self.text("track_id");
        self.array("<i4", &[n], &i32s(&|o| numbers.get(o.track_id.as_str()).copied().unwrap_or(-1)));
        self.text("score");
        self.array("<f4", &[n], &f32s(&|o| o.score));
        self.op(b"u");
    }
}

/// As an element of a NumPy array of `<U31`.
fn padded(text: &str) -> [u8; 124] {
    let mut out = [0; 124];
    for (cell, c) in out.chunks_exact_mut(4).zip(text.chars()) {
        cell.copy_from_slice(&u32::from(c).to_le_bytes());
    }
    out
}
