//! `host-sim completions`: what a shell knows of the command line.

use clap::CommandFactory;
use clap_complete::Shell;
use files::UserError;

use super::Cli;
use super::terminal::print_bytes;

/// Print a shell's script that completes commands and options
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  host-sim completions bash > ~/.local/share/bash-completion/completions/host-sim"
)]
pub struct Args {
    /// The shell
    shell: Shell,
}

pub fn run(args: &Args) -> Result<(), UserError> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "host-sim", &mut script);
    print_bytes(&script);
    Ok(())
}
