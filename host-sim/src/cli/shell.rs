//! `host-sim completions` and `host-sim man`: what a shell and `man` know of the command line.

use std::path::PathBuf;

use clap_complete::Shell;
use files::UserError;
use files::write::write_all;

use super::arguments::output::replaced;
use super::terminal::{print_bytes, say};

#[derive(Debug, clap::Args)]
pub struct CompletionsArgs {
    /// The shell
    shell: Shell,
}

#[derive(Debug, clap::Args)]
pub struct ManArgs {
    /// The folder for the pages, made if it is not there
    dir: PathBuf,
}

/// Prints the completions of `command` for a shell.
pub fn completions(args: &CompletionsArgs, mut command: clap::Command) {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut command, "host-sim", &mut script);
    print_bytes(&script);
}

/// Writes a page for the program and one for each of its commands.
///
/// # Errors
/// If they cannot be written.
pub fn man(args: &ManArgs, mut command: clap::Command) -> Result<(), UserError> {
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
