//! Special points of one-parameter curves, at some values of the second parameter: a curve begins at each.

use nalgebra::DVector;

use super::conditions::System;
use super::graze::Windows;
use super::plane::{Plane, Scale, Varied};
use super::{Condition, TwoParameterPoint};
use crate::continuation::diagram::{OrbitsRequest, diagram};
use crate::continuation::family::Node;
use crate::continuation::{Along, FamilyDrive, OrbitDiagram, Special};
use crate::error::Error;
use crate::orbit::{Orbit, carried};
use crate::progress::Progress;
use crate::reference::LocatedContact;

/// A point from which a curve is followed.
#[derive(Clone, Debug)]
pub struct Seed {
    pub(super) system: System,
    /// Point at which the curve is begun.
    pub point: TwoParameterPoint,
}

/// Special points of the one-parameter curves at one value of the second parameter.
#[derive(Clone, Debug, Default)]
pub struct SpecialPoints {
    /// Those from which a curve can be followed.
    pub seeds: Vec<Seed>,
    /// How many could not be refined.
    pub refused: usize,
    /// Simulations that searched for orbits.
    pub simulations: usize,
    /// How many of them left what the model describes.
    pub failed: usize,
}

/// The special points of `plane` at `values` of its second parameter. `search` says how to look for orbits; what it varies
/// and its limits are the plane's.
///
/// # Errors
/// As [`diagram`].
pub fn seeds(
    plane: &Plane,
    values: &[f64],
    search: &OrbitsRequest,
    progress: &dyn Progress,
) -> Result<SpecialPoints, Error> {
    let mut found = SpecialPoints::default();
    for value in values {
        let at = one_parameter(plane, *value, search, progress)?;
        found.simulations += at.simulations;
        found.failed += at.failed;
        for curve in &at.curves {
            for (node, special) in curve.specials() {
                match seed(plane, &at, node, special, *value) {
                    Some(seed) => found.seeds.push(seed),
                    None => found.refused += 1,
                }
            }
        }
    }
    Ok(found)
}

/// The one-parameter curves at one value of the second parameter.
///
/// # Errors
/// As [`diagram`].
pub fn one_parameter(
    plane: &Plane,
    value: f64,
    search: &OrbitsRequest,
    progress: &dyn Progress,
) -> Result<OrbitDiagram, Error> {
    let first = plane.dimensions[0];
    let (params, hz) = plane
        .at([first.range.0, value])
        .unwrap_or((plane.params, plane.drive.hz(&plane.params)));
    let drive = match plane.dimensions[1].varied {
        Varied::Ratio => FamilyDrive::Ratio(value),
        Varied::Frequency => FamilyDrive::Hz(hz),
        Varied::Rig(_) => plane.drive,
    };
    let (from, to) = first.range;
    let (along, unit) = match first.varied {
        Varied::Ratio => (Along::Frequency, 1.0),
        Varied::Frequency => (Along::Frequency, params.natural_frequency_hz()),
        Varied::Rig(knob) => {
            let unit = match first.scale {
                Scale::Even(unit) => unit,
                Scale::Log(_) => to,
            };
            (Along::Rig { knob, unit, drive }, unit)
        }
    };
    let request = OrbitsRequest {
        along,
        limits: (from / unit, to / unit),
        ..*search
    };
    diagram(&params, &request, progress)
}

/// The seed at a special point of a one-parameter curve.
fn seed(
    plane: &Plane,
    at: &OrbitDiagram,
    node: &Node,
    special: Special,
    second: f64,
) -> Option<Seed> {
    let unit = match (at.request.along, plane.dimensions[0].varied) {
        (Along::Rig { unit, .. }, _) => unit,
        (_, Varied::Frequency) => at.params.natural_frequency_hz(),
        _ => 1.0,
    };
    let values = [node.parameter() * unit, second];
    let places = [0, 1].map(|i| plane.dimensions[i].place(values[i]));
    let (_, params, frequency_hz) = plane.at_places(places)?;
    let orbit = &node.orbit;
    let condition = match special {
        Special::PeriodDoubling => Condition::PeriodDoubling,
        Special::Fold => Condition::Fold,
        Special::GrazingGained | Special::GrazingLost => Condition::Grazing,
    };
    let mut system = System::new(*plane, &params, condition, orbit.periods).ok()?;
    let (mut x, lost) = if condition == Condition::Grazing {
        let (touch, lost) = touch(orbit, special)?;
        system.windows = windows(orbit, touch, lost);
        let there = carried(&params, frequency_hz, orbit.at(), (0.0, touch), &mut ())?;
        let mut x = vec![touch.rem_euclid(1.0)];
        if system.recoils() {
            x.extend([there[2] / system.units[2], there[3] / system.units[3]]);
        }
        (x, lost.is_some())
    } else {
        (system.section_unknowns(orbit.at()), false)
    };
    x.extend(places);
    let point = system.correct_at(&DVector::from_vec(x), 1)?;
    let impacts = orbit.impacts - u16::from(lost);
    (point.impacts == impacts).then_some(Seed { system, point })
}

/// When (drive periods) an orbit touches without a blow, and with which of its contacts, if it is one that is about to be
/// missed.
fn touch(orbit: &Orbit, special: Special) -> Option<(f64, Option<LocatedContact>)> {
    if special == Special::GrazingGained {
        return Some((orbit.seen.near_miss_at?, None));
    }
    let slow = |a: &&LocatedContact, b: &&LocatedContact| {
        a.approach_speed_m_per_s
            .total_cmp(&b.approach_speed_m_per_s)
    };
    let contact = orbit.seen.grazing_contacts().min_by(slow)?;
    let middle = contact.onset_s + 0.5 * contact.duration_s;
    Some((middle * orbit.frequency_hz, Some(*contact)))
}

/// The flights between a touch and the other contacts.
fn windows(orbit: &Orbit, touch: f64, lost: Option<LocatedContact>) -> Windows {
    let round = f64::from(orbit.periods);
    let widest = Windows::default();
    let others = orbit.seen.contacts.iter().filter(|c| Some(**c) != lost);
    others.fold(widest, |w, contact| {
        let onset = contact.onset_s * orbit.frequency_hz;
        let release = (contact.onset_s + contact.duration_s) * orbit.frequency_hz;
        Windows {
            after: w.after.min(0.5 * (onset - touch).rem_euclid(round)),
            before: w.before.min(0.5 * (touch - release).rem_euclid(round)),
        }
    })
}
