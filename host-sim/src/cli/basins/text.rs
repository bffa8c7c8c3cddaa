//! Basins as a person reads them.

use super::Line;
use crate::pictures::basins::caption;
use crate::words::number;
use numerics::basins::{Basins, BasinsSummary, Entropy, SampledShare};
use plot::chart::Chart;

/// Most attractors listed; of the smaller ones only the number is told.
const LISTED: usize = 12;

pub fn one(basins: &Basins, s: &BasinsSummary) -> String {
    let mut text = format!("{}\n\n", caption(basins));
    let mut line = |name: &str, what: String| text += &format!("  {name:<22} {what}\n");
    line(
        "impact",
        format!(
            "{} of {} by {} starts have a contact in the last {} of {} cycles",
            with_mesh(s.impact_share, s.impact_share_mesh_error),
            s.grid[0],
            s.grid[1],
            s.recorded,
            s.cycles
        ),
    );
    if let Some(share) = s.impact_share_random {
        line(
            "",
            format!("{} of {} random starts", sampled(&share), share.of),
        );
    }
    line("entropy, impact", entropy(s.impact_entropy));
    line("entropy, attractors", entropy(s.attractor_entropy));
    if let Some(u) = s.impact_uncertainty {
        line(
            "uncertainty exponent",
            format!(
                "{:.3} over 1 to {} cells (misfit {:.2}); dimension of the boundary {:.3}",
                u.exponent, u.farthest, u.misfit, u.dimension
            ),
        );
    }
    if s.uncertain > 0 {
        line(
            "uncertain",
            format!("{} starts, run again by the reference", s.uncertain),
        );
    }
    text +=
        "\n  ends in          force/weight   share of the grid    of the random starts (95 %)\n";
    for a in s.attractors.iter().take(LISTED) {
        let random = a
            .share_random
            .map_or("-".to_owned(), |share| sampled(&share));
        text += &format!(
            "  {:<16} {:>12.2}   {:<20} {random}\n",
            a.name,
            a.force_ratio,
            with_mesh(a.share, a.share_mesh_error)
        );
    }
    if s.attractors.len() > LISTED {
        let left = s.attractors.len() - LISTED;
        text += &format!("  and {left} smaller ones (--format json gives all)\n");
    }
    text + &over_cycles(s)
}

/// The share of impact over the number of cycles, as a table and a chart.
fn over_cycles(s: &BasinsSummary) -> String {
    if s.over_cycles.is_empty() {
        return String::new();
    }
    let mut text = format!(
        "\n  cycles   impact, % of the random starts (95 %): a contact in the {} cycles before\n",
        s.recorded
    );
    for look in &s.over_cycles {
        text += &format!("  {:>6}   {}\n", look.cycles, sampled(&look.impact));
    }
    let curve = s.over_cycles.iter();
    let curve = curve.map(|l| (f64::from(l.cycles), 100.0 * l.impact.value()));
    text.push('\n');
    text + &Chart::new("cycles", "impact, %")
        .size(72, 10)
        .series("impact", curve.collect())
        .render()
}

fn entropy(entropy: Option<Entropy>) -> String {
    let Some(e) = entropy else {
        return "the grid is too small for boxes of 5 by 5".to_owned();
    };
    match e.boundary {
        None => "0 (no boundary)".to_owned(),
        Some(boundary) => format!(
            "basin {:.4}, boundary {:.4} ({} of {} boxes; ln 2 = 0.693)",
            e.basin, boundary, e.boundary_boxes, e.boxes
        ),
    }
}

fn with_mesh(share: f64, error: Option<f64>) -> String {
    let error = error.map_or(String::new(), |e| format!(" ± {:.2}", 100.0 * e));
    format!("{:.2}{error} %", 100.0 * share)
}

fn sampled(share: &SampledShare) -> String {
    format!(
        "{:.2} % ({:.2} to {:.2})",
        100.0 * share.value(),
        100.0 * share.low,
        100.0 * share.high
    )
}

/// The chapter's points side by side.
pub fn several(lines: &[Line<'_>]) -> String {
    let mut text = String::from(
        "figure  rig       Ω/ω   gap/A0  impact, %        random (95 %)           S_b     S_bb   α      ends in\n",
    );
    for l in lines {
        let percent = |x: Option<f64>| number(x.map(|x| 100.0 * x), 1);
        text += &format!(
            "{:<7} {:<9} {:<5.2} {:<6.2}  {:<16} {:>5} ({} to {})  {:>10} {:>6} {:>6}  {} kinds, most {}\n",
            l.figure,
            l.rig,
            l.frequency_ratio,
            l.gap_over_amplitude,
            with_mesh(l.impact_share, l.impact_share_mesh_error),
            percent(l.impact_share_random),
            percent(l.impact_share_random_low),
            percent(l.impact_share_random_high),
            number(l.basin_entropy, 3),
            number(l.boundary_basin_entropy, 3),
            number(l.uncertainty_exponent, 3),
            l.attractors,
            l.largest_attractor
        );
    }
    text
}
