//! The channels of the MCAP file, and the fields of their messages.

use serde_json::{Map, Value, json};

/// A field of a message: its name (with the unit), its JSON type (or `time`, seconds and nanoseconds), what it is.
type Field = (&'static str, &'static str, &'static str);

/// A channel: topic, the name of its schema, its fields.
pub(super) struct LogChannel {
    pub topic: &'static str,
    pub schema: &'static str,
    pub fields: &'static [Field],
}

/// Declares channels: name, topic and schema, and of each field its name, type and what it is.
macro_rules! channels {
    ($(
        $(#[$doc:meta])* $id:ident $topic:literal $schema:literal {
            $($name:literal $kind:literal $what:literal;)*
        }
    )*) => {
        $($(#[$doc])*
        pub(super) const $id: LogChannel = LogChannel {
            topic: $topic,
            schema: $schema,
            fields: &[$(($name, $kind, $what)),*],
        };)*

        /// Every channel, in the order of its number.
        pub(super) const CHANNELS: [&LogChannel; 6] = [$(&$id),*];
    };
}

channels! {
    STATUS "/status" "status" {
        "state" "string" "What the controller is doing";
        "fault" "string" "The fault that is or was";
        "fault_origin" "string" "The sensor the fault is about";
        "fault_tick" "integer" "The tick its condition was seen at";
        "fault_value" "number" "The value that tripped it";
        "fault_frequency_hz" "number" "Drive frequency then, Hz";
        "episode" "string" "All faults until they are cleared";
        "limits" "integer" "Limits that clamp: 1 force, 2 travel, 4 frequency, 8 amplitude, 16 feed";
        "frequency_hz" "number" "Drive frequency, Hz";
        "amplitude_m" "number" "Commanded cart amplitude, m";
        "measured_amplitude_m" "number" "Measured cart amplitude, m";
        "lag_rad" "number" "Lag of the cart, rad";
        "regime" "string" "Measured regime, contacts/periods";
        "peak_n" "number" "Measured peak force of the last period, N";
        "impulse_n_s" "number" "Mean impulse per contact, N s";
        "target_hz" "number" "The forecast's target, Hz";
        "target_n" "number" "The forecast's force there, N";
        "basin" "string" "Where the last disturbance ended";
        "reseeks" "integer" "Times the regime was sought again";
        "overruns" "integer" "Overruns of the control task";
        "events_dropped" "integer" "Events that are lost";
    }

    FORCE "/force" "force" {
        "sensor_n" "number" "Contact force as the sensor has it, N";
        "true_n" "number" "True contact force, N";
    }

    DISPLACEMENT "/displacement" "displacement" {
        "hammer_mm" "number" "Hammer, sensor, fixed frame, mm";
        "cart_mm" "number" "Cart, sensor, fixed frame, mm";
        "relative_mm" "number" "Hammer relative to the cart, sensors, mm";
        "true_hammer_mm" "number" "Hammer, true, fixed frame, mm";
        "true_cart_mm" "number" "Cart, true, fixed frame, mm";
        "true_relative_mm" "number" "Hammer relative to the cart, true, mm";
    }

    CONTACTS "/contacts" "contact" {
        "onset_s" "number" "Onset, s";
        "duration_s" "number" "Onset to release, s";
        "approach_speed_m_per_s" "number" "Speed towards the surface at onset, m/s";
        "rebound_speed_m_per_s" "number" "Speed away from it at release, m/s";
        "peak_force_n" "number" "Largest force, N";
        "peak_at_s" "number" "When it was largest, s";
        "impulse_n_s" "number" "Impulse, N s";
        "energy_lost_j" "number" "Energy it took, J";
    }

    /// Foxglove's log panel knows a message by the name of this schema, and by the fields from `timestamp` on.
    EVENTS "/events" "foxglove.Log" {
        "text" "string" "What happened";
        "timestamp" "time" "When";
        "level" "integer" "2 information, 4 error";
        "message" "string" "What happened";
        "name" "string" "Who says it: controller, or rig for what the scenario does";
        "file" "string" "None";
        "line" "integer" "None";
    }

    FAULTS "/faults" "fault" {
        "code" "integer" "Stable number";
        "name" "string" "Stable name";
        "origin" "string" "The sensor it is about, or system";
        "value" "number" "The value that tripped it";
    }
}

impl LogChannel {
    /// The schema of its messages, as JSON Schema.
    pub fn json_schema(&self) -> Value {
        let properties: Map<String, Value> = self
            .fields
            .iter()
            .map(|(name, kind, what)| {
                let field = match *kind {
                    "time" => json!({
                        "type": "object",
                        "title": "time",
                        "description": what,
                        "properties": {
                            "sec": { "type": "integer", "minimum": 0 },
                            "nsec": { "type": "integer", "minimum": 0, "maximum": 999_999_999 },
                        },
                    }),
                    kind => json!({ "type": kind, "description": what }),
                };
                ((*name).to_owned(), field)
            })
            .collect();
        json!({ "title": self.schema, "type": "object", "properties": properties })
    }
}
