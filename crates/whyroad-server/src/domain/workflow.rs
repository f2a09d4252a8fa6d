//! The life of a task as a pure function: who may do what in which state, and the next state. No store, no clock.
//!
//! ```text
//!            take            lock_stage1           submit             take             accept
//!   open ──────────▶ stage1 ────────────▶ stage2 ─────────▶ submitted ─────▶ in_check ───────┬──▶ accepted
//!    ▲ ◀───release─────┘     release │ ▲ take               ▲                  │             │        ▲
//!    │                               ▼ │                    │ submit           │ send_back   ▼        │ accept
//!    │ reopen (lead)          stage1_locked               rework ◀─────────────┘          checked     │
//!    └── skipped, rejected ◀── skip, reject                 ▲                         take   │        │
//!                                                           └──────── send_back ──── in_audit ◀───────┘
//! ```
//!
//! Invariants on every path, tested on random ones: a label is accepted only if it was checked after its last
//! submission; its checker has not written it; its auditor has neither written nor checked it; a task that shows the
//! future never becomes `stage1` again for those who saw it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use whyroad_model::Bilingual;

macro_rules! words {
    ($(#[$doc:meta])* $name:ident { $($(#[$vdoc:meta])* $variant:ident = $word:literal),+ $(,)? }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema)]
        pub enum $name { $($(#[$vdoc])* #[serde(rename = $word)] $variant),+ }
        impl $name {
            /// All, in the order of the work.
            pub const ALL: &'static [$name] = &[$($name::$variant),+];
            /// Its value in the store and the API.
            pub fn word(self) -> &'static str { match self { $($name::$variant => $word),+ } }
            /// The one with this value.
            pub fn from_word(word: &str) -> Option<Self> { match word { $($word => Some($name::$variant),)+ _ => None } }
        }
    };
}

words!(
    /// State of a task.
    State {
        /// Nobody works on it.
        Open = "open",
        /// Stage I: components, from history only.
        Stage1 = "stage1",
        /// Stage I is done and nobody holds it; only its author can continue.
        Stage1Locked = "stage1_locked",
        /// Stage II: decision, causes and trace.
        Stage2 = "stage2",
        /// Waits for a checker.
        Submitted = "submitted",
        /// With a checker.
        InCheck = "in_check",
        /// Returned to its author with comments.
        Rework = "rework",
        /// Checked, selected for audit, waits for an auditor.
        Checked = "checked",
        /// With an auditor.
        InAudit = "in_audit",
        /// Done.
        Accepted = "accepted",
        /// Skipped with a reason.
        Skipped = "skipped",
        /// Cannot be labeled, with a reason.
        Rejected = "rejected",
    }
);

words!(
    /// Role of a member in a project.
    Role {
        /// Creates tasks, assigns, reopens, adjudicates, exports.
        Lead = "lead",
        /// Labels.
        Annotator = "annotator",
        /// Checks what others labeled.
        Checker = "checker",
        /// Audits what others labeled and checked.
        Auditor = "auditor",
    }
);

words!(
    /// An action of a user on a task.
    Action {
        /// Takes the lease: a task to label, to rework, to check or to audit.
        Take = "take",
        /// Releases the lease.
        Release = "release",
        /// Ends Stage I.
        LockStage1 = "lock_stage1",
        /// Submits the label.
        Submit = "submit",
        /// Skips the task.
        Skip = "skip",
        /// States that the clip cannot be labeled.
        Reject = "reject",
        /// Accepts the label.
        Accept = "accept",
        /// Returns it for rework.
        SendBack = "send_back",
        /// Starts it again; an accepted label goes to rework.
        Reopen = "reopen",
    }
);

/// How much of a task may be shown now.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Stage {
    /// History only.
    Stage1,
    /// All of it.
    Stage2,
}

/// State of a task in the workflow. Users by id.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Position {
    /// State.
    pub state: State,
    /// All users who wrote in it since it was opened; the last one is its current author.
    pub authors: Vec<String>,
    /// User who checks or checked the current submission.
    pub checker: Option<String>,
    /// User who audits or audited it.
    pub auditor: Option<String>,
    /// User who holds the lease.
    pub holder: Option<String>,
    /// The checker has accepted the current submission.
    pub checked: bool,
}

/// The acting user.
#[derive(Clone, Debug)]
pub struct Actor {
    /// User id.
    pub id: String,
    /// Roles in the task's project.
    pub roles: Vec<Role>,
    /// Has seen what lies after this task's keyframe.
    pub has_seen: Seen,
}

/// Whether a user knows the future of a task.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seen {
    /// Only the history, or nothing.
    History,
    /// What comes after the keyframe as well.
    Future,
}

/// Whether a label that passed its check is audited.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Draw {
    /// It is accepted at once.
    Pass,
    /// It waits for an auditor.
    Audit,
}

/// Why an action is refused.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// Stable code.
    pub code: &'static str,
    /// Message.
    pub text: Bilingual,
}

impl State {
    /// True if Stage I is over, so the part after the keyframe may be shown.
    pub fn shows_future(self) -> bool {
        !matches!(self, State::Open | State::Stage1 | State::Skipped | State::Rejected)
    }

    /// How much of a task in this state is shown, to any user.
    pub fn stage(self) -> Stage {
        if self.shows_future() { Stage::Stage2 } else { Stage::Stage1 }
    }

    /// True if a user may hold a lease.
    pub fn is_held(self) -> bool {
        matches!(self, State::Stage1 | State::Stage2 | State::InCheck | State::Rework | State::InAudit)
    }

    /// True if the label was submitted, and not skipped or rejected since.
    pub fn is_handed_in(self) -> bool {
        matches!(
            self,
            State::Submitted
                | State::InCheck
                | State::Rework
                | State::Checked
                | State::InAudit
                | State::Accepted
        )
    }

    /// True where the holder may change the draft.
    pub fn is_editable(self) -> bool {
        matches!(self, State::Stage1 | State::Stage2 | State::Rework)
    }
}

impl Position {
    /// A new task.
    pub fn open() -> Self {
        Self {
            state: State::Open,
            authors: vec![],
            checker: None,
            auditor: None,
            holder: None,
            checked: false,
        }
    }

    /// User who labels or labeled it.
    pub fn author(&self) -> Option<&str> {
        self.authors.last().map(String::as_str)
    }

    fn wrote(&self, user: &str) -> bool {
        self.authors.iter().any(|a| a == user)
    }
}

impl Actor {
    /// True with this role.
    pub fn is(&self, role: Role) -> bool {
        self.roles.contains(&role)
    }

    /// Refuses an actor without this role.
    pub fn needs(&self, role: Role) -> Result<(), Refusal> {
        if self.is(role) { Ok(()) } else { Err(role_missing(role)) }
    }
}

/// The position after `action`. The caller checks that no live lease of somebody else prevents a `take`: that needs a
/// clock.
pub fn step(at: &Position, actor: &Actor, action: Action, draw: Draw) -> Result<Position, Refusal> {
    let holds = at.holder.as_deref() == Some(actor.id.as_str());
    let to = |state: State| Position { state, holder: None, ..at.clone() };
    // A role may have ended since the task was taken.
    let need = |role: Role| actor.needs(role);
    match (action, at.state) {
        (Action::Take, _) => take(at, actor),
        (Action::Release, state) if state.is_held() => {
            if !(holds || actor.is(Role::Lead)) {
                return Err(not_yours());
            }
            Ok(to(match state {
                State::Stage1 => State::Open,
                State::Stage2 => State::Stage1Locked,
                State::InCheck => State::Submitted,
                State::InAudit => State::Checked,
                other => other,
            }))
        }
        (Action::LockStage1, State::Stage1) if holds => {
            need(Role::Annotator)?;
            Ok(Position { state: State::Stage2, ..at.clone() })
        }
        (Action::Submit, State::Stage2 | State::Rework) if holds => {
            need(Role::Annotator)?;
            Ok(Position { checker: None, auditor: None, checked: false, ..to(State::Submitted) })
        }
        (
            Action::Skip | Action::Reject,
            State::Open | State::Stage1 | State::Stage1Locked | State::Stage2 | State::Rework,
        ) => {
            if !(holds || actor.is(Role::Lead)) {
                return Err(not_yours());
            }
            if !actor.is(Role::Lead) {
                need(Role::Annotator)?;
            }
            Ok(to(if action == Action::Skip { State::Skipped } else { State::Rejected }))
        }
        (Action::Accept, State::InCheck) if holds => {
            need(Role::Checker)?;
            judge_allowed(at, actor)?;
            let next = match draw {
                Draw::Pass => State::Accepted,
                Draw::Audit => State::Checked,
            };
            Ok(Position { checked: true, ..to(next) })
        }
        (Action::Accept, State::InAudit) if holds && at.checked => {
            need(Role::Auditor)?;
            audit_allowed(at, actor)?;
            Ok(to(State::Accepted))
        }
        (Action::SendBack, State::InCheck | State::InAudit) if holds => {
            need(if at.state == State::InCheck { Role::Checker } else { Role::Auditor })?;
            Ok(Position { checked: false, ..to(State::Rework) })
        }
        (Action::Reopen, _) if !actor.is(Role::Lead) => Err(role_missing(Role::Lead)),
        (Action::Reopen, State::Accepted) => {
            Ok(Position { checked: false, checker: None, auditor: None, ..to(State::Rework) })
        }
        (Action::Reopen, State::Open) => Err(not_now(action, at.state)),
        (Action::Reopen, _) => Ok(Position::open()),
        (_, state) if state.is_held() && !holds => Err(not_yours()),
        (_, state) => Err(not_now(action, state)),
    }
}

fn take(at: &Position, actor: &Actor) -> Result<Position, Refusal> {
    let need = |role: Role| actor.needs(role);
    let held = |state: State| Position { state, holder: Some(actor.id.clone()), ..at.clone() };
    match at.state {
        State::Open | State::Stage1 => {
            need(Role::Annotator)?;
            if actor.has_seen == Seen::Future {
                return Err(Refusal {
                    code: "task.future_seen",
                    text: Bilingual::new(
                        "您已看过关键帧之后的内容，不得做该任务的阶段一",
                        "you have seen what comes after this task's keyframe: you cannot do its Stage I",
                    ),
                });
            }
            let mut next = held(State::Stage1);
            next.authors.retain(|a| *a != actor.id);
            next.authors.push(actor.id.clone());
            Ok(next)
        }
        State::Stage1Locked | State::Stage2 | State::Rework => {
            need(Role::Annotator)?;
            if at.author() != Some(&actor.id) {
                return Err(Refusal {
                    code: "task.not_author",
                    text: Bilingual::new("只有作者可以继续该任务", "only the author can continue this task"),
                });
            }
            Ok(held(if at.state == State::Rework { State::Rework } else { State::Stage2 }))
        }
        State::Submitted | State::InCheck => {
            need(Role::Checker)?;
            judge_allowed(at, actor)?;
            Ok(Position { checker: Some(actor.id.clone()), ..held(State::InCheck) })
        }
        State::Checked | State::InAudit => {
            need(Role::Auditor)?;
            audit_allowed(at, actor)?;
            Ok(Position { auditor: Some(actor.id.clone()), ..held(State::InAudit) })
        }
        State::Accepted | State::Skipped | State::Rejected => Err(not_now(Action::Take, at.state)),
    }
}

fn judge_allowed(at: &Position, actor: &Actor) -> Result<(), Refusal> {
    if at.wrote(&actor.id) {
        return Err(Refusal {
            code: "task.own_work",
            text: Bilingual::new("不能质检自己的标注", "you cannot check your own label"),
        });
    }
    Ok(())
}

fn audit_allowed(at: &Position, actor: &Actor) -> Result<(), Refusal> {
    judge_allowed(at, actor)?;
    if at.checker.as_deref() == Some(actor.id.as_str()) {
        return Err(Refusal {
            code: "task.own_check",
            text: Bilingual::new("不能抽检自己质检过的标注", "you cannot audit a label that you checked"),
        });
    }
    Ok(())
}

/// Code of the refusal for a missing role.
pub const ROLE_MISSING: &str = "task.role_missing";

fn role_missing(role: Role) -> Refusal {
    Refusal {
        code: ROLE_MISSING,
        text: Bilingual::new(
            format!("需要{}角色", role.name().zh),
            format!("this needs the role {}", role.name().en),
        ),
    }
}

fn not_yours() -> Refusal {
    Refusal {
        code: "lease.not_yours", text: Bilingual::new("您没有领取该任务", "you do not hold this task")
    }
}

fn not_now(action: Action, state: State) -> Refusal {
    Refusal {
        code: "task.wrong_state",
        text: Bilingual::new(
            format!("{}任务不能{}", state.name().zh, action.name().zh),
            format!("a task that is {} cannot be {}", state.name().en, action.name().en),
        ),
    }
}

/// The names for people. The page has the same names.
impl State {
    /// The name of the state.
    pub fn name(self) -> Bilingual {
        let (zh, en) = match self {
            Self::Open => ("待标注", "open"),
            Self::Stage1 => ("阶段一", "in Stage I"),
            Self::Stage1Locked => ("阶段一已锁定", "after Stage I"),
            Self::Stage2 => ("阶段二", "in Stage II"),
            Self::Submitted => ("待质检", "submitted"),
            Self::InCheck => ("质检中", "in check"),
            Self::Rework => ("返工", "in rework"),
            Self::Checked => ("待抽检", "checked"),
            Self::InAudit => ("抽检中", "in audit"),
            Self::Accepted => ("已接受", "accepted"),
            Self::Skipped => ("已跳过", "skipped"),
            Self::Rejected => ("已剔除", "rejected"),
        };
        Bilingual::new(zh, en)
    }
}

impl Action {
    /// The name of the action; in English the participle.
    pub fn name(self) -> Bilingual {
        let (zh, en) = match self {
            Self::Take => ("领取", "taken"),
            Self::Release => ("退回队列", "released"),
            Self::LockStage1 => ("锁定阶段一", "locked"),
            Self::Submit => ("提交", "submitted"),
            Self::Skip => ("跳过", "skipped"),
            Self::Reject => ("剔除", "rejected"),
            Self::Accept => ("接受", "accepted"),
            Self::SendBack => ("退回", "sent back"),
            Self::Reopen => ("重新打开", "reopened"),
        };
        Bilingual::new(zh, en)
    }
}

impl Role {
    /// The name of the role.
    pub fn name(self) -> Bilingual {
        let (zh, en) = match self {
            Self::Lead => ("负责人", "lead"),
            Self::Annotator => ("标注员", "annotator"),
            Self::Checker => ("质检员", "checker"),
            Self::Auditor => ("抽检员", "auditor"),
        };
        Bilingual::new(zh, en)
    }
}

#[cfg(test)]
mod tests;
