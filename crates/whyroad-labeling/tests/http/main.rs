//! The service over HTTP, on both stores: each test of the suite runs on a SQLite file, and all of them on a real
//! PostgreSQL where the machine has one.

#![allow(clippy::unwrap_used, reason = "a test says what went wrong by failing")]

#[path = "../support/postgres.rs"]
#[allow(dead_code)]
mod postgres;

mod access;
mod flow;
mod leaks;
mod recorded;
mod sessions;
mod work;
mod world;

use recorded::Future;
use world::World;

macro_rules! suite {
    ($($module:ident :: $name:ident),+ $(,)?) => {
        $(#[test] fn $name() { $module::$name(&World::on_sqlite(Future::Brakes)); })+

        #[test]
        fn the_suite_on_postgresql() {
            let Some(server) = postgres::Server::start() else { return };
            $($module::$name(&World::on_server(&server.database(), Future::Brakes));)+
        }
    };
}

suite! {
    flow::the_whole_path_from_setup_to_export,
    leaks::nothing_of_the_future_is_in_any_answer_of_stage_one,
    leaks::who_has_seen_the_future_of_a_drive_gets_no_stage_one_of_it,
    leaks::a_second_person_begins_stage_one_with_the_suggestion,
    sessions::the_first_run_makes_one_admin_and_no_second,
    sessions::cookies_and_headers_are_safe,
    sessions::writing_needs_the_csrf_value_of_the_session,
    sessions::sessions_end,
    sessions::guessing_passwords_is_slowed,
    sessions::passwords_and_tokens_are_kept_as_hashes,
    sessions::people_change_themselves_and_admins_everybody,
    access::every_route_lets_in_only_whom_it_should,
    access::the_roles_of_a_project_bound_its_work,
}
