//! `pick --objective rop`: the frequency of the largest rate of penetration on ground that gives way.

use serde::Serialize;

use super::text::{decides, jumps, stable};
use super::write;
use crate::cli::arguments::output::OutputArgs;
use crate::pictures::rop::figure;
use crate::progress::ProgressLine;
use files::UserError;
use files::table::Selection;
use files::words::digits::{decimals, significant};
use numerics::CartModel;
use numerics::NamedRig;
use numerics::drill::pick::{DrillPickRequest, RopPick, pick_rop};
use plot::chart::Chart;

/// Finds the frequency of the largest rate of penetration, and answers with it.
pub fn run(
    rig: &NamedRig,
    request: &DrillPickRequest,
    output: &OutputArgs,
) -> Result<(), UserError> {
    let progress = ProgressLine::new("rigs and runs", request.steps(), output.quiet);
    let pick = pick_rop(rig, request, &progress)?;
    progress.finish();
    let value = Worded {
        answer: &pick.answer,
        ground: &pick.ground,
        why: why(&pick),
    };
    let point = |(hz, rate): &(f64, f64)| CurveRow {
        rig: &pick.answer.rig,
        gap_mm: pick.answer.gap_mm,
        threshold_n: pick.ground.threshold_n,
        frequency_hz: *hz,
        rate_of_penetration_um_per_s: *rate,
    };
    let curve: Vec<_> = pick.curve.iter().map(point).collect();
    write(output, &figure(&pick), &value, &curve)?;
    output.emit(&value, &[Selection::of(&value, COLUMNS)], || text(&pick))
}

/// The answer with its sentence, as JSON has it.
#[derive(Serialize)]
struct Worded<'a> {
    #[serde(flatten)]
    answer: &'a numerics::pick::PickAnswer,
    #[serde(flatten)]
    ground: &'a numerics::drill::pick::answer::OnGround,
    why: String,
}

/// The columns of the answer as a line of a table. What every pick has, has the name that it has there.
const COLUMNS: &[&str] = &[
    "rig",
    "gap_mm",
    "objective",
    "threshold_n",
    "ground_stiffness_n_per_m",
    "ground_damping_n_s_per_m",
    "operating_frequency_hz",
    "frequency_ratio",
    "rate_of_penetration_um_per_s",
    "rate_worst_um_per_s",
    "rate_largest_um_per_s",
    "progress_per_blow_um",
    "energy_per_blow_mj",
    "share_into_progress",
    "feed_needed_mm_per_s",
    "force_ratio",
    "force_n",
    "band_low_hz",
    "band_high_hz",
    "safe_band_low_hz",
    "safe_band_high_hz",
    "period_doubling_hz",
    "multipliers",
    "jump_free",
    "cart",
    "force_optimum_hz",
    "force_optimum_rate_um_per_s",
    "recoil_frequency_hz",
    "recoil_rate_um_per_s",
    "prescribed_frequency_hz",
    "prescribed_rate_um_per_s",
    "amplitude_mm",
    "loop_force_n",
    "bit_mass_kg",
    "bit_feed_force_n",
];

/// A point of the nominal stable 1/1.
#[derive(Serialize)]
struct CurveRow<'a> {
    rig: &'a str,
    gap_mm: f64,
    threshold_n: f64,
    frequency_hz: f64,
    rate_of_penetration_um_per_s: f64,
}

/// Frequencies are found to a hundred-thousandth of the natural one; with an uncertainty, a person needs two decimals.
fn hz(pick: &RopPick, value: f64) -> String {
    let decimals = if pick.answer.uncertainty.is_some() {
        2
    } else {
        4
    };
    format!("{value:.decimals$}")
}

/// A rate, to the digit in which the uncertainty begins.
fn rate(pick: &RopPick, value: f64) -> String {
    let g = &pick.ground;
    let half = 0.5 * (g.rate_largest_um_per_s - g.rate_worst_um_per_s);
    format!("{value:.*}", decimals(half, 2).max(1))
}

/// Why this frequency, in one sentence.
pub fn why(pick: &RopPick) -> String {
    let (a, g) = (&pick.answer, &pick.ground);
    let binding: Vec<_> = a
        .limits
        .iter()
        .filter(|l| l.binds)
        .map(|l| l.name)
        .collect();
    let first = if binding.is_empty() {
        let over = if a.uncertainty.is_some() {
            ", and 1/1 stays stable over the whole uncertainty"
        } else {
            " of the nominal rig"
        };
        format!("No stable 1/1 drills faster{over}")
    } else {
        format!(
            "No stable 1/1 that {} allows drills faster ({} µm/s at {} Hz for the nominal rig without any limit)",
            binding.join(" and "),
            rate(pick, g.nominal_optimum_rate_um_per_s),
            hz(pick, a.nominal_optimum_hz)
        )
    };
    format!(
        "{first}: {} µm/s, {:.2} µm with each blow.",
        rate(pick, g.rate_of_penetration_um_per_s),
        g.progress_per_blow_um
    )
}

fn text(pick: &RopPick) -> String {
    let (a, g) = (&pick.answer, &pick.ground);
    let mut text = format!(
        "{}, gap {:?} mm, {}, ground that gives way at {:?} N: run it at {} Hz ({:.2} times the natural frequency)\n{}\n\n",
        a.rig,
        a.gap_mm,
        a.cart.words(),
        g.threshold_n,
        hz(pick, a.operating_frequency_hz),
        a.frequency_ratio,
        why(pick)
    );
    for (name, what) in lines(pick) {
        text += &format!("  {name:<20} {what}\n");
    }
    text += &sensitivity(pick);
    let points = pick.curve.iter();
    let natural_hz = a.operating_frequency_hz / a.frequency_ratio;
    let points = points.map(|(hz, rate)| (hz / natural_hz, *rate));
    let chart = Chart::new("Ω/ω", "rate of penetration, µm/s, stable 1/1");
    text + "\n" + &chart.series(a.rig.clone(), points.collect()).render()
}

fn lines(pick: &RopPick) -> Vec<(&'static str, String)> {
    let (a, g) = (&pick.answer, &pick.ground);
    let over = if a.uncertainty.is_some() {
        format!(
            "; {} to {} over the uncertainty of rig and ground",
            rate(pick, g.rate_worst_um_per_s),
            rate(pick, g.rate_largest_um_per_s)
        )
    } else {
        String::new()
    };
    let own = rate(pick, g.rate_of_penetration_um_per_s);
    let between = |from, to| format!("{} to {} Hz", hz(pick, from), hz(pick, to));
    let mut lines = vec![
        ("rate of penetration", format!("{own} µm/s{over}")),
        (
            "blow",
            format!(
                "{:.3} mJ, {:.0} % of it goes into {:.2} µm of progress",
                g.energy_per_blow_mj,
                100.0 * g.share_into_progress,
                g.progress_per_blow_um
            ),
        ),
        (
            "feed",
            format!("{:.4} mm/s keeps the gap", g.feed_needed_mm_per_s),
        ),
        ("regime", regime(pick)),
        (
            "force",
            format!("{:.1} N, {:.1} times the weight", a.force_n, a.force_ratio),
        ),
        ("safe band", safe_band(pick)),
        ("stable 1/1", stable(a, |at| hz(pick, at))),
        ("jumps", jumps(a, "drill the same", between)),
        ("surface that stays", force_optimum(pick)),
        ("cart", cart(pick)),
    ];
    if let Some((mass, feed)) = g.bit_mass_kg.zip(g.bit_feed_force_n) {
        lines.push((
            "bit",
            format!("{mass:?} kg between hammer and ground, pressed on with {feed:.2} N"),
        ));
    }
    if a.bending.on_beams {
        lines.push((
            "bending modes",
            "one: the effect of the springs' higher modes has not been computed on ground that gives way".to_owned(),
        ));
    }
    lines.push(("shaker", shaker(pick)));
    let limits: Vec<_> = a.limits.iter().filter(|l| l.limit.is_some()).collect();
    for limit in limits {
        let what = format!(
            "{} ({})",
            limit.limit.map_or(String::new(), |x| significant(x, 4)),
            if limit.binds {
                decides(limit, &a.limits)
            } else {
                "does not decide".to_owned()
            }
        );
        lines.push((limit.name, what));
    }
    lines
}

fn regime(pick: &RopPick) -> String {
    let a = &pick.answer;
    let reached = if a.regime_from_rest != a.regime {
        format!(
            "; from rest it ends in {}: it needs a push",
            a.regime_from_rest
        )
    } else if a.corners > a.corners_reaching_one_one_from_rest {
        format!(
            "; from rest {} of {} corners of the uncertainty reach 1/1 by themselves",
            a.corners_reaching_one_one_from_rest, a.corners
        )
    } else {
        ", also from rest".to_owned()
    };
    let worst = if a.uncertainty.is_some() {
        format!(
            " ({:.2} at worst over the uncertainty)",
            a.multipliers_worst
        )
    } else {
        String::new()
    };
    format!(
        "{}{reached}; largest multiplier {:.2}{worst}",
        a.regime, a.multipliers
    )
}

fn safe_band(pick: &RopPick) -> String {
    let (a, g) = (&pick.answer, &pick.ground);
    let [low, high] = a.safe_band_hz;
    let (over, ends) = match (a.uncertainty, g.safe_band_rate_worst_um_per_s) {
        (Some(_), [Some(low), Some(high)]) => (
            " over the uncertainty",
            format!(
                " (at worst {} µm/s at the lower end, {} at the upper)",
                rate(pick, low),
                rate(pick, high)
            ),
        ),
        _ => ("", String::new()),
    };
    // Rounded inwards.
    let inwards = if a.uncertainty.is_some() { 1e2 } else { 1e4 };
    let (up, down) = (
        (low * inwards - 1e-6).ceil() / inwards,
        (high * inwards + 1e-6).floor() / inwards,
    );
    let (low, high) = if up < down { (up, down) } else { (low, high) };
    format!(
        "{} to {} Hz: 1/1 stable{over}, nominal rate above 90 %{ends}",
        hz(pick, low),
        hz(pick, high)
    )
}

fn force_optimum(pick: &RopPick) -> String {
    let g = &pick.ground;
    let Some(at) = g.force_optimum_hz else {
        return "has no stable 1/1 at this gap to compare with".to_owned();
    };
    let apart = 100.0 * (at / pick.answer.operating_frequency_hz - 1.0);
    let there = g.force_optimum_rate_um_per_s.map_or_else(
        || "there is no stable 1/1 on this ground".to_owned(),
        |there| {
            let share = 100.0 * there / g.rate_of_penetration_um_per_s;
            format!("there the rate is {share:.1} % of that here")
        },
    );
    format!(
        "would have its largest force at {} Hz, {:.1} % {}; {there}",
        hz(pick, at),
        apart.abs(),
        if apart >= 0.0 { "higher" } else { "lower" }
    )
}

fn cart(pick: &RopPick) -> String {
    let (a, g) = (&pick.answer, &pick.ground);
    let recoil = (a.recoil_frequency_hz, g.recoil_rate_um_per_s);
    let prescribed = (a.prescribed_frequency_hz, g.prescribed_rate_um_per_s);
    let (moves, otherwise, (_, own), (at, value)) = match a.cart {
        CartModel::Recoil => ("recoils", "with a prescribed cart", recoil, prescribed),
        CartModel::Prescribed => (
            "moves as prescribed",
            "with a recoiling cart",
            prescribed,
            recoil,
        ),
    };
    let (Some(own), Some(at), Some(value)) = (own, at, value) else {
        return format!("{moves}; the other kind of cart was not computed");
    };
    let more = 100.0 * (value / own - 1.0);
    let against = match own > g.rate_of_penetration_um_per_s * (1.0 + 1e-6) {
        true => format!(
            " against {} of this cart, both nominal and without a limit of the shaker",
            rate(pick, own)
        ),
        false => String::new(),
    };
    format!(
        "{moves}; {otherwise}, {} µm/s at {} Hz ({more:+.0} %{against})",
        rate(pick, value),
        hz(pick, at)
    )
}

fn shaker(pick: &RopPick) -> String {
    let s = &pick.answer.shaker;
    let held = s.loop_force_n.map_or(String::new(), |n| {
        format!(", its loop at most {} N with the recoil", significant(n, 3))
    });
    let lowered = if pick.answer.amplitude_lowered {
        format!(
            " (the amplitude is lowered to {:.3} mm: at the rig's amplitude no frequency keeps the shaker's limits)",
            pick.answer.amplitude_mm
        )
    } else {
        String::new()
    };
    format!(
        "{:.2} mm peak to peak{lowered}, {} N to move cart and hammer{held}, {} W",
        s.stroke_mm,
        significant(s.force_n, 3),
        significant(s.mean_power_w, 2)
    )
}

/// What to measure first.
fn sensitivity(pick: &RopPick) -> String {
    let mut text =
        "\n  parameter                 per        rate, % uncertainty   of the rate, %\n"
            .to_owned();
    for row in &pick.ground.rate_sensitivity {
        let name = row.parameter.split(" (").next().unwrap_or_default();
        let known = row.known_to.map_or("-".to_owned(), |x| format!("±{x:.0}"));
        let open = row.rate_over_uncertainty_percent;
        let open = open.map_or("-".to_owned(), |x| format!("±{x:.0}"));
        text += &format!(
            "  {name:<25} {:<8} {:>+9.2} {known:>11} {open:>16}\n",
            row.per, row.rate_percent
        );
    }
    text
}
