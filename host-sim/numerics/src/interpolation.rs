//! Between places at which something is known.

/// Of what is `known`, by rising place, the nearest `count` on either side of `x`; fewer at an end.
pub fn around<T>(known: &[T], x: f64, count: usize, place: impl Fn(&T) -> f64) -> &[T] {
    let above = known.partition_point(|k| place(k) < x);
    &known[above.saturating_sub(count)..(above + count).min(known.len())]
}

/// The numbers at `x` on the polynomial through those `known` at other places. Of two at one place the first counts.
pub fn polynomial<const N: usize>(known: &[(f64, [f64; N])], x: f64) -> [f64; N] {
    let mut sum = [0.0; N];
    for (i, (own, values)) in known.iter().enumerate() {
        if known[..i].iter().any(|(place, _)| place == own) {
            continue;
        }
        let others = known.iter().map(|(place, _)| place);
        let others = others.filter(|place| *place != own);
        let weight: f64 = others.map(|place| (x - place) / (own - place)).product();
        for (sum, value) in sum.iter_mut().zip(values) {
            *sum += weight * value;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_is_met_between_the_two_on_either_side_and_at_an_end() {
        let cubic = |x: f64| [x * x * x - 2.0 * x, 1.0 - x];
        let known: Vec<_> = [0.0, 1.0, 1.5, 3.0, 4.0, 4.25]
            .map(|x| (x, cubic(x)))
            .into();
        for (x, few) in [(2.0, 4), (3.0, 4), (0.5, 3), (4.1, 3)] {
            let near = around(&known, x, 2, |k| k.0);
            assert_eq!(near.len(), few);
            let found = polynomial(near, x);
            if few == 4 {
                assert!((found[0] - cubic(x)[0]).abs() < 1e-12, "{x}: {found:?}");
            }
            assert!((found[1] - cubic(x)[1]).abs() < 1e-12, "{x}: {found:?}");
        }
    }
}
