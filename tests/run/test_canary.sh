#!/usr/bin/env bash
# A canary: the scores of a short run find the corrupted photos of the table, and other validation photos would agree with them. A
# fault is planted in a copy of the ledger, where every step is that of the photo before, and must be found. Takes the program's path.
. "$(dirname "$0")/../support/program_test.sh"

auc() { "$root/scripts/lab/score_quality" "$1" | awk '$1 == "dv_psnr" {print $2}'; }
agreement() { sqlite3 :memory: "SELECT json_extract(CAST(readfile('$1') AS TEXT), '\$.verdict.ranking.other_views')"; }
at_least() { awk -v limit="$1" -v figure="$2" 'BEGIN {exit !(figure >= limit)}' || { echo "$2 is below $1"; return 1; }; }
value() {
    "$program" value "$root/scenes/table.json" --out "$folder/run" --accuracy draft --effects none --quiet --json >"$folder/run.json"
}

plant_fault() {
    mkdir "$folder/fault" && cp "$folder/run/ledger.db" "$folder/fault/ledger.db" || return 1
    sqlite3 "$folder/fault/ledger.db" "
        UPDATE step SET image_id = before.image_id FROM (SELECT step, lag(image_id) OVER (ORDER BY step) AS image_id FROM step) AS before
            WHERE before.step = step.step;
        CREATE TABLE credit AS $(sed 's/;$//' "$root/scripts/dv_psnr.sql");
        UPDATE score SET value = (SELECT dv_psnr FROM credit WHERE credit.image_id = score.image_id) WHERE method = 'dv_psnr';"
}

check "the table is valued" value
# Each figure moves by a few hundredths from device to device.
check "corrupted photos rank low" at_least 0.9 "$(auc "$folder/run")"
check "other validation photos would agree" at_least 0.5 "$(agreement "$folder/run.json")"
check "a fault is planted" plant_fault
check "the canary finds it" at_least "$(auc "$folder/fault")" 0.8
conclude "$@"
