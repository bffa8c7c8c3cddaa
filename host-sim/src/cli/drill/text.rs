//! What `drill` says on a terminal.

use super::DrillReport;
use numerics::CartModel;
use numerics::drill::{Corner, DrillAnswer, DrillRow};
use plot::chart::Chart;

pub fn text(answer: &DrillReport) -> String {
    let advice = &answer.advice;
    let best = &advice.best;
    let faster = faster(answer);
    let mut text = format!(
        "{}, gap {:?} mm, {}, ground that gives way at {:?} N: drills fastest{} on {} at {:.4} Hz ({:.3} times the natural frequency{})\n{}\n",
        answer.rig,
        best.gap_mm,
        advice.cart.words(),
        answer.threshold_n,
        if faster.is_empty() { " of all" } else { "" },
        best.regime,
        best.frequency_hz,
        best.frequency_ratio,
        at_the_end(answer, best),
        faster
    );
    let mut line = |name: &str, value: String| text += &format!("  {name:<22} {value}\n");
    line(
        "rate of penetration",
        format!("{:.1} µm/s", best.rate_of_penetration_um_per_s),
    );
    if let Some(blow) = best.progress_per_blow_um {
        let cycle = best.progress_per_cycle_um;
        line(
            "progress",
            format!("{blow:.2} µm per blow, {cycle:.2} µm per cycle"),
        );
    }
    line(
        "feed",
        format!(
            "{:.4} mm/s keeps the gap{}",
            best.feed_needed_mm_per_s,
            match answer.feed.as_str() {
                "cart" | "ground" | "steady" => String::new(),
                speed => format!(
                    "; at the feed of {speed}, the mean gap is {:.3} mm",
                    best.mean_clearance_mm
                ),
            }
        ),
    );
    let stable = advice
        .multiplier
        .map_or(String::new(), |m| format!(", largest multiplier {m:.3}"));
    line("regime", format!("{}{stable}", best.regime));
    if let (Some(energy), Some(share)) = (best.energy_per_blow_mj, best.share_into_progress) {
        let percent = 100.0 * share;
        line(
            "energy per blow",
            format!("{energy:.3} mJ, {percent:.0} % of it goes into progress"),
        );
    }
    line("peak force", force(advice, answer.threshold_n));
    line("surface that stays", rigid(advice));
    line("cart", cart(answer));
    if let Some(bit) = bit(answer) {
        line("bit", bit);
    }
    text += &corners(&advice.corners, answer);
    if answer.gaps.len() > 1 {
        text += &gaps(answer);
    }
    text += "\n";
    text + &chart(answer)
}

/// First and last Ω/ω of the range.
fn range(answer: &DrillReport) -> (f64, f64) {
    let ratio = |row: Option<&DrillRow>| row.map_or(f64::NAN, |r| r.frequency_ratio);
    (ratio(answer.rows.first()), ratio(answer.rows.last()))
}

/// Nearer to an end of the range than this (in Ω/ω) is at it: the search between the frequencies stops this short of it.
const AT_THE_END: f64 = 5e-4;

/// That a best frequency is at an end of the range, where it is: beyond, more may be had.
fn at_the_end(answer: &DrillReport, row: &DrillRow) -> &'static str {
    let (first, last) = range(answer);
    let near = |end: f64| (row.frequency_ratio - end).abs() < AT_THE_END;
    if first < last && (near(first) || near(last)) {
        ", the end of the range"
    } else {
        ""
    }
}

/// That a frequency (in Ω/ω) is outside the range, where it is.
fn outside(answer: &DrillReport, ratio: f64) -> &'static str {
    let (first, last) = range(answer);
    if ratio < first - AT_THE_END || ratio > last + AT_THE_END {
        ", outside the range"
    } else {
        ""
    }
}

/// That a frequency (in Hz) is outside the range, where it is.
fn outside_hz(answer: &DrillReport, hz: f64) -> &'static str {
    let best = &answer.advice.best;
    outside(answer, hz * best.frequency_ratio / best.frequency_hz)
}

/// The line of the motion that drills fastest of all; empty if that is the one recommended.
fn faster(answer: &DrillReport) -> String {
    let (best, fastest) = (&answer.advice.best, &answer.fastest_of_all);
    if fastest == best {
        return String::new();
    }
    // The cart's peak force (M + m) A0 Ω², at the same amplitude.
    let force = (fastest.frequency_hz / best.frequency_hz).powi(2);
    format!(
        "fastest of all: {} at {:.4} Hz (Ω/ω {:.3}){}, gap {:?} mm: {:.1} µm/s instead of {:.1}; the shaker must move the cart with {force:.1} times the force\n",
        fastest.regime,
        fastest.frequency_hz,
        fastest.frequency_ratio,
        at_the_end(answer, fastest),
        fastest.gap_mm,
        fastest.rate_of_penetration_um_per_s,
        best.rate_of_penetration_um_per_s
    )
}

fn force(advice: &DrillAnswer, threshold_n: f64) -> String {
    match advice.threshold_reached_ratios {
        Some((low, high)) => format!(
            "{:.1} N: it cannot exceed {threshold_n:?} N, which it reaches from Ω/ω {low:.3} to {high:.3}, so it does not rank frequencies",
            advice.best.ground_force_n
        ),
        None => format!("{:.1} N", advice.best.ground_force_n),
    }
}

fn rigid(advice: &DrillAnswer) -> String {
    let found = (
        advice.rigid_frequency_hz,
        advice.rigid_frequency_ratio,
        advice.rigid_force_n,
        advice.rigid_share,
    );
    let (Some(hz), Some(ratio), Some(force), Some(share)) = found else {
        return "has no stable 1/1 at this gap to compare with".to_owned();
    };
    let apart = 100.0 * (hz / advice.best.frequency_hz - 1.0);
    format!(
        "it would have its largest force ({force:.1} N) at {hz:.4} Hz (Ω/ω {ratio:.3}), {:.1} % {}; there the rate is {:.1} % of that here",
        apart.abs(),
        if apart >= 0.0 { "higher" } else { "lower" },
        100.0 * share
    )
}

/// How the cart is moved, and what the other would drill.
fn cart(answer: &DrillReport) -> String {
    let advice = &answer.advice;
    let (own, other, what, value) = match advice.cart {
        CartModel::Recoil => (
            "recoils",
            "with a prescribed cart",
            advice.prescribed_frequency_hz,
            advice.prescribed_rate_um_per_s,
        ),
        CartModel::Prescribed => (
            "moves as prescribed",
            "with a recoiling cart",
            advice.recoil_frequency_hz,
            advice.recoil_rate_um_per_s,
        ),
    };
    let (Some(hz), Some(rate)) = (what, value) else {
        return format!("{own}; its recoil is not known (shaker_loop_hz in the rig's file)");
    };
    let more = 100.0 * (rate / advice.best.rate_of_penetration_um_per_s - 1.0);
    format!(
        "{own}; {other}, {rate:.1} µm/s at {hz:.4} Hz{} ({more:+.0} %)",
        outside_hz(answer, hz)
    )
}

/// What the bit takes, and what would be drilled without it.
fn bit(answer: &DrillReport) -> Option<String> {
    let advice = &answer.advice;
    let best = &advice.best;
    let (mass, feed) = (best.bit_mass_kg?, best.bit_feed_force_n?);
    let into = best.ground_energy_per_blow_mj.map_or(String::new(), |mj| {
        format!("; {mj:.3} mJ with each blow into the ground")
    });
    let without = advice
        .without_bit_rate_um_per_s
        .zip(advice.without_bit_frequency_hz);
    let without = without.map_or(String::new(), |(rate, hz)| {
        let more = 100.0 * (rate / best.rate_of_penetration_um_per_s - 1.0);
        let outside = outside_hz(answer, hz);
        format!("; without it, {rate:.1} µm/s at {hz:.4} Hz{outside} ({more:+.0} %)")
    });
    Some(format!(
        "{mass:?} kg, pressed on the ground with {feed:.2} N, struck with at most {:.1} N{into}{without}",
        best.force_n
    ))
}

fn corners(corners: &[Corner], answer: &DrillReport) -> String {
    let over = |value: fn(&Corner) -> f64| {
        let values = corners.iter().map(value);
        let low = values.clone().fold(f64::INFINITY, f64::min);
        (low, values.fold(f64::NEG_INFINITY, f64::max))
    };
    if corners.is_empty() {
        return String::new();
    }
    let (low, high) = over(|c| c.rate_at_nominal_um_per_s);
    let (from, to) = over(|c| c.best_frequency_ratio);
    let outside = match (outside(answer, from), outside(answer, to)) {
        ("", "") => "",
        _ => " (partly or wholly outside the range)",
    };
    let share =
        |c: &Corner| c.rate_at_nominal_um_per_s / c.best_rate_um_per_s.max(f64::MIN_POSITIVE);
    let least = corners
        .iter()
        .filter(|c| c.best_rate_um_per_s > 0.0)
        .map(share);
    let least = least.fold(1.0, f64::min);
    let still = corners
        .iter()
        .all(|c| c.regime_at_nominal == answer.advice.best.regime);
    format!(
        "  {:<22} threshold ±{:?} %, stiffness ±{:?} %: {low:.1} to {high:.1} µm/s at this frequency, {}; the best frequencies of these corners are at Ω/ω {from:.3} to {to:.3}{}, and this frequency has at least {:.1} % of their rates\n",
        "uncertainty",
        answer.uncertainty.threshold_percent,
        answer.uncertainty.ground_stiffness_percent,
        if still {
            "the same regime"
        } else {
            "not always the same regime"
        },
        outside,
        100.0 * least
    )
}

fn gaps(answer: &DrillReport) -> String {
    let mut text =
        "\n  gap, mm    Hz        Ω/ω     µm/s     of the best   µm per cycle   regime      any motion\n"
            .to_owned();
    let largest = answer.advice.best.rate_of_penetration_um_per_s;
    for (row, any) in answer.gaps.iter().zip(&answer.gaps_any_regime) {
        let rate = row.rate_of_penetration_um_per_s;
        if rate > 0.0 {
            text += &format!(
                "  {:>7.2}   {:>7.4}   {:.3} {:>8.1} {:>11.1} % {:>13.2}   {:<9}   {:.1} µm/s at Ω/ω {:.3}, {}\n",
                row.gap_mm,
                row.frequency_hz,
                row.frequency_ratio,
                rate,
                100.0 * rate / largest,
                row.progress_per_cycle_um,
                row.regime,
                any.rate_of_penetration_um_per_s,
                any.frequency_ratio,
                any.regime
            );
        } else {
            text += &format!(
                "  {:>7.2}   the ground holds at every frequency of the range\n",
                row.gap_mm
            );
        }
    }
    text + "\n"
}

fn chart(answer: &DrillReport) -> String {
    let gap = answer.advice.gap_mm;
    let rows = answer.rows.iter().filter(|r| r.gap_mm == gap);
    let points = rows.map(|r| (r.frequency_ratio, r.rate_of_penetration_um_per_s));
    Chart::new("Ω/ω", "rate of penetration, µm/s")
        .series(format!("{gap:?} mm"), points.collect())
        .render()
}
