//! What to measure first: what each parameter leaves open, in words and as a table.

use numerics::pick::PickAnswer;
use numerics::pick::sensitivity::Sensitivity;

/// The parameters that leave the force most open, first.
pub fn by_what_they_leave_open(a: &PickAnswer) -> Vec<&Sensitivity> {
    let mut rows: Vec<_> = a.sensitivity.iter().collect();
    rows.sort_by(|a, b| b.force_open_percent().total_cmp(&a.force_open_percent()));
    rows
}

/// How well the parameter of `row` is known.
pub fn known_to(row: &Sensitivity) -> String {
    if let Some(factor) = row.uncertainty_factor {
        return format!("×÷ {factor}");
    }
    match (row.uncertainty_percent, row.uncertainty_mm) {
        (Some(0.0), _) | (None, Some(0.0)) => "exact".to_owned(),
        (Some(percent), _) => format!("±{percent} %"),
        (None, Some(mm)) => format!("±{mm} mm"),
        (None, None) => "-".to_owned(),
    }
}

/// How far a parameter leaves frequency and force open, in %: "±13.2", or "-37.1 to +58.9" where the range was computed or it is known to a factor. `None`
/// where nothing is said of it.
pub fn left_open(row: &Sensitivity) -> Option<[String; 2]> {
    let shares = [
        row.frequency_over_uncertainty_percent?,
        row.force_over_uncertainty_percent?,
    ];
    let [frequency, force] = shares.map(|up| match row.uncertainty_factor {
        Some(_) => format!("-{:.1} to +{up:.1}", 100.0 * up / (100.0 + up)),
        None => format!("±{up:.1}"),
    });
    let range = row.force_range_percent;
    let range = range.map(|[least, most]| format!("{least:+.1} to {most:+.1}"));
    Some([frequency, range.unwrap_or(force)])
}

/// The table of slopes; with an uncertainty, what each parameter leaves open comes first.
pub fn table(a: &PickAnswer) -> String {
    let mut text = format!(
        "What to measure first. Each row: change of the nominal optimum with the parameter, uncertainty of the parameter, and uncertainty of the force because of it (first three rows: over the whole range; others: from the slope)\n  {:<44} {:>8} {:>13} {:>9}  {:>11}  {:>15}\n",
        "parameter", "per", "frequency, %", "force, %", "uncertainty", "of the force, %"
    );
    for row in by_what_they_leave_open(a) {
        let known = known_to(row);
        let open = left_open(row).map_or("-".to_owned(), |[_, force]| force);
        let guessed = row.force_range_percent.is_none() && row.uncertainty_factor.is_some();
        let open = if guessed { format!("~{open}") } else { open };
        text += &format!(
            "  {:<44} {:>8} {:>+13.2} {:>+9.2}  {known:>11}  {open:>15}\n",
            row.parameter, row.per, row.frequency_percent, row.force_percent
        );
    }
    text
}
