//! Time from which the log shows that the ego intends to move over (LABELING.md 4, row lane_change): the indicator to
//! that side, or a routing command that requires it. The reason is not determined: unstated reasons are determined by
//! the rules.

use crate::road::lane_change::Side;
use crate::series::GAP_S;
use crate::target::interaction::Interaction;
use whyroad_model::scene::TurnSignal;

/// An intention is traced back over at most the length of a clip, s (LABELING.md 4).
const LONGEST_S: f64 = 20.0;
/// Jitter of timestamps, s.
const CLOCK_S: f64 = 0.02;

fn shows(signal: TurnSignal, side: Side) -> bool {
    matches!((signal, side), (TurnSignal::Left, Side::Left) | (TurnSignal::Right, Side::Right))
}

/// Whether a car moves over to that side for this routing command. For a command to go straight on it may change to
/// either side.
fn asks_for(command: &str, side: Side) -> bool {
    match side {
        Side::Left => matches!(command, "left" | "uturn"),
        Side::Right => matches!(command, "right" | "exit"),
    }
}

/// First frame of an intention to move over to `side`, for a motion whose first frame is `first`; `first` if the log
/// has none. It is not traced back beyond `earliest`.
pub fn formed(scene: &Interaction<'_>, side: Side, first: usize, earliest: usize) -> usize {
    let times = scene.times;
    let bus = scene.drive.ego.as_ref().map(|e| &e.bus);
    // First frame of the uninterrupted run just before the motion in which it holds.
    let since = |holds: &dyn Fn(usize) -> bool| {
        let mut from = first;
        while from > earliest
            && times[first] - times[from - 1] <= LONGEST_S + CLOCK_S
            && times[from] - times[from - 1] <= GAP_S
            && holds(from - 1)
        {
            from -= 1;
        }
        from
    };
    let signal = |i: usize| bus?.turn_signal.get(i).copied().flatten();
    let command = |i: usize| bus?.route_command.get(i)?.as_deref();
    let indicated = since(&|i| signal(i).is_some_and(|s| shows(s, side)));
    let commanded = since(&|i| command(i).is_some_and(|c| asks_for(c, side)));
    // The time of a command is known only if the log shows no command, or another one, before.
    let given = commanded > earliest && command(commanded - 1).is_some_and(|c| !asks_for(c, side));
    if given { indicated.min(commanded) } else { indicated }
}
