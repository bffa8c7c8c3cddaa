//! The answer as a person reads it.

use super::{bending, measure_first};
use files::words::digits::Digits;
use files::words::pick::{
    assumed, beyond, cannot, is_beyond, jumping_at, of_shaker, other_cart, rounded_mm,
    shaker_limit, why,
};
use numerics::CartModel;
use numerics::branch::BranchEnd;
use numerics::limits::LimitUse;
use numerics::pick::{Pick, PickAnswer};
use plot::chart::Chart;

/// One answer in full, several side by side.
pub fn text(picks: &[Pick]) -> String {
    if let [one] = picks {
        return one_text(one);
    }
    let mut text = String::from(
        "rig        run at, Hz  ratio  force, N  force/weight (worst)        safe band, Hz  doubling, Hz  jumps  cart\n",
    );
    for pick in picks {
        let a = &pick.answer;
        let digits = Digits::of(a);
        text += &format!(
            "{:<9} {:>11} {:>6.*} {:>9.*} {:>13.*} ({:.*}) {:>20} {:>13} {:>6}  {}\n",
            a.rig,
            digits.run_at(a),
            digits.ratio,
            a.frequency_ratio,
            digits.force_n,
            a.force_n,
            digits.force_ratio,
            a.force_ratio,
            digits.force_ratio,
            a.force_ratio_worst,
            digits.safe_band(a),
            a.period_doubling_hz
                .map_or("-".to_owned(), |hz| digits.hz(hz)),
            if a.jump_free { "no" } else { "yes" },
            a.cart.words().trim_start_matches("cart ")
        );
    }
    text.push('\n');
    text + &chart_of(picks)
}

/// The curves of several rigs, over frequency ratio.
pub fn chart_of(picks: &[Pick]) -> String {
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
    chart.render()
}

/// A choice closer than this to the top of its safe band has no margin, %.
const EDGE_PERCENT: f64 = 0.5;

fn one_text(pick: &Pick) -> String {
    let a = &pick.answer;
    let head = format!("{}\n{}\n\n", head(a), why(a));
    let lines = lines(a);
    let lines = lines
        .iter()
        .map(|(name, what)| format!("  {name:<18} {what}\n"));
    let lines: String = lines.collect();
    format!(
        "{head}{lines}\n{}\n{}",
        measure_first::table(a),
        chart(pick)
    )
}

/// Names and what is said of them.
pub type Lines = Vec<(&'static str, String)>;

/// The answer line by line.
pub fn lines(a: &PickAnswer) -> Lines {
    [operation(a), stability(a), shaker(a), limits(a)].concat()
}

/// The answer in one line: rig, gap, cart, stroke if it is another, and the frequency to run at.
pub fn head(a: &PickAnswer) -> String {
    let mm = rounded_mm(a.shaker.stroke_mm);
    let stroke = match a.wanted_force_n {
        Some(n) => format!("for {n} N, give it {mm} mm of stroke and "),
        None if a.amplitude_lowered => format!("lower the stroke to {mm} mm and "),
        None => String::new(),
    };
    let cannot = cannot(a);
    format!(
        "{}, gap {:?} mm, {}: {stroke}run it at {} Hz ({:.*} times the natural frequency){cannot}",
        a.rig,
        a.gap_mm,
        a.cart.words(),
        Digits::of(a).run_at(a),
        Digits::of(a).ratio,
        a.frequency_ratio
    )
}

/// The force at the operating point, and over the uncertainty.
pub fn force(a: &PickAnswer) -> String {
    let digits = Digits::of(a);
    let (n, ratio) = (digits.force_n, digits.force_ratio);
    let nominal = format!(
        "{:.n$} N, {:.ratio$} times the weight",
        a.force_n, a.force_ratio
    );
    match a.uncertainty {
        Some(_) => format!(
            "{nominal}; {:.ratio$} to {:.ratio$} times over the uncertainty",
            a.force_ratio_worst, a.force_ratio_largest
        ),
        None => nominal,
    }
}

/// Regime, force and band at the operating point.
fn operation(a: &PickAnswer) -> Lines {
    let digits = Digits::of(a);
    let over = a.uncertainty.map_or("", |_| " over the uncertainty");
    let [low, high] = a.safe_band_hz;
    let power = format!(
        "{} W; at most {} W, at {} Hz",
        digits.other(a.impact_power_w),
        digits.other(a.power_optimum_w),
        digits.hz(a.power_optimum_hz)
    );
    let mut lines = vec![("regime", from_rest(a)), ("force", force(a))];
    lines.extend(settling(a));
    lines.extend(bending::lines(a));
    lines.extend(cart(a));
    lines.push(("impact power", power));
    lines.push((
        "safe band",
        format!(
            "{} Hz: 1/1 stable{over}, nominal force above 90 %{}{}{}",
            digits.safe_band(a),
            with_modes(a),
            at_the_ends(a),
            reserve(a)
        ),
    ));
    let middle = digits.hz(0.5 * (low + high));
    let edge = |end: &str, way: &str| {
        format!(
            "the operating frequency is the {end} of the safe band; if it can drift, run {way}, for example at {middle} Hz"
        )
    };
    let [below, above] = [a.margin_below_percent, a.margin_above_percent].map(|m| m < EDGE_PERCENT);
    lines.extend(match (below, above) {
        (false, false) => None,
        (true, false) => Some(("no margin below", edge("bottom", "higher"))),
        (false, true) => Some(("no margin above", edge("top", "lower"))),
        (true, true) => Some((
            "no margin",
            "the safe band is so narrow that a small drift leaves it on either side".to_owned(),
        )),
    });
    lines
}

/// How long a run from rest takes to get to the force.
fn settling(a: &PickAnswer) -> Option<(&'static str, String)> {
    let (cycles, seconds) = (a.force_settling_cycles?, a.force_settling_s?);
    Some((
        "settles",
        format!("from rest within 1 % of this force after {cycles} drive periods ({seconds:.1} s)"),
    ))
}

/// What the force in the band is of, on beams.
fn with_modes(a: &PickAnswer) -> String {
    match a.bending.modes {
        None if a.bending.on_beams => " with one bending mode".to_owned(),
        None | Some(1) => String::new(),
        Some(modes) => format!(" with one bending mode and with {modes}"),
    }
}

/// Which cart the answer is for, and what the other would give.
fn cart(a: &PickAnswer) -> Lines {
    let digits = Digits::of(a);
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
            CartModel::Prescribed => {
                "moved as prescribed, with any force that this takes".to_owned()
            }
        },
    )];
    if let Some(other) = other_cart(a) {
        let more = 100.0 * (other.force_ratio / other.own_force_ratio - 1.0);
        let n = digits.force_ratio;
        let same =
            other.own_force_ratio == a.force_ratio && other.own_hz == a.operating_frequency_hz;
        let against = match same {
            true => String::new(),
            false => format!(
                "; both carts nominal and without a limit of the shaker: the cart above then gives {:.n$} times the weight at {} Hz",
                other.own_force_ratio,
                digits.hz(other.own_hz)
            ),
        };
        lines.push((
            "other cart",
            format!(
                "{:.n$} times the weight at {} Hz {} ({more:+.1} % of force{against})",
                other.force_ratio,
                digits.hz(other.hz),
                other.what
            ),
        ));
    }
    lines
}

/// What the frequency keeps from the ends of the range in which every rig of the uncertainty has its 1/1.
fn reserve(a: &PickAnswer) -> &'static str {
    if a.limits.iter().any(LimitUse::is_reserve) {
        "; the frequency keeps a reserve of 1 % from where a rig of the uncertainty loses its 1/1"
    } else if a.limits.iter().any(LimitUse::is_narrow_reserve) {
        "; a rig of the uncertainty loses its 1/1 less than 1 % below or above the frequency, which is the middle of the remaining range"
    } else {
        ""
    }
}

/// The weakest of the uncertainty at the ends of the safe band, where there is an uncertainty.
fn at_the_ends(a: &PickAnswer) -> String {
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

fn stability(a: &PickAnswer) -> Lines {
    let digits = Digits::of(a);
    let others = digits.others;
    let worst = match a.uncertainty {
        Some(_) => format!(
            "; {:.others$} at worst over the uncertainty",
            a.multipliers_worst
        ),
        None => String::new(),
    };
    vec![
        ("stable 1/1", stable(a, |hz| digits.hz(hz))),
        (
            "multipliers",
            format!(
                "{:.others$}{worst} (1 is the limit of stability)",
                a.multipliers
            ),
        ),
        ("jumps", jumps(a, "agree", jumping_at)),
        (
            "at natural freq.",
            format!(
                "{} times the weight",
                digits.other(a.force_ratio_at_natural_frequency)
            ),
        ),
    ]
}

/// Between which frequencies, shown by `hz`, the nominal 1/1 is stable, and how it ends at each.
pub(super) fn stable(a: &PickAnswer, hz: impl Fn(f64) -> String) -> String {
    let [low, high] = a.stable_one_one_hz.map(hz);
    let [below, above] = a.stable_one_one_ends.map(ending);
    format!("{low} Hz ({below}) to {high} Hz ({above})")
}

/// Where the hammer jumps, as `between` says it of two frequencies, or that up and down sweeps `agree`.
pub(super) fn jumps(a: &PickAnswer, agree: &str, between: impl Fn(f64, f64) -> String) -> String {
    let Some([from, to]) = a.jump_range_hz else {
        return format!(
            "none: up and down sweeps across the stable 1/1 {agree}, and it does not fold"
        );
    };
    let inside = if a.jump_free_in_safe_band {
        "not"
    } else {
        "also"
    };
    format!(
        "{}, {inside} inside the safe band (up and down sweeps differ, or the 1/1 folds)",
        between(from, to)
    )
}

/// What the shaker must give, and what it gets for it.
fn shaker(a: &PickAnswer) -> Lines {
    let s = &a.shaker;
    let digits = Digits::of(a);
    let held = s.loop_force_n.map_or(String::new(), |force| {
        format!(
            "; its position loop gives up to {} N, recoil included",
            digits.other(force)
        )
    });
    let lowered = if a.wanted_force_n.is_some() {
        " (half the stroke that gives the force wanted)"
    } else if a.amplitude_lowered {
        " (lowered: at the rig's amplitude no frequency keeps the shaker's limits)"
    } else {
        ""
    };
    let mut lines = vec![
        (
            "amplitude",
            format!("{} mm{lowered}", rounded_mm(a.amplitude_mm)),
        ),
        (
            "shaker must give",
            format!(
                "{} mm stroke, {} m/s, {} N on cart and hammer, {} W mean and {} W reactive power{held}",
                rounded_mm(s.stroke_mm),
                digits.other(s.velocity_m_per_s),
                digits.other(s.force_n),
                digits.other(s.mean_power_w),
                digits.other(s.reactive_power_w)
            ),
        ),
        (
            "blows",
            format!(
                "{} a second, {} mJ each, {} ms at {} m/s",
                digits.other(s.blows_per_second),
                digits.other(s.energy_per_blow_j * 1e3),
                digits.other(a.contact_time_ms),
                digits.other(a.approach_speed_m_per_s)
            ),
        ),
    ];
    lines.extend(enough(a).map(|what| ("shaker enough", what)));
    lines
}

/// Whether the shaker that was asked for is strong enough, and if not, what gave way.
fn enough(a: &PickAnswer) -> Option<String> {
    let limit = shaker_limit(a)?;
    let (most, digits) = (limit.limit?, Digits::of(a));
    let here = digits.other(a.shaker.loop_force_n.unwrap_or(a.shaker.force_n));
    let at_best = digits.other(a.shaker_force_at_optimum_n?);
    let best_hz = digits.hz(a.nominal_optimum_hz);
    Some(if let Some(why) = beyond(a) {
        format!("no: {why}")
    } else if a.wanted_force_n.is_some() && assumed(limit) {
        format!(
            "it needs {here} N; {most} N are assumed, so measure the largest force of yours (shaker_max_force_n)"
        )
    } else if a.amplitude_lowered {
        format!(
            "no, not at the rig's amplitude: there the strongest 1/1 needs {at_best} N, and the shaker can give {most} N; at the lower amplitude it needs {here} N"
        )
    } else if limit.binds {
        let moved = if a.operating_frequency_hz < a.nominal_optimum_hz {
            "lower"
        } else {
            "higher"
        };
        format!(
            "no, not at {best_hz} Hz: there the strongest 1/1 needs {at_best} N, and the shaker can give {most} N; at the {moved} frequency it needs {here} N"
        )
    } else {
        format!("yes, for the nominal rig: it needs {here} N and can give {most} N")
    })
}

/// That a limit decides, and whether only with another of `all`.
pub(super) fn decides(limit: &LimitUse, all: &[LimitUse]) -> String {
    let others = all
        .iter()
        .filter(|l| l.together && l.name != limit.name)
        .map(|l| l.name);
    match others.collect::<Vec<_>>()[..] {
        _ if !limit.together => "decides".to_owned(),
        [other] => format!("decides, but only together with {other}"),
        _ => "decides, but only together with others".to_owned(),
    }
}

fn limits(a: &PickAnswer) -> Lines {
    let line = |limit: &LimitUse| {
        let value = limit.limit.map_or(String::new(), |x| format!(" = {x}"));
        let needed = a.shaker.loop_force_n.unwrap_or(a.shaker.force_n);
        let beyond = limit.limit.is_some_and(|most| is_beyond(needed, most));
        let binds = if of_shaker(limit) && beyond {
            "is not kept".to_owned()
        } else if of_shaker(limit) && a.amplitude_lowered {
            "decides, by the stroke".to_owned()
        } else if limit.binds {
            decides(limit, &a.limits)
        } else {
            "does not decide".to_owned()
        };
        ("limit", format!("{}{value}: {binds}", limit.name))
    };
    let told = a.limits.iter().filter(|limit| !assumed(limit));
    told.map(line).collect()
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

fn from_rest(a: &PickAnswer) -> String {
    let nominal = format!(
        "{} (a run from rest settles on {}",
        a.regime, a.regime_from_rest
    );
    match a.corners {
        0 => nominal + ")",
        corners => format!(
            "{nominal}; of {corners} corners of the uncertainty, {} settle on 1/1)",
            a.corners_reaching_one_one_from_rest
        ),
    }
}

/// How a stable 1/1 ends, in words.
pub fn ending(end: BranchEnd) -> &'static str {
    match end {
        BranchEnd::PeriodDoubling => "period doubling",
        BranchEnd::ExtraContact => "another contact appears",
        BranchEnd::Fold => "the orbit ends: fold or graze",
        BranchEnd::SearchLimit => "end of the search",
        BranchEnd::ContactAtSection => {
            "it continues with a contact at drive phase 0, where the search does not follow it"
        }
    }
}
