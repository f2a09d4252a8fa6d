//! The ego alone: its motion, its meta actions, its vehicle bus.

pub mod bus;
pub mod meta_actions;
pub mod motion;
