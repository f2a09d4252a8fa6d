//! Unknown names, and suggestions.

use super::super::Fault;
use super::super::syntax::Span;
use whyroad_signals::SignalKind;
use whyroad_signals::catalog::Catalog;

/// Prefixes that name a target and at the same time say what it is (DATA_FORMAT.md 5.1 `target_vehicle.`).
const TARGET_PREFIXES: &[&str] = &["target_vehicle.", "target_vru."];

/// The fault for a name that is neither a signal nor one of the rule's `own` names.
pub(super) fn unknown<'n>(
    catalog: &'n Catalog,
    written: &str,
    span: Span,
    own: impl Iterator<Item = &'n str>,
) -> Fault {
    let fault = Fault::new(
        "rule.signal.unknown",
        span,
        format!("没有名为 '{written}' 的信号或参数"),
        format!("signal or parameter '{written}' not found"),
    );
    let prefix = TARGET_PREFIXES.iter().find(|p| written.starts_with(**p));
    let plain = prefix.map_or(written.to_owned(), |p| format!("target.{}", &written[p.len()..]));
    let known = || {
        catalog
            .iter()
            .flat_map(|d| std::iter::once(d.name.as_str()).chain(d.aliases.iter().map(String::as_str)))
    };
    let own: Vec<&str> = own.collect();
    let near = if plain.contains('.') {
        nearest(&plain, known().chain(own))
    } else if let Some(near) = nearest(&plain, known().filter(|n| !n.contains('.')).chain(own)) {
        Some(near)
    } else {
        return of_a_word(catalog, &plain, fault);
    };
    match near {
        Some(n) => {
            let n = match (prefix, n.strip_prefix("target.")) {
                (Some(p), Some(rest)) => format!("{p}{rest}"),
                _ => n.to_owned(),
            };
            fault.hint(format!("是否想写 '{n}'？"), format!("did you mean '{n}'?"))
        }
        None => see_the_list(fault),
    }
}

/// The fault for a definition that is written below the one that uses it.
pub(super) fn defined_later(name: &str, span: Span) -> Fault {
    Fault::new(
        "rule.name",
        span,
        format!("定义 '{name}' 写在用到它的定义之后"),
        format!("'{name}' is defined below the definition that uses it"),
    )
    .hint(
        "定义只能用到写在它前面的名称：把它移到前面；两个定义不能互相引用",
        "a definition can use only earlier ones: move it up; two definitions cannot use each other",
    )
}

/// `speed` may have been meant as `ego.speed`; `left` is what a category is compared with.
fn of_a_word(catalog: &Catalog, word: &str, fault: Fault) -> Fault {
    let names = || catalog.iter().map(|d| d.name.as_str());
    let whole: Vec<&str> = names().filter(|n| n.rsplit('.').next() == Some(word)).take(3).collect();
    if !whole.is_empty() {
        let quoted: Vec<String> = whole.iter().map(|n| format!("'{n}'")).collect();
        return fault.hint(
            format!("是否想写 {}？", quoted.join(" 或 ")),
            format!("did you mean {}?", quoted.join(" or ")),
        );
    }
    let of = catalog.iter().find(|d| match &d.kind {
        SignalKind::Category(values) => values.iter().any(|v| v == word),
        _ => false,
    });
    if let Some(signal) = of.map(|d| &d.name) {
        return fault.hint(
            format!("'{word}' 是类别的取值，只能与类别信号比较，如 {signal} == {word}"),
            format!("'{word}' is a value of a category: compare it with one, as in {signal} == {word}"),
        );
    }
    see_the_list(fault)
}

fn see_the_list(fault: Fault) -> Fault {
    fault.hint(
        "可用信号见 `whyroad signals list`（docs/reference/signals.md）",
        "`whyroad signals list` (docs/reference/signals.md) shows the signals",
    )
}

/// The same fault with a moment of the match as its suggestion, where that is what the unknown name resembles.
pub(super) fn or_moment(written: &str, fault: Fault) -> Fault {
    let near = nearest(written, ["keyframe", "match.start", "match.end"].into_iter());
    match near.filter(|_| fault.code == "rule.signal.unknown") {
        Some(moment) => fault.hint(format!("是否想写 '{moment}'？"), format!("did you mean '{moment}'?")),
        None => fault,
    }
}

/// The fault for a word that is both a value of a category and a name of the rule.
pub(super) fn also_a_value(name: &str, span: Span) -> Fault {
    Fault::new(
        "rule.name",
        span,
        format!("'{name}' 既是类别的取值，又是本规则的参数或定义的名称"),
        format!("'{name}' is a value of a category here, and also a parameter or a definition of this rule"),
    )
    .hint("请给参数或定义换一个名称", "give the parameter or the definition another name")
}

/// The fault for `obstacle.gapp`, where `obstacle` is a role.
pub(super) fn unknown_of_role(catalog: &Catalog, role: &str, written: &str, span: Span) -> Fault {
    let fault = Fault::new(
        "rule.signal.unknown",
        span,
        format!("没有名为 'target.{written}' 的信号，角色 {role} 也就没有 '{written}'"),
        format!("signal 'target.{written}' not found, so '{role}' has no '{written}'"),
    );
    let known = catalog.iter().filter_map(|d| d.name.strip_prefix("target."));
    match nearest(written, known) {
        Some(n) => fault.hint(format!("是否想写 '{role}.{n}'？"), format!("did you mean '{role}.{n}'?")),
        None => fault.hint(
            "角色可用的是 schema/signals.yaml 中的 target.* 信号",
            "a role has the target.* signals of schema/signals.yaml",
        ),
    }
}

/// The fault for `pair.distanc`, where `prefix` stands for signals of `family`.
pub(super) fn unknown_of_family(
    catalog: &Catalog,
    (prefix, family): (&str, &str),
    written: &str,
    span: Span,
) -> Fault {
    let fault = Fault::new(
        "rule.signal.unknown",
        span,
        format!("没有名为 '{family}.{written}' 的信号"),
        format!("signal '{family}.{written}' not found"),
    );
    let start = format!("{family}.");
    let known = catalog.iter().filter_map(|d| d.name.strip_prefix(&start));
    match nearest(written, known) {
        Some(n) => fault.hint(format!("是否想写 '{prefix}.{n}'？"), format!("did you mean '{prefix}.{n}'?")),
        None => see_the_list(fault),
    }
}

/// The candidate most like `written`, when one is similar enough to be a suggestion. The first one wins a tie.
pub fn nearest<'c>(written: &str, candidates: impl Iterator<Item = &'c str>) -> Option<&'c str> {
    let mut best: Option<(f64, &str)> = None;
    for c in candidates {
        let likeness =
            strsim::jaro_winkler(written, c).max(strsim::normalized_damerau_levenshtein(written, c));
        if likeness > best.map_or(0.0, |b| b.0) {
            best = Some((likeness, c));
        }
    }
    // Below this, names of one family (`target.speed`, `target.accel`) are proposed for nonsense.
    best.filter(|(likeness, _)| *likeness >= 0.8).map(|(_, c)| c)
}

/// The fault for `pair.`, `reverse.` or `other.` where there is no other object.
pub(super) fn no_other(name: &str, span: Span) -> Fault {
    Fault::new(
        "rule.target",
        span,
        format!("'{name}' 说的是两个对象，但此处只有一个"),
        format!("'{name}' refers to two objects, but there is only one here"),
    )
    .hint(
        "写在 exists、forall 或 count 之内，例如 exists(pair.sector == right, bicycle)，或给规则第二个角色",
        "write it inside exists, forall or count, as in exists(pair.sector == right, bicycle), or give the rule a second role",
    )
}
