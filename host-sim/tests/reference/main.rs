//! Both engines against what is known independently of them.

mod balances;
mod closed_form;
mod events;
mod laws;
mod monodromy;
mod orders;
mod scipy;
mod stiff_limit;
mod support;
