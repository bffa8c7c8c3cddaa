//! The answer as a person reads it.

use crate::words::pick::{jumping_at, why};
use numerics::branch::End;
use numerics::pick::{Answer, Pick};
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
    let mut text = format!(
        "{}, gap {:?} mm: run it at {:.4} Hz ({:.3} times the natural frequency)\n{}\n\n",
        a.rig,
        a.gap_mm,
        a.operating_frequency_hz,
        a.frequency_ratio,
        why(a)
    );
    let mut line = |name: &str, what: String| text += &format!("  {name:<18} {what}\n");
    line("regime", from_rest(a));
    line(
        "force",
        match a.uncertainty {
            Some(_) => format!(
                "{:.2} N, {:.2} times the weight; {:.2} to {:.2} over the uncertainty",
                a.force_n, a.force_ratio, a.force_ratio_worst, a.force_ratio_largest
            ),
            None => format!("{:.2} N, {:.2} times the weight", a.force_n, a.force_ratio),
        },
    );
    line(
        "safe band",
        format!(
            "{:.4} to {:.4} Hz: 1/1 stable{}, force above 90 %",
            a.safe_band_hz[0],
            a.safe_band_hz[1],
            if a.uncertainty.is_some() {
                " over the uncertainty"
            } else {
                ""
            }
        ),
    );
    let margin = (a.safe_band_hz[1] / a.operating_frequency_hz - 1.0) * 100.0;
    if margin < EDGE_PERCENT {
        line(
            "no margin above",
            format!(
                "the choice is the top of the safe band; if the frequency can drift, run lower, at {:.3} Hz say",
                0.5 * (a.safe_band_hz[0] + a.safe_band_hz[1])
            ),
        );
    }
    line(
        "stable 1/1",
        format!(
            "{:.4} Hz ({}) to {:.4} Hz ({})",
            a.stable_one_one_hz[0],
            ending(a.stable_one_one_ends[0]),
            a.stable_one_one_hz[1],
            ending(a.stable_one_one_ends[1])
        ),
    );
    line(
        "multipliers",
        match a.uncertainty {
            Some(_) => format!(
                "{:.4}; {:.4} at worst over the uncertainty (1 is the limit of stability)",
                a.multipliers, a.multipliers_worst
            ),
            None => format!("{:.4} (1 is the limit of stability)", a.multipliers),
        },
    );
    line(
        "jumps",
        match a.jump_range_hz {
            None => "none: up and down sweeps across the stable 1/1 agree, and it does not fold"
                .to_owned(),
            Some([low, high]) => {
                let inside = if a.jump_free_in_safe_band {
                    "not"
                } else {
                    "also"
                };
                format!(
                    "{}, {inside} inside the safe band (up and down sweeps differ, or the 1/1 folds)",
                    jumping_at(low, high)
                )
            }
        },
    );
    line(
        "at natural freq.",
        format!("{:.2} times the weight", a.force_ratio_at_natural_frequency),
    );
    let s = &a.shaker;
    line(
        "shaker must give",
        format!(
            "{} mm stroke, {:.4} m/s, {:.2} N on cart and hammer, {:.4} W mean, {:.4} W swinging",
            s.stroke_mm, s.velocity_m_per_s, s.force_n, s.mean_power_w, s.reactive_power_w
        ),
    );
    line(
        "blows",
        format!(
            "{:.3} a second, {:.3} mJ each, {:.4} ms at {:.4} m/s",
            s.blows_per_second,
            s.energy_per_blow_j * 1e3,
            a.contact_time_ms,
            a.approach_speed_m_per_s
        ),
    );
    for limit in &a.limits {
        let value = limit.limit.map_or(String::new(), |x| format!(" = {x}"));
        let binds = if limit.binds {
            "decides"
        } else {
            "does not bind"
        };
        line("limit", format!("{}{value}: {binds}", limit.name));
    }
    text += "\nWhat to measure first (change of the nominal optimum)\n";
    text += &format!(
        "  {:<44} {:>8} {:>13} {:>9}\n",
        "parameter", "per", "frequency, %", "force, %"
    );
    for row in &a.sensitivity {
        text += &format!(
            "  {:<44} {:>8} {:>+13.2} {:>+9.2}\n",
            row.parameter, row.per, row.frequency_percent, row.force_percent
        );
    }
    text.push('\n');
    let mut chart = Chart::new("drive frequency, Hz", "force over weight, stable 1/1")
        .series("force", pick.curve.clone())
        .marker("run here", a.operating_frequency_hz);
    if let Some(hz) = a.period_doubling_hz {
        chart = chart.marker("period doubling", hz);
    }
    text + &chart.render()
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
