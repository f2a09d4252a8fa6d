//! Small square matrices of fixed size, by hand: what a Kalman filter of two to six states needs, and nothing else.

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
        // A row at a time: it stays in registers.
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
pub fn sum<const N: usize>(a: &Matrix<N>, b: &Matrix<N>) -> Matrix<N> {
    let mut out = *a;
    for i in 0..N {
        for j in 0..N {
            out[i][j] += b[i][j];
        }
    }
    out
}

/// `a - b`.
pub fn difference<const N: usize>(a: &Matrix<N>, b: &Matrix<N>) -> Matrix<N> {
    let mut out = *a;
    for i in 0..N {
        for j in 0..N {
            out[i][j] -= b[i][j];
        }
    }
    out
}

/// The mean of a matrix and its transpose: rounding makes covariances asymmetric.
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

/// `x` of `a x = b` for a symmetric positive definite `a`, by Cholesky decomposition. A pivot that rounding has made
/// negative is taken as a very small one.
pub fn solve<const N: usize>(a: &Matrix<N>, b: &Matrix<N>) -> Matrix<N> {
    let mut l: Matrix<N> = zero();
    for i in 0..N {
        for j in 0..=i {
            let mut rest = a[i][j];
            for k in 0..j {
                rest -= l[i][k] * l[j][k];
            }
            l[i][j] = if i == j { rest.max(1e-18).sqrt() } else { rest / l[j][j] };
        }
    }
    let mut x = *b;
    // A row at a time, as in a product.
    for i in 0..N {
        let mut row = x[i];
        for k in 0..i {
            let factor = l[i][k];
            for c in 0..N {
                row[c] -= factor * x[k][c];
            }
        }
        for value in &mut row {
            *value /= l[i][i];
        }
        x[i] = row;
    }
    for i in (0..N).rev() {
        let mut row = x[i];
        for k in i + 1..N {
            let factor = l[k][i];
            for c in 0..N {
                row[c] -= factor * x[k][c];
            }
        }
        for value in &mut row {
            *value /= l[i][i];
        }
        x[i] = row;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_solution_gives_back_the_right_side() {
        let a = [[4.0, 1.0, 0.5], [1.0, 3.0, 0.2], [0.5, 0.2, 2.0]];
        let b = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 10.0]];
        let back = product(&a, &solve(&a, &b));
        for i in 0..3 {
            for j in 0..3 {
                assert!((back[i][j] - b[i][j]).abs() < 1e-12);
            }
        }
    }
}
