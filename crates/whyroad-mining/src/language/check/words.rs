//! How faults name types, dimensions and operators, in both languages.

use super::super::Fault;
use super::super::program::ValueKind;
use super::super::syntax::Span;
use super::names::nearest;
use whyroad_model::units::Dimension;

/// Operators written as calls, with their forms.
const CALLS: &[(&str, &str)] = &[
    ("abs", "abs(x)"),
    ("min", "min(x, 3 s)"),
    ("max", "max(x, 3 s)"),
    ("share", "share(c, 3 s)"),
    ("rises", "rises(c)"),
    ("falls", "falls(c)"),
    ("previously", "previously(c) or previously(c, 3 s)"),
    ("count", "count(c) >= 2"),
    ("exists", "exists(c)"),
    ("forall", "forall(c)"),
    ("least", "least(x) < 2 s"),
    ("greatest", "greatest(x) > 2 s"),
];

pub(super) fn unknown_call(name: &str, count: usize, span: Span) -> Fault {
    if let Some((_, form)) = CALLS.iter().find(|(n, _)| *n == name) {
        return Fault::new(
            "rule.call",
            span,
            format!("{name} 的参数不对（给了 {count} 个）"),
            format!("{name} does not take {count} argument(s) here"),
        )
        .hint(format!("写法：{form}"), format!("it is written {form}"));
    }
    if matches!(name, "first" | "last") {
        return Fault::new(
            "rule.call",
            span,
            format!("{name}(…) 是时刻，不是条件"),
            format!("{name}(..) is a moment, not a condition; moments belong in keyframe, start and end"),
        );
    }
    let fault = Fault::new(
        "rule.call",
        span,
        format!("没有名为 {name} 的运算"),
        format!("operator '{name}' not found"),
    );
    let all: Vec<&str> = CALLS.iter().map(|(_, form)| *form).collect();
    let all = all.join(", ");
    match nearest(name, CALLS.iter().map(|(n, _)| *n)) {
        Some(n) => fault
            .hint(format!("是否想写 '{n}'？可用：{all}"), format!("did you mean '{n}'? There are: {all}")),
        None => fault.hint(format!("可用：{all}"), format!("there are: {all}")),
    }
}

pub(super) fn mismatch(span: Span, a: Dimension, b: Dimension) -> Fault {
    Fault::new(
        "rule.unit.mismatch",
        span,
        format!("单位不一致：{} 与 {}", dimension_zh(a), dimension_zh(b)),
        format!("units do not match: {} and {}", dimension_en(a), dimension_en(b)),
    )
    .hint(
        "两边须为同一种量：改用另一个信号，或改正参数的单位",
        "both sides must be of one kind: use another signal, or correct the unit of the parameter",
    )
}

fn with_unit(word: &str, d: Dimension) -> String {
    match d.base().symbol {
        "" => word.to_owned(),
        unit => format!("{word} ({unit})"),
    }
}

fn dimension_en(d: Dimension) -> String {
    let word = match d {
        Dimension::Ratio => "a number without a unit",
        Dimension::Length => "a length",
        Dimension::Time => "a time",
        Dimension::Speed => "a speed",
        Dimension::Acceleration => "an acceleration",
        Dimension::Jerk => "a jerk",
        Dimension::Angle => "an angle",
        Dimension::AngularSpeed => "an angular speed",
        Dimension::Curvature => "a curvature",
    };
    with_unit(word, d)
}

fn dimension_zh(d: Dimension) -> String {
    let word = match d {
        Dimension::Ratio => "无单位的数",
        Dimension::Length => "长度",
        Dimension::Time => "时间",
        Dimension::Speed => "速度",
        Dimension::Acceleration => "加速度",
        Dimension::Jerk => "加加速度",
        Dimension::Angle => "角度",
        Dimension::AngularSpeed => "角速度",
        Dimension::Curvature => "曲率",
    };
    with_unit(word, d)
}

pub(super) fn kind_en(k: &ValueKind) -> String {
    match k {
        ValueKind::Number(d) => dimension_en(*d),
        ValueKind::Condition => "a condition".to_owned(),
        ValueKind::Category(_) => "a category".to_owned(),
    }
}

pub(super) fn kind_zh(k: &ValueKind) -> String {
    match k {
        ValueKind::Number(d) => dimension_zh(*d),
        ValueKind::Condition => "条件".to_owned(),
        ValueKind::Category(_) => "类别".to_owned(),
    }
}
