//! `--cycles`, `--transient` and `--initial`: how long to simulate and where to start.

use files::UserError;
use numerics::engine::{Plan, Start};

use super::range::parse_finite;

/// How many drive cycles are simulated and recorded.
#[derive(Clone, Copy, Debug, clap::Args)]
pub struct CycleArgs {
    /// Drive cycles in all
    #[arg(long, value_name = "N", default_value_t = 600)]
    cycles: u32,

    /// Drive cycles at the beginning that are not recorded [default: 480, of fewer than 600 cycles four fifths]
    #[arg(long, value_name = "N")]
    transient: Option<u32>,
}

impl CycleArgs {
    /// The plan of the simulation.
    ///
    /// # Errors
    /// If no cycle is left to record.
    pub fn plan(self) -> Result<Plan, UserError> {
        let cycles = self.cycles;
        let usual = (cycles - cycles.div_ceil(5)).min(480);
        let transient = self.transient.unwrap_or(usual);
        Ok(Plan::new(cycles, transient)?)
    }
}

/// How many of the last of `cycles` are recorded where that is left open: 100, of fewer than 200 half.
pub fn usual_recorded(cycles: u32) -> u32 {
    (cycles / 2).clamp(1, 100)
}

/// Reads `rest`, `fixed`, or `MM,M_PER_S`.
pub fn parse_start(text: &str) -> Result<Start, String> {
    let moving = || {
        let (displacement_mm, velocity) = text.split_once(',')?;
        let whole = |text: &str| {
            text.trim_start_matches('-')
                .bytes()
                .all(|b| b.is_ascii_digit())
        };
        if whole(displacement_mm) && whole(velocity) && velocity != "0" {
            return None;
        }
        let displacement_m = parse_finite(displacement_mm)? * 1e-3;
        Some(Start::Moving(displacement_m, parse_finite(velocity)?))
    };
    match text {
        "rest" => Ok(Start::Rest),
        "fixed" => Ok(Start::FixedFrameRest),
        _ => moving().ok_or_else(|| {
            "write rest, fixed (at rest in the fixed frame), or DISPLACEMENT_MM,VELOCITY_M_PER_S relative to the cart, with decimal points: -2.5,0.1 or 2.0,1.0".to_owned()
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn starts_are_read() {
        assert_eq!(parse_start("rest"), Ok(Start::Rest));
        assert_eq!(parse_start("-2.5,0.1"), Ok(Start::Moving(-2.5e-3, 0.1)));
        assert!(parse_start("-2,5").is_err(), "-2.5 mm or 5 m/s");
        assert_eq!(parse_start("80,0"), Ok(Start::Moving(80e-3, 0.0)));
        assert!(parse_start("up").is_err() && parse_start("1,nan").is_err());
    }
}
