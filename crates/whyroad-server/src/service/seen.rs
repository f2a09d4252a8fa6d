//! Who was shown which part of a drive: nobody does Stage I of what they have seen.

use crate::domain::project::HistoryRule;
use crate::domain::workflow::{Actor, Role, Seen};
use crate::problem::{Answer, Problem};
use crate::service::tasks::TaskRow;
use crate::store::Tx;
use crate::values;

/// The user as an actor on `t`: roles, and whether its future was shown to them, by this task or by another of its drive.
pub fn actor(tx: &mut dyn Tx, t: &TaskRow, user: &str, roles: &[Role], rule: HistoryRule) -> Answer<Actor> {
    let has_seen = if knows(tx, t, user, rule)? { Seen::Future } else { Seen::History };
    Ok(Actor { id: user.to_owned(), roles: roles.to_vec(), has_seen })
}

fn knows(tx: &mut dyn Tx, t: &TaskRow, user: &str, rule: HistoryRule) -> Answer<bool> {
    let row = match rule {
        HistoryRule::Drive => tx.row(
            "SELECT 1 FROM seen WHERE user_id = $1 AND drive_id = $2 AND to_ns > $3 AND from_ns < $4 LIMIT 1",
            values![user, &t.drive_id, t.keyframe_ns, t.to_ns],
        )?,
        HistoryRule::Episode => tx.row(
            "SELECT 1 FROM seen s JOIN tasks o ON o.id = s.task_id
             WHERE s.user_id = $1 AND s.drive_id = $2 AND o.episode_id = $3 LIMIT 1",
            values![user, &t.drive_id, &t.episode.episode_id],
        )?,
    };
    Ok(row.is_some())
}

/// True when `user` was shown the future of `t` in this very task.
pub fn was_shown(tx: &mut dyn Tx, t: &TaskRow, user: &str) -> Answer<bool> {
    Ok(tx.row("SELECT 1 FROM seen WHERE user_id = $1 AND task_id = $2", values![user, &t.id])?.is_some())
}

/// Notes that `user` is shown the future of `t`. Refused while they are in Stage I of another task that it would give away.
pub fn show_future(tx: &mut dyn Tx, t: &TaskRow, user: &str) -> Answer<()> {
    if was_shown(tx, t, user)? {
        return Ok(());
    }
    let stage1 = tx.row(
        "SELECT id FROM tasks WHERE holder = $1 AND state = 'stage1' AND drive_id = $2 AND id <> $3
           AND keyframe_ns < $4 AND to_ns > $5 LIMIT 1",
        values![user, &t.drive_id, &t.id, t.to_ns, t.from_ns],
    )?;
    if let Some(other) = stage1 {
        return Err(Problem::new(
            409,
            "task.stage1_first",
            "这会显示您正在做阶段一的另一任务关键帧之后的内容；请先完成该任务或将其退回队列",
            "this would show the future of another task whose Stage I you are doing: finish or release that one first",
        )
        .with(serde_json::json!({ "task": other.text("id")? })));
    }
    tx.run(
        "INSERT INTO seen (user_id, task_id, drive_id, from_ns, to_ns) VALUES ($1, $2, $3, $4, $5) ON CONFLICT DO NOTHING",
        values![user, &t.id, &t.drive_id, t.from_ns, t.to_ns],
    )?;
    Ok(())
}
