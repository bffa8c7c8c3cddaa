//! `--rig`, `--set` and `--gap`: the rig, its parameters and its clearance.

use std::fmt::Display;

use files::UserError;
use files::rigfile;
use numerics::NamedRig;
use shared::model::params::RigParams;

use super::choice::CartChoice;
use super::range::parse_range;

/// A rig without a choice of gap.
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "Rig")]
pub struct RigName {
    /// A preset (wires, beam-170, beam-150, beam-135) or a rig file
    #[arg(long, value_name = "NAME|FILE.toml", default_value = "wires")]
    rig: String,

    /// Change a parameter, unit in the key: mass_kg=0.3 (`host-sim rigs wires` prints the keys)
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
}

impl RigName {
    /// The preset's name or the file's path.
    pub fn name(&self) -> &str {
        &self.rig
    }

    /// The rig with its overrides.
    ///
    /// # Errors
    /// If the rig or an override cannot be used.
    pub fn load(&self) -> Result<NamedRig, UserError> {
        self.load_named(&self.rig)
    }

    /// The rig `name` with the same overrides.
    ///
    /// # Errors
    /// If the rig or an override cannot be used.
    pub fn load_named(&self, name: &str) -> Result<NamedRig, UserError> {
        self.load_with(name, &[])
    }

    /// The rig `name` with the same overrides, and `settings` on top.
    ///
    /// # Errors
    /// If the rig, an override or a setting cannot be used.
    pub fn load_with(&self, name: &str, settings: &[String]) -> Result<NamedRig, UserError> {
        once(&self.set).map_err(|error| error.at("--set"))?;
        once(settings)?;
        rigfile::load(name, &[&self.set, settings].concat())
    }

    /// Whether an override sets the parameter `key`.
    pub fn overrides(&self, key: &str) -> bool {
        let keys = self.set.iter().filter_map(|set| set.split('=').next());
        keys.map(str::trim).any(|set| set == key)
    }

    /// This rig at the gap `gap_mm`; None: its own.
    pub fn at(&self, gap_mm: Option<f64>) -> RigArgs {
        RigArgs {
            name: self.clone(),
            gap: gap_mm,
        }
    }

    /// Refuses an override of the gap where `--gap` is there, too.
    ///
    /// # Errors
    /// If there is one.
    pub fn check_gap(&self) -> Result<(), UserError> {
        if self.overrides("gap_mm") {
            return Err(UserError::new(
                "--gap and --set gap_mm both set the gap; leave one of them out",
            ));
        }
        Ok(())
    }
}

/// Refuses settings of which two set the same parameter.
fn once(settings: &[String]) -> Result<(), UserError> {
    let key = |setting: &String| {
        setting
            .split('=')
            .next()
            .unwrap_or_default()
            .trim()
            .to_owned()
    };
    let keys: Vec<String> = settings.iter().map(key).collect();
    match (1..keys.len()).find(|i| keys[..*i].contains(&keys[*i])) {
        Some(i) => Err(UserError::new(format!(
            "{} is given twice; leave one of the two out",
            keys[i]
        ))),
        None => Ok(()),
    }
}

/// A rig at one gap.
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "Rig")]
pub struct RigArgs {
    #[command(flatten)]
    pub name: RigName,

    /// Clearance at rest, mm [default: the rig's]
    #[arg(long, value_name = "MM", value_parser = parse_gap, allow_hyphen_values = true)]
    gap: Option<f64>,
}

impl RigArgs {
    /// The rig.
    ///
    /// # Errors
    /// If the rig, an override or the gap cannot be used.
    pub fn load(&self) -> Result<NamedRig, UserError> {
        self.load_with(self.name.name(), &[])
    }

    /// The rig `name` with the same overrides and gap, and `settings` on top.
    ///
    /// # Errors
    /// If the rig, an override, a setting or the gap cannot be used.
    pub fn load_with(&self, name: &str, settings: &[String]) -> Result<NamedRig, UserError> {
        let mut rig = self.name.load_with(name, settings)?;
        let gap_set = settings
            .iter()
            .any(|setting| setting.trim_start().starts_with("gap_mm"));
        if gap_set {
            return Ok(rig);
        }
        if let Some(gap_mm) = self.gap {
            self.name.check_gap()?;
            rig.params = at_gap(&rig.params, gap_mm, "--gap")?;
        }
        Ok(rig)
    }

    /// Whether the command line sets the gap.
    pub fn sets_gap(&self) -> bool {
        self.gap.is_some() || self.name.overrides("gap_mm")
    }

    /// Whether `--gap` is there.
    pub fn has_gap_option(&self) -> bool {
        self.gap.is_some()
    }
}

/// How the cart is moved.
#[derive(Clone, Copy, Debug, clap::Args)]
#[command(next_help_heading = "Rig")]
pub struct CartArg {
    /// Motion of the cart [default: recoil where the rig's shaker is known, else prescribed]
    #[arg(long, value_enum)]
    cart: Option<CartChoice>,
}

impl CartArg {
    /// `rig` with its cart moved as asked for; without that, as the machine's: recoiling where its shaker is known.
    ///
    /// # Errors
    /// If it should recoil and its shaker is not known.
    pub fn apply(&self, rig: NamedRig) -> Result<NamedRig, UserError> {
        match self.cart {
            None => Ok(rig.recoiling().unwrap_or(rig)),
            Some(CartChoice::Prescribed) => Ok(rig.prescribed()),
            Some(CartChoice::Recoil) => rig.recoiling().ok_or_else(|| {
                UserError::new(format!(
                    "--cart recoil: the shaker of rig {} is not known; give shaker_loop_hz in its file or with --set",
                    rig.name
                ))
            }),
        }
    }
}

/// A rig at one gap or several.
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "Rig")]
pub struct RigAtGaps {
    #[command(flatten)]
    pub name: RigName,

    /// Clearances at rest, mm: one, or FROM:TO:STEP; may be given several times
    #[arg(long = "gap", alias = "gaps", value_name = "MM", value_parser = parse_gaps, allow_hyphen_values = true)]
    gaps: Vec<Gaps>,
}

impl RigAtGaps {
    /// The gaps asked for, mm, in the order given; none if the option was left out.
    ///
    /// # Errors
    /// If an override says the gap, too.
    pub fn gaps_mm(&self) -> Result<Option<Vec<f64>>, UserError> {
        if self.gaps.is_empty() {
            return Ok(None);
        }
        self.name.check_gap()?;
        Ok(Some(self.gaps.iter().flat_map(|g| g.0.clone()).collect()))
    }

    /// The gaps asked for, mm, in the order given; none if the option was left out, or given once with one number.
    ///
    /// # Errors
    /// As [`RigAtGaps::gaps_mm`].
    pub fn several_mm(&self) -> Result<Option<Vec<f64>>, UserError> {
        let one = matches!(self.gaps.as_slice(), [Gaps(_, Form::One)]);
        if one { Ok(None) } else { self.gaps_mm() }
    }

    /// The rig at the gap given, where it is one.
    pub fn at_one(&self) -> RigArgs {
        let first = self.gaps.first().and_then(|g| g.0.first());
        self.name.at(first.copied())
    }
}

/// `params` at a gap of `gap_mm`, which `option` gives.
///
/// # Errors
/// If the gap is out of range.
pub fn at_gap(
    params: &RigParams,
    gap_mm: f64,
    option: impl Display,
) -> Result<RigParams, UserError> {
    let there = params.with_gap_mm(gap_mm);
    there.map_err(|error| UserError::from(error).at(option))
}

/// The gaps of one `--gap`, mm.
#[derive(Clone, Debug, PartialEq)]
struct Gaps(Vec<f64>, Form);

/// How they were written.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Form {
    One,
    Range,
}

/// Reads one gap, mm.
///
/// # Errors
/// In words: it is no number.
pub fn parse_gap(text: &str) -> Result<f64, String> {
    let number = text.trim().parse();
    number.map_err(|_| "write a number of millimetres; this command takes one gap".to_owned())
}

fn parse_gaps(text: &str) -> Result<Gaps, String> {
    if text.contains(':') {
        return parse_range(text).map(|gaps| Gaps(gaps, Form::Range));
    }
    let number = text.trim().parse();
    let number = number.map_err(|_| "write a number of millimetres, or FROM:TO:STEP".to_owned())?;
    Ok(Gaps(vec![number], Form::One))
}
