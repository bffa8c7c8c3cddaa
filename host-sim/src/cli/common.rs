//! Options every command has.

use std::path::{Path, PathBuf};

use clap::ValueEnum;

use super::emit::check_format;
use files::UserError;
use numerics::engine::{Engine, Method, Plan, Precision, Setting, Start};

use files::rigfile;
use numerics::NamedRig;
use shared::model::params::RigParams;

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum EngineName {
    /// Event-located reference, f64
    Event,
    /// The microcontroller's switch model, corrected stepper, fixed tick
    Switch,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PrecisionName {
    F32,
    F64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum StepperName {
    /// The step is split where the switch falls
    Corrected,
    /// The chapter's band and nothing else
    Banded,
    /// Arctangents in place of the switch
    Smoothed,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// For a person, with a small chart
    Text,
    /// For a program
    Json,
    /// For a spreadsheet
    Csv,
    /// For large tables: columns with their types, packed
    Parquet,
}

#[derive(Clone, Debug, clap::Args)]
pub struct Common {
    /// A preset (wires, beam-170, beam-150, beam-135) or a rig file
    #[arg(long, value_name = "NAME|FILE.toml", default_value = "wires")]
    pub rig: String,

    /// Override a parameter, unit in the key: mass_kg=0.3 (`host-sim rigs wires` prints the keys)
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,

    /// Clearance at rest, mm; where a command takes several gaps, also FROM:TO:STEP, or the option again
    #[arg(long, value_name = "MM", value_parser = parse_gaps, allow_hyphen_values = true)]
    pub gap: Option<Vec<Gaps>>,

    /// What integrates
    #[arg(long, value_enum, default_value = "event")]
    pub engine: EngineName,

    /// Arithmetic of the switch engine [default: f32]
    #[arg(long, value_enum)]
    pub precision: Option<PrecisionName>,

    /// Tick of the switch engine, microseconds [default: 50]
    #[arg(long, value_name = "US", allow_negative_numbers = true)]
    pub tick_us: Option<f64>,

    /// How the switch engine takes the switch [default: corrected]
    #[arg(long, value_enum)]
    pub stepper: Option<StepperName>,

    /// Width of the banded or smoothed switch in penetration, m [default: 5e-8]
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    pub eta_alpha_m: Option<f64>,

    /// Width of the banded or smoothed switch in force, N [default: 0.01]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub eta_beta_n: Option<f64>,

    /// How to answer on standard output
    #[arg(long, value_enum, default_value = "text")]
    pub format: Format,

    /// Folder for pictures (SVG, PNG) and tables
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,

    /// No progress, no notes on standard error
    #[arg(long)]
    pub quiet: bool,
}

impl Common {
    pub fn rig(&self) -> Result<NamedRig, UserError> {
        self.rig_named(&self.rig)
    }

    /// The rig called `name`, with this command's settings and gap on top.
    pub fn rig_named(&self, name: &str) -> Result<NamedRig, UserError> {
        let mut rig = rigfile::load(name, &self.set)?;
        if let Some(gaps) = self.gaps() {
            let [gap] = gaps[..] else {
                return Err(UserError::new(format!(
                    "--gap gives {} gaps, and this command takes one",
                    gaps.len()
                )));
            };
            rig.params = at_gap(&rig.params, gap, "--gap")?;
        }
        Ok(rig)
    }

    /// The gaps asked for, mm, in the order given; none if the option was left out.
    pub fn gaps(&self) -> Option<Vec<f64>> {
        let gaps = self.gap.as_ref()?;
        Some(gaps.iter().flat_map(|g| g.0.iter().copied()).collect())
    }

    pub fn engine(&self) -> Result<Engine, UserError> {
        if self.engine == EngineName::Event {
            let given = [
                ("--precision", self.precision.is_some()),
                ("--tick-us", self.tick_us.is_some()),
                ("--stepper", self.stepper.is_some()),
                ("--eta-alpha-m", self.eta_alpha_m.is_some()),
                ("--eta-beta-n", self.eta_beta_n.is_some()),
            ];
            return match given.iter().find(|(_, given)| *given) {
                Some((option, _)) => Err(UserError::new(format!(
                    "{option} belongs to the switch engine; add --engine switch or leave it out"
                ))),
                None => Ok(Engine::Event),
            };
        }
        let tick_us = self.tick_us.unwrap_or(50.0);
        if !(0.05..=1000.0).contains(&tick_us) {
            return Err(UserError::new(format!(
                "--tick-us is {tick_us}, must be from 0.05 to 1000 microseconds"
            )));
        }
        let precision = match self.precision {
            Some(PrecisionName::F64) => Precision::F64,
            Some(PrecisionName::F32) | None => Precision::F32,
        };
        if tick_us > 50.0 {
            self.note("note: above 50 microseconds the switch engine is no longer exact (docs/accuracy.md)");
        }
        Ok(Engine::Switch(Setting {
            method: self.method()?,
            precision,
            tick_s: tick_us * 1e-6,
        }))
    }

    fn method(&self) -> Result<Method, UserError> {
        let width = |option: &str, value: Option<f64>, default: f64| {
            let value = value.unwrap_or(default);
            if value > 0.0 && value.is_finite() {
                return Ok(value);
            }
            Err(UserError::new(format!(
                "{option} is {value}, must be a positive number"
            )))
        };
        let alpha = width("--eta-alpha-m", self.eta_alpha_m, 5e-8)?;
        let beta = width("--eta-beta-n", self.eta_beta_n, 0.01)?;
        match self.stepper {
            Some(StepperName::Banded) => Ok(Method::Banded {
                eta_alpha_m: alpha,
                eta_beta_n: beta,
            }),
            Some(StepperName::Smoothed) => Ok(Method::Smoothed {
                epsilon_alpha_m: alpha,
                epsilon_beta_n: beta,
            }),
            _ if self.eta_alpha_m.is_some() || self.eta_beta_n.is_some() => Err(UserError::new(
                "--eta-alpha-m and --eta-beta-n are for --stepper banded or smoothed; the corrected stepper has no band",
            )),
            _ => Ok(Method::Corrected),
        }
    }

    /// Refuses an output folder that cannot be one, and Parquet on a terminal, before any work is done.
    pub fn check_out(&self) -> Result<(), UserError> {
        check_format(self.format, self.out.is_some())?;
        match &self.out {
            Some(dir) => check_out_folder(dir),
            None => Ok(()),
        }
    }

    /// Writes a note for a person on standard error.
    pub fn note(&self, text: &str) {
        if !self.quiet {
            super::say(text);
        }
    }

    /// Writes files into `dir` and says so.
    pub fn write(&self, dir: &Path, contents: &[(String, Vec<u8>)]) -> Result<(), UserError> {
        let paths = files::write::write_all(dir, contents)?;
        let names: Vec<_> = paths.iter().map(|p| p.display().to_string()).collect();
        self.note(&format!("wrote {}", names.join(", ")));
        Ok(())
    }
}

/// Whether `--out` can be a folder to write into.
pub fn check_out_folder(dir: &Path) -> Result<(), UserError> {
    if dir.exists() && !dir.is_dir() {
        return Err(UserError::new(format!(
            "--out {} is a file; choose another folder",
            dir.display()
        )));
    }
    Ok(files::write::check_folder(dir)?)
}

#[derive(Clone, Copy, Debug, clap::Args)]
pub struct Cycles {
    /// Drive cycles in all
    #[arg(long, value_name = "N", default_value_t = 600)]
    pub cycles: u32,

    /// How many of the first are not recorded
    #[arg(long, value_name = "N", default_value_t = 480)]
    pub transient: u32,
}

impl Cycles {
    pub fn plan(self) -> Result<Plan, UserError> {
        if self.transient >= self.cycles {
            return Err(UserError::new(format!(
                "--transient {} leaves nothing of --cycles {} to record; it must be smaller",
                self.transient, self.cycles
            )));
        }
        Ok(Plan {
            cycles: self.cycles,
            transient: self.transient,
        })
    }
}

/// `rest`, `fixed`, or `MM,M_PER_S`.
pub fn parse_start(text: &str) -> Result<Start, String> {
    let wrong = || {
        "write rest, fixed (at rest in the fixed frame), or DISPLACEMENT_MM,VELOCITY_M_PER_S relative to the cart".to_owned()
    };
    match text {
        "rest" => Ok(Start::Rest),
        "fixed" => Ok(Start::FixedFrameRest),
        _ => {
            let (x, v) = text.split_once(',').ok_or_else(wrong)?;
            let number = |t: &str| t.trim().parse::<f64>().ok().filter(|x| x.is_finite());
            let (x, v) = (number(x).ok_or_else(wrong)?, number(v).ok_or_else(wrong)?);
            Ok(Start::Moving(x * 1e-3, v))
        }
    }
}

/// The gaps of one `--gap`, mm.
#[derive(Clone, Debug, PartialEq)]
pub struct Gaps(Vec<f64>);

/// `MM`, or `FROM:TO:STEP`.
fn parse_gaps(text: &str) -> Result<Gaps, String> {
    if text.contains(':') {
        return parse_range(text).map(Gaps);
    }
    let number = text.trim().parse::<f64>();
    let number = number.map_err(|_| "write a number of millimetres, or FROM:TO:STEP".to_owned())?;
    Ok(Gaps(vec![number]))
}

/// `FROM:TO:STEP`, both ends included.
pub fn parse_range(text: &str) -> Result<Vec<f64>, String> {
    const MOST: f64 = 1e6;
    let parts: Vec<_> = text.split(':').map(|t| t.trim().parse::<f64>()).collect();
    let [Ok(from), Ok(to), Ok(step)] = parts.as_slice() else {
        return Err("write FROM:TO:STEP, for example 1.0:3.0:0.01".to_owned());
    };
    let (from, to, step) = (*from, *to, *step);
    if !(from.is_finite() && to.is_finite() && step.is_finite()) {
        return Err("every part must be a finite number".to_owned());
    }
    if from > to {
        return Err(format!("FROM ({from}) is above TO ({to}); swap them"));
    }
    if step <= 0.0 {
        return Err(format!("STEP is {step}, must be positive"));
    }
    let count = ((to - from) / step + 1e-9).floor() + 1.0;
    if count > MOST {
        return Err(format!(
            "that is {count:.0} values, more than {MOST:.0}; use a larger STEP"
        ));
    }
    Ok((0..count as u64).map(|i| from + i as f64 * step).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_include_both_ends_and_a_single_value_is_allowed() {
        assert_eq!(
            parse_range("1:2:0.25").unwrap(),
            [1.0, 1.25, 1.5, 1.75, 2.0]
        );
        assert_eq!(parse_range("1.5:1.5:1").unwrap(), [1.5]);
        assert_eq!(parse_range("0:0.3:0.1").unwrap().len(), 4);
        for bad in [
            "", "1:2", "2:1:0.1", "1:2:0", "1:2:-1", "a:b:c", "1:inf:1", "0:1e9:1",
        ] {
            assert!(parse_range(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn starts_are_read() {
        assert_eq!(parse_start("rest"), Ok(Start::Rest));
        assert_eq!(parse_start("-2.5,0.1"), Ok(Start::Moving(-2.5e-3, 0.1)));
        assert!(parse_start("up").is_err() && parse_start("1,nan").is_err());
    }
}

/// `params` at a gap of `gap_mm`, which the option `option` gives.
///
/// # Errors
/// If any parameter is out of range.
pub fn at_gap(
    params: &RigParams,
    gap_mm: f64,
    option: impl std::fmt::Display,
) -> Result<RigParams, UserError> {
    let there = params.with_gap_mm(gap_mm);
    there.map_err(|error| UserError::from(error).at(option))
}
