//! Small square matrices of fixed size: the operations that a Kalman filter with two to six states needs.

/// Rows of a square matrix.
pub type Matrix<const N: usize> = [[f64; N]; N];

/// The matrix of zeros.
pub const fn zero<const N: usize>() -> Matrix<N> {
    [[0.0; N]; N]
}

/// The identity.
pub fn identity<const N: usize>() -> Matrix<N> {
    let mut out = zero();
    for (i, row) in out.iter_mut().enumerate() {
        row[i] = 1.0;
    }
    out
}

/// A matrix with this diagonal.
pub fn diagonal<const N: usize>(values: [f64; N]) -> Matrix<N> {
    let mut out = zero();
    for i in 0..N {
        out[i][i] = values[i];
    }
    out
}

/// `a b`.
pub fn product<const N: usize>(a: &Matrix<N>, b: &Matrix<N>) -> Matrix<N> {
    let mut out = zero();
    for i in 0..N {
        // One row at a time: it stays in registers.
        let mut row = [0.0; N];
        for k in 0..N {
            let factor = a[i][k];
            for j in 0..N {
                row[j] += factor * b[k][j];
            }
        }
        out[i] = row;
    }
    out
}

/// `a` transposed.
#[inline]
pub fn transposed<const N: usize>(a: &Matrix<N>) -> Matrix<N> {
    let mut out = zero();
    for i in 0..N {
        for j in 0..N {
            out[j][i] = a[i][j];
        }
    }
    out
}

/// `a + b`.
#[inline]
pub fn sum<const N: usize>(a: &Matrix<N>, b: &Matrix<N>) -> Matrix<N> {
    let mut out = *a;
    for i in 0..N {
        for j in 0..N {
            out[i][j] += b[i][j];
        }
    }
    out
}

/// The mean of a matrix and its transpose: rounding makes covariances asymmetric.
#[inline]
pub fn symmetric<const N: usize>(a: &Matrix<N>) -> Matrix<N> {
    let mut out = *a;
    for i in 0..N {
        for j in 0..i {
            let mean = 0.5 * (a[i][j] + a[j][i]);
            (out[i][j], out[j][i]) = (mean, mean);
        }
    }
    out
}
