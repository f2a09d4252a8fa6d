//! `annotations.feather`: cuboids in the ego frame of their own timestamp.

use super::classes::EGO;
use crate::assemble::se3::unit;
use crate::encodings::columns::Columns;
use crate::report::RowCount;
use std::collections::HashSet;

/// One cuboid.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cuboid {
    pub time: i64,
    /// Index into [`Annotations::tracks`].
    pub track: usize,
    /// Index into [`Annotations::categories`].
    pub category: usize,
    /// Length, width, height, m; NaN where the row's size is not valid.
    pub size: [f64; 3],
    /// Rotation object to ego.
    pub q: [f64; 4],
    /// Center in the ego frame, m.
    pub t: [f64; 3],
    /// Lidar points in the box; NaN when not stated.
    pub points: f64,
}

/// All usable cuboids in file order, and what was found on the way.
#[derive(Default)]
pub(super) struct Annotations {
    /// Ids of the tracks.
    pub tracks: Vec<String>,
    /// Names of the categories.
    pub categories: Vec<String>,
    pub objects: Vec<Cuboid>,
    /// Rows of the recording vehicle.
    pub ego: Vec<Cuboid>,
    pub count: RowCount,
    /// First duplicate, as `track at time`.
    pub duplicate_example: Option<String>,
    /// Description of the first invalid row.
    pub invalid_example: Option<String>,
    /// Rows whose size was not valid; kept, with the size set to unknown.
    pub bad_sizes: usize,
    pub has_points: bool,
}

/// Reads the rows. A row without a usable time, id, position or rotation is dropped and counted; of two rows of
/// one track at one time the first is kept. Ego rows stay in `count.kept` as `ego`; tracks are counted by the caller.
pub(super) fn read(file: &Columns) -> Result<Annotations, String> {
    let times = file.integers("timestamp_ns")?;
    let tracks = file.words("track_uuid")?;
    let categories = file.words("category")?;
    let size = [file.numbers("length_m")?, file.numbers("width_m")?, file.numbers("height_m")?];
    let q = [file.numbers("qw")?, file.numbers("qx")?, file.numbers("qy")?, file.numbers("qz")?];
    let t = [file.numbers("tx_m")?, file.numbers("ty_m")?, file.numbers("tz_m")?];
    let has_points = file.has("num_interior_pts");
    let points = if has_points { file.numbers("num_interior_pts")? } else { vec![f64::NAN; times.len()] };

    let mut out = Annotations {
        count: RowCount { read: times.len(), ..RowCount::new("annotations") },
        has_points,
        ..Annotations::default()
    };
    let mut seen: Vec<Times> = tracks.texts.iter().map(|_| Times::default()).collect();
    // A row without a category has the one without a name.
    let mut names = categories.texts;
    let nameless = names.iter().position(String::is_empty).unwrap_or(names.len());
    if nameless == names.len() {
        names.push(String::new());
    }
    let own = names.iter().position(|name| name == EGO);
    for i in 0..times.len() {
        let translation = [t[0][i], t[1][i], t[2][i]];
        let rotation = unit([q[0][i], q[1][i], q[2][i], q[3][i]]);
        let (Some(time), Some(track), Some(q), true) =
            (times[i], tracks.rows[i], rotation, translation.iter().all(|v| v.is_finite()))
        else {
            out.count.drop_rows("invalid", 1);
            out.invalid_example.get_or_insert_with(|| {
                let id = tracks.rows[i].map_or("null", |track| &tracks.texts[track]);
                let what = if rotation.is_none() {
                    "its quaternion is not a rotation"
                } else {
                    "a value is missing or not finite"
                };
                format!("row {i}, track {id}: {what}")
            });
            continue;
        };
        if !seen[track].insert(time) {
            out.count.drop_rows("duplicate", 1);
            out.duplicate_example.get_or_insert_with(|| format!("{} at {time}", tracks.texts[track]));
            continue;
        }
        let raw_size = [size[0][i], size[1][i], size[2][i]];
        let sized = raw_size.iter().all(|v| v.is_finite() && *v > 0.0);
        out.bad_sizes += usize::from(!sized);
        let cuboid = Cuboid {
            time,
            track,
            category: categories.rows[i].unwrap_or(nameless),
            size: if sized { raw_size } else { [f64::NAN; 3] },
            q,
            t: translation,
            points: points[i],
        };
        if Some(cuboid.category) == own { out.ego.push(cuboid) } else { out.objects.push(cuboid) }
    }
    out.count.keep("ego", out.ego.len());
    (out.tracks, out.categories) = (tracks.texts, names);
    Ok(out)
}

/// The times of one track. Most files have them in their order.
#[derive(Default)]
struct Times {
    ascending: Vec<i64>,
    others: HashSet<i64>,
}

impl Times {
    /// False where the time already exists.
    fn insert(&mut self, time: i64) -> bool {
        if self.ascending.last().is_none_or(|last| *last < time) {
            self.ascending.push(time);
            return true;
        }
        self.ascending.binary_search(&time).is_err() && self.others.insert(time)
    }
}
