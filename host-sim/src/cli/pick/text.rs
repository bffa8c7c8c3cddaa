//! The answer as a person reads it.

use super::bending;
use crate::words::pick::{jumping_at, other_cart, why};
use numerics::branch::End;
use numerics::pick::answer::LimitUse;
use numerics::pick::{Answer, CartModel, Pick};
use plot::chart::Chart;

/// One answer in full, several side by side.
pub fn text(picks: &[Pick]) -> String {
    if let [one] = picks {
        return one_text(one);
    }
    let mut text = String::from(
        "rig        run at, Hz  ratio  force, N  force/weight (worst)  safe band, Hz        doubling, Hz  jumps\n",
    );
    for pick in picks {
        let a = &pick.answer;
        text += &format!(
            "{:<9} {:>11.4} {:>6.3} {:>9.2} {:>13.2} ({:.2}) {:>9.3} to {:<9.3} {:>12} {:>6}\n",
            a.rig,
            a.operating_frequency_hz,
            a.frequency_ratio,
            a.force_n,
            a.force_ratio,
            a.force_ratio_worst,
            a.safe_band_hz[0],
            a.safe_band_hz[1],
            a.period_doubling_hz
                .map_or("-".to_owned(), |hz| format!("{hz:.3}")),
            if a.jump_free { "no" } else { "yes" }
        );
    }
    text.push('\n');
    let chart = Chart::new(
        "drive frequency over natural frequency",
        "force over weight, stable 1/1",
    );
    let chart = picks.iter().fold(chart, |chart, pick| {
        let natural_hz = pick.answer.operating_frequency_hz / pick.answer.frequency_ratio;
        let curve = pick
            .curve
            .iter()
            .map(|(hz, force)| (hz / natural_hz, *force));
        chart.series(pick.answer.rig.clone(), curve.collect())
    });
    text + &chart.render()
}

/// A choice closer than this to the top of its safe band has no margin, %.
const EDGE_PERCENT: f64 = 0.5;

fn one_text(pick: &Pick) -> String {
    let a = &pick.answer;
    let head = format!(
        "{}, gap {:?} mm: run it at {:.4} Hz ({:.3} times the natural frequency)\n{}\n\n",
        a.rig,
        a.gap_mm,
        a.operating_frequency_hz,
        a.frequency_ratio,
        why(a)
    );
    let lines = [operation(a), stability(a), shaker(a), limits(a)].concat();
    let lines = lines
        .iter()
        .map(|(name, what)| format!("  {name:<18} {what}\n"));
    let lines: String = lines.collect();
    format!("{head}{lines}\n{}\n{}", sensitivity(a), chart(pick))
}

type Lines = Vec<(&'static str, String)>;

/// Regime, force and band at the operating point.
fn operation(a: &Answer) -> Lines {
    let force = format!("{:.2} N, {:.2} times the weight", a.force_n, a.force_ratio);
    let (spread, over) = match a.uncertainty {
        Some(_) => (
            format!(
                "; {:.2} to {:.2} over the uncertainty",
                a.force_ratio_worst, a.force_ratio_largest
            ),
            " over the uncertainty",
        ),
        None => (String::new(), ""),
    };
    let [low, high] = a.safe_band_hz;
    let power = format!(
        "{:.5} W; at most {:.5} W, at {:.4} Hz",
        a.impact_power_w, a.power_optimum_w, a.power_optimum_hz
    );
    let mut lines = vec![("regime", from_rest(a)), ("force", force + &spread)];
    lines.extend(bending::lines(a));
    lines.extend(cart(a));
    lines.push(("impact power", power));
    lines.push((
        "safe band",
        format!(
            "{low:.4} to {high:.4} Hz: 1/1 stable{over}, nominal force above 90 %{}{}",
            with_modes(a),
            at_the_ends(a)
        ),
    ));
    let margin = (high / a.operating_frequency_hz - 1.0) * 100.0;
    if margin < EDGE_PERCENT {
        lines.push((
            "no margin above",
            format!(
                "the operating frequency is the top of the safe band; if it can drift, run lower, for example at {:.3} Hz",
                0.5 * (low + high)
            ),
        ));
    }
    lines
}

/// What the force in the band is of, on beams.
fn with_modes(a: &Answer) -> String {
    match a.bending.modes {
        None if a.bending.on_beams => " with one bending mode".to_owned(),
        None | Some(1) => String::new(),
        Some(modes) => format!(" with one bending mode and with {modes}"),
    }
}

/// Which cart the answer is for, and what the other would give.
fn cart(a: &Answer) -> Lines {
    let Some(held) = a.shaker_loop else {
        let what =
            "moved as prescribed: its shaker is not known (shaker_loop_hz), so it cannot recoil";
        return vec![("cart", what.to_owned())];
    };
    let held = format!(
        "a position loop of {} Hz damped at {}",
        held.frequency_hz, held.damping_ratio
    );
    let mut lines = vec![(
        "cart",
        match a.cart {
            CartModel::Recoil => format!("recoils from the contacts, held by {held}"),
            CartModel::Prescribed => "moved as prescribed, whatever force that takes".to_owned(),
        },
    )];
    if let Some((what, force, hz)) = other_cart(a) {
        let more = 100.0 * (force / a.force_ratio - 1.0);
        lines.push((
            "other cart",
            format!("{force:.2} times the weight at {hz:.4} Hz {what} ({more:+.1} % of force)"),
        ));
    }
    lines
}

/// The weakest of the uncertainty at the ends of the safe band, where there is an uncertainty.
fn at_the_ends(a: &Answer) -> String {
    let [Some(low), Some(high)] = a.safe_band_force_ratio_worst else {
        return String::new();
    };
    if a.uncertainty.is_none() {
        return String::new();
    }
    let percent = |force: f64| 100.0 * force / a.force_ratio;
    format!(
        " (at worst {:.0} % at the lower end, {:.0} % at the upper)",
        percent(low),
        percent(high)
    )
}

fn stability(a: &Answer) -> Lines {
    let [low, high] = a.stable_one_one_hz;
    let [below, above] = a.stable_one_one_ends.map(ending);
    let worst = match a.uncertainty {
        Some(_) => format!("; {:.4} at worst over the uncertainty", a.multipliers_worst),
        None => String::new(),
    };
    let jumps = match a.jump_range_hz {
        None => {
            "none: up and down sweeps across the stable 1/1 agree, and it does not fold".to_owned()
        }
        Some([from, to]) => {
            let inside = if a.jump_free_in_safe_band {
                "not"
            } else {
                "also"
            };
            format!(
                "{}, {inside} inside the safe band (up and down sweeps differ, or the 1/1 folds)",
                jumping_at(from, to)
            )
        }
    };
    vec![
        (
            "stable 1/1",
            format!("{low:.4} Hz ({below}) to {high:.4} Hz ({above})"),
        ),
        (
            "multipliers",
            format!("{:.4}{worst} (1 is the limit of stability)", a.multipliers),
        ),
        ("jumps", jumps),
        (
            "at natural freq.",
            format!("{:.2} times the weight", a.force_ratio_at_natural_frequency),
        ),
    ]
}

/// A length to a micrometre.
fn rounded_mm(mm: f64) -> f64 {
    (mm * 1e3).round() / 1e3
}

/// What the shaker must give, and what it gets for it.
fn shaker(a: &Answer) -> Lines {
    let s = &a.shaker;
    let held = s.loop_force_n.map_or(String::new(), |force| {
        let most = a.shaker_loop.map_or(f64::INFINITY, |held| held.max_force_n);
        format!(
            "; its position loop gives up to {force:.1} N, recoil included, of the {most} N it can"
        )
    });
    let lowered = if a.amplitude_lowered {
        " (the amplitude is lowered: with the rig's no frequency keeps the limits of the shaker)"
    } else {
        ""
    };
    vec![
        (
            "amplitude",
            format!("{} mm{lowered}", rounded_mm(a.amplitude_mm)),
        ),
        (
            "shaker must give",
            format!(
                "{} mm stroke, {:.4} m/s, {:.2} N on cart and hammer, {:.4} W mean and {:.4} W reactive power{held}",
                rounded_mm(s.stroke_mm),
                s.velocity_m_per_s,
                s.force_n,
                s.mean_power_w,
                s.reactive_power_w
            ),
        ),
        (
            "blows",
            format!(
                "{:.3} a second, {:.3} mJ each, {:.4} ms at {:.4} m/s",
                s.blows_per_second,
                s.energy_per_blow_j * 1e3,
                a.contact_time_ms,
                a.approach_speed_m_per_s
            ),
        ),
    ]
}

fn limits(a: &Answer) -> Lines {
    let line = |limit: &LimitUse| {
        let value = limit.limit.map_or(String::new(), |x| format!(" = {x}"));
        let binds = if limit.binds {
            "decides"
        } else {
            "does not bind"
        };
        ("limit", format!("{}{value}: {binds}", limit.name))
    };
    a.limits.iter().map(line).collect()
}

fn sensitivity(a: &Answer) -> String {
    let mut text = format!(
        "What to measure first (change of the nominal optimum)\n  {:<44} {:>8} {:>13} {:>9}\n",
        "parameter", "per", "frequency, %", "force, %"
    );
    for row in &a.sensitivity {
        text += &format!(
            "  {:<44} {:>8} {:>+13.2} {:>+9.2}\n",
            row.parameter, row.per, row.frequency_percent, row.force_percent
        );
    }
    text
}

fn chart(pick: &Pick) -> String {
    let chart = Chart::new("drive frequency, Hz", "force over weight, stable 1/1")
        .series("force", pick.curve.clone())
        .marker("run here", pick.answer.operating_frequency_hz);
    match pick.answer.period_doubling_hz {
        Some(hz) => chart.marker("period doubling", hz),
        None => chart,
    }
    .render()
}

fn from_rest(a: &Answer) -> String {
    let nominal = format!(
        "{} (a run from rest settles on {}",
        a.regime, a.regime_from_rest
    );
    match a.corners {
        0 => nominal + ")",
        corners => format!(
            "{nominal}; of the uncertainty's {corners} corners, {} settle on 1/1)",
            a.corners_reaching_one_one_from_rest
        ),
    }
}

fn ending(end: End) -> &'static str {
    match end {
        End::PeriodDoubling => "period doubling",
        End::ExtraContact => "another contact appears",
        End::Fold => "the orbit ends: fold or graze",
        End::SearchLimit => "end of the search",
    }
}
