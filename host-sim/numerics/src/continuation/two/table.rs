//! Curves over two parameters as tables.

use serde::Serialize;

use super::{Codimension, Condition, Plane, TwoParameterCurve, TwoParameterPoint};
use crate::continuation::CurveEnd;
use crate::continuation::table::motion_of;
use crate::row::CartModel;
use crate::row::{extent, number, tidy};

/// A point of a curve. Units are in the names, or in the name of the parameter beside a value.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CurvePointRow {
    /// Name of the curve: its condition and a number.
    pub curve: String,
    /// What holds along it.
    pub condition: Condition,
    /// Which point of the curve, in order along it, from 1.
    pub point: usize,
    /// Name of the first parameter, with its unit.
    pub parameter_1: &'static str,
    /// Value of the first parameter, in the unit of its name.
    pub value_1: f64,
    /// Name of the second parameter, with its unit.
    pub parameter_2: &'static str,
    /// Value of the second parameter, in the unit of its name.
    pub value_2: f64,
    /// Drive frequency, Hz.
    pub frequency_hz: f64,
    /// Drive frequency over the natural frequency, Ω/ω.
    pub frequency_ratio: f64,
    /// Clearance at rest, mm.
    pub gap_mm: f64,
    /// Displacement at drive phase 0, mm.
    pub displacement_mm: f64,
    /// Velocity relative to the cart at drive phase 0, m/s.
    pub velocity_m_per_s: f64,
    /// p: contacts of the orbit; on a graze without the touch.
    pub impacts: u16,
    /// n: drive periods of the orbit.
    pub periods: u8,
    /// Largest contact force over m g.
    pub force_ratio: f64,
    /// First multiplier, real part; on a graze on the side without the touch.
    pub multiplier_1_re: f64,
    /// First multiplier, imaginary part.
    pub multiplier_1_im: f64,
    /// Second multiplier, real part.
    pub multiplier_2_re: f64,
    /// Second multiplier, imaginary part.
    pub multiplier_2_im: f64,
    /// The second condition of this point, if it has one.
    pub codimension_two: Option<Codimension>,
}

/// A curve as a whole.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TwoParameterCurveRow {
    /// Name of the curve: its condition and a number.
    pub curve: String,
    /// What holds along it.
    pub condition: Condition,
    /// p; on a graze without the touch.
    pub impacts: u16,
    /// Drive periods of each of its orbits, n.
    pub periods: u8,
    /// Number of points found along the curve.
    pub points: usize,
    /// Smallest and largest value of the first parameter.
    pub range_1: [f64; 2],
    /// Smallest and largest value of the second parameter.
    pub range_2: [f64; 2],
    /// How it ends on either side.
    pub ends: [CurveEnd; 2],
}

/// Curves over two parameters.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CurvesAnswer {
    /// Name of the rig.
    pub rig: String,
    /// How the cart is moved.
    pub cart: CartModel,
    /// The first parameter, with its unit.
    pub parameter_1: &'static str,
    /// The second parameter, with its unit.
    pub parameter_2: &'static str,
    /// The curves, one row each.
    pub curves: Vec<TwoParameterCurveRow>,
    /// Points with a second condition.
    pub codimension_two: Vec<CurvePointRow>,
    /// Every point of every curve, curve by curve.
    pub points: Vec<CurvePointRow>,
    /// Values of the second parameter at which one-parameter curves were searched for special points.
    pub searched_at: Vec<f64>,
    /// Special points found there from which no curve could be followed.
    pub not_followed: usize,
    /// Simulations that searched for orbits.
    pub simulations: usize,
    /// How many of them left what the model describes.
    pub failed_simulations: usize,
}

impl CurvesAnswer {
    /// Of the curves over `plane` of the rig called `name`; how they were searched for is the caller's to add.
    pub fn new(name: &str, plane: &Plane, curves: &[TwoParameterCurve]) -> Self {
        let names: Vec<String> = (curves.iter().enumerate())
            .map(|(i, curve)| {
                let number = number(curves, i, |c| c.condition);
                format!("{} {number}", curve.condition.name())
            })
            .collect();
        let [first, second] = plane.dimensions.map(|d| d.varied.name());
        let points: Vec<CurvePointRow> = (curves.iter().zip(&names))
            .flat_map(|(curve, name)| {
                let rows = curve.points.iter().enumerate();
                rows.map(|(i, p)| point_row(curve, name, i + 1, p, [first, second]))
                    .collect::<Vec<_>>()
            })
            .collect();
        let marked = points.iter().filter(|p| p.codimension_two.is_some());
        Self {
            rig: name.to_owned(),
            cart: CartModel::of(&plane.params),
            parameter_1: first,
            parameter_2: second,
            curves: (curves.iter().zip(&names))
                .map(|(c, n)| curve_row(c, n))
                .collect(),
            codimension_two: marked.cloned().collect(),
            points,
            searched_at: Vec::new(),
            not_followed: 0,
            simulations: 0,
            failed_simulations: 0,
        }
    }
}

fn curve_row(curve: &TwoParameterCurve, name: &str) -> TwoParameterCurveRow {
    let range = |k: usize| extent(curve.points.iter().map(|p| p.values[k])).map(tidy);
    TwoParameterCurveRow {
        curve: name.to_owned(),
        condition: curve.condition,
        impacts: curve.impacts(),
        periods: curve.periods,
        points: curve.points.len(),
        range_1: range(0),
        range_2: range(1),
        ends: curve.ends,
    }
}

fn point_row(
    curve: &TwoParameterCurve,
    name: &str,
    number: usize,
    point: &TwoParameterPoint,
    [first, second]: [&'static str; 2],
) -> CurvePointRow {
    let params = &point.params;
    let (displacement_mm, velocity_m_per_s) = motion_of(params, point.section);
    let [(a_re, a_im), (b_re, b_im)] = point.multipliers;
    CurvePointRow {
        curve: name.to_owned(),
        condition: curve.condition,
        point: number,
        parameter_1: first,
        value_1: tidy(point.values[0]),
        parameter_2: second,
        value_2: tidy(point.values[1]),
        frequency_hz: tidy(point.frequency_hz),
        frequency_ratio: tidy(point.frequency_hz / params.natural_frequency_hz()),
        gap_mm: tidy(params.gap_m * 1e3),
        displacement_mm,
        velocity_m_per_s,
        impacts: point.impacts,
        periods: curve.periods,
        force_ratio: point.force_n / params.weight_n(),
        multiplier_1_re: a_re,
        multiplier_1_im: a_im,
        multiplier_2_re: b_re,
        multiplier_2_im: b_im,
        codimension_two: point.mark,
    }
}
