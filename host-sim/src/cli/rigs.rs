//! `host-sim rigs`.

use shared::model::contact::Law;
use shared::model::params::{PRESETS, RigParams, SupportParams};

use super::terminal::{print, say};
use files::UserError;
use files::rigfile;

/// List the rigs, or print one as a TOML file to start from
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  host-sim rigs\n  host-sim rigs wires > mine.toml")]
pub struct Args {
    /// The rig to print as TOML; without it, the presets are listed
    #[arg(value_name = "NAME|FILE.toml")]
    name: Option<String>,
}

pub fn run(args: &Args) -> Result<(), UserError> {
    let text = match &args.name {
        Some(name) => {
            let rig = rigfile::load(name, &[])?;
            rigfile::doubts(&rig.params)
                .iter()
                .for_each(|line| say(line));
            rigfile::to_toml(&rig)
        }
        None => {
            let mut text = String::from("rig       natural frequency  hangs on\n");
            for (name, params) in PRESETS {
                let hz = params.natural_frequency_hz();
                text.push_str(&format!("{name:<9} {hz:>14.2} Hz  {}\n", describe(&params)));
            }
            text + "\n`host-sim rigs NAME` prints one as a TOML file to start from.\n"
        }
    };
    print(&text);
    Ok(())
}

fn describe(params: &RigParams) -> String {
    let on = match params.support {
        SupportParams::Wires { length_m, .. } => format!("wires of {:.0} mm", length_m * 1e3),
        SupportParams::Beams { damping_ratio, .. } => {
            format!("beam springs, damping ratio {damping_ratio}")
        }
    };
    let contact = match params.contact {
        Law::SpringDashpot { .. } => "spring-dashpot contact",
        _ => "nonlinear contact",
    };
    format!("{on}; hammer {} kg; {contact}", params.mass_kg)
}
