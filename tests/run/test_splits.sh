#!/usr/bin/env bash
# --splits of an earlier run: when a photo is deleted, all others validate, test and train as before, and the run resumes and verifies.
# --val-weights: the means over validation photos, credit and lasting credit are weighted, and the run resumes, verifies and is replayed.
# Takes the program's path.
. "$(dirname "$0")/../support/program_test.sh"

mkdir -p "$folder/scene/images"
# frames FIRST: transforms.json of the photos from FIRST to 15 and of photo 0, on a circle.
frames() {
    sqlite3 :memory: "WITH photo(i) AS (SELECT 0 UNION SELECT value FROM generate_series($1, 15)) SELECT json_object('camera_angle_x', 0.8,
        'frames', json_group_array(json_object('file_path', printf('images/%04d.png', i), 'transform_matrix', json_array(
            json_array(cos(i / 2.5), 0, sin(i / 2.5), 3 * sin(i / 2.5)), json_array(0, 1, 0, 0.1),
            json_array(-sin(i / 2.5), 0, cos(i / 2.5), 3 * cos(i / 2.5)), json_array(0, 0, 0, 1))))) FROM photo" \
        >"$folder/scene/transforms.json"
}
for i in {0..15}; do
    write_photo "$folder/scene/images/$(printf %04d "$i").png"
    echo "$i" >>"$folder/scene/images/$(printf %04d "$i").png" # behind the image's end: only its hash differs
done
value() { run "$program" value "$folder/scene" --out "$folder/$1" "${small[@]}" --epochs 2 --quiet "${@:2}"; }
judges() { query "$1" "SELECT name, split FROM image WHERE split IN ('val', 'test') ORDER BY name"; } # judges OUT

frames 1
check "a first valuation takes every eighth photo" eval 'value first && [[ $(judges first | wc -l) -eq 4 ]]'
check "splits.json says so" answers "j ->> '\$.val' = '[\"images/0000.png\",\"images/0008.png\"]' AND
    json_array_length(j, '\$.train') = 12 AND j -> '\$.excluded' IS NULL" cat "$folder/first/splits.json"
frames 4
check "without --splits other photos judge once some are deleted" eval 'value moved && [[ $(judges moved) != "$(judges first)" ]]'
check "with it the same ones do" eval 'value kept --splits "$folder/first/splits.json" && [[ $(judges kept) == "$(judges first)" ]]'
check "the run resumes" eval 'value kept --splits "$folder/first/splits.json" --resume --epochs 3'
check "and is replayed" run "$program" verify "$folder/kept" --replay 3
check "by its own splits, too" eval 'value kept --splits "$folder/kept/splits.json" --resume --epochs 4'
check "--splits and --val are refused together" fails 2 'leave out --train, --val and --test' "$program" value "$folder/scene" \
    --out "$folder/both" --splits "$folder/first/splits.json" --val "$folder/first/splits.json" --quiet
check "a report of runs that other photos judge says so" eval 'run "$program" report "$folder"/{first,moved} --to "$folder/both.html" &&
    grep -q "moved: validates or tests on other photos or weights than .*first.*--splits" "$folder/stderr"'
check "of runs that the same ones judge it does not" eval 'run "$program" report "$folder"/{first,kept} --to "$folder/same.html" &&
    ! grep -q "validates or tests" "$folder/stderr"'

# ---- Weights -------------------------------------------------------------------------------------------------------------

printf 'name,weight\n0008.png,3\n' >"$folder/weights.csv"
printf 'name,weight\n0000.png,0\n' >"$folder/one.csv"
printf 'name,weight\n0000.png,0.3\n0008.png,0.3\n' >"$folder/equal.csv"
frames 1
# of_weights OUT TABLE VALUE: by step, the mean of a view's value in a table by the weights 1 and $heavy of the validation photos.
of_weights() {
    echo "SELECT v.step, sum(w * $3) / sum(w) AS mean FROM (SELECT v.*, CASE WHEN name LIKE '%0008.png' THEN $heavy ELSE $light END AS w
        FROM $2 AS v JOIN image USING (image_id)) AS v GROUP BY v.step"
}
weighs() { # weighs OUT LIGHT HEAVY: whether validation PSNR and lasting credit are these means
    local light=$2 heavy=$3
    [[ $(query "$1" "SELECT max(abs(val_psnr - mean)) < 1e-10
            FROM step JOIN ($(of_weights "$1" view '-10 * log10(mse)')) USING (step)") == 1 &&
        $(query "$1" "SELECT max(abs(psnr - mean)) < 1e-3 * (SELECT max(abs(psnr)) FROM lasting_step)
            FROM lasting_step JOIN ($(of_weights "$1" lasting_view psnr)) USING (step)") == 1 ]]
}
identity() { query "$1" "SELECT run_id, scene_hash, (SELECT row_hash FROM step ORDER BY step DESC LIMIT 1) FROM run"; }
lasting=(--lasting --lasting-matrix --no-gate)
check "weights are those of the means" eval 'value weighted --val-weights "$folder/weights.csv" "${lasting[@]}" && weighs weighted 1 3'
check "and not of those without" eval '! weighs weighted 1 1'
check "a weight of 0 leaves the other photo alone" eval 'value one --val-weights "$folder/one.csv" "${lasting[@]}" && weighs one 0 1'
check "the mean of a row of the matrix is the weighted credit" test "$(sqlite3 :memory: ".import --csv $folder/weighted/matrix.csv m" \
    ".import --csv $folder/weighted/scores.csv s" "SELECT count(*), max(abs(mean - value)) < 1e-9, max(abs(mean - (\"images/0000.png\" +
    3 * \"images/0008.png\") / 4)) < 1e-9 FROM m JOIN s USING (name) WHERE measure = 'dv_psnr' AND method = 'dv_psnr'")" = "12|1|1"
check "a weighted run verifies and is replayed" run "$program" verify "$folder/weighted" --replay 5
check "its splits.json gives the same judge" eval 'value again --splits "$folder/weighted/splits.json" &&
    [[ $(identity again) == "$(identity weighted)" ]] && run "$program" verify "$folder/again" --replay 2'
check "equal weights are none" eval 'value equal --val-weights "$folder/equal.csv" && value plain &&
    [[ $(identity equal) == "$(identity plain)" ]]'
check "resume refuses other weights" fails 2 'another scene' "$program" value "$folder/scene" --out "$folder/weighted" "${small[@]}" \
    --epochs 2 --val-weights "$folder/one.csv" --resume --quiet
check "and continues with the same" value again --val-weights "$folder/weights.csv" --resume --epochs 3
check "select refuses weights" fails 2 'without weights' "$program" select "$folder/weighted" --to "$folder/list.txt" --quiet
check "a report of runs with other weights says so" eval 'run "$program" report "$folder"/{plain,weighted} --to "$folder/both.html" &&
    grep -q "weighted: validates or tests on other photos or weights" "$folder/stderr"'
conclude "$@"
