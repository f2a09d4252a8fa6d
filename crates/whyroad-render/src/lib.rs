//! Scenes and charts: the bird's-eye view of one moment as markup or PNG, the plot of one signal, bar charts,
//! conditions over time.
//!
//! Nothing here decides what is shown: callers choose the frame, the target and the signals.

pub mod bars;
pub mod birds_eye;
pub mod charts;
pub mod language;
pub mod markup;
pub mod plot;
pub mod raster;
pub mod traces;
pub mod truths;
mod view;
