#!/usr/bin/env bash
# A canary: the scores of a short run find the corrupted photos of the table, and other validation photos would agree with them. A
# fault is planted in a copy of the ledger, where every step is that of the photo before, and must be found. Takes the program's path.
. "$(dirname "$0")/../support/program_test.sh"

auc() { "$root/scripts/lab/score_quality" "$1" | awk '$1 == "dv_psnr" {print $2}'; }
agreement() { sed -nE 's/^ranks .* other validation photos .*about ([0-9.]+)\)$/\1/p' "$1"; }
within() { # within LOW HIGH FIGURE
    awk -v low="$1" -v high="$2" -v figure="$3" 'BEGIN {exit !(figure != "" && figure + 0 >= low && figure + 0 <= high)}' ||
        { echo "\"$3\" is not from $1 to $2"; return 1; }
}
value() {
    "$program" value "$root/scenes/table.json" --out "$folder/run" --accuracy draft --effects none --quiet >"$folder/run.txt"
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
check "corrupted photos rank low" within 0.9 1 "$(auc "$folder/run")"
check "other validation photos would agree" within 0.5 1 "$(agreement "$folder/run.txt")"
check "so ranks are told, with quality and ground truth" test "$(grep -cE ' % +rank .* quality [01]\.[0-9]{2}  view_[0-9]+ \([a-z_]+\)$' \
    "$folder/run.txt")" = 6
check "what covers photos is found, and no untouched one has it" test "$(sqlite3 :memory: ".import --csv $folder/run/advice.csv a" "ATTACH
    '$folder/run/ledger.db' AS run; SELECT group_concat(found, ' ') FROM (SELECT DISTINCT
    (CAST(covered_share AS REAL) > 0.02) || ground_truth AS found FROM a JOIN run.image USING (name)
    WHERE ground_truth IN ('occluder', 'clean')) ORDER BY found")" = '0clean 1occluder'
check "a fault is planted" plant_fault
check "the canary finds it" within 0 0.8 "$(auc "$folder/fault")"
conclude "$@"
