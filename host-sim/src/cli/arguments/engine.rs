//! `--engine` and the options of the switch engine.

use clap::ValueEnum;

use files::UserError;
use files::range::positive;
use numerics::engine::{Engine, Method, Precision, Setting};

use super::output::OutputArgs;

/// The longest tick at which the switch engine meets its accuracy, microseconds; the default.
const USUAL_TICK_US: f64 = 50.0;

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum EngineName {
    /// The reference, f64, with located events; in map, basins and bifurcation the fast engine, which runs many motions at
    /// once
    Event,
    /// The microcontroller's switch model, corrected stepper, fixed tick; with --cart prescribed only
    Switch,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum PrecisionName {
    F32,
    F64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum StepperName {
    /// The step is split at the instant of the switch
    Corrected,
    /// The chapter's band, without correction
    Banded,
    /// Arctangents in place of the switch
    Smoothed,
}

/// What integrates the equations of motion.
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "Engine")]
pub struct EngineArgs {
    /// What integrates the equations of motion
    #[arg(long, value_enum, default_value = "event")]
    engine: EngineName,

    /// Arithmetic of the switch engine [default: f32]
    #[arg(long, value_enum)]
    precision: Option<PrecisionName>,

    /// Tick of the switch engine, microseconds [default: 50]
    #[arg(long, value_name = "US")]
    tick_us: Option<f64>,

    /// Treatment of the switch in the switch engine [default: corrected]
    #[arg(long, value_enum)]
    stepper: Option<StepperName>,

    /// Width of the banded or smoothed switch in penetration, m [default: 5e-8]
    #[arg(long, value_name = "M")]
    eta_alpha_m: Option<f64>,

    /// Width of the banded or smoothed switch in force, N [default: 0.01]
    #[arg(long, value_name = "N")]
    eta_beta_n: Option<f64>,
}

impl EngineArgs {
    /// The engine asked for; notes go to `output`.
    ///
    /// # Errors
    /// If an option does not go with the engine or is out of range.
    pub fn engine(&self, output: &OutputArgs) -> Result<Engine, UserError> {
        if self.engine == EngineName::Event {
            self.refuse_switch_options()?;
            return Ok(Engine::Event);
        }
        let tick_us = self.tick_us.unwrap_or(USUAL_TICK_US);
        if !(0.05..=1000.0).contains(&tick_us) {
            return Err(UserError::new(format!(
                "--tick-us is {tick_us}, must be from 0.05 to 1000 microseconds"
            )));
        }
        let precision = match self.precision {
            Some(PrecisionName::F64) => Precision::F64,
            Some(PrecisionName::F32) | None => Precision::F32,
        };
        if tick_us > USUAL_TICK_US {
            output.note("note: above 50 microseconds the switch engine is no longer exact (docs/accuracy.md)");
        }
        Ok(Engine::Switch(Setting {
            method: self.method()?,
            precision,
            tick_s: tick_us * 1e-6,
        }))
    }

    fn refuse_switch_options(&self) -> Result<(), UserError> {
        let given = [
            ("--precision", self.precision.is_some()),
            ("--tick-us", self.tick_us.is_some()),
            ("--stepper", self.stepper.is_some()),
            ("--eta-alpha-m", self.eta_alpha_m.is_some()),
            ("--eta-beta-n", self.eta_beta_n.is_some()),
        ];
        match given.iter().find(|(_, given)| *given) {
            Some((option, _)) => Err(UserError::new(format!(
                "{option} belongs to the switch engine; add --engine switch or leave it out"
            ))),
            None => Ok(()),
        }
    }

    fn method(&self) -> Result<Method, UserError> {
        let alpha = positive("--eta-alpha-m", self.eta_alpha_m.unwrap_or(5e-8))?;
        let beta = positive("--eta-beta-n", self.eta_beta_n.unwrap_or(0.01))?;
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
}
