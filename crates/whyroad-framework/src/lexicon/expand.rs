//! Patterns to plain texts: `(a|b|)` is a choice, `{side}` a word of one side.

use super::Sides;
use whyroad_model::decision::LateralDirection;

/// One plain text of a pattern.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plain {
    pub text: String,
    pub side: Option<LateralDirection>,
}

/// All texts of `pattern`; `None` when a bracket is open.
pub(super) fn expand(pattern: &str, sides: &Sides) -> Option<Vec<Plain>> {
    let mut out = Vec::new();
    for text in choices(pattern)? {
        // An empty choice leaves two spaces; a text that is punctuation and a space keeps its space.
        let mut text = text;
        while text.contains("  ") {
            text = text.replace("  ", " ");
        }
        let text = if pattern.starts_with('(') { text.trim_start().to_owned() } else { text };
        if !text.contains("{side}") {
            out.push(Plain { text, side: None });
            continue;
        }
        let is_ascii = text.is_ascii();
        for (side, words) in [(LateralDirection::Left, &sides.left), (LateralDirection::Right, &sides.right)]
        {
            let words = if is_ascii { &words.en } else { &words.zh };
            out.extend(words.iter().map(|w| Plain { text: text.replace("{side}", w), side: Some(side) }));
        }
    }
    Some(out)
}

/// The choices of the first bracket, times those of the rest.
pub fn choices(pattern: &str) -> Option<Vec<String>> {
    let Some(open) = pattern.find('(') else {
        return (!pattern.contains([')', '|'])).then(|| vec![pattern.to_owned()]);
    };
    let close = open + pattern[open..].find(')')?;
    let rest = choices(&pattern[close + 1..])?;
    let head = &pattern[..open];
    Some(
        pattern[open + 1..close]
            .split('|')
            .flat_map(|choice| rest.iter().map(move |r| format!("{head}{choice}{r}")))
            .collect(),
    )
}
