//! `light.state` compared with the letters of `SaveTLSStates`. The letter for the ego is determined from its later
//! path: the first lane inside the junction that FCD names has a link number in the network.

use super::{GRID_RUN, Tally};

fn word(letter: u8) -> &'static str {
    match letter {
        b'r' => "red",
        b'y' => "yellow",
        b'G' => "green",
        b'g' => "green_yield",
        _ => "other",
    }
}

#[test]
fn light_states_are_the_simulators() {
    let s = &GRID_RUN.truth;
    let mut tally = Tally::default();
    for (&ego, derived) in &GRID_RUN.seen_from {
        let column = &derived.table.frame_columns["light.state"];
        for (&step, &frame) in &derived.frames {
            let now = s.vehicle(step, ego).expect("the ego is in its own log");
            let ahead = (step..).map_while(|t| s.vehicle(t, ego)).find(|v| v.lane.starts_with(':'));
            let Some(next) = ahead.filter(|_| !now.lane.starts_with(':')) else { continue };
            let end = s.lane_end[&now.lane];
            let distance = (end.0 - now.x).hypot(end.1 - now.y);
            let letter = |(light, link): &(String, usize)| {
                let letters = s.lights[light].range(..=step).next_back().expect("a state before").1;
                word(letters.as_bytes()[*link])
            };
            let expected = s.link_of.get(&next.lane).filter(|_| distance < 140.0).map(letter);
            // Between 140 and 160 m either answer is accepted: our reach is 150 m from the center.
            if expected.is_none() && s.link_of.contains_key(&next.lane) {
                continue;
            }
            let known = column.category(frame);
            // Behind a junction without lights the next one within reach may already be reported. Its link for the ego
            // is known only if the ego drives through it before its log ends.
            let beyond = expected.is_none() && known.is_some_and(|k| k != "none");
            let lit = (step..).map_while(|t| s.vehicle(t, ego)).find_map(|v| s.link_of.get(&v.lane));
            if beyond && lit.is_none() {
                continue;
            }
            let expected = if beyond { lit.map(letter) } else { expected };
            let changing = s.lane_changes.iter().any(|c| c.vehicle == ego && (c.step - step).abs() <= 40);
            tally.add(match (known, expected) {
                (Some("none"), None) => "none, as there",
                (Some(a), Some(b)) if a == b => "same",
                _ if changing => "while changing lanes",
                (Some("none") | None, Some(_)) => "theirs only",
                (Some(_), None) => "ours only",
                _ => "different",
            });
        }
    }
    println!("light state, grid: {}", tally.line());
    assert!(tally.get("same") > 500, "{}", tally.line());
    assert!(tally.share(&["same", "none, as there"]) > 0.99, "{}", tally.line());
}
