//! Polynomials and circular functions in lanes.

use super::number::Num;
use super::width::LaneWidth;

/// Value and slope of the polynomial Σ c_k s^k, its even and odd terms apart: four short chains instead of two long ones.
#[inline(always)]
pub fn horner<W: LaneWidth, const N: usize>(c: &[Num<W>; N], s: Num<W>) -> (Num<W>, Num<W>) {
    let z = s * s;
    let zero = s.of(0.0);
    // value = even + s odd; slope = odd + 2 s (even' + s odd'), the dashes by z.
    let (mut even, mut even1) = (c[(N - 1) & !1], zero);
    let (mut odd, mut odd1) = (c[((N - 2) & !1) + 1], zero);
    for k in (0..(N - 1) / 2).rev() {
        even1 = even1.mul_add(z, even);
        even = even.mul_add(z, c[2 * k]);
    }
    for k in (0..(N - 2) / 2).rev() {
        odd1 = odd1.mul_add(z, odd);
        odd = odd.mul_add(z, c[2 * k + 1]);
    }
    let slope = (s + s).mul_add(s.mul_add(odd1, even1), odd);
    (s.mul_add(odd, even), slope)
}

/// Value alone of the polynomial Σ c_k s^k.
#[inline(always)]
pub fn polynomial<W: LaneWidth, const N: usize>(c: &[Num<W>; N], s: Num<W>) -> Num<W> {
    let mut value = c[N - 1];
    for k in (0..N - 1).rev() {
        value = value.mul_add(s, c[k]);
    }
    value
}

/// Σ c_k x^k for constants known beforehand.
#[inline(always)]
pub fn series<W: LaneWidth, const N: usize>(c: [f64; N], x: Num<W>) -> Num<W> {
    let mut value = x.of(c[N - 1]);
    for k in (0..N - 1).rev() {
        value = value.mul_add(x, x.of(c[k]));
    }
    value
}

/// (sin a, cos a) for 0 ≤ a ≤ 9, by quarter turns and Taylor's series (|remainder| < 1e-11).
#[inline(always)]
pub fn sin_cos<W: LaneWidth>(a: Num<W>) -> (Num<W>, Num<W>) {
    use core::f64::consts::FRAC_PI_2;
    // A number whose last bit is 1/1: adding and taking it away rounds.
    let rounder = 1.5 / f64::EPSILON;
    let quarter = (a * (1.0 / FRAC_PI_2) + rounder) - rounder;
    let r = quarter.mul_sub_from(a.of(FRAC_PI_2), a);
    let z = r * r;
    let sin = r * series(SIN, z);
    let cos = series(COS, z);
    // Quarter 0 to 6: back to 0 to 3, then by its two bits.
    let four = a.of(3.5).lt(quarter);
    let quarter = quarter - four.choose(a.of(4.0), a.of(0.0));
    let upper = a.of(1.5).lt(quarter);
    let half = quarter - upper.choose(a.of(2.0), a.of(0.0));
    let odd = a.of(0.5).lt(half);
    let (s, c) = (odd.choose(cos, sin), odd.choose(-sin, cos));
    (upper.choose(-s, s), upper.choose(-c, c))
}

/// sin x = x Σ SIN_k x^2k.
pub const SIN: [f64; 7] = [
    1.0,
    -1.0 / 6.0,
    1.0 / 120.0,
    -1.0 / 5_040.0,
    1.0 / 362_880.0,
    -1.0 / 39_916_800.0,
    1.0 / 6_227_020_800.0,
];

/// cos x = Σ COS_k x^2k.
pub const COS: [f64; 7] = [
    1.0,
    -0.5,
    1.0 / 24.0,
    -1.0 / 720.0,
    1.0 / 40_320.0,
    -1.0 / 3_628_800.0,
    1.0 / 479_001_600.0,
];
