//! `host-sim emulate`.

use std::path::Path;

use serde::Serialize;
#[cfg(unix)]
use serialport::SerialPort;
use shared::control::BootInfo;
use shared::settings::TICK_RATE_HZ;

use super::arguments::output::{OutputArgs, to_json};
use super::terminal::{print, say};
#[cfg(unix)]
use crate::link::live::{self, Pace};
use crate::pictures::drawn;
use crate::pictures::emulate::{About, Trace, figure};
use crate::progress::ProgressLine;
use emulator::local::Local;
use emulator::log::{Header, Logs};
use emulator::record::{RunObserver, TickRow};
use emulator::run::run as emulate;
use emulator::scenario::{self, BUILTIN, Scenario};
use emulator::timeline::Timeline;
use emulator::verdict::{Verdict, judge};
use files::UserError;
use files::made_from::pair;
use files::read_text;
use files::table::to_csv;
use files::write::{commit_all, stage_all};
use numerics::NamedRig;

/// Duration of a scenario behind a pseudo-terminal, which ends only when it is interrupted: thirty years, s.
#[cfg(unix)]
const ENDLESS_S: f64 = 1e9;

/// Run a scenario: the controller on an emulated rig, with verdict, log and picture
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Examples:\n  host-sim emulate\n  host-sim emulate field --out out")]
pub struct Args {
    /// A built-in scenario (`host-sim scenarios` lists them) or a scenario file
    #[arg(value_name = "NAME|FILE.toml", conflicts_with = "scenario")]
    name: Option<String>,

    /// The scenario as an option [default: field]
    #[arg(long, value_name = "NAME|FILE.toml")]
    scenario: Option<String>,

    /// Write no log, only picture, verdict and timeline
    #[arg(long)]
    no_log: bool,

    /// Run behind a pseudo-terminal for `host-sim link`, in real time, until interrupted, with the scenario's rig and
    /// settings; commands come over the link only
    #[cfg(unix)]
    #[arg(long, conflicts_with_all = ["out", "format"])]
    pty: bool,

    /// With --pty: how many times faster than real time (above 8, `link start --manual` does not keep up)
    #[cfg(unix)]
    #[arg(long, value_name = "N", default_value_t = 1.0, requires = "pty")]
    speed: f64,

    #[command(flatten)]
    pub output: OutputArgs,
}

pub fn run(args: &Args) -> Result<i32, UserError> {
    let name = args.name.as_ref().or(args.scenario.as_ref());
    let name = name.map_or("field", String::as_str);
    let scenario = scenario::load(name)?;
    #[cfg(unix)]
    if args.pty {
        return at_a_terminal(args, scenario);
    }
    let rig = NamedRig::new("true rig", scenario.true_rig);
    let output = &args.output.named(file_name(&scenario), [&rig])?;
    let mut control = Local::new(&scenario.settings)?;
    let mut watch = Watch::new(args, output, &scenario, name)?;
    let tally = emulate(&scenario, &mut control, &mut watch.observer(&mut ()))?;
    watch.seconds.progress.finish();
    let verdict = judge(&scenario, &tally);
    if let Some(dir) = &output.out {
        write(output, dir, &scenario, &verdict, &mut watch)?;
    }
    output.emit(&verdict, &lines(&watch.timeline), || {
        text(&scenario, &watch.timeline, &verdict)
    })?;
    Ok(i32::from(!passed(&verdict)))
}

/// Offers the emulated board at a pseudo-terminal, at `--speed` times real time, until interrupted.
#[cfg(unix)]
fn at_a_terminal(args: &Args, mut scenario: Scenario) -> Result<i32, UserError> {
    if !(0.01..=1e6).contains(&args.speed) {
        return Err(UserError::new(format!(
            "--speed is {:?}, must be a number from 0.01 to 1000000",
            args.speed
        )));
    }
    scenario.events.clear();
    scenario.duration_s = ENDLESS_S;
    let block_ticks = u8::try_from(scenario.block_ticks).unwrap_or(u8::MAX);
    let (mut control, far_end) = live::board(&scenario.settings, block_ticks)?;
    print(&format!("{}\n", far_end.name().unwrap_or_default()));
    emulate(&scenario, &mut control, &mut Pace::new(args.speed))?;
    Ok(0)
}

/// What is recorded of the run.
struct Watch {
    timeline: Timeline,
    trace: Trace,
    logs: Option<Logs>,
    seconds: Seconds,
}

impl Watch {
    fn new(
        args: &Args,
        output: &OutputArgs,
        scenario: &Scenario,
        name: &str,
    ) -> Result<Self, UserError> {
        let logs = match &output.out {
            Some(dir) if !args.no_log => {
                let header = Header {
                    source: "emulator".into(),
                    settings: scenario.settings,
                    birth: BootInfo::STORED,
                    block_ticks: u32::try_from(scenario.block_ticks).unwrap_or(u32::MAX),
                    scenario: Some(scenario_text(name)?),
                    made_from: Some(pair(output.made_from()).1),
                };
                Some(Logs::create(dir, &file_name(scenario), &header)?)
            }
            _ => None,
        };
        let seconds = scenario.duration_s as u64;
        let progress = ProgressLine::new("s of rig time", seconds, output.quiet);
        Ok(Self {
            timeline: Timeline::default(),
            trace: Trace::default(),
            logs,
            seconds: Seconds { progress, ticks: 0 },
        })
    }

    /// All of it, with `unlogged` in place of a log where there is none.
    fn observer<'a>(&'a mut self, unlogged: &'a mut ()) -> impl RunObserver {
        let logs: &mut dyn RunObserver = match &mut self.logs {
            Some(logs) => logs,
            None => unlogged,
        };
        let drawn = (&mut self.timeline, &mut self.trace);
        (drawn, (logs, &mut self.seconds))
    }
}

/// The rig time that has passed, on the line of progress.
struct Seconds {
    progress: ProgressLine,
    ticks: u64,
}

impl RunObserver for Seconds {
    fn tick(&mut self, _: &TickRow) {
        self.ticks += 1;
        if self.ticks.is_multiple_of(u64::from(TICK_RATE_HZ)) {
            self.progress.inc(1);
        }
    }
}

fn scenario_text(name: &str) -> Result<String, UserError> {
    if let Some((_, text)) = BUILTIN.iter().find(|(known, _)| *known == name) {
        return Ok((*text).to_owned());
    }
    read_text(name.as_ref())
}

/// The scenario's name as a file's.
fn file_name(scenario: &Scenario) -> String {
    let plain = |c: char| {
        if c.is_alphanumeric() || c == '-' || c == '_' {
            c
        } else {
            '-'
        }
    };
    let name: String = scenario.name.chars().map(plain).collect();
    if name.is_empty() { "run".into() } else { name }
}

fn write(
    output: &OutputArgs,
    dir: &Path,
    scenario: &Scenario,
    verdict: &Verdict,
    watch: &mut Watch,
) -> Result<(), UserError> {
    let name = output.name("");
    // A picture that cannot be drawn must not cost the verdict.
    let mut contents = match drawn(&name, &figure(&watch.trace, &about(scenario, verdict))) {
        Ok(pictures) => pictures,
        Err(why) => {
            say(&format!("no picture of this run: {why}"));
            Vec::new()
        }
    };
    let no_picture = contents.is_empty();
    contents.push((format!("{name}.json"), to_json(verdict)?.into_bytes()));
    contents.push((
        format!("{name}-timeline.csv"),
        to_csv(&lines(&watch.timeline)),
    ));
    let mut staged = match watch.logs.take() {
        Some(logs) => logs.close()?,
        None => Vec::new(),
    };
    staged.extend(stage_all(dir, &output.stamped(contents)?)?);
    let written = commit_all(staged)?;
    if no_picture {
        // Nor may an older run's stand beside it.
        for kind in ["svg", "png"] {
            let _ = std::fs::remove_file(dir.join(format!("{name}.{kind}")));
        }
    }
    output.note_written(&written);
    Ok(())
}

fn passed(verdict: &Verdict) -> bool {
    verdict.verdict == "pass"
}

fn about(scenario: &Scenario, verdict: &Verdict) -> About {
    let weight_n = scenario.true_rig.weight_n();
    let best = verdict
        .optimum_frequency_hz
        .zip(verdict.optimum_force_ratio);
    About {
        title: title(verdict),
        subtitle: scenario.description.clone(),
        weight_n,
        optimum: best.map(|(hz, ratio)| (hz, ratio * weight_n)),
    }
}

fn title(verdict: &Verdict) -> String {
    let outcome = if passed(verdict) {
        "as expected"
    } else {
        "NOT as expected"
    };
    let share = verdict.force_share.map_or(String::new(), |share| {
        format!(", held {:.1} % of the optimum's force", 100.0 * share)
    });
    format!(
        "Emulated run {}: {outcome}; ends in {}{share}",
        verdict.scenario, verdict.final_state
    )
}

/// A line of the timeline.
#[derive(Serialize)]
struct Line {
    time_s: f64,
    tick: u64,
    what: String,
}

fn lines(timeline: &Timeline) -> Vec<Line> {
    let lines = timeline.events.iter().map(|event| Line {
        time_s: event.time_s,
        tick: event.tick,
        what: event.what.to_string(),
    });
    lines.collect()
}

fn text(scenario: &Scenario, timeline: &Timeline, verdict: &Verdict) -> String {
    let lines = verdict_lines(verdict);
    let colon = if scenario.description.is_empty() {
        ""
    } else {
        ": "
    };
    let (name, what) = (&scenario.name, &scenario.description);
    format!("{name}{colon}{what}\n\n{timeline}\n{lines}")
}

/// The verdict for a person.
fn verdict_lines(verdict: &Verdict) -> String {
    let number = |value: Option<f64>, digits: usize, unit: &str| {
        value.map_or("none".to_owned(), |value| format!("{value:.digits$}{unit}"))
    };
    let mut text = format!("verdict        {}\n", verdict.verdict);
    for why in &verdict.why {
        text += &format!("               {why}\n");
    }
    text += &format!("final state    {}\n", verdict.final_state);
    text += &format!(
        "time to hold   {}\n",
        number(verdict.time_to_hold_s, 1, " s after the start")
    );
    text += &format!(
        "frequency      {} in hold; optimum of the true rig {}\n",
        number(verdict.frequency_hz, 4, " Hz"),
        number(verdict.optimum_frequency_hz, 4, " Hz")
    );
    text += &format!(
        "force          {} times the weight from hold on; optimum {}\n",
        number(verdict.force_ratio_mean, 2, ""),
        number(verdict.optimum_force_ratio, 2, "")
    );
    text += &format!(
        "force share    {} from hold on, {} from the start on\n",
        number(verdict.force_share.map(|share| 100.0 * share), 2, " %"),
        number(verdict.share_from_start.map(|share| 100.0 * share), 2, " %")
    );
    text += &format!(
        "largest        force {:.1} N, cart {:.3} mm; longest drive during a fault {:.4} s\n",
        verdict.largest_force_n, verdict.largest_cart_mm, verdict.driven_with_fault_s
    );
    if verdict.faults.is_empty() {
        text += "faults         none\n";
    }
    for fault in &verdict.faults {
        let off = fault
            .drive_off_after_ticks
            .map_or("the drive did not go off".to_owned(), |ticks| {
                format!("drive off after {ticks} ticks")
            });
        text += &format!(
            "fault          {} {} at {:.4} s, {off}\n",
            fault.code, fault.name, fault.at_s
        );
    }
    text += &format!(
        "also           {} contacts, {} reseeks, {} overruns; basin {}; largest force {:.1} times the weight, travel {:.3} mm\n",
        verdict.contacts,
        verdict.reseeks,
        verdict.overruns,
        verdict.basin,
        verdict.largest_force_ratio,
        verdict.largest_travel_mm
    );
    if let Some(why) = &verdict.loop_left_out {
        text += &format!(
            "shaker loop    not in the controller's settings, so its forecast has no recoil: {why}\n"
        );
    }
    if let Some(dug) = verdict.progress_mm {
        let rate = verdict.rate_of_penetration_um_per_s;
        let rate = rate.map_or(String::new(), |r| {
            format!("; {r:.1} µm/s from the first Hold on")
        });
        text += &format!("drilled        {dug:.4} mm{rate}\n");
    }
    text
}
