//! The contact of a rig file: from what a person measured of it, or from what surface it is.

use super::{Answers, Described, SURFACE_MISSING, missing};
use crate::own_rig::contact::{OwnContact, of_restitution_and_surface, of_restitution_and_time};
use crate::own_rig::reading::OwnReading;
use files::UserError;

impl Described {
    /// The contact from a contact time or a surface, and a restitution or the surface's.
    pub(super) fn measured_contact(
        &mut self,
        answers: &Answers,
        mass_kg: f64,
        speed_m_per_s: f64,
    ) -> Result<(), UserError> {
        let surface = answers.surface.map(|choice| choice.0);
        let (restitution, of_restitution) = match (&answers.restitution, surface) {
            (Some(reading), _) => {
                let read = self.read("--restitution", reading);
                (reading.clone(), format!("restitution {read}"))
            }
            (None, Some(surface)) => {
                let [low, high] = surface.restitution;
                let middle = OwnReading::assumed(0.5 * (low + high), 0.5 * (high - low));
                (
                    middle,
                    format!("restitution of {}, {low} to {high}", surface.name()),
                )
            }
            (None, None) if answers.contact_time.is_none() => return Err(missing(answers)),
            (None, None) => return Err(stiffness_unknown("--contact-time")),
        };
        let (contact, source) = match (&answers.contact_time, surface) {
            (Some(time), _) => (
                of_restitution_and_time(mass_kg, &restitution, time)?,
                format!(
                    "contact time {}{}",
                    self.read("--contact-time", time),
                    surface.map_or(String::new(), |surface| {
                        format!("; it decides, not the surface ({})", surface.name())
                    })
                ),
            ),
            (None, Some(surface)) => {
                let range = surface.stiffness(mass_kg, speed_m_per_s);
                let [low, high] = range;
                let name = surface.name();
                self.notes.push(format!(
                    "note: the contact of steel with {name} has some {low:.1e} to {high:.1e} N/m; measure a contact time for a narrower range (--contact-time)"
                ));
                (
                    of_restitution_and_surface(mass_kg, &restitution, range)?,
                    format!(
                        "steel on {name}: {low:.1e} to {high:.1e} N/m; narrower with a contact time"
                    ),
                )
            }
            (None, None) => return Err(stiffness_unknown("--restitution")),
        };
        let of_damping = format!("{of_restitution}, with that stiffness");
        let wide = contact.widths[0].0 == "contact_stiffness_factor";
        let of_stiffness = if wide {
            format!("geometric mean of {source}")
        } else {
            source.clone()
        };
        self.contact(
            &contact,
            [&of_stiffness, &of_damping],
            [&source, &of_restitution],
        );
        Ok(())
    }

    /// A spring-dashpot with the sources of its stiffness and of its damping, and those of their half-widths.
    pub fn contact(&mut self, contact: &OwnContact, values: [&str; 2], widths: [&str; 2]) {
        self.file.word(
            "contact_law",
            "spring-dashpot",
            "the simplest law that a person can measure",
        );
        self.file
            .number("contact_stiffness_n_per_m", contact.stiffness, values[0]);
        self.file
            .number("contact_damping_n_s_per_m", contact.damping, values[1]);
        for ((key, width), source) in contact.widths.into_iter().zip(widths) {
            self.file.width(key, width, source);
        }
    }
}

/// `given` alone does not say how stiff the contact is, or what it gives back.
fn stiffness_unknown(given: &str) -> UserError {
    UserError::new(format!(
        "{given} alone does not describe the contact; give {SURFACE_MISSING}"
    ))
}
