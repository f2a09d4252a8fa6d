//! True/false questions: which are put, what the answers make of a label, who goes to people, and agreement with them.

use crate::draft::{cut_in, recorded};
use crate::hand_drive as fixture;
use crate::scripted::{Reply, Scripted};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use whyroad_chat::judge::{
    Judge, JudgedLabel, QuestionKind, agreement_with_people, agreement_with_tasks, is_for_people,
};
use whyroad_chat::scene::NoCamera;
use whyroad_chat::{ChatError, Client, Settings};
use whyroad_framework::Framework;
use whyroad_model::messages::CocLabel;
use whyroad_model::{Drive, Lang};

/// The label of the hand-made cut-in. The car is named, or (omission) a wet road instead.
fn label(drive: &Drive, names_the_car: bool) -> CocLabel {
    let episode = fixture::episode(drive);
    let recorded = recorded(drive);
    let framework = Framework::bundled();
    let mut label =
        whyroad_label::draft::draft(framework, drive, &recorded.signals, &episode, Lang::En).label;
    label.driving_decision.longitudinal = Some(whyroad_model::decision::Longitudinal::YieldToAgent);
    let component = &mut label.critical_components[0];
    component.id = Some("c1".into());
    component.linked_objects = if names_the_car { vec![drive.tracks[0].id.to_string()] } else { Vec::new() };
    component.description =
        if names_the_car { "a car from the left is moving over the line." } else { "the road is wet." }
            .into();
    label.critical_components.truncate(1);
    label.causes = serde_json::from_value(json!({ "longitudinal": { "components": ["c1"] } })).unwrap();
    label
}

fn judged(endpoint: &Scripted, drive: &Drive, label: &CocLabel) -> Result<Option<JudgedLabel>, ChatError> {
    let client = Client::new(Settings::new(&endpoint.url, "judge-model")).unwrap();
    let framework = Framework::bundled();
    let judge = Judge { client: &client, framework, images: &NoCamera, lang: Lang::En };
    judge.judge(drive, &recorded(drive), label, true)
}

/// The car in the ego's lane from the start, slow: the ego has to brake for it.
fn slow_lead() -> Drive {
    let mut drive = cut_in("car-7");
    for i in 0..fixture::FRAMES {
        let car = &mut drive.tracks[0].motion;
        (car.x[i], car.y[i], car.vx[i]) = (65.0 + 0.3 * i as f64, 0.0, 3.0);
    }
    drive
}

fn answer_all(answer: impl Fn(&Value) -> bool + Send + 'static) -> Scripted {
    Scripted::new(move |_, seen| {
        let text = seen.text();
        let statements: Value = serde_json::from_str(text[text.rfind("\n[").unwrap()..].trim()).unwrap();
        let all = statements.as_array().unwrap().iter();
        let answers: Vec<Value> =
            all.map(|s| json!({ "id": s["id"], "answer": answer(s), "reason": "seen" })).collect();
        Reply::Says(json!({ "answers": answers }).to_string())
    })
}

#[test]
fn every_kind_of_question_is_put_and_omission_is_asked_of_what_the_ranking_names() {
    let drive = slow_lead();
    let all_true = answer_all(|_| true);
    let named = judged(&all_true, &drive, &label(&drive, true)).unwrap().unwrap();
    let count = |j: &JudgedLabel, kind| j.questions.iter().filter(|q| q.kind == kind).count();
    assert_eq!(count(&named, QuestionKind::Omission), 0);
    assert_eq!(named.passed, Some(true));
    let omitting = judged(&all_true, &drive, &label(&drive, false)).unwrap().unwrap();
    let kinds: BTreeMap<QuestionKind, usize> =
        QuestionKind::ALL.into_iter().map(|k| (k, count(&omitting, k))).collect();
    let expected = [2, 1, 1, 1, 1, 1, 1, 1];
    assert_eq!(kinds.into_values().collect::<Vec<_>>(), expected);
    // "The object is a cause, too": true is what a correct label would not give.
    let asked = omitting.questions.last().unwrap();
    assert_eq!((asked.text.starts_with("Object o1 (car)"), asked.passed()), (true, Some(false)));
    assert_eq!(omitting.passed, Some(false));
    assert_eq!((omitting.judge.as_str(), omitting.for_people), ("judge-model", true));
}

#[test]
fn an_answer_that_leaves_questions_out_is_asked_for_again_and_given_up() {
    let drive = slow_lead();
    let lazy = Scripted::new(|_, _| {
        Reply::Says(json!({ "answers": [{ "id": "q1", "answer": true, "reason": "" }] }).to_string())
    });
    let result = judged(&lazy, &drive, &label(&drive, true));
    assert_eq!(result, Err(ChatError::Answer("it does not answer q2".into())));
    assert_eq!(lazy.seen().len(), 2);
}

#[test]
fn one_label_in_ten_goes_to_people_whatever_else_is_judged() {
    let drive = slow_lead();
    let mut one = label(&drive, true);
    let chosen = |seed, one: &mut CocLabel| {
        (0..2000)
            .filter(|i| {
                one.clip_id = format!("clip_{i}");
                is_for_people(one, 0.1, seed)
            })
            .collect::<Vec<_>>()
    };
    let (first, again, other) = (chosen(1, &mut one), chosen(1, &mut one), chosen(2, &mut one));
    // 200 expected, standard deviation 13.4.
    assert!((140..=260).contains(&first.len()), "{}", first.len());
    assert_eq!(first, again);
    assert_ne!(first, other);
    assert!(!is_for_people(&one, 0.0, 1) && is_for_people(&one, 1.0, 1));
}

#[test]
fn agreement_counts_answers_that_both_gave() {
    let drive = slow_lead();
    let all_true = answer_all(|_| true);
    let model = judged(&all_true, &drive, &label(&drive, true)).unwrap().unwrap();
    let mut person = model.blank();
    assert!(person.questions.iter().all(|q| q.answer.is_none()) && person.judge == "person");
    assert_eq!(agreement_with_people(std::slice::from_ref(&model), &[person.clone()], 1).labels, 0);
    let n = person.questions.len();
    for (i, q) in person.questions.iter_mut().enumerate().skip(1) {
        q.answer = Some(i > 2);
    }
    let of = agreement_with_people(std::slice::from_ref(&model), &[person.clone()], 1);
    let all = of.kinds.last().unwrap();
    // One left open; two of the others differ.
    assert_eq!((of.labels, all.kind, all.answers), (1, "all", n - 1));
    assert_eq!(all.counts, [0, 0, 2, n - 3]);
    // A person's answers to other questions do not count.
    person.questions.iter_mut().for_each(|q| q.text.push('!'));
    assert_eq!(agreement_with_people(std::slice::from_ref(&model), &[person], 1).unmatched, 1);

    let task = |action: &str, state: &str| {
        let label = serde_json::to_value(label(&drive, true)).unwrap();
        let history = json!([{ "action": "submit", "draft": label }, { "action": action }]);
        json!({ "task": { "state": state, "draft": label, "history": history } })
    };
    let tasks = [task("accept", "accepted"), task("send_back", "accepted"), task("take", "check")];
    let of = agreement_with_tasks(&[model], &tasks, 1);
    assert_eq!((of.labels, of.kinds[0].counts), (2, [0, 0, 1, 1]));
}
