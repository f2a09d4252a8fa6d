//! The service over HTTP and its store, on both databases: each test of the suite runs on a SQLite file, and all of
//! them on a real PostgreSQL if the machine has one.

#![allow(clippy::unwrap_used, reason = "a test says what went wrong by failing")]

mod access;
mod attacks;
mod auditor;
mod choice;
mod clock;
mod drafts;
mod ending;
mod flow;
mod gold;
mod group;
mod identities;
mod in_hand;
mod later_task;
mod leaks;
mod meanwhile;
mod migration;
mod mined;
mod model;
mod oidc;
mod other_class;
mod other_ways;
mod page;
#[allow(dead_code, reason = "restarts are for the tests of the binary")]
mod postgres_server;
mod provider;
mod recorded;
#[path = "../../../whyroad-model/testing/require.rs"]
mod require;
mod safety;
mod sessions;
mod signer;
mod store;
mod wire;
mod work;
mod world;

use recorded::Future;
use world::World;

macro_rules! suite {
    ($($module:ident :: $name:ident),+ $(,)?) => {
        $(#[test] fn $name() { $module::$name(&World::on_sqlite(Future::Brakes)); })+

        #[test]
        fn the_suite_on_postgresql() {
            let Some(server) = postgres_server::Server::start() else { return };
            let tests: &[fn(&World)] = &[$($module::$name),+];
            // Several at once: each waits mostly for the disk.
            std::thread::scope(|scope| {
                for part in tests.chunks(tests.len().div_ceil(4)) {
                    let server = &server;
                    scope.spawn(move || part.iter().for_each(|t| t(&World::on_server(&server.database(), Future::Brakes))));
                }
            });
        }
    };
}

suite! {
    flow::the_whole_path_from_setup_to_export,
    flow::a_label_made_here_names_a_cause_of_each_decision,
    leaks::nothing_of_the_future_is_in_any_answer_of_stage_one,
    leaks::the_leaf_is_shown_when_stage_one_is_locked,
    gold::order_and_history_of_gold_tasks_are_those_of_others,
    gold::gold_answers_are_compared_and_shown_to_leads_alone,
    mined::mined_episodes_are_browsed_and_judged,
    mined::moments_without_a_class_are_listed_apart,
    mined::who_is_in_stage_one_is_not_shown_the_episode,
    model::a_models_draft_shows_its_future_only_in_stage_two,
    model::begun_tasks_are_left_alone_and_runs_are_stopped,
    model::a_run_goes_on_after_a_restart_and_ends_with_its_budget,
    model::judgements_are_shown_to_checkers_after_their_own,
    safety::decisions_wait_for_the_safety_filter,
    safety::unsafe_driving_is_rejected_with_its_reasons,
    leaks::who_has_seen_the_future_of_a_drive_gets_no_stage_one_of_it,
    leaks::a_second_person_begins_stage_one_with_the_suggestion,
    sessions::the_first_run_makes_one_admin_and_no_second,
    sessions::cookies_and_headers_are_safe,
    sessions::writing_needs_the_csrf_value_of_the_session,
    sessions::sessions_end,
    sessions::guessing_passwords_is_slowed,
    sessions::passwords_and_tokens_are_kept_as_hashes,
    sessions::no_two_people_have_one_display_name,
    sessions::people_change_themselves_and_admins_everybody,
    identities::who_has_a_verified_address_signs_in_to_the_account_that_has_it,
    oidc::a_token_that_is_wrong_anywhere_lets_nobody_in,
    oidc::an_answer_serves_once_and_in_one_browser,
    identities::no_account_is_taken_over,
    identities::who_is_signed_in_links_themselves_and_unlinks,
    identities::accounts_are_made_and_roles_given_where_the_set_up_says_so,
    oidc::what_only_userinfo_tells_is_asked_for_and_is_of_the_same_person,
    oidc::keys_change_and_old_ones_are_forgotten,
    oidc::a_provider_that_fails_or_lies_about_itself_is_said_to,
    oidc::every_way_of_being_a_client_will_do,
    oidc::services_on_one_store_share_the_work,
    oidc::attempts_are_counted_and_the_first_account_is_made_here,
    access::every_route_lets_in_only_whom_it_should,
    access::the_roles_of_a_project_bound_its_work,
    auditor::an_auditor_reads_the_project_and_changes_nothing,
    drafts::changes_of_different_fields_merge_and_of_the_same_conflict,
    drafts::an_older_token_writes_nothing,
    drafts::a_task_is_never_held_twice,
    clock::a_clock_that_jumps_gives_no_task_twice,
    clock::a_clock_that_jumps_makes_no_lease_longer,
    drafts::an_earlier_draft_comes_back,
    drafts::in_stage_one_the_end_of_the_keyframes_range_survives_unseen,
    drafts::in_stage_one_a_keyframe_before_its_range_can_be_locked,
    group::overlaps_are_blind_until_all_are_in_then_one_is_chosen,
    choice::a_group_without_a_choice_is_neither_checked_nor_exported,
    choice::only_the_chosen_label_waits_for_a_check,
    choice::a_choice_is_open_again_when_the_chosen_label_is_gone,
    choice::a_label_whose_group_was_left_by_others_can_be_chosen,
    choice::an_added_copy_is_waited_for,
    group::what_cannot_be_labelled_is_left_out_with_a_reason_and_comes_back,
    group::audits_follow_the_share_and_the_record,
    group::an_empty_queue_says_why,
    group::the_queue_goes_by_hand_skill_language_and_priority,
    group::lists_come_page_by_page_and_filtered,
    attacks::a_draft_nested_too_deep_is_refused_and_nobody_else_feels_it,
    attacks::texts_that_one_of_the_databases_cannot_hold_are_refused_by_both,
    attacks::an_episode_that_cannot_be_of_its_drive_makes_no_task,
    attacks::people_know_whom_they_work_with_and_no_others,
    attacks::what_leads_name_has_to_be_there,
    attacks::many_guesses_at_once_are_judged_like_one_after_another,
    attacks::tokens_end_and_make_no_tokens,
    attacks::a_password_that_everybody_guesses_is_refused,
    attacks::a_field_has_one_path,
    attacks::more_values_than_any_label_has_are_refused_at_once,
    attacks::a_text_to_search_for_may_not_be_a_book,
    later_task::taking_a_later_task_bars_from_the_earlier_one,
    later_task::a_task_that_comes_back_asks_again_what_was_seen,
    later_task::opening_a_later_task_shows_no_future_of_the_one_in_hand,
    later_task::where_only_the_episode_bars_a_later_task_may_be_begun,
    in_hand::lists_leave_out_what_comes_after_the_keyframe_in_hand,
    in_hand::an_earlier_task_whose_label_reaches_further_is_left_out,
    in_hand::exports_and_mined_lists_wait_for_the_stage_one_in_hand,
    in_hand::what_was_seen_before_is_not_opened_again_during_stage_one,
    in_hand::a_thumbnail_counts_as_seen,
    in_hand::a_label_stays_with_its_clip,
    in_hand::findings_compare_only_what_the_task_shows,
    other_class::a_lead_makes_the_task_of_the_class_that_fits,
    other_class::an_l2_is_a_class_whose_variant_is_unknown,
    other_class::who_saw_no_future_may_do_the_task_again_with_another_class,
    other_class::an_episode_that_no_class_explains_becomes_a_task_of_a_chosen_class,
    other_class::lists_have_the_time_in_the_drive_and_what_checks_found,
    other_class::days_are_those_of_the_projects_clock,
    other_ways::labels_side_by_side_count_as_seen,
    other_ways::a_choice_in_a_group_shows_no_future_of_the_task_in_hand,
    other_ways::who_browsed_an_episode_does_no_stage_one_of_it,
    other_ways::what_was_seen_outlasts_the_task,
    other_ways::an_imported_draft_carries_no_future_into_stage_one,
    other_ways::an_imported_draft_does_not_come_back_in_stage_one,
    other_ways::a_role_that_ended_decides_nothing,
    other_ways::another_persons_label_is_hidden_until_the_own_one_is_submitted,
    meanwhile::who_is_disabled_while_a_password_is_hashed_stays_so,
    meanwhile::an_old_password_opens_nothing_once_it_was_replaced,
    group::what_is_given_back_says_why_and_the_history_comes_in_pages,
    page::lists_have_a_total_and_an_order_that_pages_keep,
    page::many_tasks_are_changed_at_once_and_each_refusal_is_named,
    page::the_work_to_do_is_counted_for_staff_and_for_oneself,
    page::a_question_to_the_lead_marks_the_task_until_it_is_answered,
    page::a_picture_is_for_those_who_cannot_do_stage_one_or_have_opened_the_task,
    page::the_history_has_the_values_before_each_change,
    page::a_label_put_together_from_a_group_is_checked_again,
    page::overlap_groups_that_disagree_are_listed_until_one_label_is_chosen,
    page::findings_side_by_side_are_those_of_each_label_alone,
    page::why_a_task_cannot_be_taken_fits_the_case,
    page::tasks_are_there_at_once_and_their_drafts_follow,
    page::a_place_is_given_as_precisely_as_the_project_says,
    page::finished_tasks_go_when_their_project_keeps_them_no_longer,
    page::overruled_labels_go_with_the_chosen_one,
    page::a_change_of_one_setting_leaves_the_others,
    migration::classes_are_carried_along_and_what_is_undecided_goes_to_people,
    migration::facts_are_those_of_the_history,
    migration::the_analytics_page_is_for_leads,
    wire::unchanged_answers_are_not_sent_again,
    wire::what_is_wrong_is_said_as_problem_json,
    wire::what_is_too_large_is_refused,
    wire::markup_comes_back_as_data,
    wire::tasks_come_from_mined_folders_within_limits,
}
