//! The region of interest of the challenge: a raster over the city, true on and near drivable areas. Objects outside of
//! it are not evaluated.
//!
//! The evaluator makes it from the map when it runs and stores it nowhere; two lines of its library save it
//! (docs/reference/evaluation.md): the raster as `.npy`, and how city coordinates become cells as `.json`.

use super::sequence::Sequence;
use serde::Deserialize;

/// A raster and its location.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    rows: usize,
    columns: usize,
    cells: Vec<bool>,
    to_cells: Similarity,
}

/// `cell = scale * (rotation * point + translation)`: the layout of AV2's `*_img_Sim2_city.json`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Similarity {
    /// By rows.
    #[serde(rename = "R")]
    pub rotation: [f64; 4],
    /// m.
    #[serde(rename = "t")]
    pub translation: [f64; 2],
    /// Cells per meter.
    #[serde(rename = "s")]
    pub scale: f64,
}

/// Why a region cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RegionError {
    /// The raster is not a two-dimensional `.npy` file of one byte per cell.
    #[error("the raster is not a .npy file with a two-dimensional array of bool or uint8: {0}")]
    Raster(String),
    /// The transform is not as AV2 writes it.
    #[error("the transform is not a JSON object with R, t and s: {0}")]
    Transform(String),
}

impl Region {
    /// From the bytes of the raster and the text of its transform.
    pub fn read(npy: &[u8], transform: &str) -> Result<Self, RegionError> {
        let to_cells = serde_json::from_str(transform).map_err(|e| RegionError::Transform(e.to_string()))?;
        let fail = |what: &str| RegionError::Raster(what.to_owned());
        let version =
            npy.get(6).filter(|_| npy.starts_with(b"\x93NUMPY")).ok_or_else(|| fail("no header"))?;
        let (start, length) = match version {
            1 => (10, npy.get(8..10).map(|b| usize::from(u16::from_le_bytes([b[0], b[1]])))),
            _ => (12, npy.get(8..12).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize)),
        };
        let end = length.and_then(|n| n.checked_add(start)).ok_or_else(|| fail("the header is cut off"))?;
        let header = npy.get(start..end).and_then(|h| std::str::from_utf8(h).ok());
        let header = header.ok_or_else(|| fail("the header is cut off"))?;
        if !["'|b1'", "'|u1'", "'<u1'"].iter().any(|t| header.contains(t)) {
            return Err(fail("its type is neither bool nor uint8"));
        }
        if header.contains("'fortran_order': True") {
            return Err(fail("it is stored by columns"));
        }
        let shape = header.split_once("'shape': (").and_then(|(_, rest)| rest.split_once(')'));
        let sides = shape.map(|(inside, _)| inside.split(',').filter_map(|n| n.trim().parse().ok()));
        let sides: Vec<usize> = sides.map(Iterator::collect).unwrap_or_default();
        let [rows, columns] = sides[..] else { return Err(fail("it does not have two dimensions")) };
        let body = &npy[end..];
        if rows.checked_mul(columns) != Some(body.len()) {
            return Err(fail("its size does not fit its shape"));
        }
        Ok(Self { rows, columns, cells: body.iter().map(|b| *b != 0).collect(), to_cells })
    }

    /// True where a point of the city is inside.
    pub fn contains(&self, x: f64, y: f64) -> bool {
        let Similarity { rotation: r, translation: t, scale } = &self.to_cells;
        let u = scale * (r[0] * x + r[1] * y + t[0]);
        let v = scale * (r[2] * x + r[3] * y + t[1]);
        // As the evaluator does: towards zero, columns along x.
        let (column, row) = (u.trunc(), v.trunc());
        let within = column >= 0.0 && row >= 0.0 && column < self.columns as f64 && row < self.rows as f64;
        within && self.cells[row as usize * self.columns + column as usize]
    }

    /// The sequence without the objects whose center is outside.
    #[must_use]
    pub fn inside(&self, sequence: &Sequence) -> Sequence {
        let mut out = sequence.clone();
        out.frames.iter_mut().for_each(|f| f.objects.retain(|o| self.contains(o.x, o.y)));
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Written by `numpy.save` of `[[0, 1, 0], [0, 0, 1]]` as bool: header of 118 bytes after 10, then the cells.
    fn raster() -> Vec<u8> {
        let mut header = "{'descr': '|b1', 'fortran_order': False, 'shape': (2, 3), }".to_owned();
        header += &" ".repeat(117 - header.len());
        header.push('\n');
        let mut out = b"\x93NUMPY\x01\x00".to_vec();
        out.extend_from_slice(&118u16.to_le_bytes());
        out.extend_from_slice(header.as_bytes());
        out.extend_from_slice(&[0, 1, 0, 0, 0, 1]);
        out
    }

    #[test]
    fn cells_are_found_by_hand() {
        // Two cells per meter, the origin of the raster at (100, 200).
        let sim = r#"{"R": [1, 0, 0, 1], "t": [-100, -200], "s": 2.0}"#;
        let region = Region::read(&raster(), sim).unwrap();
        assert!(region.contains(100.6, 200.2), "row 0, column 1");
        assert!(!region.contains(100.2, 200.2), "row 0, column 0");
        assert!(region.contains(101.4, 200.9), "row 1, column 2");
        assert!(!region.contains(101.6, 200.9), "beyond the last column");
        assert!(!region.contains(99.0, 200.2), "before the first");
    }

    #[test]
    fn what_is_no_raster_is_refused() {
        let sim = r#"{"R": [1, 0, 0, 1], "t": [0, 0], "s": 1}"#;
        let short = &raster()[..raster().len() - 1];
        for bytes in [short, b"\x93NUMPY\x01\x00".as_slice(), b"".as_slice(), b"\x93NUMPY\x01\x00\xff\xffx"] {
            assert!(matches!(Region::read(bytes, sim), Err(RegionError::Raster(_))), "{bytes:?}");
        }
        assert!(matches!(Region::read(&raster(), "{}"), Err(RegionError::Transform(_))));
    }
}
