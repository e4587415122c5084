-- Every dv_psnr of a run, from the step table alone:
--     sqlite3 -header OUT/ledger.db < scripts/dv_psnr.sql
-- A photo's score is the sum of the changes of val_psnr (dB, positive = better) over the steps trained on it, from the epoch after
-- burn-in on. Steps without a validation value (flagged non-finite) are left out, so that the next change is taken from the last
-- value there is. Photos without a visit after burn-in have no row here and a score of 0 in the score table.
WITH
    settings AS (
        SELECT run_id, scene_hash, coalesce(json_extract(config_json, '$.burn_in_epochs'), 1) AS burn_in_epochs FROM run
    ),
    change AS (
        SELECT run_id, step, epoch, image_id, val_psnr - lag(val_psnr) OVER (PARTITION BY run_id ORDER BY step) AS delta
        FROM step
        WHERE val_psnr IS NOT NULL
    )
SELECT change.run_id, change.image_id, image.name, sum(change.delta) AS dv_psnr, count(change.delta) AS visits
FROM change
JOIN settings ON settings.run_id = change.run_id
JOIN image ON image.scene_hash = settings.scene_hash AND image.image_id = change.image_id
WHERE change.epoch >= settings.burn_in_epochs AND change.delta IS NOT NULL AND image.split = 'train'
GROUP BY change.run_id, change.image_id
ORDER BY change.run_id, dv_psnr DESC, image.name;
