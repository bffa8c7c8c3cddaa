//! The contact of a rig file: from what a person measured of it, or assumed.

use super::{Answers, Described, needed};
use crate::own_rig::contact::{Contact, of_restitution, of_restitution_and_time};
use crate::own_rig::reading::Reading;
use files::UserError;
use shared::model::contact::Law;
use shared::model::params::TABLE_3_1;

/// How well a contact is known that nobody measured, %.
const ASSUMED_CONTACT_PERCENT: f64 = 50.0;

impl Described {
    /// The contact from restitution and contact time, or assumed.
    pub(super) fn measured_contact(
        &mut self,
        answers: &Answers,
        mass_kg: f64,
    ) -> Result<(), UserError> {
        let Law::SpringDashpot { stiffness, damping } = TABLE_3_1 else {
            return Err(UserError::new(
                "rig new: the assumed contact is no spring-dashpot",
            ));
        };
        let assumed = "not measured: the chapter's steel surface";
        let Some(text) = &answers.restitution else {
            let contact = Contact {
                stiffness,
                stiffness_percent: ASSUMED_CONTACT_PERCENT,
                damping,
                damping_percent: ASSUMED_CONTACT_PERCENT,
            };
            self.contact(&contact, [assumed, assumed]);
            return Ok(());
        };
        let restitution = needed("--restitution", Some(text))?;
        let (contact, sources) = match &answers.contact_time_ms {
            Some(text) => {
                let ms = needed("--contact-time-ms", Some(text))?;
                let time = Reading {
                    value: ms.value / 1e3,
                    half_width: ms.half_width / 1e3,
                    ..ms.clone()
                };
                let source = format!(
                    "restitution {}, contact time {} ms",
                    restitution.text, ms.text
                );
                (
                    of_restitution_and_time(mass_kg, &restitution, &time),
                    [source.clone(), source],
                )
            }
            None => (
                of_restitution(mass_kg, &restitution, stiffness, ASSUMED_CONTACT_PERCENT),
                [
                    assumed.to_owned(),
                    format!("restitution {}, with that stiffness", restitution.text),
                ],
            ),
        };
        let contact = contact.ok_or_else(|| {
            UserError::new(format!(
                "--restitution {}: with its uncertainty it must lie between 0.14 (a contact damped critically) and 1 (one that loses nothing), and the contact time above 0",
                restitution.text
            ))
        })?;
        self.contact(&contact, [&sources[0], &sources[1]]);
        Ok(())
    }

    /// A spring-dashpot with the sources of its stiffness and of its damping.
    pub fn contact(&mut self, contact: &Contact, sources: [&str; 2]) {
        self.file.word(
            "contact_law",
            "spring-dashpot",
            "the simplest law that a person can measure",
        );
        self.file
            .number("contact_stiffness_n_per_m", contact.stiffness, sources[0]);
        self.file
            .number("contact_damping_n_s_per_m", contact.damping, sources[1]);
        self.file.width(
            "contact_stiffness_percent",
            contact.stiffness_percent,
            sources[0],
        );
        self.file.width(
            "contact_damping_percent",
            contact.damping_percent,
            sources[1],
        );
    }
}
