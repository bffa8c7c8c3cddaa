//! `host-sim scenarios`.

use super::terminal::print;
use emulator::scenario::{self, BUILTIN};
use files::UserError;
use files::rigfile::nearest;

/// List the built-in scenarios, or print one as a TOML file to start from
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  host-sim scenarios\n  host-sim scenarios field > mine.toml")]
pub struct Args {
    /// The scenario to print as TOML; without it, the built-in ones are listed
    #[arg(value_name = "NAME")]
    name: Option<String>,
}

pub fn run(args: &Args) -> Result<(), UserError> {
    let Some(name) = &args.name else {
        print(&list()?);
        return Ok(());
    };
    let Some((_, text)) = BUILTIN.iter().find(|(known, _)| known == name) else {
        let hint = nearest(name, BUILTIN.iter().map(|(known, _)| *known));
        return Err(UserError::new(format!(
            "no built-in scenario is called '{name}'{hint}; `host-sim scenarios` lists them"
        )));
    };
    print(text);
    Ok(())
}

fn list() -> Result<String, UserError> {
    let wide = BUILTIN
        .iter()
        .map(|(name, _)| name.len())
        .max()
        .unwrap_or(0);
    let mut text = format!("{:<wide$}  rig time  what\n", "name");
    for (name, toml) in BUILTIN {
        let scenario = scenario::parse(name, toml, name)?;
        text += &format!(
            "{name:<wide$} {:>7} s  {}\n",
            scenario.duration_s, scenario.description
        );
    }
    Ok(
        text + "\n`host-sim emulate NAME` runs one, `host-sim scenarios NAME` prints it as a TOML file to start from.\n"
    )
}
