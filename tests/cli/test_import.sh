#!/usr/bin/env bash
# import-steps from outside: a run of ours that is exported and imported again, what is refused, and what other commands make of such a
# ledger. Takes the program's path.
. "$(dirname "$0")/../support/program_test.sh"
tiny=("${small[@]}" --epochs 4 --quiet)
log=$folder/log.csv

refuses() { fails "$1" "$2" "$program" "${@:3}"; } # refuses CODE PATTERN ARGUMENT...

# export_steps RUN: its steps as another trainer would log them.
export_steps() {
    sqlite3 -header -csv "$folder/$1/ledger.db" "SELECT printf('%!.17g', val_l1) AS l1, name AS photo, step, train_loss, epoch,
        printf('%!.17g', val_psnr) AS psnr FROM step LEFT JOIN image USING (image_id) ORDER BY step"
}

# same_scores RUN IMPORTED: dv_psnr and dv_loss of all photos are equal to the last bit, and there are some.
same_scores() {
    [[ $(query "$2" "ATTACH '$folder/$1/ledger.db' AS ours;
        SELECT count(*) FROM score JOIN image USING (image_id)
        JOIN ours.image AS our_image ON our_image.name = image.name
        JOIN ours.score AS our_score ON our_score.image_id = our_image.image_id AND our_score.method = score.method
        WHERE score.method IN ('dv_psnr', 'dv_loss') AND score.value = our_score.value AND score.visits = our_score.visits") == 24 ]]
}

# ---- There and back -----------------------------------------------------------------------------------------------------

check "value gives a run" prints '' "$program" value "$root/scenes/clean.json" --out "$folder/ours" "${tiny[@]}"
export_steps ours >"$log"
check "its steps are a log" test "$(wc -l <"$log")" = 50
check "the log is imported" prints '^imported  48 steps on 12 photos in 4 epochs$' "$program" import-steps "$log" --out "$folder/imported"
check "its scores are those of the run" same_scores ours imported
check "nothing is made up of what the log lacks" test \
    "$(query imported "SELECT count(val_psnr_pooled), (SELECT count(*) FROM score WHERE method LIKE '%pooled%') FROM step")" = '0|0'
check "the ledger has what sha256sum says of the log" test "$(query imported "SELECT scene_options_json ->> '\$.log_sha256' FROM run")" = \
    "$(sha256sum "$log" | cut -d ' ' -f 1)"
check "the ledger says where it is from" test "$(query imported "SELECT device, scene_path = '$log', status FROM run")" = \
    'imported|1|finished'
check "scores.csv has a line per score" test "$(wc -l <"$folder/imported/scores.csv")" = \
    "$(($(query imported 'SELECT count(*) FROM score') + 1))"
check "importing again leaves the same rows" bash -c "'$program' import-steps '$log' --out '$folder/again' >/dev/null"
check "they are the same" same_rows imported again
check "--burn-in is heard" bash -c "'$program' import-steps '$log' --out '$folder/late' --burn-in 3 >/dev/null"
check "--beta1 is heard" bash -c "'$program' import-steps '$log' --out '$folder/slow' --beta1 0.5 >/dev/null"
check "imports of one log by other options are other runs" test "$(for run in imported late slow; do
    query "$run" 'SELECT run_id FROM run'; done | sort -u | wc -l)" = 3
check "visits say so" test "$(query late "SELECT DISTINCT visits FROM score WHERE method = 'dv_psnr'")" = 1
check "--json tells the same" bash -c "'$program' import-steps '$log' --out '$folder/json' --json >'$folder/answer.json' &&
    sqlite3 :memory: \"SELECT j ->> '\$.steps' = 48 AND j ->> '\$.photos' = 12 AND j ->> '\$.epochs' = 4 AND j ->> '\$.nonfinite' = 0
        AND length(j ->> '\$.head') = 64 AND length(j ->> '\$.log_sha256') = 64
        FROM (SELECT CAST(readfile('$folder/answer.json') AS TEXT) AS j)\" | grep -qx 1"
check "too few epochs warn" bash -c "'$program' import-steps '$log' --out '$folder/none' --burn-in 9 2>&1 >/dev/null |
    grep -q '^warning: .*no scores'"

# ---- Other commands -----------------------------------------------------------------------------------------------------

head=$("$program" verify "$folder/imported" | sed -n 's/^head *//p')
check "verify finds it intact and says what it cannot check" prints '^the run was imported, so' "$program" verify "$folder/imported"
check "and the log's hash" grep -q "^ *$(sha256sum "$log" | cut -d ' ' -f 1)$" "$folder/stdout"
check "verify --expect knows its head" prints 'is intact' "$program" verify "$folder/imported" --expect "$head"
check "verify --replay is refused" refuses 2 'was imported from' verify "$folder/imported" --replay 3 --quiet
check "render is refused" refuses 2 'was imported from' render "$folder/imported" --quiet
check "value --resume does not go on with it" refuses 2 'another scene' value "$root/scenes/clean.json" --out "$folder/imported" --resume \
    "${tiny[@]}"
query again "UPDATE step SET val_psnr = val_psnr + 1 WHERE step = 7"
check "verify finds an edited step" refuses 1 'step 7 or one of its view rows was edited' verify "$folder/again"
query late "UPDATE run SET config_json = '{}'"
check "verify finds an edited configuration" refuses 1 'run row was edited' verify "$folder/late"

# final_hash RUN: the final hash of a run without scores, as viewworth/ledger.h describes it: of texts, each with its tag and length, and
# of the field that an imported run lacks.
final_hash() {
    local text
    { query "$1" "SELECT row_hash FROM step ORDER BY step DESC LIMIT 1;
        SELECT scene_path, config_json, scene_options_json, effects_json, plan_json, started_utc, finished_utc, status
        FROM run" | tr '|' '\n' |
        while read -r text; do
            printf "t\\x$(printf %02x "${#text}")\\0\\0\\0\\0\\0\\0\\0%s" "$text"
        done; printf n; } | b2sum -l 256 | cut -d ' ' -f 1
}
check "a run without scores is sealed as described" test "$(final_hash none)" = "$(query none 'SELECT final_hash FROM run')"

# ---- Refusals -----------------------------------------------------------------------------------------------------------

check "a folder that holds a run is refused" refuses 2 'already contains a run' import-steps "$log" --out "$folder/imported"
check "a file in place of --out is refused" refuses 2 'is a file' import-steps "$log" --out "$log"
check "--out is needed" refuses 2 '--out is missing' import-steps "$log"
check "options of training are refused" refuses 2 'unknown option "--rays"' import-steps "$log" --out "$folder/bad" --rays 5
check "a burn-in out of range is refused" refuses 2 '--burn-in takes' import-steps "$log" --out "$folder/bad" --burn-in 4000000000
check "a log that is not there is refused" refuses 2 'no/log.csv' import-steps "$folder/no/log.csv" --out "$folder/bad"
sed '20s/[0-9.]*$/x/' "$log" >"$folder/broken.csv"
check "a malformed line is refused by its number" refuses 2 'broken\.csv:20: field psnr' import-steps "$folder/broken.csv" \
    --out "$folder/bad"
check "refused logs leave no --out folder" test ! -e "$folder/bad"

# ---- Size ---------------------------------------------------------------------------------------------------------------

awk 'BEGIN { print "step,epoch,photo,psnr,l1"; print "0,0,,10,0.5"
    for (i = 1; i <= 100000; i++)
        printf "%d,%d,photo %d.jpg,%.6f,%.6f\n", i, int((i - 1) / 500), i * 7 % 500, 20 + sin(i), 0.1 + 0.01 * sin(i) }' \
    >"$folder/long.csv"
TIMEFORMAT=%U # not what others do with the machine meanwhile
{ time check "100,000 lines are imported" prints '^imported  100000 steps on 500 photos in 200 epochs$' \
    "$program" import-steps "$folder/long.csv" --out "$folder/long"; } 2>"$folder/seconds"
echo "in $(cat "$folder/seconds") s of CPU time"
check "in a few seconds" test "$(cut -d . -f 1 "$folder/seconds")" -lt 30
# The C library has other code for processors without fused multiply-adds, whose last bits differ.
other=glibc.cpu.hwcaps=-AVX2,-FMA,-AVX2_Usable,-FMA_Usable
check "and verified where sines and logarithms are rounded otherwise" prints 'is intact' env "GLIBC_TUNABLES=$other" "$program" verify \
    "$folder/long"
conclude "$@"
