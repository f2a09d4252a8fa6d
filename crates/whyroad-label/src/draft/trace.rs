//! The draft of the trace: state, then decision, in one sentence. It has no reason of its own to give, which is
//! why it opens with a mark that it is a draft.

use whyroad_framework::DecisionSets;
use whyroad_model::Lang;
use whyroad_model::decision::LateralDirection;
use whyroad_model::messages::{CriticalComponent, DrivingDecision};

pub(super) fn sentence(
    names: &DecisionSets,
    components: &[CriticalComponent],
    decision: &DrivingDecision,
    lang: Lang,
) -> String {
    let state: Vec<&str> = components.iter().map(|c| c.description.as_str()).collect();
    let mut actions: Vec<String> = Vec::new();
    if let Some(text) = decision.longitudinal.and_then(|d| names.longitudinal(d)) {
        actions.push(text.name.get(lang).to_owned());
    }
    if let Some(text) = decision.lateral.and_then(|d| names.lateral(d)) {
        let name = text.name.get(lang);
        actions.push(match (lang, decision.lateral_direction) {
            (Lang::Zh, Some(LateralDirection::Left)) => format!("向左{name}"),
            (Lang::Zh, Some(LateralDirection::Right)) => format!("向右{name}"),
            (Lang::En, Some(LateralDirection::Left)) => format!("{name} to the left"),
            (Lang::En, Some(LateralDirection::Right)) => format!("{name} to the right"),
            _ => name.to_owned(),
        });
    }
    match lang {
        Lang::Zh => {
            let state =
                if state.is_empty() { String::new() } else { format!("{}，因此", state.join("，")) };
            let action = if actions.is_empty() {
                "自车行驶状态不变".to_owned()
            } else {
                format!("自车{}", actions.join("并"))
            };
            format!("【草稿】{state}{action}。")
        }
        Lang::En => {
            let state =
                if state.is_empty() { String::new() } else { format!("{}; therefore ", state.join("; ")) };
            let action = if actions.is_empty() {
                "the ego goes on as before".to_owned()
            } else {
                format!("the ego's decision: {}", actions.join(" and ").to_lowercase())
            };
            format!("[DRAFT] {state}{action}.")
        }
    }
}
