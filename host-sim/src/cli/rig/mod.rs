//! `host-sim rig new`.

mod answers;
mod ask;
mod describe;

use shared::model::contact::LawKind;
use std::io::{IsTerminal, stderr, stdin};
use std::path::{Path, PathBuf};

use super::arguments::output::note;
use super::pick::measure_first::left_open;
use super::terminal::print;
use crate::own_rig::contact::OwnContact;
use answers::Answers;
use describe::{Described, describe};
use files::words::identify::WordedFit;
use files::{UserError, rigfile};
use numerics::NamedRig;
use numerics::PickLimits;
use numerics::identify::{IdentifiedFit, Misfit, SearchSettings, fit, measure, release_m};
use numerics::pick::pick;
use numerics::uncertainty::Stated;
use shared::model::params::RigParams;

/// Write a rig file from measured weights, lengths and times
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  host-sim rig new mine.toml\n  host-sim rig new mine.toml --support wires --mass 298g --swings 20 --swing-time 10.99s --stroke 1.8mm --cart-mass 5.4kg --surface steel"
)]
pub struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, clap::Subcommand)]
enum Command {
    /// Write a rig file from readings of a scale, a ruler and a stopwatch; on a terminal it asks for them
    New(New),
}

#[derive(Debug, clap::Args)]
struct New {
    /// The rig file to write; an existing one is not replaced
    #[arg(value_name = "FILE.toml")]
    file: PathBuf,

    #[command(flatten)]
    answers: Answers,

    /// No notes on standard error
    #[arg(long)]
    quiet: bool,
}

pub fn run(args: &Args) -> Result<(), UserError> {
    let Command::New(new) = &args.command;
    refuse_to_replace(&new.file)?;
    let mut answers = new.answers.clone();
    if stdin().is_terminal() && stderr().is_terminal() {
        ask::ask(&mut answers, &mut stdin().lock(), &mut stderr().lock())?;
    }
    let mut described = describe(&answers)?;
    if described.contact_open {
        let contact = identified(&answers, &mut described, new.quiet)?;
        let file = answers.drop_test.as_deref().unwrap_or(Path::new(""));
        let source = format!("drop test {}", file.display());
        described.contact(&contact, [&source, &source], [&source, &source]);
    }
    let name = new.file.file_stem().unwrap_or_default().to_string_lossy();
    let text = described.file.text(&name);
    // What is written must be a rig.
    let (params, stated) = rigfile::parse_whole(&text, "rig new")?;
    let rig = NamedRig::new(name.clone(), params);
    files::write::write_new(&new.file, &text)?;
    for line in &described.notes {
        note(new.quiet, line);
    }
    for line in rigfile::doubts(&params) {
        note(false, &line);
    }
    note(new.quiet, &format!("wrote {}", new.file.display()));
    print(&summary(&new.file, &described, &rig, &stated));
    Ok(())
}

fn refuse_to_replace(file: &Path) -> Result<(), UserError> {
    if file.symlink_metadata().is_ok() {
        return Err(UserError::new(format!(
            "{} exists already and is not replaced; choose another name or remove it",
            file.display()
        )));
    }
    Ok(())
}

/// The contact that a drop test shows.
fn identified(
    answers: &Answers,
    described: &mut Described,
    quiet: bool,
) -> Result<OwnContact, UserError> {
    let file = answers.drop_test.as_deref().unwrap_or(Path::new(""));
    let signal = crate::record::read(file, |line| note(quiet, line), |_| ())?;
    let settings = SearchSettings {
        release_m: release_m(answers.release_mm, &signal)?,
        impacts: 6,
        ..SearchSettings::DEFAULT
    };
    let params = without_contact(described)?;
    let measured = measure(&signal, &settings)?;
    let fit = fit(
        &measured,
        &params,
        LawKind::SpringDashpot,
        Misfit::Force,
        &settings,
    )?;
    if fit.refused {
        return Err(UserError::new(format!(
            "{}: a spring-dashpot does not fit this drop test; give --contact-time and --restitution instead",
            file.display()
        )));
    }
    let warnings = WordedFit::from(&fit).warnings;
    let notes = warnings.iter().map(|w| format!("note: drop test: {w}"));
    described.notes.extend(notes);
    let (stiffness, stiffness_percent) = estimate(&fit, "contact_stiffness_n_per_m")?;
    let (damping, damping_percent) = estimate(&fit, "contact_damping_n_s_per_m")?;
    let percent = [stiffness_percent, damping_percent];
    Ok(OwnContact::apart(stiffness, damping, percent))
}

/// The rig so far, with a contact that the search begins from.
fn without_contact(described: &Described) -> Result<RigParams, UserError> {
    let mut file = described.file.clone();
    file.word("contact_law", "spring-dashpot", "");
    file.number("contact_stiffness_n_per_m", 5.5e6, "");
    file.number("contact_damping_n_s_per_m", 1.2e3, "");
    rigfile::parse(&file.text("rig"), "rig new")
}

/// A parameter and its half-width, %. An interval that the data do not bound is one of 80 %.
fn estimate(fit: &IdentifiedFit, key: &str) -> Result<(f64, f64), UserError> {
    let found = fit.parameters.iter().find(|p| p.key == key);
    let found = found.ok_or_else(|| UserError::new(format!("the drop test gives no {key}")))?;
    let off = |end: Option<f64>| end.map_or(80.0, |end| 100.0 * (end / found.value - 1.0).abs());
    Ok((found.value, off(found.low).max(off(found.high))))
}

/// What was written, and what to measure better first.
fn summary(file: &Path, described: &Described, rig: &NamedRig, stated: &Stated) -> String {
    let mut text = String::new();
    for (key, value, source) in described.file.sources() {
        text += &format!("  {key:<29} {value:<16} {source}\n");
    }
    text.push('\n');
    text += &worst_known(rig, stated);
    text + &format!("\nNow: host-sim pick --rig {}\n", file.display())
}

/// What spoils the answer most, by the slopes of the nominal optimum.
fn worst_known(rig: &NamedRig, stated: &Stated) -> String {
    let picked = match pick(rig, None, PickLimits::default(), &()) {
        Ok(picked) => picked,
        Err(error) => return format!("No recommendation yet: {}\n", UserError::from(error)),
    };
    let uncertainty = stated.complete(0, 1, rig.params.cart.recoils());
    let rows = picked.answer.sensitivity.into_iter();
    let contact = &rig.params.contact;
    let rows = rows.map(|row| row.known_to(&uncertainty, contact));
    let mut rows: Vec<_> = rows.collect();
    rows.retain(|row| row.force_over_uncertainty_percent.is_some());
    let by = |row: &numerics::pick::sensitivity::Sensitivity| {
        row.force_over_uncertainty_percent.unwrap_or(0.0)
    };
    rows.sort_by(|a, b| by(b).total_cmp(&by(a)));
    let mut text = String::from(
        "What to measure better first (the uncertainty of force and frequency that each causes, to first order)\n",
    );
    for row in &rows {
        if let Some([frequency, force]) = left_open(row) {
            text += &format!(
                "  {:<43} force {force} %, frequency {frequency} %\n",
                row.parameter
            );
        }
    }
    text
}
