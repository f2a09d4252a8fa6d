//! Rain from wipers that run continuously (taxonomy, weather_adaptation.rain). A single wipe cleans the windscreen, and
//! wipers that are off do not determine the weather: fog, snow and light drizzle need none.

use whyroad_model::Drive;

/// Minimum time for which wipers run, and the maximum pause between wipes, s. Washing takes a few wipes.
const RUN_ON_S: f64 = 15.0;
const PAUSE_S: f64 = 12.0;

/// `context.weather`: rain from when the wipers have run long enough until they have paused too long.
pub(super) fn weather(drive: &Drive) -> Vec<Option<&'static str>> {
    let Some(ego) = drive.ego.as_ref().filter(|e| !e.bus.wipers.is_empty()) else { return Vec::new() };
    let mut since = None;
    let mut last = None;
    let mut out = Vec::with_capacity(drive.times.len());
    for (wiping, time) in ego.bus.wipers.iter().zip(&drive.times) {
        if *wiping == Some(true) {
            since.get_or_insert(*time);
            last = Some(*time);
        }
        if last.is_some_and(|l| time.seconds_since(l) > PAUSE_S) {
            (since, last) = (None, None);
        }
        let lasts = since.zip(last).is_some_and(|(a, b)| b.seconds_since(a) >= RUN_ON_S);
        out.push(lasts.then_some("rain"));
    }
    out
}
