//! The picture of a pick for the largest rate of penetration.

use numerics::CartModel;
use numerics::drill::pick::RopPick;
use plot::{Axis, Color, Figure, Item, Panel};

/// Rate of the stable 1/1 over frequency, with the safe band and the choice.
pub fn figure(pick: &RopPick) -> Figure {
    let (a, g) = (&pick.answer, &pick.ground);
    let [low, high] = a.safe_band_hz;
    let cart = match a.cart {
        CartModel::Recoil => "recoils",
        CartModel::Prescribed => "is prescribed",
    };
    let over = match a.uncertainty {
        Some(_) => format!(
            ", {:.1} to {:.1} over the uncertainty",
            g.rate_worst_um_per_s, g.rate_largest_um_per_s
        ),
        None => String::new(),
    };
    let panel = Panel::new(
        "drive frequency, Hz",
        Axis::new("rate of penetration, µm/s").with_zero(),
    );
    let band = Color(0x2e, 0x7d, 0x32);
    let mut panel = panel
        .item(Item::line(
            "stable 1/1",
            Color::series(0),
            pick.curve.clone(),
        ))
        .item(Item::mark_x("run here", a.operating_frequency_hz));
    let inside = pick.curve.iter().copied();
    let inside = inside.filter(|(hz, _)| (low..=high).contains(hz));
    panel = panel.item(Item::line("safe band", band, inside.collect()));
    if let Some(hz) = g.force_optimum_hz {
        panel = panel.item(Item::mark_x("hardest on a surface that stays", hz));
    }
    Figure::new(format!(
        "{}: run at {:.4} Hz on ground that gives way at {:?} N (gap {:?} mm)",
        a.rig, a.operating_frequency_hz, g.threshold_n, a.gap_mm
    ))
    .subtitle(format!(
        "{:.1} µm/s{over}, {:.2} µm and {:.3} mJ with each blow. Ground {:e} N/m, {:?} N·s/m{}. The cart {cart}.",
        g.rate_of_penetration_um_per_s,
        g.progress_per_blow_um,
        g.energy_per_blow_mj,
        g.ground_stiffness_n_per_m,
        g.ground_damping_n_s_per_m,
        g.bit_mass_kg
            .map_or(String::new(), |kg| format!(", a bit of {kg:?} kg"))
    ))
    .size(1000, 560)
    .panel(panel)
}
