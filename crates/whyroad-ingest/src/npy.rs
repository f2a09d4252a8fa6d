//! NumPy `.npy` arrays as rows and columns, in either memory order. Never a pickle: object arrays are refused.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

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

fn open(path: &Path) -> Result<npyz::NpyFile<BufReader<File>>, String> {
    let file = File::open(path).map_err(|e| e.to_string())?;
    npyz::NpyFile::new(BufReader::new(file)).map_err(|e| e.to_string())
}

/// Reads floating-point numbers (float64, or int64 converted).
pub fn read_numbers(path: &Path) -> Result<Table, String> {
    let npy = open(path)?;
    let shape: Vec<usize> = npy.shape().iter().map(|&n| n as usize).collect();
    let (rows, columns) = match shape[..] {
        [n] => (n, 1),
        [n, m] => (n, m),
        _ => return Err(format!("an array of {} dimensions where one or two are expected", shape.len())),
    };
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

/// Reads an array of byte strings (`S8`), each at its full width: NumPy and the crate take zeros at a string's end for
/// padding, but in a bus frame they are data.
pub fn read_bytes(path: &Path) -> Result<Vec<Vec<u8>>, String> {
    let npy = open(path)?;
    let npyz::DType::Plain(kind) = npy.dtype() else {
        return Err("an array of records, not of byte strings".into());
    };
    let width = kind.num_bytes().unwrap_or(0);
    let mut strings = npy.into_vec::<Vec<u8>>().map_err(|e| e.to_string())?;
    for s in &mut strings {
        s.resize(width, 0);
    }
    Ok(strings)
}
