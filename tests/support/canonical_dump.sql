-- What two merged.db must have in common if the same jobs were run, in whatever order and however many at a time, on equal devices:
--     sqlite3 OUT/merged.db < tests/support/canonical_dump.sql
-- Every row of every table, in the order of the keys, with the hashes that cover what a run is. Left out is what differs from one
-- start of the same job to the next, and the hashes that cover it: times (of the run and in its plan and in the evidence of its
-- effects), paths of scene and lists, and the names of device and driver, for which run_id stands.
.mode list
.headers on
SELECT 'run' AS "table", job, run_id, scene_hash, seed, config_json, subset_hash, shader_hash, version, status, row_hash, field_sha256,
    (SELECT group_concat(value ->> 'name') FROM json_each(effects_json) WHERE value ->> 'on') AS effects
FROM run ORDER BY job, run_id;
SELECT 'image' AS "table", * FROM image ORDER BY job, scene_hash, image_id;
SELECT 'step' AS "table", * FROM step ORDER BY job, run_id, step;
SELECT 'view' AS "table", * FROM view ORDER BY job, run_id, step, image_id;
SELECT 'score' AS "table", * FROM score ORDER BY job, run_id, method, image_id;
SELECT 'retraining' AS "table", * FROM retraining ORDER BY job, run_id, retraining;
SELECT 'lasting' AS "table", * FROM lasting ORDER BY job, run_id;
SELECT 'lasting_step' AS "table", * FROM lasting_step ORDER BY job, run_id, step;
SELECT 'lasting_check' AS "table", * FROM lasting_check ORDER BY job, run_id, image_id;
SELECT 'lasting_view' AS "table", * FROM lasting_view ORDER BY job, run_id, step, image_id;
