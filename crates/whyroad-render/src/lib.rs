//! Scenes and charts as markup: the bird's-eye view of one moment and the plot of one signal.
//!
//! Nothing here decides what is shown: callers choose the frame, the target and the signals.

pub mod birds_eye;
pub mod markup;
pub mod plot;
pub mod traces;
mod view;
