-- Every dv_psnr of a run, from the step table alone:
--     sqlite3 -header OUT/ledger.db < scripts/dv_psnr.sql
-- A photo's score is the sum of the changes of val_psnr (dB, positive = better) over the steps trained on it, from the epoch after
-- burn-in on. Where train photos judge each other, val_psnr and val_psnr_before are of the same judges, and each epoch's mean is taken
-- off (src/value/README.md). Steps without a validation value (flagged non-finite) are left out, so that the next change is taken
-- from the last value there is. Photos without a visit after burn-in have no row here and a score of 0 in the score table.
WITH
    settings AS (
        SELECT run_id, scene_hash, coalesce(json_extract(config_json, '$.burn_in_epochs'), 1) AS burn_in_epochs FROM run
    ),
    change AS (
        SELECT
            run_id, epoch, image_id, val_psnr_before IS NOT NULL AS judged,
            val_psnr - coalesce(val_psnr_before, lag(val_psnr) OVER (PARTITION BY run_id ORDER BY step)) AS delta
        FROM step
        WHERE val_psnr IS NOT NULL
    ),
    credit AS (
        SELECT run_id, epoch, image_id, delta - judged * avg(delta) OVER (PARTITION BY run_id, epoch) AS delta
        FROM change
        WHERE delta IS NOT NULL
    )
SELECT credit.run_id, credit.image_id, image.name, sum(credit.delta) AS dv_psnr, count(credit.delta) AS visits
FROM credit
JOIN settings ON settings.run_id = credit.run_id
JOIN image ON image.scene_hash = settings.scene_hash AND image.image_id = credit.image_id
WHERE credit.epoch >= settings.burn_in_epochs AND image.split = 'train'
GROUP BY credit.run_id, credit.image_id
ORDER BY credit.run_id, dv_psnr DESC, image.name;
