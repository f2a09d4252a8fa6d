//! Projects and members.

use crate::domain::people::User;
use crate::domain::project::{Member, Project, Settings};
use crate::domain::workflow::Role;
use crate::problem::{Answer, Problem};
use crate::service::appearance::appearance;
use crate::service::people;
use crate::store::{Row, Tx};
use crate::values;
use std::collections::BTreeSet;

const COLUMNS: &str = "id, name, guide, quota, settings";

fn project(row: &Row) -> Answer<Project> {
    Ok(Project {
        id: row.text("id")?,
        name: row.text("name")?,
        guide: row.text("guide")?,
        quota: parse(&row.text("quota")?)?,
        settings: parse(&row.text("settings")?)?,
        roles: vec![],
    })
}

/// A value that the store holds as JSON.
pub fn parse<T: serde::de::DeserializeOwned>(text: &str) -> Answer<T> {
    serde_json::from_str(text).map_err(Problem::store)
}

/// JSON for the store.
pub fn json<T: serde::Serialize>(value: &T) -> Answer<String> {
    serde_json::to_string(value).map_err(Problem::store)
}

/// All projects by name.
pub fn all(tx: &mut dyn Tx) -> Answer<Vec<Project>> {
    tx.rows(&format!("SELECT {COLUMNS} FROM projects ORDER BY name"), &[])?.iter().map(project).collect()
}

/// The project with this id or name.
pub fn find(tx: &mut dyn Tx, id_or_name: &str) -> Answer<Option<Project>> {
    let sql = format!("SELECT {COLUMNS} FROM projects WHERE id = $1 OR name = $2");
    tx.row(&sql, values![id_or_name, id_or_name])?.as_ref().map(project).transpose()
}

/// The project with this id.
pub fn get(tx: &mut dyn Tx, id: &str) -> Answer<Project> {
    let row = tx.row(&format!("SELECT {COLUMNS} FROM projects WHERE id = $1"), values![id])?;
    project(&row.ok_or_else(Problem::missing)?)
}

fn check(project: &Project) -> Answer<()> {
    let Settings {
        lease_s,
        audit_min_percent,
        audit_max_percent,
        lang,
        history: _,
        stage1_class: _,
        place_precision_m,
        gold_labels,
        gold_percent,
        retention_days,
        hourly_rate,
        currency,
        utc_offset_min,
    } = &project.settings;
    let sound = !appearance(&project.name).is_empty()
        && project.name.chars().count() <= 100
        && project.guide.len() <= 200_000
        && (30..=3600).contains(lease_s)
        && audit_min_percent <= audit_max_percent
        && *audit_max_percent <= 100
        && (*place_precision_m == 0 || (100..=1_000_000).contains(place_precision_m))
        && *gold_labels <= 1000
        && *gold_percent <= 100
        && *retention_days <= 36_500
        && hourly_rate.is_none_or(|r| (0.0..=1e6).contains(&r))
        && currency.chars().count() <= 10
        && (-14 * 60..=14 * 60).contains(utc_offset_min)
        && matches!(lang.as_str(), "zh" | "en");
    if sound {
        Ok(())
    } else {
        Err(Problem::new(
            422,
            "project.invalid",
            "项目设置无效：名称 1–100 个字符，领取时限 30–3600 秒，抽检比例 0–100 且最小值不大于最大值，位置精度 0 或 100 m 以上，金标数 0–1000，合格线 0–100，保留天数 0–36500，工时费率 0–1000000，时差 -14 至 14 小时",
            "invalid project settings: name 1 to 100 characters, lease 30 to 3600 s, audit rates 0 to 100 % with minimum <= maximum, place precision 0 or from 100 m, gold labels 0 to 1000, qualifying share 0 to 100 %, retention 0 to 36500 days, hourly rate 0 to 1000000, offset from UTC -14 to 14 hours",
        ))
    }
}

/// Milliseconds of a day.
pub const DAY_MS: i64 = 86_400_000;

/// The day, counted from 1970, of `now` by the clock of a project with these settings.
pub fn day(settings: &Settings, now: i64) -> i64 {
    (now + i64::from(settings.utc_offset_min) * 60_000).div_euclid(DAY_MS)
}

/// Stores a new project.
pub fn create(tx: &mut dyn Tx, project: &Project, now: i64) -> Answer<()> {
    check(project)?;
    check_name(tx, project)?;
    tx.run(
        "INSERT INTO projects (id, name, guide, quota, settings, created) VALUES ($1, $2, $3, $4, $5, $6)",
        values![
            &project.id,
            &project.name,
            &project.guide,
            json(&project.quota)?,
            json(&project.settings)?,
            now
        ],
    )?;
    Ok(())
}

/// A name that no other project has, also not in another letter case or with other spaces: people and command lines
/// tell projects apart by it.
pub fn check_name(tx: &mut dyn Tx, project: &Project) -> Answer<()> {
    // Until the transaction ends, no other one reads the names here.
    tx.rows(&format!("SELECT id FROM projects ORDER BY created, id LIMIT 1{}", tx.lock()), &[])?;
    let wanted = appearance(&project.name);
    let rows = tx.rows("SELECT id, name FROM projects WHERE id <> $1", values![&project.id])?;
    for row in rows {
        if appearance(&row.text("name")?) == wanted || row.text("id")? == project.name {
            return Err(Problem::new(
                409,
                "project.exists",
                "已有同名或名称看起来相同的项目",
                "a project of this name, or of one that looks the same, exists",
            ));
        }
    }
    Ok(())
}

/// Stores a changed project.
pub fn update(tx: &mut dyn Tx, project: &Project) -> Answer<()> {
    check(project)?;
    tx.run(
        "UPDATE projects SET name = $1, guide = $2, quota = $3, settings = $4 WHERE id = $5",
        values![&project.name, &project.guide, json(&project.quota)?, json(&project.settings)?, &project.id],
    )?;
    Ok(())
}

/// Roles of a user in a project.
pub fn roles(tx: &mut dyn Tx, project: &str, user: &str) -> Answer<Vec<Role>> {
    let row =
        tx.row("SELECT roles FROM members WHERE project_id = $1 AND user_id = $2", values![project, user])?;
    row.map_or(Ok(vec![]), |r| parse(&r.text("roles")?))
}

/// Classes that the queue gives to a member; empty for all.
pub fn skills(tx: &mut dyn Tx, project: &str, user: &str) -> Answer<Vec<String>> {
    let row =
        tx.row("SELECT skills FROM members WHERE project_id = $1 AND user_id = $2", values![project, user])?;
    row.map_or(Ok(vec![]), |r| parse(&r.text("skills")?))
}

/// Languages of the tasks that the queue gives to a member; empty for the language of their page.
pub fn languages(tx: &mut dyn Tx, project: &str, user: &str) -> Answer<Vec<String>> {
    let sql = "SELECT languages FROM members WHERE project_id = $1 AND user_id = $2";
    tx.row(sql, values![project, user])?.map_or(Ok(vec![]), |r| parse(&r.text("languages")?))
}

/// Sets the languages of a member; does nothing for a user who is not a member.
pub fn set_languages(tx: &mut dyn Tx, project: &str, user: &str, languages: &[String]) -> Answer<()> {
    if let Some(odd) = languages.iter().find(|l| !matches!(l.as_str(), "zh" | "en")) {
        return Err(Problem::request(
            format!("'{odd}' 不是语言：zh 或 en"),
            format!("'{odd}' is not a language: zh or en"),
        ));
    }
    let sorted: BTreeSet<&String> = languages.iter().collect();
    tx.run(
        "UPDATE members SET languages = $1 WHERE project_id = $2 AND user_id = $3",
        values![json(&sorted)?, project, user],
    )?;
    Ok(())
}

/// Members by name.
pub fn members(tx: &mut dyn Tx, project: &str) -> Answer<Vec<Member>> {
    let rows = tx.rows(
        "SELECT m.user_id, m.roles, m.skills, m.languages FROM members m JOIN users u ON u.id = m.user_id
         WHERE m.project_id = $1 ORDER BY u.name",
        values![project],
    )?;
    let mut out = Vec::new();
    for row in rows {
        let Some(user) = people::find(tx, &row.text("user_id")?)? else { continue };
        // Addresses are visible only to the user and to administrators.
        let user = User { email: None, ..user };
        let (roles, skills) = (parse(&row.text("roles")?)?, parse(&row.text("skills")?)?);
        out.push(Member { user, roles, skills, languages: parse(&row.text("languages")?)? });
    }
    Ok(out)
}

/// Adds, changes or (without roles) removes a member.
pub fn set_member(
    tx: &mut dyn Tx,
    project: &str,
    user: &str,
    roles: &[Role],
    skills: &[String],
) -> Answer<()> {
    if roles.is_empty() {
        tx.run("DELETE FROM members WHERE project_id = $1 AND user_id = $2", values![project, user])?;
        return Ok(());
    }
    tx.run(
        "INSERT INTO members (project_id, user_id, roles, skills) VALUES ($1, $2, $3, $4)
         ON CONFLICT (project_id, user_id) DO UPDATE SET roles = excluded.roles, skills = excluded.skills",
        values![project, user, json(&roles)?, json(&skills)?],
    )?;
    Ok(())
}

/// True if the user leads some project.
pub fn leads_any(tx: &mut dyn Tx, user: &str) -> Answer<bool> {
    let row = tx
        .row("SELECT 1 FROM members WHERE user_id = $1 AND roles LIKE '%\"lead\"%' LIMIT 1", values![user])?;
    Ok(row.is_some())
}

/// Users who are in a project with `user`.
pub fn fellows(tx: &mut dyn Tx, user: &str) -> Answer<BTreeSet<String>> {
    let sql =
        "SELECT o.user_id FROM members m JOIN members o ON o.project_id = m.project_id WHERE m.user_id = $1";
    tx.rows(sql, values![user])?.iter().map(|r| r.text("user_id")).collect()
}
