//! The pictures of the analyses: axes, colours and words.

use files::UserError;
use plot::{Figure, render_png, render_svg};

pub mod basins;
pub mod bifurcation;
pub mod compare;
pub mod contact_law;
pub mod drill;
pub mod emulate;
pub mod gaps;
pub mod identify;
pub mod map;
pub mod orbits;
pub mod over;
pub mod pick;
pub mod poincare;
pub mod regimes;
pub mod rop;
pub mod trials;
pub mod two;

/// `figure` as the files `NAME.svg` and `NAME.png`.
///
/// # Errors
/// If the figure is too crowded to be drawn.
pub fn drawn(name: &str, figure: &Figure) -> Result<Vec<(String, Vec<u8>)>, UserError> {
    let refused = |error: plot::PictureError| UserError::new(error.to_string());
    Ok(vec![
        (
            format!("{name}.svg"),
            render_svg(figure).map_err(refused)?.into_bytes(),
        ),
        (format!("{name}.png"), render_png(figure).map_err(refused)?),
    ])
}
