//! `host-sim man`: a page for the program and one for each of its commands.

use std::path::PathBuf;

use clap::CommandFactory;
use files::UserError;
use files::write::write_all;

use super::Cli;
use super::arguments::output::replaced;
use super::terminal::say;

/// Write the manual as pages for `man`
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  host-sim man ~/.local/share/man/man1")]
pub struct Args {
    /// The folder for the pages, made if it is not there
    dir: PathBuf,
}

pub fn run(args: &Args) -> Result<(), UserError> {
    let mut command = Cli::command();
    command.build();
    let mut pages = vec![page(command.clone(), "host-sim")?];
    for one in command.get_subcommands() {
        if one.is_hide_set() || one.get_name() == "help" {
            continue;
        }
        let name = format!("host-sim-{}", one.get_name());
        pages.push(page(one.clone(), &name)?);
    }
    let written = write_all(&args.dir, &pages)?;
    say(&format!(
        "wrote {} pages into {}{}",
        written.paths.len(),
        args.dir.display(),
        replaced(written.replaced)
    ));
    Ok(())
}

fn page(command: clap::Command, name: &str) -> Result<(String, Vec<u8>), UserError> {
    let mut text = Vec::new();
    let made = clap_mangen::Man::new(command).render(&mut text);
    made.map_err(|e| UserError::new(format!("cannot make the page {name}: {e}")))?;
    Ok((format!("{name}.1"), text))
}
