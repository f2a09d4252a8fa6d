-- The tasks whose Stage I a user is doing: looked up before anything else of their drives is shown.
CREATE INDEX tasks_in_hand ON tasks (holder, drive_id, keyframe_ns, to_ns, id, episode_id) WHERE state = 'stage1';
