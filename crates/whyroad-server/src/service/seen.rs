//! Records which part of a drive each user was shown: nobody does Stage I of a part that they have seen. Every view
//! counts, including those of Stage I: a task with a later keyframe shows what comes after an earlier one.

use crate::domain::project::HistoryRule;
use crate::domain::workflow::{Actor, Role, Seen, Stage, State};
use crate::problem::{Answer, Problem};
use crate::service::tasks::TaskRow;
use crate::service::{copies, projects};
use crate::store::{Store, Tx};
use crate::values;
use whyroad_model::DriveId;

/// The user as an actor on `t`: roles, and whether its future was shown to them, by this task or by another of its
/// drive.
pub fn actor(tx: &mut dyn Tx, t: &TaskRow, user: &str, roles: &[Role], rule: HistoryRule) -> Answer<Actor> {
    let has_seen = if knows(tx, t, user, rule)? { Seen::Future } else { Seen::History };
    Ok(Actor { id: user.to_owned(), roles: roles.to_vec(), has_seen })
}

fn knows(tx: &mut dyn Tx, t: &TaskRow, user: &str, rule: HistoryRule) -> Answer<bool> {
    // Gold tasks and tasks of another class are of the same episode.
    let episode = copies::mined_of(&t.episode.episode_id);
    let [copies, classes] = copies::from_mined(episode);
    let row = match rule {
        HistoryRule::Drive => tx.row(
            "SELECT 1 FROM seen WHERE user_id = $1 AND drive_id = $2 AND to_ns > $3 AND from_ns < $4 LIMIT 1",
            values![user, &t.drive_id, t.keyframe_ns, t.to_ns],
        )?,
        HistoryRule::Episode => tx.row(
            "SELECT 1 FROM seen s LEFT JOIN tasks o ON o.id = s.task_id
             WHERE s.user_id = $1 AND s.drive_id = $2 AND s.to_ns > $4
               AND (o.episode_id = $3 OR substr(o.episode_id, 1, length($5)) IN ($6, $7) OR s.task_id = $8)
             LIMIT 1",
            values![
                user,
                &t.drive_id,
                episode,
                t.keyframe_ns,
                &copies,
                &copies,
                &classes,
                of_episode(episode)
            ],
        )?,
    };
    Ok(row.is_some())
}

/// The place of a task id for an episode that was seen without a task, or in a task that was removed.
pub fn of_episode(episode_id: &str) -> String {
    format!("mined:{}", copies::mined_of(episode_id))
}

/// Keeps what users have seen in a task that is about to be removed, under its episode.
pub fn outlast(tx: &mut dyn Tx, task: &str, episode_id: &str) -> Answer<()> {
    tx.run(
        "INSERT INTO seen (user_id, task_id, drive_id, from_ns, to_ns)
         SELECT s.user_id, $1, s.drive_id, s.from_ns, s.to_ns FROM seen s WHERE s.task_id = $2
         ON CONFLICT (user_id, task_id) DO UPDATE SET
           from_ns = CASE WHEN excluded.from_ns < seen.from_ns THEN excluded.from_ns ELSE seen.from_ns END,
           to_ns = CASE WHEN excluded.to_ns > seen.to_ns THEN excluded.to_ns ELSE seen.to_ns END",
        values![of_episode(episode_id), task],
    )?;
    tx.run("DELETE FROM seen WHERE task_id = $1", values![task]).map(drop)
}

/// The last time of its drive that a task shows in `state`.
fn shown_until(t: &TaskRow, state: State) -> i64 {
    match state.stage() {
        Stage::Stage1 => t.keyframe_ns,
        Stage::Stage2 => t.to_ns,
    }
}

/// True when `user` was already shown the current content of `t`, in this task.
pub fn was_shown(tx: &mut dyn Tx, t: &TaskRow, user: &str) -> Answer<bool> {
    was_shown_in(tx, t, t.at.state, user)
}

fn was_shown_in(tx: &mut dyn Tx, t: &TaskRow, state: State, user: &str) -> Answer<bool> {
    let sql = "SELECT 1 FROM seen WHERE user_id = $1 AND task_id = $2 AND to_ns >= $3";
    Ok(tx.row(sql, values![user, &t.id, shown_until(t, state)])?.is_some())
}

/// Lets one transaction at a time change what `user` is doing and has seen. On PostgreSQL, two of them could otherwise
/// each miss what the other does: one begins a Stage I while the other shows its future.
pub fn lock(tx: &mut dyn Tx, user: &str) -> Answer<()> {
    // The weaker lock: entries of the history refer to users.
    let lock = if tx.lock().is_empty() { "" } else { " FOR NO KEY UPDATE" };
    tx.row(&format!("SELECT 1 FROM users WHERE id = $1{lock}"), values![user]).map(drop)
}

/// Records that `t` is shown to `user`; writes only if it is more than they were shown before. Refused if
/// [`may_be_shown`] refuses it, also where it was shown before.
pub fn note(store: &Store, t: &TaskRow, user: &str) -> Answer<()> {
    note_in(store, t, t.at.state, user)
}

/// Records that the keyframe of `t` is shown to `user`, and nothing after it.
pub fn note_keyframe(store: &Store, t: &TaskRow, user: &str) -> Answer<()> {
    note_in(store, t, State::Open, user)
}

fn note_in(store: &Store, t: &TaskRow, state: State, user: &str) -> Answer<()> {
    let known = store.read(|tx| {
        may_be_shown(tx, t, state, user)?;
        was_shown_in(tx, t, state, user)
    })?;
    if known {
        return Ok(());
    }
    let (t, user) = (t.clone(), user.to_owned());
    store.write(move |tx| show_in(tx, &t, state, &user))
}

/// Refuses to show `t` in `state` to `user` while they do Stage I of another task whose future it would show, or have
/// not submitted their own label of its episode.
pub fn may_be_shown(tx: &mut dyn Tx, t: &TaskRow, state: State, user: &str) -> Answer<()> {
    if t.overlap_count > 1 && state.stage() == Stage::Stage2 {
        let own = tx.row(
            "SELECT 1 FROM tasks WHERE project_id = $1 AND episode_id = $2 AND id <> $3 AND author = $4
               AND state IN ('stage1_locked', 'stage2') LIMIT 1",
            values![&t.project, &t.episode.episode_id, &t.id, user],
        )?;
        if own.is_some() {
            return Err(Problem::new(
                409,
                "overlap.own_first",
                "您尚未提交自己对该事件的标注，不能查看他人的标注",
                "you have not submitted your own label of this episode: you cannot see another person's",
            ));
        }
    }
    let others =
        tx.rows(IN_HAND_BEFORE, values![user, &t.drive_id, &t.id, shown_until(t, state), t.from_ns])?;
    if others.is_empty() {
        return Ok(());
    }
    // If only the same episode excludes, tasks of other episodes may be started; but their whole future may not be
    // opened.
    let rule = projects::get(tx, &t.project)?.settings.history;
    for other in others {
        let same = copies::mined_of(&other.text("episode_id")?) == copies::mined_of(&t.episode.episode_id);
        if same || rule == HistoryRule::Drive || state.stage() == Stage::Stage2 {
            return Err(stage1_first(&other.text("id")?));
        }
    }
    Ok(())
}

/// Tasks whose Stage I a user does, and whose future something else of their drive would show: until `$4`, from `$5`.
pub(super) const IN_HAND_BEFORE: &str = "SELECT id, episode_id FROM tasks WHERE holder = $1 AND state = 'stage1' \
    AND drive_id = $2 AND id <> $3 AND keyframe_ns < $4 AND to_ns > $5 ORDER BY id";

fn stage1_first(task: &str) -> Problem {
    Problem::new(
        409,
        "task.stage1_first",
        "这会显示您正在做阶段一的另一任务关键帧之后的内容；请先完成该任务或将其退回队列",
        "this would show the future of another task whose Stage I you are doing: finish or release that one first",
    )
    .with(serde_json::json!({ "task": task }))
}

/// SQL for the ids of tasks that lists leave out for a user (`$`), because they are in the future of a task whose Stage
/// I the user does: of their class and their number, too, nothing is shown before the lock. The same tasks as
/// [`may_be_shown`] refuses.
pub fn hidden_in_stage1(rule: HistoryRule) -> String {
    let before = "('open', 'stage1', 'skipped', 'rejected')";
    let begun = match rule {
        HistoryRule::Drive => String::new(),
        HistoryRule::Episode => format!(" AND t.state NOT IN {before}"),
    };
    format!(
        "id NOT IN (SELECT t.id FROM tasks h JOIN tasks t ON t.drive_id = h.drive_id
           WHERE h.holder = $ AND h.state = 'stage1' AND t.id <> h.id AND t.from_ns < h.to_ns
             AND CASE WHEN t.state IN {before} THEN t.keyframe_ns ELSE t.to_ns END > h.keyframe_ns{begun})"
    )
}

/// The tasks whose Stage I `user` does, with their drives.
pub fn in_hand(tx: &mut dyn Tx, user: &str) -> Answer<Vec<(String, DriveId)>> {
    let rows = tx.rows(
        "SELECT id, drive_id FROM tasks WHERE holder = $1 AND state = 'stage1' ORDER BY drive_id, id",
        values![user],
    )?;
    rows.iter().map(|r| Ok((r.text("id")?, r.text("drive_id")?.as_str().into()))).collect()
}

/// Refuses to show what is known about whole drives to a user who does Stage I of one of them; `shows` says whether a
/// drive is among them.
pub fn not_in_hand(store: &Store, user: &str, mut shows: impl FnMut(&DriveId) -> Answer<bool>) -> Answer<()> {
    for (task, drive) in store.read(|tx| in_hand(tx, user))? {
        if shows(&drive)? {
            return Err(stage1_first(&task));
        }
    }
    Ok(())
}

/// Records that `user` is shown the current content of `t`; refused if [`may_be_shown`] refuses it.
pub fn show(tx: &mut dyn Tx, t: &TaskRow, user: &str) -> Answer<()> {
    show_in(tx, t, t.at.state, user)
}

fn show_in(tx: &mut dyn Tx, t: &TaskRow, state: State, user: &str) -> Answer<()> {
    lock(tx, user)?;
    may_be_shown(tx, t, state, user)?;
    if was_shown_in(tx, t, state, user)? {
        return Ok(());
    }
    tx.run(
        "INSERT INTO seen (user_id, task_id, drive_id, from_ns, to_ns) VALUES ($1, $2, $3, $4, $5)
         ON CONFLICT (user_id, task_id) DO UPDATE SET
           to_ns = CASE WHEN excluded.to_ns > seen.to_ns THEN excluded.to_ns ELSE seen.to_ns END",
        values![user, &t.id, &t.drive_id, t.from_ns, shown_until(t, state)],
    )
    .map(drop)
}
