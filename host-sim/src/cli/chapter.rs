//! `host-sim chapter`.

use super::arguments::output::OutputArgs;
use crate::chapter::{AREAS, ChapterVerdict, Statement, statements};
use crate::figures::Effort;
use crate::progress::ProgressLine;
use files::UserError;
use numerics::NamedRig;

/// Compare the chapter statement by statement: its words, the result computed here, same or different
#[derive(Debug, clap::Args)]
#[command(
    after_help = "On two cores it takes half a minute, with --coarse a quarter of that.\n\nExamples:\n  host-sim chapter\n  host-sim chapter --coarse --format csv > chapter.csv"
)]
pub struct Args {
    /// Coarser grids: the same verdicts in a few seconds, with rougher figures
    #[arg(long)]
    coarse: bool,

    #[command(flatten)]
    pub output: OutputArgs,
}

pub fn run(args: &Args) -> Result<(), UserError> {
    let rigs = NamedRig::presets();
    let name = match args.coarse {
        true => "chapter-coarse",
        false => "chapter",
    };
    let output = &args.output.named(name.to_owned(), &rigs)?;
    let effort = match args.coarse {
        true => Effort::Coarse,
        false => Effort::Full,
    };
    let progress = ProgressLine::new("areas", AREAS, output.quiet);
    let hidden = ProgressLine::new("areas", AREAS, true);
    let all = statements(effort, &hidden)?;
    progress.inc(AREAS);
    progress.finish();
    let page = || Ok(vec![(output.name(".md"), text(&all).into_bytes())]);
    output.answer(&all, &all, page, || text(&all))
}

/// The page as Markdown.
fn text(all: &[Statement]) -> String {
    let of = |verdict| all.iter().filter(|s| s.verdict == verdict).count();
    let mut text = format!(
        "# What the chapter says, and what is computed here

The statements of the chapter *Study of an embarked vibro-impact system: mathematical modeling and nonlinear
analysis* about its model, its figures and its measurements. This command computes every result with the
chapter's cart and writes this page (`out/chapter.md`, with CSV and JSON):

    host-sim chapter

\"Same\": the words hold, to the digits that the chapter gives.
\"Cannot be told\": the statement needs the chapter's measurements, which are not public, or has no figure.

{} statements: {} same, {} differ, {} cannot be told.

| | section | the chapter | computed here | verdict |
|---|---|---|---|---|
",
        all.len(),
        of(ChapterVerdict::Same),
        of(ChapterVerdict::Differs),
        of(ChapterVerdict::CannotBeTold)
    );
    for s in all {
        text += &format!(
            "| {} | {} | {} | {} | {} |\n",
            s.number,
            s.section,
            s.words,
            s.ours.replace('|', "\\|"),
            s.verdict.words()
        );
    }
    text
}
