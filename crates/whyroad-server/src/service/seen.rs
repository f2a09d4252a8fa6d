//! Records which part of a drive each user was shown: nobody does Stage I of a part that they have seen. Every view
//! counts, including those of Stage I: a task with a later keyframe shows what comes after an earlier one.

use crate::domain::project::HistoryRule;
use crate::domain::workflow::{Actor, Role, Seen, Stage, State};
use crate::problem::{Answer, Problem};
use crate::service::tasks::TaskRow;
use crate::service::{copies, projects};
use crate::store::{Store, Tx};
use crate::values;

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
    let sql = "SELECT 1 FROM seen WHERE user_id = $1 AND task_id = $2 AND to_ns >= $3";
    Ok(tx.row(sql, values![user, &t.id, shown_until(t, t.at.state)])?.is_some())
}

/// Records that `t` is shown to `user`; writes only if it is more than they were shown before.
pub fn note(store: &Store, t: &TaskRow, user: &str) -> Answer<()> {
    if store.read(|tx| was_shown(tx, t, user))? {
        return Ok(());
    }
    let (t, user) = (t.clone(), user.to_owned());
    store.write(move |tx| show(tx, &t, &user))
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
    let others = tx.rows(
        "SELECT id, episode_id FROM tasks WHERE holder = $1 AND state = 'stage1' AND drive_id = $2 AND id <> $3
           AND keyframe_ns < $4 AND to_ns > $5 ORDER BY id",
        values![user, &t.drive_id, &t.id, shown_until(t, state), t.from_ns],
    )?;
    if others.is_empty() {
        return Ok(());
    }
    // If only the same episode excludes, tasks of other episodes may be started; but their whole future may not be
    // opened.
    let rule = projects::get(tx, &t.project)?.settings.history;
    for other in others {
        let same = copies::mined_of(&other.text("episode_id")?) == copies::mined_of(&t.episode.episode_id);
        if same || rule == HistoryRule::Drive || state.stage() == Stage::Stage2 {
            return Err(Problem::new(
                409,
                "task.stage1_first",
                "这会显示您正在做阶段一的另一任务关键帧之后的内容；请先完成该任务或将其退回队列",
                "this would show the future of another task whose Stage I you are doing: finish or release that one first",
            )
            .with(serde_json::json!({ "task": other.text("id")? })));
        }
    }
    Ok(())
}

/// Records that `user` is shown the current content of `t`; refused if [`may_be_shown`] refuses it.
pub fn show(tx: &mut dyn Tx, t: &TaskRow, user: &str) -> Answer<()> {
    if was_shown(tx, t, user)? {
        return Ok(());
    }
    may_be_shown(tx, t, t.at.state, user)?;
    tx.run(
        "INSERT INTO seen (user_id, task_id, drive_id, from_ns, to_ns) VALUES ($1, $2, $3, $4, $5)
         ON CONFLICT (user_id, task_id) DO UPDATE SET
           to_ns = CASE WHEN excluded.to_ns > seen.to_ns THEN excluded.to_ns ELSE seen.to_ns END",
        values![user, &t.id, &t.drive_id, t.from_ns, shown_until(t, t.at.state)],
    )?;
    Ok(())
}
