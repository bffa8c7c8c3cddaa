//! Measures how far the steppers are from the event-located reference and writes `docs/accuracy.md`:
//!
//! `cargo run --release -p host-sim --example accuracy`

mod band;
mod named;
mod outcome;
mod survey;

use std::fmt::Write as _;
use std::path::Path;

use band::ErrorsOverTicks;
use files::UserError;
use named::StepperCell;
use numerics::engine::{Method, Precision, Setting};
use outcome::PeriodsOutcome;
use shared::model::step::{Banded, Corrected};
use shared::model::switch::Band;
use survey::{Compared, ErrorSpread, ReferenceEdge};

const SEED: u64 = 2010;
const POINTS: usize = 200;
const SURVEY_TICKS_US: [f64; 4] = [10.0, 50.0, 100.0, 200.0];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut page = String::from(INTRODUCTION);
    eprintln!("random points");
    page.push_str(&survey_section()?);
    eprintln!("one contact");
    page.push_str(&single_section()?);
    eprintln!("named points");
    page.push_str(&named_section()?);
    eprintln!("the band");
    page.push_str(&band_section()?);
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/accuracy.md");
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder)?;
    }
    std::fs::write(&path, page)?;
    println!("wrote {}", path.display());
    Ok(())
}

const INTRODUCTION: &str = "\
# How accurate the microcontroller's model is

How far is the microcontroller's model from the exact solution, and which stepper and tick should you use?
*`cargo run --release -p host-sim --example accuracy` writes this page.*

The page compares the switch model of `shared`, in `f32` as on the microcontroller or in `f64`, with the event-located reference
([checks.md](checks.md)). A *stepper* is the switch model's treatment of the step in which contact begins or ends: `Corrected`, `Banded` or
`Smoothed` (`--stepper corrected` and so on). The results:

- **Use `Corrected` in `f32`, with a tick of 10 to 50 µs.** It splits the step at the instant of onset or release, so its error is that of
  Runge–Kutta: fourth order in the tick. Below some 20 µs only the rounding of `f32` remains. With nonlinear laws, up to a hundred times
  harder than the presets', the largest force at 50 µs is within 8e-6 of the reference's (27 random rigs;
  `cargo test -p host-sim --test nonlinear`). If a contact is too hard for the tick, the program refuses it and names a short enough tick.
- **At 100 µs** (six steps per contact of 0.57 ms) forces are accurate to about a tenth of a percent. **At 200 µs** they are not: the
  section no longer repeats, and impacts may even die out.
- **`Banded`**, the chapter's band alone, needs a band of 50 nm or less *and* a tick that resolves it (about 0.05 µs). With a longer tick
  the hammer steps over the band. The force error then depends on the instant of the onset within the tick, and periodic motion looks
  aperiodic.
- **`Smoothed`** is for comparison. On a periodic orbit it converges to the switch as its transition narrows, if the tick shrinks with it.
  Its rows compare the law's F at the peak; the force that acts there is smaller by the two arctangent factors.

The switch model rounds the drive frequency to the resolution of its phase accumulator (2⁻³² turns per tick). The reference runs at this
rounded frequency, so both solve the same problem.

";

fn percent(x: f64) -> String {
    let p = 100.0 * x;
    match p.abs() {
        a if a >= 10.0 => format!("{p:+.0}"),
        a if a >= 1.0 => format!("{p:+.1}"),
        a if a >= 0.01 => format!("{p:+.3}"),
        0.0 => "0".to_owned(),
        _ => format!("{p:+.0e}"),
    }
}

fn cell_text(cell: &Option<StepperCell>) -> String {
    match cell {
        None => "lost".to_owned(),
        Some(c) if c.force == -1.0 => "no contact *".to_owned(),
        Some(c) => {
            let mark = if c.same_regime { "" } else { " *" };
            format!("{} ({}){mark}", percent(c.force), percent(c.approach))
        }
    }
}

fn row_text(name: &str, cells: &ErrorsOverTicks) -> String {
    let cells: Vec<_> = cells.iter().map(cell_text).collect();
    format!("| {name} | {} |\n", cells.join(" | "))
}

fn header(first: &str, ticks_us: &[f64]) -> String {
    let ticks: Vec<_> = ticks_us.iter().map(|t| format!("{t} µs")).collect();
    let rule = "|---".repeat(ticks.len() + 1);
    format!("| {first} | {} |\n{rule}|\n", ticks.join(" | "))
}

fn method_name(method: Method, precision: Precision) -> String {
    let precision = match precision {
        Precision::F32 => "f32",
        Precision::F64 => "f64",
    };
    match method {
        Method::Corrected => format!("`Corrected` {precision}"),
        Method::Banded {
            eta_alpha_m,
            eta_beta_n,
        } => format!("`Banded` {precision}, η_α {eta_alpha_m:e} m, η_β {eta_beta_n} N"),
        Method::Smoothed {
            epsilon_alpha_m,
            epsilon_beta_n,
        } => format!("`Smoothed` {precision}, ε_α {epsilon_alpha_m:e} m, ε_β {epsilon_beta_n} N"),
    }
}

fn single_section() -> Result<String, UserError> {
    let mut text = String::from(
        "## One contact\n\nA free mass of 0.298 kg strikes the surface, in `f32`. Each cell has the largest error of the peak contact\n\
         force in percent, and in brackets that of the rebound speed, relative to the closed form, over 100 onsets\n\
         spread over a tick. `Banded` has η_α = 5e-8 m, η_β = 0.01 N.\n\n",
    );
    let ticks_us = &named::TICKS_US;
    text.push_str(&header("stepper", ticks_us));
    let band = Band::new(5e-8, 1e-2);
    let mut corrected = Vec::new();
    let mut banded = Vec::new();
    for tick_us in ticks_us {
        let tick_s = tick_us * 1e-6;
        let say = |(force, rebound): (f64, f64)| {
            format!("{:.1e} ({:.1e})", 100.0 * force, 100.0 * rebound)
        };
        corrected.push(say(band::worst_single(Corrected, tick_s)?));
        banded.push(say(band::worst_single(Banded { band }, tick_s)?));
    }
    for (name, cells) in [("`Corrected`", corrected), ("`Banded`", banded)] {
        let _ = writeln!(text, "| {name} | {} |", cells.join(" | "));
    }
    text.push('\n');
    Ok(text)
}

fn survey_section() -> Result<String, UserError> {
    let points = survey::points(SEED, POINTS)?;
    let mut text = format!(
        "## {POINTS} random periodic points, `Corrected` in `f32`\n\n\
         The points use all four rigs in turn, a random gap from 0 to {} mm and a random frequency ratio from\n\
         {} to {} (both uniform, seed {SEED}). At each point the reference finds, from rest, a regime z = p/n with\n\
         n ≤ 16. Both engines run {} drive periods from rest; the largest forces of the last {} are compared. The\n\
         requirement is {} % at 10 and 50 µs.\n\n\
         Where the engines disagree, the **reference** also runs from {} initial conditions around rest, {:e} m away\n\
         (in displacement and rate/Ω). If one of them changes the regime, or the force by more than the\n\
         requirement, the point lies *on the boundary between two attractors*. No engine can decide such points, so\n\
         they have a table of their own.\n\n",
        survey::GAP_MM,
        survey::RATIOS.start,
        survey::RATIOS.end,
        survey::PLAN.cycles,
        survey::PLAN.cycles - survey::PLAN.transient,
        100.0 * survey::REQUIREMENT,
        survey::NUDGES,
        survey::NUDGE_M,
    );
    text.push_str(
        "| tick | points | median, % | 95 %, % | largest, % | above the requirement | same regime |\n\
         |---|---|---|---|---|---|---|\n",
    );
    let mut apart = String::new();
    for tick_us in SURVEY_TICKS_US {
        let all = survey::compare(&points, Setting::corrected_f32(tick_us * 1e-6))?;
        let (mut plain, mut edge) = (Vec::new(), Vec::new());
        for c in all {
            let off = c.error() > survey::REQUIREMENT || c.seen.regime != c.truth.regime;
            let nudged = if off {
                Some(ReferenceEdge::of(&c)?)
            } else {
                None
            };
            match nudged {
                Some(nudged) if nudged.decides() => edge.push((c, nudged)),
                _ => plain.push(c),
            }
        }
        let spread = ErrorSpread::of(plain.iter().map(Compared::error));
        let same = plain.iter().filter(|c| c.seen.regime == c.truth.regime);
        let p = |x: f64| format!("{:.1e}", 100.0 * x);
        let _ = writeln!(
            text,
            "| {tick_us} µs | {} | {} | {} | {} | {} | {} |",
            plain.len(),
            p(spread.median),
            p(spread.p95),
            p(spread.max),
            spread.above,
            same.count(),
        );
        for (c, nudged) in edge {
            apart.push_str(&edge_text(tick_us, &c, &nudged));
        }
    }
    if !apart.is_empty() {
        text.push_str(
            "\nOn the boundary (regime and largest force):\n\n\
             | tick | rig | gap, mm | ratio | reference from rest | nearby initial conditions that end elsewhere | switch model |\n\
             |---|---|---|---|---|---|---|\n",
        );
        text.push_str(&apart);
    }
    text.push('\n');
    Ok(text)
}

fn edge_text(tick_us: f64, c: &Compared, edge: &ReferenceEdge) -> String {
    let say = |o: &PeriodsOutcome| format!("{}, {:.2} N", o.regime, o.force_n);
    let strayed: Vec<_> = edge.strayed().map(say).collect();
    format!(
        "| {tick_us} µs | {} | {:.4} | {:.4} | {} | {} of {}: {} | {} |\n",
        c.point.rig_name(),
        c.point.gap_mm,
        c.point.ratio,
        say(&edge.rest),
        strayed.len(),
        edge.nudged.len(),
        strayed.join("; "),
        say(&c.seen),
    )
}

fn named_section() -> Result<String, UserError> {
    let mut text = format!(
        "## Named points, every stepper\n\n\
         Each cell has the error of the largest force in percent, and in brackets that of the approach speed of that\n\
         contact. The runs start on the reference's settled orbit; after {} periods the next {} are compared. An\n\
         asterisk means that the regime differs from the reference's.\n\n",
        named::PLAN.transient,
        named::PLAN.cycles - named::PLAN.transient,
    );
    for point in named::POINTS {
        let table = named::table(point)?;
        let _ = writeln!(
            text,
            "### {}, {:.1} mm, ratio {} ({}, force ratio {:.3})\n",
            point.rig, point.gap_mm, point.ratio, table.regime, table.force_ratio
        );
        text.push_str(&header("stepper", &named::TICKS_US));
        for ((method, precision), row) in named::STEPPERS.into_iter().zip(&table.rows) {
            text.push_str(&row_text(&method_name(method, precision), row));
        }
        text.push('\n');
    }
    Ok(text)
}

fn band_section() -> Result<String, UserError> {
    let p = band::POINT;
    let mut text = format!(
        "## How narrow the band must be\n\n\
         {}, {:.1} mm, ratio {}, `f64`, started on the reference's orbit. The cells have the same meaning as\n\
         above. Only the tick of 0.05 µs resolves the band (the hammer travels 1e-8 m in it); the longer ticks step\n\
         over it.\n\nη_α, with η_β = 0.001 N:\n\n",
        p.rig, p.gap_mm, p.ratio
    );
    text.push_str(&header("η_α", &band::TICKS_US));
    for (width, row) in band::by_eta_alpha() {
        text.push_str(&row_text(&format!("{width:e} m"), &row));
    }
    text.push_str(
        "\nOnly the damper acts in the band. Crossing it reduces the speed by 2 η_α ci/m, and a slower hammer is\n\
         trapped.\n\n\
         ## The smoothing method\n\nThe same point; ε_β = 1e7 N/m · ε_α.\n\n",
    );
    text.push_str(&header("ε_α", &band::TICKS_US));
    for (width, row) in band::by_epsilon() {
        text.push_str(&row_text(&format!("{width:e} m"), &row));
    }
    Ok(text)
}
