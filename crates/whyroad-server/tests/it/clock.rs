//! A clock that jumps: leases may end early or late because of it, but no task is ever held twice and no acknowledged
//! data is lost.

use crate::work::Work;
use crate::world::World;
use serde_json::json;

/// A day, s.
const DAY: i64 = 86_400;

pub fn a_clock_that_jumps_gives_no_task_twice(world: &World) {
    let admin = world.admin();
    let p = world.project(&admin, "p", &json!({}));
    let task = world.tasks(&admin, &p, &["drive1"], 1).remove(0);
    let one = world.person(&admin, &p, "one", &["annotator"]);
    let two = world.person(&admin, &p, "two", &["annotator"]);
    let component = |text: &str| json!([{ "description": text }]);
    let take =
        |who: &crate::world::Person| who.post(&format!("/tasks/{task}/lease"), &json!({ "action": "take" }));

    // Back by a day: the lease only seems longer; its holder continues, and nobody else gets the task.
    let mut first = Work::take(&one, &task);
    world.wait(-DAY);
    assert_eq!(first.set(&[("/critical_components", component("first"))]).status, 200);
    assert_ne!(take(&two).status, 200);

    // Forward by two days: the lease has expired, another user gets the task, and the older token cannot write any
    // more.
    world.wait(2 * DAY);
    let mut second = Work::take(&two, &task);
    assert!(second.fence > first.fence);
    let late = first.set(&[("/critical_components", component("late"))]);
    // For a user who is not concerned by a Stage I any more, the task does not exist.
    assert_eq!(late.refusal(), (404, "not_found".to_owned()));

    // Back again, to before the second lease began: its holder renews it, and the first lease does not become valid
    // again.
    world.wait(-2 * DAY);
    assert_eq!(first.set(&[("/critical_components", component("later"))]).refusal().0, 404);
    assert_eq!(second.set(&[("/critical_components", component("second"))]).status, 200);
    assert_ne!(take(&one).status, 200);
    assert_eq!(second.view()["draft"]["critical_components"][0]["description"], "second");
}

pub fn a_clock_that_jumps_makes_no_lease_longer(world: &World) {
    let admin = world.admin();
    let p = world.project(&admin, "p", &json!({}));
    let task = world.tasks(&admin, &p, &["drive1"], 1).remove(0);
    let one = world.person(&admin, &p, "one", &["annotator"]);
    let two = world.person(&admin, &p, "two", &["annotator"]);
    // Taken while the clock was two hours ahead, and then left: a lease is five minutes.
    world.wait(7200);
    Work::take(&one, &task);
    world.wait(-7200 + 301);
    assert_eq!(Work::next(&two, &p, "label").map(|w| w.task), Some(task));
}
