//! Sine and versine (1 − cos) for small angles, without range reduction.
//!
//! The pendulum swings through a few degrees and the drive is rotated by a fraction of a degree per
//! tick, so the Taylor polynomials are used as they stand, cut where the next term no longer matters.
//! For |x| ≤ 1 rad, measured against `f64` over a dense grid (see the tests, which enforce it):
//!
//! | function | terms to | error in units in the last place |
//! |---|---|---|
//! | `sin`, f32 | x¹¹ | ≤ 1.0 |
//! | `versin`, f32 | x¹² | ≤ 2.0 |
//! | `sin`, `versin`, f64 | x²¹, x²² (x¹¹, x¹² up to 0.25 rad) | relative error ≤ 7e-16 |
//!
//! Beyond 1 rad (no hammer that works gets there) `f32` takes quarters of a turn off first, and `f64` has libm answer.

/// Largest |angle| the polynomials are used for, rad.
pub const SMALL_ANGLE_RAD: f64 = 1.0;

/// `(sin x, 1 − cos x)` in `f32`.
#[inline]
pub fn sin_versin_f32(x: f32) -> (f32, f32) {
    if x.abs() > SMALL_ANGLE_RAD as f32 {
        let (sin, cos) = sin_cos_f32(x);
        return (sin, 1.0 - cos);
    }
    small(x)
}

#[inline]
fn small(x: f32) -> (f32, f32) {
    let x2 = x * x;
    let sin = 1.0 / 362_880.0 - x2 * (1.0 / 39_916_800.0);
    let sin = -1.0 / 5_040.0 + x2 * sin;
    let sin = 1.0 / 120.0 + x2 * sin;
    let sin = -1.0 / 6.0 + x2 * sin;
    let versin = 1.0 / 3_628_800.0 - x2 * (1.0 / 479_001_600.0);
    let versin = -1.0 / 40_320.0 + x2 * versin;
    let versin = 1.0 / 720.0 + x2 * versin;
    let versin = -1.0 / 24.0 + x2 * versin;
    (x + x * (x2 * sin), x2 * (0.5 + x2 * versin))
}

/// `(sin x, cos x)` in `f32`, for |x| up to 100 rad within 1.2e-7: without the products in `f64` of which libm's are made, each some
/// hundred cycles where the processor has none.
pub fn sin_cos_f32(x: f32) -> (f32, f32) {
    use core::f32::consts::{FRAC_2_PI, FRAC_PI_2};
    /// π/2 in two parts: its first bits, so that a product with a count of quarters is exact, and the rest.
    const FIRST: f32 = 1.570_312_5;
    const REST: f32 = (core::f64::consts::FRAC_PI_2 - FIRST as f64) as f32;
    const { assert!(FIRST + REST == FRAC_PI_2) };
    let quarters = libm::rintf(x * FRAC_2_PI);
    let (sin, versin) = small((x - quarters * FIRST) - quarters * REST);
    let cos = 1.0 - versin;
    match quarters as i32 & 3 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

/// `(sin x, 1 − cos x)` in `f64`.
#[inline]
pub fn sin_versin_f64(x: f64) -> (f64, f64) {
    let size = x.abs();
    if size > SMALL_ANGLE_RAD {
        let half = libm::sin(0.5 * x);
        return (libm::sin(x), 2.0 * half * half);
    }
    let x2 = x * x;
    let (sin, versin) = if size > FEW_TERMS_RAD {
        (tail::<9>(x2, 2), tail::<9>(x2, 3))
    } else {
        (tail::<4>(x2, 2), tail::<4>(x2, 3))
    };
    (x - x * (x2 * sin), x2 * (0.5 - x2 * versin))
}

/// Largest |angle| for which the first half of the f64 polynomials' terms is enough, rad.
const FEW_TERMS_RAD: f64 = 0.25;

/// 1/(k+1)! − x²/(k+3)! + x⁴/(k+5)! − …, to the term with x²ᴺ: what comes after the first term of sin x (k = 2) and the
/// first of 1 − cos x (k = 3), signs apart.
#[inline]
fn tail<const N: usize>(x2: f64, k: usize) -> f64 {
    // Even and odd powers of x² apart: two short chains of operations instead of a long one.
    let x4 = x2 * x2;
    let mut sums = [0.0, 0.0];
    for n in (0..=N).rev() {
        let sum = &mut sums[n % 2];
        *sum = *sum * x4 + RECIPROCAL_FACTORIAL[k + 1 + 2 * n];
    }
    sums[0] - x2 * sums[1]
}

/// `RECIPROCAL_FACTORIAL[k] = 1 / k!`.
const RECIPROCAL_FACTORIAL: [f64; 24] = {
    let mut table = [1.0; 24];
    let mut k = 1;
    while k < 24 {
        table[k] = table[k - 1] / k as f64;
        k += 1;
    }
    table
};

#[cfg(test)]
mod tests {
    use super::*;

    /// Distance of `got` from `want` in units in the last place of `want` as `f32`.
    fn ulps(got: f32, want: f64) -> f64 {
        let scale = (want as f32).abs().max(f32::MIN_POSITIVE);
        let ulp = f32::from_bits(scale.to_bits() + 1) - scale;
        (f64::from(got) - want).abs() / f64::from(ulp)
    }

    #[test]
    fn f32_is_within_its_stated_bounds_up_to_one_radian() {
        let (mut worst_sin, mut worst_versin) = (0.0_f64, 0.0_f64);
        for i in 1..=400_000 {
            let x = i as f32 * 2.5e-6;
            for x in [x, -x] {
                let (sin, versin) = sin_versin_f32(x);
                let exact = f64::from(x);
                worst_sin = worst_sin.max(ulps(sin, exact.sin()));
                worst_versin = worst_versin.max(ulps(versin, 2.0 * (0.5 * exact).sin().powi(2)));
            }
        }
        assert!(worst_sin <= 1.0, "sin: {worst_sin} ulp");
        assert!(worst_versin <= 2.0, "versin: {worst_versin} ulp");
    }

    #[test]
    fn large_angles_in_f32_are_within_the_stated_bound() {
        let mut worst = 0.0_f64;
        for i in -200_000..=200_000 {
            let x = i as f32 * 5e-4;
            let (sin, cos) = sin_cos_f32(x);
            let (want_sin, want_cos) = f64::from(x).sin_cos();
            let off = (f64::from(sin) - want_sin).abs();
            worst = worst.max(off).max((f64::from(cos) - want_cos).abs());
        }
        assert!(worst <= 1.2e-7, "{worst}");
        assert!(sin_cos_f32(f32::INFINITY).0.is_nan());
    }

    #[test]
    fn f64_agrees_with_the_standard_library() {
        for i in -3_000..=3_000 {
            let x = f64::from(i) * 1e-3;
            let (sin, versin) = sin_versin_f64(x);
            let want = 2.0 * (0.5 * x).sin().powi(2);
            assert!((sin - x.sin()).abs() <= 7e-16 * x.sin().abs(), "sin {x}");
            assert!((versin - want).abs() <= 7e-16 * want, "versin {x}");
        }
    }

    #[test]
    fn beyond_the_polynomials_f32_still_answers() {
        for x in [-3.0_f32, -1.1, 1.1, 2.0, 3.1] {
            let (sin, versin) = sin_versin_f32(x);
            assert!((sin - x.sin()).abs() < 2e-7);
            assert!((versin - (1.0 - x.cos())).abs() < 2e-7);
        }
    }
}
