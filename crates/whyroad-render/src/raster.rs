//! The bird's-eye view of one moment as a small PNG with a fixed palette, as input for models: the ego at a fixed
//! pixel, its heading up, and no later measurements. Drawn without antialiasing, so that every pixel belongs to one
//! class.

mod canvas;

use canvas::Canvas;
use whyroad_model::road_map::{Lane, LaneKind, LaneMark, Point3, RoadMap};
use whyroad_model::scene::LightColor;
use whyroad_model::{Drive, ObjectClass};

/// Size and resolution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Raster {
    /// Width and height, pixels.
    pub size_px: u32,
    /// Meters per pixel.
    pub m_per_px: f64,
}

/// Class of a pixel: the index into the palette, and its color (red, green, blue).
pub const PALETTE: [(&str, [u8; 3]); 16] = [
    ("outside", [20, 22, 26]),
    ("drivable", [52, 56, 64]),
    ("lane", [70, 76, 86]),
    ("junction", [84, 88, 98]),
    ("bike_lane", [66, 88, 84]),
    ("sidewalk", [44, 44, 50]),
    ("crosswalk", [150, 150, 132]),
    ("mark", [190, 190, 180]),
    ("stop_line", [240, 240, 240]),
    ("light_red", [230, 60, 50]),
    ("light_yellow", [240, 200, 60]),
    ("light_green", [70, 200, 100]),
    ("ego", [90, 170, 255]),
    ("vehicle", [255, 160, 70]),
    ("vru", [255, 110, 190]),
    ("fixed", [160, 140, 120]),
];

// Positions in the palette.
const DRIVABLE: u8 = 1;
const LANE: u8 = 2;
const JUNCTION: u8 = 3;
const BIKE: u8 = 4;
const SIDEWALK: u8 = 5;
const CROSSWALK: u8 = 6;
const MARK: u8 = 7;
const STOP_LINE: u8 = 8;
const RED: u8 = 9;
const YELLOW: u8 = 10;
const GREEN: u8 = 11;
const EGO: u8 = 12;
const VEHICLE: u8 = 13;
const VRU: u8 = 14;
const FIXED: u8 = 15;

/// Share of the image's height that is ahead of the ego.
const AHEAD: f64 = 0.7;

/// The PNG at `frame`; `None` when the log has no ego pose there.
pub fn birds_eye(drive: &Drive, frame: usize, raster: &Raster) -> Option<Vec<u8>> {
    let ego = drive.ego.as_ref()?;
    let at = |v: &[f64]| v.get(frame).copied().filter(|v| v.is_finite());
    let pose = (at(&ego.motion.x)?, at(&ego.motion.y)?, at(&ego.motion.heading)?);
    let mut canvas = Canvas::new(raster.size_px);
    let view = View { pose, m_per_px: raster.m_per_px, size: f64::from(raster.size_px) };
    if let Some(map) = &drive.map {
        road(&mut canvas, &view, map);
        lights(&mut canvas, &view, drive, frame, map);
    }
    for track in &drive.tracks {
        let Some(row) = track.row_at(frame) else { continue };
        let color = match track.class {
            c if c.is_vehicle() => VEHICLE,
            c if c.is_vru() || c == ObjectClass::Animal => VRU,
            _ => FIXED,
        };
        let size =
            |v: &[f64], otherwise: f64| v.get(row).copied().filter(|v| v.is_finite()).unwrap_or(otherwise);
        let m = &track.motion;
        let heading = Some(m.heading[row]).filter(|h| h.is_finite()).unwrap_or(0.0);
        let extent = (size(&track.length_m, 0.6), size(&track.width_m, 0.6));
        view.rectangle(&mut canvas, (m.x[row], m.y[row], heading), extent, color);
    }
    let known = |v: f64, otherwise: f64| if v.is_finite() && v > 0.0 { v } else { otherwise };
    view.rectangle(&mut canvas, pose, (known(ego.length_m, 4.5), known(ego.width_m, 1.8)), EGO);
    canvas.png(&PALETTE.map(|(_, rgb)| rgb))
}

/// From the world to pixels.
struct View {
    pose: (f64, f64, f64),
    m_per_px: f64,
    size: f64,
}

impl View {
    fn pixel(&self, x: f64, y: f64) -> (f64, f64) {
        let (s, c) = self.pose.2.sin_cos();
        let (dx, dy) = (x - self.pose.0, y - self.pose.1);
        let (ahead, left) = (dx * c + dy * s, -dx * s + dy * c);
        (self.size / 2.0 - left / self.m_per_px, self.size * AHEAD - ahead / self.m_per_px)
    }

    fn pixels(&self, points: &[Point3]) -> Vec<(f64, f64)> {
        points.iter().map(|p| self.pixel(p.x, p.y)).collect()
    }

    fn rectangle(
        &self,
        canvas: &mut Canvas,
        (x, y, heading): (f64, f64, f64),
        (length, width): (f64, f64),
        color: u8,
    ) {
        let (s, c) = heading.sin_cos();
        let corner = |f: f64, k: f64| self.pixel(x + f * c - k * s, y + f * s + k * c);
        let (l, w) = (length / 2.0, width / 2.0);
        canvas.fill(&[corner(l, w), corner(l, -w), corner(-l, -w), corner(-l, w)], color);
    }
}

fn road(canvas: &mut Canvas, view: &View, map: &RoadMap) {
    for area in &map.drivable_areas {
        canvas.fill(&view.pixels(&area.boundary), DRIVABLE);
    }
    for area in &map.junctions {
        canvas.fill(&view.pixels(&area.boundary), JUNCTION);
    }
    for lane in &map.lanes {
        surface(canvas, view, lane);
    }
    for area in &map.crosswalks {
        canvas.fill(&view.pixels(&area.boundary), CROSSWALK);
    }
    for lane in map.lanes.iter().filter(|l| !l.in_junction && l.kind != LaneKind::Sidewalk) {
        for (edge, mark) in [(&lane.left, lane.left_mark), (&lane.right, lane.right_mark)] {
            if mark != LaneMark::None {
                canvas.line(&view.pixels(edge), MARK);
            }
        }
    }
    for line in &map.stop_lines {
        canvas.line(&view.pixels(&line.line), STOP_LINE);
    }
}

fn surface(canvas: &mut Canvas, view: &View, lane: &Lane) {
    let color = match lane.kind {
        LaneKind::Vehicle if lane.in_junction => JUNCTION,
        LaneKind::Vehicle | LaneKind::Bus => LANE,
        LaneKind::Bike => BIKE,
        LaneKind::Sidewalk => SIDEWALK,
        LaneKind::Shoulder | LaneKind::Other => DRIVABLE,
    };
    if lane.left.len() > 1 && lane.right.len() > 1 {
        let mut outline = view.pixels(&lane.left);
        outline.extend(view.pixels(&lane.right).into_iter().rev());
        canvas.fill(&outline, color);
        return;
    }
    let half = lane.width_m.unwrap_or(3.0) / 2.0;
    for pair in lane.center.windows(2) {
        let (dx, dy) = (pair[1].x - pair[0].x, pair[1].y - pair[0].y);
        let length = dx.hypot(dy);
        if length > 0.0 {
            let middle = ((pair[0].x + pair[1].x) / 2.0, (pair[0].y + pair[1].y) / 2.0, dy.atan2(dx));
            view.rectangle(canvas, middle, (length, 2.0 * half), color);
        }
    }
}

/// The last state at or before the frame, at the end of each lane.
fn lights(canvas: &mut Canvas, view: &View, drive: &Drive, frame: usize, map: &RoadMap) {
    let Some(time) = drive.times.get(frame) else { return };
    for lane in &map.lanes {
        let mut states = drive.lights.iter().flatten().filter(|l| l.lane_id == lane.id && l.time <= *time);
        let (Some(state), Some(end)) = (states.next_back(), lane.center.last()) else { continue };
        let color = match state.color {
            LightColor::Red => RED,
            LightColor::Yellow | LightColor::RedYellow | LightColor::FlashingYellow => YELLOW,
            LightColor::Green
            | LightColor::GreenYield
            | LightColor::GreenRound
            | LightColor::GreenArrow
            | LightColor::FlashingGreen => GREEN,
            LightColor::Off | LightColor::Unknown => continue,
        };
        view.rectangle(canvas, (end.x, end.y, 0.0), (1.5, 1.5), color);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use whyroad_model::Nanos;
    use whyroad_model::scene::{Ego, Motion, Track};

    fn drive() -> Drive {
        let n = 2;
        let still = |x: f64, y: f64, heading: f64| Motion {
            x: vec![x; n],
            y: vec![y; n],
            heading: vec![heading; n],
            ..Motion::unknown(n)
        };
        Drive {
            times: vec![Nanos(0), Nanos(100_000_000)],
            ego: Some(Ego { length_m: 4.0, width_m: 2.0, motion: still(10.0, 5.0, 1.0), ..Ego::default() }),
            // 10 m straight ahead of the ego, whose heading is 1 rad.
            tracks: vec![Track {
                id: "a".into(),
                class: ObjectClass::Car,
                frames: vec![1],
                motion: Motion {
                    x: vec![10.0 + 10.0 * 1f64.cos()],
                    y: vec![5.0 + 10.0 * 1f64.sin()],
                    heading: vec![1.0],
                    ..Motion::unknown(1)
                },
                length_m: vec![4.0],
                width_m: vec![2.0],
                height_m: vec![1.5],
                interior_points: vec![f64::NAN],
                ..Track::default()
            }],
            ..Drive::default()
        }
    }

    fn pixels(png: &[u8]) -> Vec<u8> {
        let mut decoder = png::Decoder::new(std::io::Cursor::new(png));
        decoder.set_transformations(png::Transformations::IDENTITY);
        let mut reader = decoder.read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut bytes).unwrap();
        assert_eq!((info.width, info.height), (100, 100));
        bytes
    }

    #[test]
    fn the_ego_is_below_the_middle_and_what_is_ahead_is_above_it() {
        let raster = Raster { size_px: 100, m_per_px: 0.5 };
        let image = pixels(&birds_eye(&drive(), 1, &raster).unwrap());
        let at = |x: usize, y: usize| image[y * 100 + x];
        assert_eq!((at(50, 70), at(50, 50)), (EGO, VEHICLE), "10 m are 20 pixels");
        assert_eq!(at(50, 60), 0);
        // 4 m by 2 m are 8 by 4 pixels.
        assert_eq!(image.iter().filter(|p| **p == EGO).count(), 32);
        let before = pixels(&birds_eye(&drive(), 0, &raster).unwrap());
        assert!(!before.contains(&VEHICLE), "the car was seen in frame 1 first");
    }

    #[test]
    fn without_a_pose_there_is_no_image_and_equal_input_gives_equal_bytes() {
        let raster = Raster { size_px: 32, m_per_px: 1.0 };
        assert_eq!(birds_eye(&drive(), 9, &raster), None);
        assert_eq!(birds_eye(&drive(), 1, &raster), birds_eye(&drive(), 1, &raster));
    }
}
