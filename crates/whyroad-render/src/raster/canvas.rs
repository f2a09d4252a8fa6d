//! Pixels with palette indices: filled polygons, lines one pixel wide, and the PNG file.

/// A square image; index 0 at first.
pub(super) struct Canvas {
    size: usize,
    pixels: Vec<u8>,
}

impl Canvas {
    pub fn new(size_px: u32) -> Self {
        let size = size_px as usize;
        Self { size, pixels: vec![0; size * size] }
    }

    /// Pixels whose center is inside the polygon (even-odd rule).
    pub fn fill(&mut self, polygon: &[(f64, f64)], color: u8) {
        if polygon.iter().any(|p| !p.0.is_finite() || !p.1.is_finite()) {
            return;
        }
        let size = self.size as f64;
        let (low, high) = polygon.iter().fold((f64::MAX, f64::MIN), |(a, b), p| (a.min(p.1), b.max(p.1)));
        let first = (low - 0.5).ceil().max(0.0);
        let mut crossings = Vec::new();
        let mut y = first;
        while y < size && y + 0.5 <= high {
            let center = y + 0.5;
            crossings.clear();
            for (i, b) in polygon.iter().enumerate() {
                let a = polygon[(i + polygon.len() - 1) % polygon.len()];
                if (a.1 > center) != (b.1 > center) {
                    crossings.push(a.0 + (center - a.1) / (b.1 - a.1) * (b.0 - a.0));
                }
            }
            crossings.sort_by(f64::total_cmp);
            for pair in crossings.chunks_exact(2) {
                let from = (pair[0] - 0.5).ceil().max(0.0);
                let to = (pair[1] - 0.5).ceil().min(size);
                if from < to {
                    let row = y as usize * self.size;
                    self.pixels[row + from as usize..row + to as usize].fill(color);
                }
            }
            y += 1.0;
        }
    }

    /// A polyline one pixel wide.
    pub fn line(&mut self, points: &[(f64, f64)], color: u8) {
        let size = self.size as f64;
        for pair in points.windows(2) {
            let ((ax, ay), (bx, by)) = (pair[0], pair[1]);
            let outside = ax.max(bx) < 0.0 || ay.max(by) < 0.0 || ax.min(bx) >= size || ay.min(by) >= size;
            if outside || ![ax, ay, bx, by].iter().all(|v| v.is_finite()) {
                continue;
            }
            let Some((from, to)) = inside((ax, ay), (bx, by), size) else { continue };
            let steps = ((bx - ax).abs().max((by - ay).abs()) * (to - from)).ceil().max(1.0);
            let mut i = 0.0;
            while i <= steps {
                let t = from + (to - from) * i / steps;
                self.set(ax + t * (bx - ax), ay + t * (by - ay), color);
                i += 1.0;
            }
        }
    }

    fn set(&mut self, x: f64, y: f64, color: u8) {
        if x >= 0.0 && y >= 0.0 && x < self.size as f64 && y < self.size as f64 {
            self.pixels[y as usize * self.size + x as usize] = color;
        }
    }

    /// The file; `None` when it cannot be encoded, which a palette of this program never causes.
    pub fn png(&self, palette: &[[u8; 3]]) -> Option<Vec<u8>> {
        let mut out = Vec::new();
        let side = u32::try_from(self.size).ok()?;
        let mut encoder = png::Encoder::new(&mut out, side, side);
        encoder.set_color(png::ColorType::Indexed);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_palette(palette.concat());
        encoder.set_compression(png::Compression::Balanced);
        let mut writer = encoder.write_header().ok()?;
        writer.write_image_data(&self.pixels).ok()?;
        writer.finish().ok()?;
        Some(out)
    }
}

/// The part of a segment inside the image, as parameters from 0 to 1 (Liang-Barsky).
fn inside(a: (f64, f64), b: (f64, f64), size: f64) -> Option<(f64, f64)> {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    for (p, q) in [(-dx, a.0), (dx, size - a.0), (-dy, a.1), (dy, size - a.1)] {
        if p == 0.0 {
            if q < 0.0 {
                return None;
            }
        } else if p < 0.0 {
            from = from.max(q / p);
        } else {
            to = to.min(q / p);
        }
    }
    (from <= to).then_some((from, to))
}
