#!/usr/bin/env bash
# --splits of an earlier run: when a photo is deleted, all others validate, test and train as before, and the run resumes and verifies.
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
    grep -q "moved: validates or tests on other photos than .*first.*--splits" "$folder/stderr"'
check "of runs that the same ones judge it does not" eval 'run "$program" report "$folder"/{first,kept} --to "$folder/same.html" &&
    ! grep -q "validates or tests" "$folder/stderr"'
conclude "$@"
