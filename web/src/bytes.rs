//! Packed answers: numbers as the page's `DataView` reads them, least byte first.

use numerics::map::MapCell;
use shared::model::regime::Regime;

/// Bytes of a packed cell of a map.
///
/// | byte | holds |
/// |---|---|
/// | 0 | what: 0 none, 1 p/n, 2 aperiodic, 3 chatter, 4 failed, 5 unsettled |
/// | 1 | n; 0: it does not repeat |
/// | 2, 3 | p |
/// | 4 to 7 | cycle after which the section had converged; 2³² − 1: it had not |
/// | 8 to 15 | largest contact force, N |
pub const CELL: usize = 16;

/// Cells of a map, [`CELL`] bytes each.
pub fn cells(cells: &[MapCell]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(CELL * cells.len());
    for cell in cells {
        let what: u8 = match cell.regime {
            _ if cell.failed => 4,
            _ if cell.unsettled => 5,
            Regime::None => 0,
            Regime::Periodic { .. } => 1,
            Regime::Aperiodic { .. } => 2,
            Regime::Chatter { .. } => 3,
        };
        bytes.extend([what, cell.regime.periods().unwrap_or(0)]);
        bytes.extend(cell.regime.impacts().to_le_bytes());
        bytes.extend(cell.settled_after.unwrap_or(u32::MAX).to_le_bytes());
        bytes.extend(cell.force_n.to_le_bytes());
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_has_its_bytes() {
        let cell = MapCell {
            regime: Regime::Periodic {
                impacts: 258,
                periods: 3,
            },
            force_n: 31.5,
            settled_after: Some(7),
            ..MapCell::FAILED
        };
        let failed = cells(&[
            cell,
            MapCell {
                failed: false,
                ..cell
            },
        ]);
        assert_eq!(failed.len(), 2 * CELL);
        assert_eq!(failed[0], 4);
        assert_eq!(failed[CELL..CELL + 8], [1, 3, 2, 1, 7, 0, 0, 0]);
        assert_eq!(failed[CELL + 8..], 31.5_f64.to_le_bytes());
    }
}
