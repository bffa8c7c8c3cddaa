//! Measured points to lay over a diagram.

use serde::Serialize;

use super::BifurcationDiagram;

/// Measured points, as read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeasuredDiagram {
    /// (frequency in Hz, displacement at drive phase 0 in mm); empty without that column.
    pub displacement_mm: Vec<(f64, f64)>,
    /// (frequency in Hz, contact force in N); empty without that column.
    pub force_n: Vec<(f64, f64)>,
}

/// How far measured displacements lie from the diagram, at the diagram's nearest frequency.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Distance {
    /// Measured points inside the diagram's range.
    pub points_compared: usize,
    /// Measured points outside it.
    pub points_outside: usize,
    /// Root mean square of the distance to the nearest point of the section, mm or N.
    pub rms: f64,
    /// Largest of these distances, mm or N.
    pub largest: f64,
}

impl MeasuredDiagram {
    /// Distance of the displacements to `diagram`.
    pub fn displacement_distance(&self, diagram: &BifurcationDiagram) -> Distance {
        distance(&self.displacement_mm, diagram, |p| p.displacement_mm)
    }

    /// Distance of the forces to `diagram`.
    pub fn force_distance(&self, diagram: &BifurcationDiagram) -> Distance {
        distance(&self.force_n, diagram, |p| p.force_n)
    }
}

fn distance(
    measured: &[(f64, f64)],
    diagram: &BifurcationDiagram,
    value: impl Fn(&super::DiagramPoint) -> f64,
) -> Distance {
    let stations = &diagram.stations;
    let nearest = |(hz, y): &(f64, f64)| {
        let (first, last) = (stations.first()?, stations.last()?);
        if !(first.row.frequency_hz..=last.row.frequency_hz).contains(hz) {
            return None;
        }
        let apart = |s: &&super::Station| (s.row.frequency_hz - hz).abs();
        let station = stations
            .iter()
            .min_by(|a, b| apart(a).total_cmp(&apart(b)))?;
        let distances = station.points.iter().map(|p| (value(p) - y).abs());
        distances.min_by(f64::total_cmp)
    };
    let found: Vec<f64> = measured.iter().filter_map(nearest).collect();
    let squares = found.iter().map(|d| d * d).sum::<f64>();
    Distance {
        points_compared: found.len(),
        points_outside: measured.len() - found.len(),
        rms: (squares / found.len().max(1) as f64).sqrt(),
        largest: found.iter().copied().fold(0.0, f64::max),
    }
}
