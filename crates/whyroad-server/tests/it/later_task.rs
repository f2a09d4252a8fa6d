//! Attacks on Stage I through other tasks of the same drive: a task with a later keyframe shows, already in its own
//! Stage I, what comes after an earlier one.

use crate::recorded::{at, episode};
use crate::work::Work;
use crate::world::{Person, Reply, World};
use serde_json::{Value, json};

/// Tasks of one drive: with the keyframe at 9.4 s, and 4 s later. Returns their ids.
pub fn two_moments(world: &World, admin: &Person, project: &str, drive: &str) -> (String, String) {
    let mut later = episode(drive, 2, world.future);
    (later.keyframe.timestamp, later.keyframe.frame_idx) = (at(134), 134);
    (later.time_range.start_timestamp, later.time_range.end_timestamp) = (at(114), at(150));
    (later.time_range.start_frame_idx, later.time_range.end_frame_idx) = (Some(114), Some(150));
    let body = json!({ "episodes": [episode(drive, 1, world.future), later] });
    let made = admin.post(&format!("/projects/{project}/tasks:create"), &body).fine();
    let id = |i: usize| made["tasks"][i].as_str().unwrap().to_owned();
    (id(0), id(1))
}

pub fn take(who: &Person, task: &str) -> Reply {
    who.post(&format!("/tasks/{task}/lease"), &json!({ "action": "take" }))
}

pub fn give_back(work: &Work<'_>) {
    work.who.post(&work.path("/lease"), &json!({ "action": "release", "fence": work.fence })).fine();
}

fn reasons(who: &Person, project: &str) -> Value {
    who.get(&format!("/projects/{project}/queue")).fine()["reasons"].clone()
}

pub fn taking_a_later_task_bars_from_the_earlier_one(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    let (early, late) = two_moments(world, &admin, &project, "drive1");
    // While it is held: neither directly nor from the queue.
    let held = Work::take(&ann, &early);
    assert_eq!(take(&ann, &late).refusal(), (409, "task.stage1_first".into()));
    assert_eq!(ann.get(&format!("/tasks/{late}")).status, 404);
    give_back(&held);
    // Taking it is permitted, but then the earlier one is not available to her: neither directly, from the queue, nor
    // by assignment.
    let later = Work::take(&ann, &late);
    give_back(&later);
    assert_eq!(take(&ann, &early).refusal(), (403, "task.future_seen".into()));
    let next = Work::next(&ann, &project, "label").map(|w| w.task);
    assert_eq!(next.as_deref(), Some(late.as_str()), "the queue gives the other one only");
    let assign = admin.post(&format!("/tasks/{early}/assign"), &json!({ "user": "ann" }));
    assert_eq!(assign.refusal(), (409, "assign.future_seen".into()));
    let bob = world.person(&admin, &project, "bob", &["annotator"]);
    admin.post(&format!("/tasks/{early}/assign"), &json!({ "user": "bob" })).fine();
    take(&bob, &early).fine();
    assert_eq!(reasons(&bob, &project), json!([]));
}

pub fn a_task_that_comes_back_asks_again_what_was_seen(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    let (early, late) = two_moments(world, &admin, &project, "drive1");
    let mut work = Work::take(&ann, &early);
    work.act("skip", &json!({ "reason": "unclear" })).fine();
    Work::take(&ann, &late);
    admin.post(&format!("/tasks/{early}/actions"), &json!({ "action": "reopen", "reason": "again" })).fine();
    assert_eq!(take(&ann, &early).refusal(), (403, "task.future_seen".into()));
    assert!(reasons(&ann, &project).as_array().is_some(), "and the queue answers");
}

pub fn opening_a_later_task_shows_no_future_of_the_one_in_hand(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({}));
    // Staff may open any task of the project, including one that is still in Stage I.
    let both = world.person(&admin, &project, "both", &["annotator", "checker"]);
    let (early, late) = two_moments(world, &admin, &project, "drive1");
    let work = Work::take(&both, &early);
    for path in ["", "/scene", "/map", "/history", "/media/front%20left/0"] {
        let answer = both.get(&format!("/tasks/{late}{path}"));
        assert_eq!(answer.refusal(), (409, "task.stage1_first".into()), "{path}");
    }
    give_back(&work);
    both.get(&format!("/tasks/{late}/scene")).fine();
    assert_eq!(take(&both, &early).refusal(), (403, "task.future_seen".into()));

    // The other order is no leak: the part before a keyframe belongs to its history.
    let cara = world.person(&admin, &project, "cara", &["annotator", "checker"]);
    Work::take(&cara, &late);
    cara.get(&format!("/tasks/{early}")).fine();
}

pub fn where_only_the_episode_bars_a_later_task_may_be_begun(world: &World) {
    let admin = world.admin();
    let project = world.project(&admin, "town", &json!({ "history": "episode" }));
    let ann = world.person(&admin, &project, "ann", &["annotator"]);
    let (early, late) = two_moments(world, &admin, &project, "drive1");
    Work::take(&ann, &early);
    let mut later = Work::take(&ann, &late);
    // Its whole future still shows that of the other one, which is in Stage I.
    later.stage1();
    let lock = later.act("lock_stage1", &json!({}));
    assert_eq!(lock.refusal(), (409, "task.stage1_first".into()));
}
