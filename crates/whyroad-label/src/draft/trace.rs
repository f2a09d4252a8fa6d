//! The draft of the trace: the state, why it calls for a decision, the decision (LABELING.md 7), in words of
//! `schema/draft_texts.yaml`. Which phrasing is taken follows from a seed, so that the same episode gives the same
//! text.

use whyroad_framework::Framework;
use whyroad_framework::label_words::WordRole;
use whyroad_model::messages::{CriticalComponent, DrivingDecision};
use whyroad_model::{Lang, ScenarioId};

/// Phrasings of one trace: of the reason, and of the decision.
const PHRASINGS: u64 = 2;

/// The trace with the phrasing that `seed` chooses.
pub(super) fn sentence(
    framework: &Framework,
    class: &ScenarioId,
    components: &[CriticalComponent],
    decision: &DrivingDecision,
    lang: Lang,
    seed: u64,
) -> String {
    let texts = &framework.draft_texts;
    // Two things in the state are enough for a person to see what matters.
    let state: Vec<&str> =
        components.iter().take(2).map(|c| c.description.trim_end_matches(['。', '.'])).collect();
    let why = texts.why(class).map_or("", |p| p.pick(lang, seed));
    let action = action(framework, decision, lang, seed / PHRASINGS);
    match lang {
        Lang::Zh => {
            let state = state.join("，");
            let head =
                [state.as_str(), why].into_iter().filter(|t| !t.is_empty()).collect::<Vec<_>>().join("，");
            if head.is_empty() { format!("{action}。") } else { format!("{head}，因此{action}。") }
        }
        Lang::En => {
            let state = capital(&state.join("; "));
            let head = match (state.is_empty(), why.is_empty()) {
                (true, true) => return format!("{}.", capital(&action)),
                (false, true) => state,
                (true, false) => capital(why),
                (false, false) => format!("{state}; {why}"),
            };
            format!("{head}, so {action}.")
        }
    }
}

/// The decision of both channels.
fn action(framework: &Framework, decision: &DrivingDecision, lang: Lang, seed: u64) -> String {
    let texts = &framework.draft_texts;
    let along =
        decision.longitudinal.and_then(|d| texts.longitudinal(d)).map(|p| p.pick(lang, seed).to_owned());
    let across = decision.lateral.and_then(|d| texts.lateral(d)).map(|p| {
        let side = decision.lateral_direction.map_or("", |s| texts.side(s, lang));
        p.pick(lang, seed).replace("{side}", side).replace("  ", " ")
    });
    match (lang, along, across) {
        (_, None, None) => texts.none().pick(lang, seed).to_owned(),
        (Lang::Zh, Some(a), Some(b)) => format!("{a}，并{b}"),
        (Lang::Zh, None, Some(b)) => format!("自车{b}"),
        (Lang::En, Some(a), Some(b)) => format!("{a} and {b}"),
        (Lang::En, None, Some(b)) => format!("the ego {b}"),
        (_, Some(a), None) => a,
    }
}

fn capital(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map_or_else(String::new, |c| c.to_uppercase().chain(chars).collect())
}

/// A number from an id, the same on every machine (FNV-1a).
pub(super) fn seed(id: &str) -> u64 {
    id.bytes().fold(0xcbf2_9ce4_8422_2325, |h, b| (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3))
}

/// True when `trace` is what a draft of these parts says, in any of its phrasings: nobody has written it.
pub(crate) fn is_draft(
    framework: &Framework,
    class: &ScenarioId,
    components: &[CriticalComponent],
    decision: &DrivingDecision,
    trace: &str,
) -> bool {
    let bare = |t: &str| t.chars().filter(|c| c.is_alphanumeric()).collect::<String>();
    let trace = bare(trace);
    [Lang::Zh, Lang::En].into_iter().any(|lang| {
        (0..PHRASINGS * PHRASINGS)
            .any(|seed| bare(&sentence(framework, class, components, decision, lang, seed)) == trace)
    })
}

/// The component that says what the class is about, where the recording tells none that does.
pub(super) fn seen(
    framework: &Framework,
    class: &ScenarioId,
    found: &[CriticalComponent],
    lang: Lang,
) -> Option<CriticalComponent> {
    let words = &framework.label_words;
    let about = framework.decision_table.leaves.get(class).map(|c| c.about);
    let speaks = |c: &CriticalComponent| {
        let mut any = false;
        words.hits(&c.description, |hit| {
            any |= matches!(hit.role, WordRole::Object(g) if about.is_some_and(|a| words.objects[g].own.meets(a)));
        });
        any
    };
    // Where nothing is known of the class, what was found has to do.
    if found.iter().any(speaks) || (about.is_none() && !found.is_empty()) {
        return None;
    }
    let seen = framework.draft_texts.seen(class)?;
    Some(CriticalComponent {
        category: None,
        description: seen.get(lang).to_owned(),
        uncertainty: seen.high.then_some(whyroad_model::messages::Uncertainty::High),
        id: None,
        evidence_times: Vec::new(),
        linked_objects: Vec::new(),
    })
}
