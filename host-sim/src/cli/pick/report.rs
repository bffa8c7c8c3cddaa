//! `pick --report`: the answer on one page of HTML, which prints on one sheet.

use std::path::Path;

use super::measure_first::{by_what_they_leave_open, known_to, left_open};
use super::text::{force, head, lines};
use crate::pictures::pick::{MARKS, figure};
use files::made_from::{self, MadeFrom, into_svg};
use files::words::digits::significant;
use files::words::pick::why;
use files::{UserError, rigfile};
use numerics::CartModel;
use numerics::NamedRig;
use numerics::pick::Pick;
use plot::render_svg;

/// Parameters named under "what to measure first".
const MOST_MEASURED: usize = 6;

/// Refuses a report of another kind, one that could not be written, and a file that is no report of this program, before
/// any work is done.
///
/// # Errors
/// If it is one.
pub fn check(file: &Path) -> Result<(), UserError> {
    let ending = file.extension().and_then(|e| e.to_str());
    let ending = ending.map(str::to_ascii_lowercase);
    if !matches!(ending.as_deref(), Some("html" | "htm")) {
        return Err(UserError::new(format!(
            "--report {}: a report is FILE.html, which a browser prints as PDF",
            file.display()
        )));
    }
    let dir = file.parent().filter(|dir| !dir.as_os_str().is_empty());
    files::write::check_folder(dir.unwrap_or(Path::new(".")))?;
    let there = file.symlink_metadata();
    if there.is_ok_and(|there| !there.is_symlink()) && !made_from::says(file) {
        return Err(UserError::new(format!(
            "--report {}: the file there is no report of this program; choose another name",
            file.display()
        )));
    }
    Ok(())
}

/// Writes the report of `pick` into `file`. Returns whether it replaced one.
///
/// # Errors
/// If it cannot be drawn or written.
pub fn write(file: &Path, rig: &NamedRig, pick: &Pick, made: &MadeFrom) -> Result<bool, UserError> {
    let answer = &pick.answer;
    // The page has the sentence already.
    let picture = figure(std::slice::from_ref(pick)).subtitle(MARKS);
    let picture = render_svg(&picture).map_err(|e| UserError::new(e.to_string()))?;
    let assumptions = [
        ("rig", parameters(rig, pick)),
        ("uncertainty", uncertainty(pick)),
        (
            "made by",
            format!(
                "host-sim {}, from the model alone: no result of this program has been compared with a measurement",
                env!("CARGO_PKG_VERSION")
            ),
        ),
        ("command", made.command.clone()),
        ("date and name", "_".repeat(40)),
    ];
    let page = format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n\
         <title>{0}</title>\n<style>{STYLE}</style></head><body>\n<h1>{0}</h1>\n\
         <p>{1}</p>\n<figure>{2}</figure>\n{3}{4}{5}</body></html>\n",
        escaped(&format!("{}, {}", head(answer), force(answer))),
        escaped(&why(answer)),
        into_svg(&picture, made),
        section("The answer", lines(answer)),
        section("What to measure first", measure_first(pick)),
        section("Assumptions", assumptions),
    );
    Ok(files::write::write(file, page)?)
}

/// A heading and rows of a name and what is said of it.
fn section<'a>(heading: &str, rows: impl IntoIterator<Item = (&'a str, String)>) -> String {
    let rows = rows.into_iter();
    let rows =
        rows.map(|(name, text)| format!("<dt>{}</dt><dd>{}</dd>\n", escaped(name), escaped(&text)));
    format!(
        "<h2>{heading}</h2>\n<dl>\n{}</dl>\n",
        rows.collect::<String>()
    )
}

/// Parameters, with what each leaves open.
fn measure_first(pick: &Pick) -> impl Iterator<Item = (&str, String)> {
    let slopes = by_what_they_leave_open(&pick.answer).into_iter();
    slopes.take(MOST_MEASURED).map(|slope| {
        let open = match left_open(slope) {
            Some([_, open]) => format!("uncertainty {}, of the force {open} %; ", known_to(slope)),
            None => String::new(),
        };
        let what = format!(
            "{open}{:+.2} % of force per {}",
            slope.force_percent, slope.per
        );
        (slope.parameter, what)
    })
}

/// Every parameter, as a rig file has it; the amplitude is the answer's, which may be lower or chosen.
fn parameters(rig: &NamedRig, pick: &Pick) -> String {
    let whole = rig.recoiling();
    let params = whole.as_ref().map_or(&rig.params, |rig| &rig.params);
    let all = rigfile::KEYS.iter();
    let all = all.filter_map(|(key, _)| {
        let number = match *key {
            "amplitude_mm" => Some(0.5 * pick.answer.shaker.stroke_mm),
            key => rigfile::number(params, key),
        };
        let value = match number {
            // Six digits, and no zeros behind them.
            Some(number) => significant(number, 6).parse::<f64>().ok()?.to_string(),
            None => rigfile::shown(params, key)?,
        };
        Some(format!("{key} = {value}"))
    });
    all.collect::<Vec<_>>().join("; ")
}

fn uncertainty(pick: &Pick) -> String {
    let Some(u) = &pick.answer.uncertainty else {
        return "none: the parameters are taken as exact".to_owned();
    };
    let damping = match u.contact_damping_ratio_percent {
        Some(percent) => format!("damping ratio ±{percent} %"),
        None => format!("damping ±{} %", u.contact_damping_percent),
    };
    let stiffness = match u.contact_stiffness_factor {
        Some(factor) => format!(
            "up to {} times as large or as small",
            significant(factor, 3)
        ),
        None => format!("±{} %", u.contact_stiffness_percent),
    };
    let of_cart = match pick.answer.cart {
        CartModel::Prescribed => String::new(),
        CartModel::Recoil => format!(
            ", cart mass ±{} %, shaker loop ±{} %, its damping ±{} %",
            u.cart_mass_percent, u.shaker_loop_percent, u.shaker_damping_percent
        ),
    };
    format!(
        "natural frequency ±{} %, amplitude ±{} %, contact stiffness {stiffness}, contact {damping}, gap ±{} mm, hammer mass ±{} %{of_cart}; {} corners of it and {} rigs drawn at random (seed {})",
        u.natural_frequency_percent,
        u.amplitude_percent,
        u.gap_mm,
        u.mass_percent,
        pick.answer.corners,
        u.samples,
        u.seed
    )
}

const STYLE: &str = "\
:root{color-scheme:light}\
body{font:15px/1.45 'Noto Sans','Segoe UI',Helvetica,Arial,sans-serif;color:#222;background:#fff;\
max-width:52rem;margin:0 auto;padding:1.5rem}\
h1{font-size:1.4rem;margin:0 0 .5rem}h2{font-size:1.05rem;margin:1.2rem 0 .4rem}\
svg{max-width:100%;height:auto}figure{margin:.8rem 0}\
dl{display:grid;grid-template-columns:12rem 1fr;gap:.25rem 1rem;margin:0}\
dt{font-weight:600;color:#555}dd{margin:0}\
@media(max-width:600px){dl{grid-template-columns:1fr}}\
@page{size:A4;margin:12mm}\
@media print{body{font-size:7.5pt;line-height:1.25;max-width:none;padding:0}h1{font-size:11pt}h2{font-size:9.5pt;margin:2mm 0 1mm}\
p{margin:1mm 0}figure{margin:1mm 0;text-align:center}svg{max-height:78mm}dl{grid-template-columns:44mm 1fr;gap:.4mm 4mm}}";

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}
