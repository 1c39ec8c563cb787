//! Separable convolution, one output row at a time.
//!
//! In: a picture of N channels as a function of column and row. Out: a row of it, each channel filtered with its own
//! kernel, first vertically, then horizontally. Needs memory for one row only.

use std::ops::{AddAssign, Mul};

/// Extension of a picture beyond its border.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Border {
    /// Repeats the border pixel: `aaa|abc|ccc`.
    Clamp,
    /// Mirrors, including the border pixel: `cba|abc|cba`.
    Mirror,
}

/// Kernels of odd length for N channels: along columns and along rows.
#[derive(Clone, Debug)]
pub(super) struct Separable<T, const N: usize> {
    pub along_columns: Vec<[T; N]>,
    pub along_rows: Vec<[T; N]>,
    pub border: Border,
}

impl Border {
    /// The pixel in `0..length` for any `index`.
    fn pixel(self, index: isize, length: usize) -> usize {
        let length = length as isize;
        let pixel = match self {
            Self::Clamp => index.clamp(0, length - 1),
            Self::Mirror => {
                let index = index.rem_euclid(2 * length);
                index.min(2 * length - 1 - index)
            }
        };
        pixel as usize
    }
}

impl<T, const N: usize> Separable<T, N>
where
    T: Copy + Default + AddAssign + Mul<Output = T>,
{
    /// Row `y` of the filtered `width` x `height` picture `source(x, y)`.
    pub(super) fn row(
        &self,
        y: usize,
        [width, height]: [usize; 2],
        source: impl Fn(usize, usize) -> [T; N],
    ) -> Vec<[T; N]> {
        let radius = self.along_rows.len() / 2;
        let mut column_sums = vec![[T::default(); N]; width + 2 * radius];
        let (sums, rows) = (&mut column_sums[radius..radius + width], self.along_columns.len() / 2);
        for (tap, weights) in self.along_columns.iter().enumerate() {
            let row = self.border.pixel((y + tap) as isize - rows as isize, height);
            for (x, sum) in sums.iter_mut().enumerate() {
                add_weighted(sum, &source(x, row), weights);
            }
        }
        for outside in 0..radius {
            let (left, right) = (outside as isize - radius as isize, (width + outside) as isize);
            column_sums[outside] = column_sums[radius + self.border.pixel(left, width)];
            column_sums[radius + width + outside] = column_sums[radius + self.border.pixel(right, width)];
        }
        let filtered = column_sums.windows(self.along_rows.len()).map(|window| {
            let mut sum = [T::default(); N];
            window
                .iter()
                .zip(&self.along_rows)
                .for_each(|(value, weights)| add_weighted(&mut sum, value, weights));
            sum
        });
        filtered.collect()
    }
}

fn add_weighted<T, const N: usize>(sum: &mut [T; N], values: &[T; N], weights: &[T; N])
where
    T: Copy + AddAssign + Mul<Output = T>,
{
    for lane in 0..N {
        sum[lane] += values[lane] * weights[lane];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn borders_are_extended() {
        let beyond = |border: Border| -> Vec<usize> { (-4..7).map(|i| border.pixel(i, 3)).collect() };
        assert_eq!(beyond(Border::Clamp), [0, 0, 0, 0, 0, 1, 2, 2, 2, 2, 2]);
        assert_eq!(beyond(Border::Mirror), [2, 2, 1, 0, 0, 1, 2, 2, 1, 0, 0]);
        assert_eq!((-3..4).map(|i| Border::Mirror.pixel(i, 1)).collect::<Vec<_>>(), [0; 7]);
    }

    /// Two kernels on two channels against the direct sum over the window.
    #[test]
    fn it_is_the_sum_over_the_window() {
        let size = [4, 3];
        let source = |x: usize, y: usize| [(x + 10 * y) as f64, (x * x) as f64 - y as f64];
        let filter = Separable {
            along_columns: vec![[1.0, 0.5], [2.0, 0.0], [-3.0, 0.25]],
            along_rows: vec![[0.5, 1.0], [1.0, -1.0], [4.0, 2.0]],
            border: Border::Clamp,
        };
        for y in 0..size[1] {
            let row = filter.row(y, size, source);
            assert_eq!(row.len(), size[0]);
            for (x, actual) in row.iter().enumerate() {
                let mut expected = [0.0; 2];
                for (i, j) in (0..9).map(|tap| (tap % 3, tap / 3)) {
                    let at =
                        |at: usize, tap: usize, length: usize| (at + tap).saturating_sub(1).min(length - 1);
                    let value = source(at(x, i, size[0]), at(y, j, size[1]));
                    for lane in 0..2 {
                        expected[lane] +=
                            value[lane] * filter.along_rows[i][lane] * filter.along_columns[j][lane];
                    }
                }
                assert_eq!(*actual, expected, "{x} {y}");
            }
        }
    }
}
