//! NumPy `.npy` arrays as rows and columns, in either memory order. Never a pickle: object arrays are refused.

use crate::file_reader::FileReader;

/// A one- or two-dimensional array of numbers, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Number of columns; 1 for a one-dimensional array.
    pub columns: usize,
    values: Vec<f64>,
}

impl Table {
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.values.len() / self.columns.max(1)
    }

    /// One row.
    pub fn row(&self, i: usize) -> &[f64] {
        &self.values[i * self.columns..(i + 1) * self.columns]
    }

    /// One column.
    pub fn column(&self, j: usize) -> Vec<f64> {
        (0..self.rows()).map(|i| self.row(i)[j]).collect()
    }
}

/// An array of byte strings of one width, one after the other.
#[derive(Clone, Debug, PartialEq)]
pub struct ByteStrings {
    /// Bytes of a string.
    pub width: usize,
    /// All strings, row by row.
    pub bytes: Vec<u8>,
}

impl ByteStrings {
    /// Number of strings.
    pub fn rows(&self) -> usize {
        self.bytes.len() / self.width.max(1)
    }

    /// One string at its full width.
    pub fn row(&self, i: usize) -> &[u8] {
        &self.bytes[i * self.width..(i + 1) * self.width]
    }
}

/// Floating-point numbers (float64, or int64 converted) from a file's bytes.
pub fn numbers(file: &[u8]) -> Result<Table, String> {
    let npy = open(file)?;
    let shape: Vec<usize> = npy.shape().iter().map(|&n| n as usize).collect();
    let (rows, columns) = match shape[..] {
        [n] => (n, 1),
        [n, m] => (n, m),
        _ => return Err(format!("an array of {} dimensions where one or two are expected", shape.len())),
    };
    let size = rows.checked_mul(columns).and_then(|n| n.checked_mul(npy.dtype().num_bytes()?));
    if size.is_none_or(|size| payload(file).is_none_or(|p| p.len() < size)) {
        return Err("the file ends inside the array".to_owned());
    }
    let fortran = npy.order() == npyz::Order::Fortran;
    let integers = npy.dtype().descr().contains("i8");
    let flat = if integers {
        npy.into_vec::<i64>().map(|v| v.into_iter().map(|x| x as f64).collect())
    } else {
        npy.into_vec::<f64>()
    }
    .map_err(|e| e.to_string())?;
    let values = if fortran && columns > 1 {
        (0..rows * columns).map(|k| flat[(k % columns) * rows + k / columns]).collect()
    } else {
        flat
    };
    Ok(Table { columns, values })
}

/// Byte strings (`S8`) from a file's bytes, each at its full width: NumPy and the crate take zeros at a string's end
/// for padding, but in a bus frame they are data. They are taken as they lie in the file, not one allocation each.
pub fn byte_strings(file: &[u8]) -> Result<ByteStrings, String> {
    let npy = open(file)?;
    let width = match npy.dtype() {
        npyz::DType::Plain(kind) if kind.type_char() == npyz::TypeChar::ByteStr => kind.num_bytes(),
        _ => None,
    };
    let Some(width) = width.filter(|&w| w > 0) else {
        return Err("not an array of byte strings of one width".into());
    };
    let rows = npy.shape().iter().try_fold(1_usize, |n, &m| n.checked_mul(usize::try_from(m).ok()?));
    let size = rows.and_then(|n| n.checked_mul(width)).ok_or("an array larger than memory")?;
    let payload = payload(file).ok_or("the file ends in its header")?;
    let bytes = payload
        .get(..size)
        .ok_or_else(|| format!("{} of {size} bytes of the array are there", payload.len()))?;
    Ok(ByteStrings { width, bytes: bytes.to_vec() })
}

/// First bytes of a file (`numpy.lib.format`).
const MAGIC: &[u8] = b"\x93NUMPY";

/// The array, unless its header is longer than the file, or states more elements than the file has bytes: the crate
/// allocates the header's length and multiplies the dimensions without a check.
fn open(file: &[u8]) -> Result<npyz::NpyFile<&[u8]>, String> {
    if let Some(payload) = payload(file) {
        let header = String::from_utf8_lossy(&file[..file.len() - payload.len()]);
        let shape =
            header.rsplit_once("shape").and_then(|(_, rest)| rest.split(')').next()).unwrap_or_default();
        let dimensions = shape.split(|c: char| !c.is_ascii_digit()).filter(|d| !d.is_empty());
        let elements =
            dimensions.map(|d| d.parse::<usize>().ok()).try_fold(1_usize, |n, d| n.checked_mul(d?));
        if elements.is_none_or(|n| n > file.len()) {
            return Err("the file ends inside the array".to_owned());
        }
    } else if file.starts_with(MAGIC) {
        return Err("the file ends in its header".to_owned());
    }
    npyz::NpyFile::new(file).map_err(|e| e.to_string())
}

/// What follows the header (NumPy's format description, `numpy.lib.format`): magic and version are 8 bytes, the
/// header's length is 2 bytes in version 1 and 4 after it.
fn payload(file: &[u8]) -> Option<&[u8]> {
    let length_bytes = if *file.get(6)? == 1 { 2 } else { 4 };
    let length = file.get(8..8 + length_bytes)?.iter().rev().fold(0, |n, &b| n << 8 | usize::from(b));
    file.get((8 + length_bytes).checked_add(length)?..)
}

/// For [`crate::readers`].
pub(crate) const READER: FileReader =
    FileReader { name: "npy", read: |bytes| numbers(bytes).is_ok() | byte_strings(bytes).is_ok() };

#[cfg(test)]
mod tests {
    use super::*;

    /// By NumPy's format description: three strings of width 4, zeros at an end are kept; version 1 and 2 headers.
    #[test]
    fn byte_strings_keep_their_zeros_and_a_cut_file_is_an_error() {
        let header = "{'descr': '|S4', 'fortran_order': False, 'shape': (3,), }\n";
        let data = [1, 2, 3, 4, 5, 0, 0, 0, 0, 0, 0, 0];
        let one: Vec<u8> =
            [b"\x93NUMPY\x01\x00".as_slice(), &(header.len() as u16).to_le_bytes(), header.as_bytes(), &data]
                .concat();
        let two: Vec<u8> =
            [b"\x93NUMPY\x02\x00".as_slice(), &(header.len() as u32).to_le_bytes(), header.as_bytes(), &data]
                .concat();
        for file in [&one, &two] {
            let strings = byte_strings(file).unwrap();
            assert_eq!((strings.rows(), strings.row(1), strings.row(2)), (3, &data[4..8], &data[8..]));
            assert!(byte_strings(&file[..file.len() - 1]).unwrap_err().contains("11 of 12 bytes"));
        }
        let numbers = String::from_utf8_lossy(&one).replace("'|S4'", "'<f4'");
        assert!(byte_strings(numbers.as_bytes()).is_err());
    }

    #[test]
    fn a_header_longer_than_the_file_is_an_error() {
        // Found by the fuzz target `npy`: the crate allocates what a header of version 2 states, up to 4 GB.
        let file = [b"\x93NUMPY\x02\x00".as_slice(), &u32::MAX.to_le_bytes(), b"{'descr': '<f8'"].concat();
        assert_eq!(numbers(&file).unwrap_err(), "the file ends in its header");
        assert_eq!(byte_strings(&file).unwrap_err(), "the file ends in its header");
    }

    #[test]
    fn a_shape_beyond_the_file_is_an_error() {
        // Found by the fuzz target `npy-frame_positions`: the product of the dimensions does not fit into 64 bits.
        for shape in ["(9223372036854775807, 3)", "(99999999999999999999,)", "(4, 4)"] {
            let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}\n");
            let length = (header.len() as u16).to_le_bytes();
            let file = [b"\x93NUMPY\x01\x00".as_slice(), &length, header.as_bytes(), &[0; 8]].concat();
            assert_eq!(numbers(&file).unwrap_err(), "the file ends inside the array", "{shape}");
        }
    }
}
