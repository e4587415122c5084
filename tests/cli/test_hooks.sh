#!/usr/bin/env bash
# The hooks of scripts/hooks/ with trainers that look like gsplat's and nerfstudio's, and import-steps on what they write, validated after
# every step and after every third. Takes the program's path.
. "$(dirname "$0")/../support/program_test.sh"
python=${PYTHON:-/usr/bin/python3}
[[ -x $python ]] || { echo "SKIPPED: python3 is missing; apt-get install python3"; exit 77; }

# steps TRAINER EVERY: LOG and run of 400 steps on four photos, of which each moves twice, three or four times as much as the first.
steps() {
    local log=$folder/$1-$2.csv
    PYTHONPATH=$root/scripts/hooks "$python" -B "$root/tests/cli/fake_trainers.py" "$1" "$log" "$2" 100 &&
        run "$program" import-steps "$log" --out "$folder/$1-$2"
}
order() { query "$1" "SELECT group_concat(name, '|') FROM (SELECT name FROM score JOIN image USING (image_id)
    WHERE method = 'dv_loss' ORDER BY value DESC)"; }
warned() { grep -q "^warning: $1" "$folder/stderr"; }

for trainer in gsplat splatfacto; do
    check "$trainer: a log of every step is imported" steps "$trainer" 1
    check "$trainer: without a warning" test ! -s "$folder/stderr"
    check "$trainer: 400 steps on four photos in 100 epochs" test \
        "$(query "$trainer-1" 'SELECT max(step), count(DISTINCT image_id), max(epoch) FROM step')" = '400|4|99'
    check "$trainer: the photo that moves most is first" test "$(order "$trainer-1")" = 'e.jpg|c, d.jpg|b.jpg|a.jpg'
    check "$trainer: the error is that of the photos" test \
        "$(query "$trainer-1" 'SELECT round(val_l1, 9), round(val_psnr, 6) FROM step WHERE step = 400')" = '0.7|3.098039'
    check "$trainer: a log of every third step is imported" steps "$trainer" 3
    check "$trainer: with a warning of its price" warned '265 steps were not validated: .* up to 3 steps apart'
    check "$trainer: and one of its end" warned 'steps before the first validation or after the last one are not credited: 1'
    check "$trainer: each change is shared, and none is lost" test \
        "$(query "$trainer-3" 'SELECT round(max(val_l1) - min(val_l1), 9), count(DISTINCT round(val_l1, 9)) FROM step')" = \
        "$(query "$trainer-1" 'SELECT round(max(val_l1) - min(val_l1), 9) FROM step WHERE step < 400')|399"
    check "$trainer: steps between two validations share alike" test "$(query "$trainer-3" 'SELECT count(DISTINCT round(change, 9))
        FROM (SELECT step, val_l1 - lag(val_l1) OVER (ORDER BY step) AS change FROM step) WHERE step BETWEEN 4 AND 6')" = 1
    check "$trainer: the photo that moves most is first again" test "$(order "$trainer-3" | cut -d '|' -f 1)" = e.jpg
    check "$trainer: the ledger says so" test "$(query "$trainer-3" "SELECT scene_options_json ->> '\$.validated_every' FROM run")" = 3
    check "$trainer: and is intact" prints 'is intact' "$program" verify "$folder/$trainer-3"
done
check "both hooks write the same" cmp "$folder/gsplat-3.csv" "$folder/splatfacto-3.csv"
conclude "$@"
