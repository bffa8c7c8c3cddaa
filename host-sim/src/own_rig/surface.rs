//! What a hammer of steel may strike: how stiff such a contact is, within a decade or two, and what it gives back.
//!
//! Hertz's law of a rounded tip and that of a flat face bound the stiffness of the contact itself; what carries hammer and
//! surface yields in series with it. docs/choosing-a-surface.md has the derivation and the sources.

use clap::ValueEnum;
use clap::builder::PossibleValue;

/// Young's modulus of steel, Pa, and Poisson's ratio.
const STEEL: (f64, f64) = (210e9, 0.3);
/// Radius of a rounded tip, m: the softest contact.
const TIP_RADIUS_M: f64 = 0.01;
/// Radius of a flat face, m: the stiffest contact.
const FACE_RADIUS_M: f64 = 0.01;
/// The chapter's contact, steel on steel, N/m: Hertz alone would make it six times as stiff, so the rest is structure.
const CHAPTER: f64 = 5.5e6;
/// How much softer or stiffer than the chapter's a structure may be, as a factor.
const STRUCTURE_FACTOR: f64 = 6.0;

/// A material that is struck.
#[derive(Debug)]
pub struct Surface {
    name: &'static str,
    what: &'static str,
    /// Young's modulus, Pa: smallest and largest of what is sold under the name.
    modulus: [f64; 2],
    poisson: f64,
    /// Restitution at some 0.1 m/s.
    pub restitution: [f64; 2],
}

const fn surface(
    name: &'static str,
    what: &'static str,
    modulus: [f64; 2],
    poisson: f64,
    restitution: [f64; 2],
) -> Surface {
    Surface {
        name,
        what,
        modulus,
        poisson,
        restitution,
    }
}

/// Every surface, the hard ones first.
pub const SURFACES: [Surface; 8] = [
    surface("steel", "mild steel", [200e9, 210e9], 0.3, [0.3, 0.8]),
    surface(
        "hardened-steel",
        "hardened steel",
        [200e9, 210e9],
        0.3,
        [0.5, 0.95],
    ),
    surface("brass", "brass or bronze", [100e9, 125e9], 0.34, [0.3, 0.8]),
    surface(
        "hard-rubber",
        "rubber, 70 to 95 Shore A",
        [5e6, 50e6],
        0.5,
        [0.3, 0.75],
    ),
    surface(
        "polyurethane",
        "polyurethane, 80 Shore A to 60 Shore D",
        [10e6, 200e6],
        0.5,
        [0.35, 0.8],
    ),
    surface(
        "wood",
        "wood, across or along the grain",
        [0.3e9, 16e9],
        0.3,
        [0.3, 0.6],
    ),
    surface("concrete", "concrete", [20e9, 45e9], 0.2, [0.2, 0.6]),
    surface("rock", "rock", [5e9, 80e9], 0.25, [0.2, 0.85]),
];

impl Surface {
    /// As the option has it.
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// Softest and stiffest contact of a hammer of steel with it, N/m.
    pub fn stiffness(&self, mass_kg: f64, speed_m_per_s: f64) -> [f64; 2] {
        let energy = 0.5 * mass_kg * speed_m_per_s * speed_m_per_s;
        let [soft, stiff] = self.modulus.map(|modulus| {
            let yields = |(e, nu): (f64, f64)| (1.0 - nu * nu) / e;
            1.0 / (yields((modulus, self.poisson)) + yields(STEEL))
        });
        // F = K d^1.5 stores the energy E up to the depth d; the linear spring that stores it there has k = 0.8 K √d.
        let hertz = 4.0 / 3.0 * soft * TIP_RADIUS_M.sqrt();
        let depth = (2.5 * energy / hertz).powf(0.4);
        let flat = 2.0 * stiff * FACE_RADIUS_M;
        let series = |a: f64, b: f64| 1.0 / (1.0 / a + 1.0 / b);
        [
            series(0.8 * hertz * depth.sqrt(), CHAPTER / STRUCTURE_FACTOR),
            series(flat, CHAPTER * STRUCTURE_FACTOR),
        ]
    }
}

/// A surface of the list [`SURFACES`].
pub type NamedSurface = &'static Surface;

/// [`NamedSurface`] as an option and an answer have it.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceChoice(pub NamedSurface);

impl SurfaceChoice {
    /// The surface of this name, or the only one whose name has `text` in it: "rubber".
    pub fn meant(text: &str) -> Option<Self> {
        let text = text.to_lowercase();
        let named = SURFACES.iter().find(|surface| surface.name == text);
        let mut having = SURFACES.iter().filter(|s| s.name.contains(&text));
        let only = having.next().filter(|_| having.next().is_none());
        named.or(only).map(Self)
    }
}

impl ValueEnum for SurfaceChoice {
    fn value_variants<'a>() -> &'a [Self] {
        const ALL: [SurfaceChoice; 8] = {
            let mut all = [SurfaceChoice(&SURFACES[0]); 8];
            let mut i = 0;
            while i < all.len() {
                all[i] = SurfaceChoice(&SURFACES[i]);
                i += 1;
            }
            all
        };
        &ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        let Surface {
            name,
            what,
            restitution: [low, high],
            ..
        } = self.0;
        let value = PossibleValue::new(*name).help(format!("{what}; restitution {low} to {high}"));
        let short = |part: &&str| Self::meant(part).is_some_and(|of| of.0.name == *name);
        Some(value.aliases(name.split('-').filter(short)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The chapter's hammer: 0.298 kg at 0.073 m/s.
    #[test]
    fn the_chapter_s_steel_is_in_the_middle_and_soft_surfaces_are_far_from_it() {
        let of = |name: &str, mass| {
            let found = SURFACES.iter().find(|surface| surface.name == name);
            found.expect("a surface").stiffness(mass, 0.073)
        };
        let [low, high] = of("steel", 0.298);
        assert!(low < 1e6 && high > 3e7, "{low} {high}");
        assert!(((low * high).sqrt() / 5.5e6 - 1.0).abs() < 0.05);
        // By hand: E* = 6.67 MPa, K = 8.9e5, depth 0.7 mm; flat, 2 · 66.6 MPa · 10 mm.
        let [low, high] = of("hard-rubber", 1.7);
        assert!((low / 1.85e4 - 1.0).abs() < 0.05, "{low}");
        assert!((high / 1.28e6 - 1.0).abs() < 0.05, "{high}");
    }

    #[test]
    fn a_part_of_one_name_alone_means_it() {
        let of = |text| SurfaceChoice::meant(text).map(|choice| choice.0.name);
        assert_eq!(of("Rubber"), Some("hard-rubber"));
        assert_eq!(of("steel"), Some("steel"));
        assert_eq!(of("hardened"), Some("hardened-steel"));
        let as_option = |text| {
            SurfaceChoice::from_str(text, false)
                .ok()
                .map(|of| of.0.name)
        };
        assert_eq!(as_option("rubber"), Some("hard-rubber"));
        assert_eq!(as_option("hard"), None);
        for unclear in ["", "r", "rope"] {
            assert_eq!(of(unclear), None, "{unclear}");
        }
    }

    /// The table of the page is what is computed, to the two digits that it has.
    #[test]
    fn the_page_has_every_surface_with_its_numbers() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/choosing-a-surface.md");
        let page = std::fs::read_to_string(path).unwrap();
        for surface in &SURFACES {
            let [low, high] = surface.stiffness(0.298, 0.073);
            let [lower, higher] = surface.stiffness(1.7, 0.073);
            let [weak, strong] = surface.restitution;
            let row = format!(
                "| `{}` | {low:.1e} to {high:.1e} | {lower:.1e} to {higher:.1e} | {weak} to {strong} |",
                surface.name
            );
            assert!(page.contains(&row), "{row}");
        }
    }
}
