//! Ground that changes and a drive that does not obey: what events do to the world, against what they say.

use emulator::scenario::{RigChange, Scenario, ScenarioAct, parse};
use emulator::schedule::Doing;
use emulator::shaker::SetPointPath;
use emulator::world::World;
use shared::io::{DacCode, Output};
use shared::model::contact::LAWS;
use shared::model::params::{RigParams, WIRES};
use std::f64::consts::TAU;

use crate::mounting::free_hammer;
use crate::support::{TICK_S, prescribed};

fn scenario(more: &str) -> Scenario {
    let text = format!("duration_s = 60.0\n[true_rig]\npreset = \"wires\"\n{more}");
    parse("mine", &text, "mine.toml").unwrap()
}

/// Wires driven at 3.66 Hz with the rig's amplitude, tick by tick.
struct Driven {
    world: World,
    turns: f64,
    m_per_code: f64,
}

impl Driven {
    fn new(scenario: &Scenario) -> Self {
        Self {
            world: World::new(scenario).unwrap(),
            turns: 0.0,
            m_per_code: f64::from(scenario.settings.drive.m_per_code),
        }
    }

    fn tick(&mut self, enable: bool) {
        self.turns = (self.turns + 3.66 * TICK_S).fract();
        let metres = WIRES.amplitude_m * (TAU * self.turns).sin();
        let output = Output {
            dac: DacCode((2048.5 + metres / self.m_per_code) as u16),
            frequency_hz: 3.66,
            enable,
        };
        self.world
            .tick(if enable { &output } else { &Output::SAFE });
        self.world.drift();
    }

    /// Largest displacement of the cart in a second, m.
    fn sway(&mut self, enable: bool) -> f64 {
        let mut largest = 0.0_f64;
        for _ in 0..20_000 {
            self.tick(enable);
            largest = largest.max(self.world.plant().cart_m().abs());
        }
        largest
    }
}

#[test]
fn a_surface_recedes_by_the_energy_of_its_blows_and_by_time_and_no_further_than_it_may() {
    let mut driven = Driven::new(&scenario(""));
    driven
        .world
        .happen(Doing::Recede(Some(emulator::world::Recession {
            m_per_j: 2e-3,
            m_per_s: 1e-6,
            left_m: 0.4e-3,
        })));
    let (mut energy, mut blows) = (0.0, 0);
    let mut last = 0.0;
    for k in 1..=400_000 {
        driven.tick(true);
        for blow in driven.world.plant().finished() {
            energy += blow.energy_lost_j;
            blows += 1;
        }
        let gap = driven.world.rig().gap_m;
        let want = (2e-3 * energy + 1e-6 * f64::from(k) * TICK_S).min(0.4e-3);
        // In contact it waits.
        if !driven.world.plant().touched() {
            assert!((gap - want).abs() < 1e-12, "{gap} against {want} at {k}");
        }
        assert!(gap >= last);
        last = gap;
    }
    assert!(blows > 30 && last > 0.1e-3, "{blows} blows, {last} m");
}

#[test]
fn a_surface_comes_to_rebound_as_it_is_told_to() {
    for (name, law) in LAWS {
        let rig = RigParams {
            contact: law,
            ..free_hammer()
        };
        let change = RigChange {
            restitution: Some(0.6),
            ..RigChange::default()
        };
        let fits = change.fits(&rig).is_ok();
        // Hertz's law loses nothing, and Hunt and Crossley's restitution depends on the speed.
        assert_eq!(fits, !["hertz", "hunt-crossley"].contains(&name), "{name}");
        if !name.contains("dashpot") {
            continue;
        }
        let rebound = |share: f64| {
            let rig = change.apply(&rig, share);
            let mut plant = prescribed(&rig, TICK_S);
            plant.set_state(emulator::bodies::BodiesState {
                q: -1e-6,
                v: 0.08,
                ..Default::default()
            });
            while plant.finished().is_empty() {
                plant.tick(SetPointPath::default(), false);
            }
            let blow = plant.finished()[0];
            blow.rebound_speed_m_per_s / blow.approach_speed_m_per_s
        };
        let (before, middle, after) = (rebound(0.0), rebound(0.5), rebound(1.0));
        assert!((after - 0.6).abs() < 1e-6, "{after}");
        assert!((middle - 0.5 * (before + after)).abs() < 1e-6, "{middle}");
    }
}

#[test]
fn a_stuck_drive_runs_on_or_keeps_its_power_and_a_whole_one_comes_to_rest() {
    use emulator::scenario::Stuck;
    for (how, moves) in [
        (None, false),
        (Some(Stuck::Powered), false),
        (Some(Stuck::RunsOn), true),
    ] {
        let mut driven = Driven::new(&scenario(""));
        driven.sway(true);
        let before = driven.sway(true);
        driven.world.happen(Doing::Stuck(how));
        driven.sway(false);
        let after = driven.sway(false);
        assert_eq!(driven.world.is_powered(), how.is_some(), "{how:?}");
        assert_eq!(driven.world.is_faulty(), how.is_some());
        let share = after / before;
        assert!(
            if moves {
                (0.97..1.03).contains(&share)
            } else {
                share < 0.02
            },
            "{how:?} {share}"
        );
    }
}

#[test]
fn a_tilt_comes_over_its_time_and_counts_as_a_clearance() {
    let mut world = World::new(&scenario("")).unwrap();
    world.happen(Doing::Tilt(-0.01, 2.0));
    for _ in 0..60_000 {
        world.tick(&Output::SAFE);
        world.drift();
    }
    let hangs = world.plant().hammer_m() - world.plant().cart_m();
    assert!((hangs + 0.075 * 0.01_f64.sin()).abs() < 0.2e-3, "{hangs}");
    let gap = world.rig().gap_m - WIRES.gap_m;
    assert!((gap - 0.075 * 0.01_f64.sin()).abs() < 1e-12, "{gap}");
}

#[test]
fn scenarios_write_carts_motors_and_ground() {
    let whole = scenario(
        "[shaker]\nimpedance_n_s_per_m = 12\narmature_kg = 0.4\narmature_hz = 30\n[cart]\ncoulomb_n = 2\nstatic_n = 3\nviscous_n_s_per_m = 4\nstop_mm = 1.5\ntilt_deg = 0.5\n[[events]]\nat_s = 1\nkind = \"stuck-drive\"\nhow = \"powered\"\nfor_s = 2\n[[events]]\nat_s = 2\nkind = \"recede\"\nmm_per_j = 0.1\nup_to_mm = 1.2\n[[events]]\nat_s = 3\nkind = \"tilt\"\ndegrees = -0.5\nover_s = 2\n[[events]]\nat_s = 4\nkind = \"cart-friction\"\ncoulomb_n = 9\nfor_s = 1\n[[events]]\nat_s = 5\nkind = \"drift\"\nover_s = 1\nrestitution = 0.6\n",
    );
    assert_eq!(whole.shaker.armature.unwrap().hz, 30.0);
    assert_eq!(whole.mounting.friction.unwrap().static_n, 3.0);
    assert_eq!(whole.mounting.stops.unwrap().at_m, 1.5e-3);
    assert!(matches!(whole.events[1].act, ScenarioAct::Recede { .. }));
    let motor = scenario("[motor]\nslip_hz_per_n_m = 0.2\n");
    assert_eq!(motor.motor.unwrap().crank_m, WIRES.amplitude_m);
    let complaint = |more: &str| {
        let text = format!("duration_s = 60.0\n[true_rig]\npreset = \"wires\"\n{more}");
        parse("mine", &text, "mine.toml").unwrap_err().to_string()
    };
    let event = |more: &str| complaint(&format!("[[events]]\nat_s = 1.0\n{more}"));
    for (line, has) in [
        (
            complaint("[cart]\nstatic_n = 3"),
            "static_n is 3, must be 0 to 0",
        ),
        (complaint("[cart]\ntilt_deg = 20"), "tilt_deg is 20"),
        (complaint("[cart]\nstop = 20"), "did you mean 'stop_mm'"),
        (complaint("[shaker]\narmature_hz = 30"), "needs armature_kg"),
        (
            complaint("[shaker]\nprescribed = true\n[motor]"),
            "both move the cart",
        ),
        (
            complaint("[shaker]\nprescribed = true\n[cart]\nstop_mm = 1"),
            "no friction and no end stops",
        ),
        (event("kind = \"recede\""), "does not recede"),
        (event("kind = \"tilt\"\ndegrees = 30"), "degrees is 30"),
        (
            event("kind = \"cart-friction\"\ncoulomb_n = -1"),
            "coulomb_n is -1",
        ),
        (
            event("kind = \"stuck-drive\"\nhow = \"on\""),
            "no word 'on'",
        ),
        (
            event("kind = \"drift\"\nover_s = 1\nrestitution = 0.05"),
            "restitution is 0.05",
        ),
    ] {
        assert!(line.contains(has), "{line}");
    }
}
