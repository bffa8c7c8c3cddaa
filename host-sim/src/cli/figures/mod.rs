//! `host-sim figures`.

mod html;
mod record;

use std::path::{Path, PathBuf};
use std::time::Instant;

use super::arguments::output::{check_folder, replaced, to_json};
use super::interrupt;
use super::terminal::print;
use crate::chapter::statements;
use crate::figures::{AREAS, DRAWINGS, Effort, FiguresPart, Make};
use files::UserError;
use files::made_from::stamped;

use crate::progress::ProgressLine;
use record::PartRecord;

/// Make every computed figure of the chapter again: pictures, tables and one page
#[derive(Debug, clap::Args)]
#[command(
    after_help = "On two cores all figures take four minutes, with --coarse half a minute.\n\nExamples:\n  host-sim figures --coarse --out out/figures\n  host-sim figures --only 3.24 --out out/figures"
)]
pub struct Args {
    /// Folder for the page (index.html), pictures and tables
    #[arg(long, value_name = "DIR", default_value = "out/figures")]
    out: PathBuf,

    /// Only these figures, separated by commas: 3.24,3.27 (figures that share their runs are made together)
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    only: Vec<String>,

    /// Coarse grids and few cycles: a first look in seconds, with rough numbers
    #[arg(long)]
    coarse: bool,

    /// No progress, no notes on standard error
    #[arg(long)]
    quiet: bool,
}

pub fn run(args: &Args) -> Result<(), UserError> {
    check_folder(&args.out)?;
    let only: Vec<String> = args
        .only
        .iter()
        .map(|name| name.trim().to_owned())
        .collect();
    let wanted = wanted(&only)?;
    if !args.quiet {
        interrupt::say_then(format!(
            "interrupted; the parts that are done are kept in {}: the same command goes on from there",
            args.out.display()
        ));
    }
    let effort = if args.coarse {
        Effort::Coarse
    } else {
        Effort::Full
    };
    refuse_others(&args.out)?;
    let key = record::key(effort)?;
    let (mut text, made) = make_missing(args, effort, &key, wanted)?;
    let records = AREAS
        .iter()
        .map(|part| record::standing(&args.out, part.name, &key));
    let records: Vec<Option<PartRecord>> = records.collect();
    let before = write_index(args, effort, &records)?;
    let there = records.iter().flatten().map(|r| r.pages.len());
    let there: usize = there.sum();
    text += &format!(
        "{there} pages, {made:.1} s in all: {}{}\n",
        args.out.join("index.html").display(),
        replaced(before)
    );
    print(&text);
    Ok(())
}

/// A folder with somebody else's page is no folder of figures.
fn refuse_others(dir: &Path) -> Result<(), UserError> {
    let text = std::fs::read(dir.join("index.json")).unwrap_or_default();
    let index: serde_json::Value = serde_json::from_slice(&text).unwrap_or_default();
    let ours = index["effort"].is_string();
    let page = ["index.html", "index.json"].map(|name| dir.join(name));
    match page.iter().find(|file| file.is_file() && !ours) {
        Some(file) => Err(UserError::new(format!(
            "{} is no page of figures of this program; move it away, or give --out another folder",
            file.display()
        ))),
        None => Ok(()),
    }
}

fn word(effort: Effort) -> &'static str {
    effort.of("full", "coarse")
}

/// Makes the parts that are not in the folder yet. Returns a line for each part, and the seconds spent.
fn make_missing(
    args: &Args,
    effort: Effort,
    key: &str,
    wanted: Vec<&FiguresPart>,
) -> Result<(String, f64), UserError> {
    let made_already = |part: &FiguresPart| record::standing(&args.out, part.name, key).is_some();
    let wanted: Vec<_> = wanted
        .into_iter()
        .map(|part| (part, made_already(part)))
        .collect();
    let missing = wanted.iter().filter(|(_, stands)| !stands);
    let progress = ProgressLine::in_parts(
        "figures",
        missing.map(|(part, _)| part.seconds).sum(),
        args.quiet,
    );
    let (mut text, mut made) = (String::new(), 0.0);
    for (part, stands) in wanted {
        let name = match part.figures {
            [] => part.name.to_owned(),
            figures => format!("{}: {}", part.name, list(figures)),
        };
        let line = if stands {
            format!("{name} already made")
        } else {
            let seconds = make(part, effort, key, args)?;
            made += seconds;
            progress.part_done(part.seconds);
            format!("{name} made in {seconds:.1} s")
        };
        progress.note(&line);
        text += &format!("{line}\n");
    }
    progress.finish();
    Ok((text, made))
}

/// The parts that make what is asked for; all when nothing is.
fn wanted(only: &[String]) -> Result<Vec<&'static FiguresPart>, UserError> {
    for name in only {
        if let Some((_, what)) = DRAWINGS.iter().find(|(figure, _)| figure == name) {
            return Err(UserError::new(format!(
                "--only {name}: figure {name} is {what}; there is nothing to compute"
            )));
        }
        if !AREAS
            .iter()
            .any(|part| part.figures.contains(&name.as_str()))
        {
            let all: Vec<&str> = AREAS
                .iter()
                .flat_map(|part| part.figures)
                .copied()
                .collect();
            return Err(UserError::new(format!(
                "--only: there is no figure '{name}'; choose from {}",
                all.join(", ")
            )));
        }
    }
    let asked = |part: &&FiguresPart| {
        only.is_empty() || only.iter().any(|o| part.figures.contains(&o.as_str()))
    };
    Ok(AREAS.iter().filter(asked).collect())
}

/// Makes a part and writes its files and, last, its record. Returns the seconds it took.
fn make(part: &FiguresPart, effort: Effort, key: &str, args: &Args) -> Result<f64, UserError> {
    let FiguresPart {
        name,
        figures,
        make,
        ..
    } = part;
    let begun = Instant::now();
    let hidden = ProgressLine::new(*name, 1, true);
    let made = match make {
        Make::Pages(make) => make(effort, &hidden).map(|pages| (pages, Vec::new())),
        Make::Statements => statements(effort, &hidden).map(|all| (Vec::new(), all)),
    };
    let (mut pages, statements) = made.map_err(|e| e.at(format!("part '{name}'")))?;
    for page in &mut pages {
        let made = crate::figures::made_from(page.figure, effort);
        for (name, bytes) in &mut page.files {
            *bytes = stamped(name, std::mem::take(bytes), &made);
        }
        if page.command.starts_with("host-sim figures") {
            page.command.clear();
        }
    }
    let seconds = begun.elapsed().as_secs_f64();
    let given: Vec<&str> = pages.iter().map(|p| p.figure).collect();
    if given != *figures {
        return Err(UserError::new(format!(
            "part '{name}' made {} where it promises {}; please report this as a bug",
            given.join(", "),
            figures.join(", ")
        )));
    }
    let all: Vec<(&str, &[u8])> = pages
        .iter()
        .flat_map(|page| &page.files)
        .map(|(name, bytes)| (name.as_str(), bytes.as_slice()))
        .collect();
    files::write::write_all(&args.out, &all)?;
    let record = PartRecord::new((key, effort), name, &pages, statements);
    let text = to_json(&record)?;
    files::write::write(args.out.join(record::file_name(name)), text)?;
    Ok(seconds)
}

/// The page and its table of contents for programs. Returns whether they replaced others.
fn write_index(
    args: &Args,
    effort: Effort,
    records: &[Option<PartRecord>],
) -> Result<bool, UserError> {
    let page = html::page(effort, records);
    let there: Vec<&PartRecord> = records.iter().flatten().collect();
    let missing: Vec<&str> = AREAS
        .iter()
        .zip(records)
        .filter(|(_, record)| record.is_none())
        .flat_map(|(part, _)| part.figures)
        .copied()
        .collect();
    let index = serde_json::json!({
        "effort": word(effort),
        "parts": there,
        "not_made": missing,
        "not_computations": DRAWINGS.map(|(figure, what)| serde_json::json!({"figure": figure, "what": what})),
    });
    let files = [("index.html", page), ("index.json", to_json(&index)?)];
    Ok(files::write::write_all(&args.out, &files)?.replaced)
}

/// Names with commas; the first and the last of many.
fn list(figures: &[&str]) -> String {
    match figures {
        [first, .., last] if figures.len() > 4 => {
            format!("{first} to {last} ({} figures)", figures.len())
        }
        _ => figures.join(", "),
    }
}
