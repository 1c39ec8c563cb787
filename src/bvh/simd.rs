//! SIMD over eight floats.
//!
//! The portable implementation uses two `Vec4`, which compile to SSE2, NEON or scalars; the other needs AVX2 and FMA,
//! detected at run time. They round differently, so they serve conservative box tests only.

use glam::Vec4;

/// Eight floats in memory.
pub(super) type Eight = [f32; 8];

/// An instruction set for eight floats.
pub(super) trait Simd: Copy {
    /// Eight floats in registers.
    type Floats: Copy;
    fn splat(self, value: f32) -> Self::Floats;
    fn load(self, values: &Eight) -> Self::Floats;
    fn store(self, values: Self::Floats) -> Eight;
    /// `a * b + c`, fused or not.
    fn mul_add(self, a: Self::Floats, b: Self::Floats, c: Self::Floats) -> Self::Floats;
    fn max(self, a: Self::Floats, b: Self::Floats) -> Self::Floats;
    fn min(self, a: Self::Floats, b: Self::Floats) -> Self::Floats;
    /// Bit mask of the lanes where `a <= b`.
    fn le(self, a: Self::Floats, b: Self::Floats) -> u32;
}

/// For any processor.
#[derive(Clone, Copy, Debug)]
pub(super) struct Portable;

impl Simd for Portable {
    type Floats = [Vec4; 2];

    #[inline(always)]
    fn splat(self, value: f32) -> Self::Floats {
        [Vec4::splat(value); 2]
    }

    #[inline(always)]
    fn load(self, values: &Eight) -> Self::Floats {
        [Vec4::from_slice(&values[..4]), Vec4::from_slice(&values[4..])]
    }

    #[inline(always)]
    fn store(self, [low, high]: Self::Floats) -> Eight {
        let mut values = [0.0; 8];
        low.write_to_slice(&mut values[..4]);
        high.write_to_slice(&mut values[4..]);
        values
    }

    #[inline(always)]
    fn mul_add(self, a: Self::Floats, b: Self::Floats, c: Self::Floats) -> Self::Floats {
        [a[0] * b[0] + c[0], a[1] * b[1] + c[1]]
    }

    #[inline(always)]
    fn max(self, a: Self::Floats, b: Self::Floats) -> Self::Floats {
        [a[0].max(b[0]), a[1].max(b[1])]
    }

    #[inline(always)]
    fn min(self, a: Self::Floats, b: Self::Floats) -> Self::Floats {
        [a[0].min(b[0]), a[1].min(b[1])]
    }

    #[inline(always)]
    fn le(self, a: Self::Floats, b: Self::Floats) -> u32 {
        a[0].cmple(b[0]).bitmask() | a[1].cmple(b[1]).bitmask() << 4
    }
}

/// AVX2 and FMA.
#[cfg(target_arch = "x86_64")]
pub(super) type Avx2 = pulp::x86::V3;

#[cfg(target_arch = "x86_64")]
impl Simd for Avx2 {
    type Floats = std::arch::x86_64::__m256;

    #[inline(always)]
    fn splat(self, value: f32) -> Self::Floats {
        self.avx._mm256_set1_ps(value)
    }

    #[inline(always)]
    fn load(self, values: &Eight) -> Self::Floats {
        bytemuck::cast(*values)
    }

    #[inline(always)]
    fn store(self, values: Self::Floats) -> Eight {
        bytemuck::cast(values)
    }

    #[inline(always)]
    fn mul_add(self, a: Self::Floats, b: Self::Floats, c: Self::Floats) -> Self::Floats {
        self.fma._mm256_fmadd_ps(a, b, c)
    }

    #[inline(always)]
    fn max(self, a: Self::Floats, b: Self::Floats) -> Self::Floats {
        self.avx._mm256_max_ps(a, b)
    }

    #[inline(always)]
    fn min(self, a: Self::Floats, b: Self::Floats) -> Self::Floats {
        self.avx._mm256_min_ps(a, b)
    }

    #[inline(always)]
    fn le(self, a: Self::Floats, b: Self::Floats) -> u32 {
        let mask = self.avx._mm256_cmp_ps::<{ std::arch::x86_64::_CMP_LE_OQ }>(a, b);
        self.avx._mm256_movemask_ps(mask) as u32
    }
}
