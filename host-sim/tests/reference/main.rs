//! Both engines against what is known independently of them.

mod balances;
mod bouncing;
mod closed_form;
mod events;
mod laws;
mod lyapunov;
mod monodromy;
mod orders;
mod published;
mod scipy;
mod special_points;
mod stiff_limit;
mod support;
mod two_parameters;
