//! `pick --report`: the answer on one page, as HTML or PDF.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::measure_first::{by_what_they_leave_open, known_to, left_open};
use super::text::{force, head, lines};
use crate::pictures::pick::{MARKS, figure};
use files::made_from::{self, MadeFrom, into_pdf, into_svg};
use files::words::digits::significant;
use files::words::pick::why;
use files::{UserError, rigfile};
use numerics::CartModel;
use numerics::NamedRig;
use numerics::pick::Pick;
use plot::{Block, PictureError, render_pdf, render_svg};

/// Parameters named under "what to measure first".
const MOST_MEASURED: usize = 6;
/// Refuses a report whose kind is not known, one that could not be written, and a file that is no report of this
/// program, before any work is done.
///
/// # Errors
/// If there is one.
pub fn check(reports: &[PathBuf]) -> Result<(), UserError> {
    for file in reports {
        kind(file)?;
        let dir = file.parent().filter(|dir| !dir.as_os_str().is_empty());
        files::write::check_folder(dir.unwrap_or(Path::new(".")))?;
        let there = file.symlink_metadata();
        if there.is_ok_and(|there| !there.is_symlink()) && !made_from::says(file) {
            return Err(UserError::new(format!(
                "--report {}: what is there is no report of this program; choose another name",
                file.display()
            )));
        }
    }
    Ok(())
}

enum Kind {
    Html,
    Pdf,
}

fn kind(file: &Path) -> Result<Kind, UserError> {
    let ending = file.extension().and_then(|e| e.to_str());
    match ending.map(str::to_ascii_lowercase).as_deref() {
        Some("html" | "htm") => Ok(Kind::Html),
        Some("pdf") => Ok(Kind::Pdf),
        _ => Err(UserError::new(format!(
            "--report {}: a report is FILE.html or FILE.pdf",
            file.display()
        ))),
    }
}

/// Writes the report of `pick` into `file`. Returns whether it replaced one.
///
/// # Errors
/// If it cannot be drawn or written.
pub fn write(file: &Path, rig: &NamedRig, pick: &Pick, made: &MadeFrom) -> Result<bool, UserError> {
    let title = format!("{}, {}", head(&pick.answer), force(&pick.answer));
    let blocks = blocks(rig, pick, made);
    let refused = |error: PictureError| UserError::new(error.to_string());
    let bytes = match kind(file)? {
        Kind::Html => html(&title, &blocks, made).map_err(refused)?.into_bytes(),
        Kind::Pdf => into_pdf(render_pdf(&title, &blocks).map_err(refused)?, made),
    };
    Ok(files::write::write(file, bytes)?)
}

/// What the page says, in order.
fn blocks(rig: &NamedRig, pick: &Pick, made: &MadeFrom) -> Vec<Block> {
    let answer = &pick.answer;
    let heading = |text: &str| Block::Heading(text.to_owned());
    let row = |name: &str, text: String| Block::Row(name.to_owned(), text);
    let mut blocks = vec![
        Block::Paragraph(why(answer)),
        // The page has the sentence already.
        Block::Picture(figure(std::slice::from_ref(pick)).subtitle(MARKS)),
        heading("The answer"),
    ];
    blocks.extend(
        lines(answer)
            .into_iter()
            .map(|(name, text)| row(name, text)),
    );
    blocks.push(heading("What to measure first"));
    for slope in by_what_they_leave_open(answer)
        .into_iter()
        .take(MOST_MEASURED)
    {
        let force = slope.force_percent;
        let open = match left_open(slope) {
            Some([_, open]) => format!(
                "known to {}, which leaves the force open by {open} %; ",
                known_to(slope)
            ),
            None => String::new(),
        };
        let what = format!("{open}{force:+.2} % of force per {}", slope.per);
        blocks.push(row(slope.parameter, what));
    }
    blocks.push(heading("Assumptions"));
    blocks.push(row("rig", parameters(rig, pick)));
    blocks.push(row("uncertainty", uncertainty(pick)));
    blocks.push(row(
        "made by",
        format!(
            "host-sim {}, from the model alone: no result of this program has been compared with a measurement",
            env!("CARGO_PKG_VERSION")
        ),
    ));
    blocks.push(row("command", made.command.clone()));
    blocks.push(row("date and name", "_".repeat(40)));
    blocks
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
@media print{body{font-size:9.5pt;padding:0}}";

/// A page that needs no other file.
fn html(title: &str, blocks: &[Block], made: &MadeFrom) -> Result<String, PictureError> {
    let mut out = format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n\
         <title>{0}</title>\n<style>{STYLE}</style></head><body>\n<h1>{0}</h1>\n",
        escaped(title)
    );
    let mut listing = false;
    for block in blocks {
        let row = matches!(block, Block::Row(..));
        if row != listing {
            out += if row { "<dl>\n" } else { "</dl>\n" };
            listing = row;
        }
        // Writing to a string cannot fail.
        let _ = match block {
            Block::Heading(text) => writeln!(out, "<h2>{}</h2>", escaped(text)),
            Block::Paragraph(text) => writeln!(out, "<p>{}</p>", escaped(text)),
            Block::Row(name, text) => {
                writeln!(out, "<dt>{}</dt><dd>{}</dd>", escaped(name), escaped(text))
            }
            Block::Picture(figure) => {
                let svg = into_svg(&render_svg(figure)?, made);
                writeln!(out, "<figure>{svg}</figure>")
            }
        };
    }
    if listing {
        out += "</dl>\n";
    }
    Ok(out + "</body></html>\n")
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}
