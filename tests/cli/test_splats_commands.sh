#!/usr/bin/env bash
# Commands that train many times, with `--field splats`: what they train are splats, by the PSNR of a training that is drawn; accuracy
# levels, prices, and the commands that are named next. Takes the program's path.
# label: once
. "$(dirname "$0")/../support/program_test.sh"
shape=(--splats 60 --rays 256 --val-rays 256 --effects none --device llvmpipe) # the hash grid refuses the first two
once=(--field splats "${shape[@]}" --epochs 1 --burn-in 0) # one epoch: retrainings are measured at its end, as a training is
config() { query "$1" "SELECT config_json ->> '\$.$2' FROM run"; }
value() { run "$program" value "$scene" --out "$folder/$1" --no-thumbnails "${@:2}"; } # value OUT [OPTION]...
is_of_splats() { [[ $(config "$1" field) == splats ]] && run "$program" render "$folder/$1" --device llvmpipe; }

# named KEY: runs the command that stdout names by KEY, with another OUT.
named() {
    local command
    command=$(sed -n "s/^$1  *viewworth //p" "$folder/stdout")
    read -ra words <<<"${command//ANOTHER/$folder/named_$1}"
    run "$program" "${words[@]}" "${@:2}"
}

# ---- Accuracy levels ----

check "a draft of the preset" value draft --preset splats --accuracy draft --splats 60 --effects none --device llvmpipe
check "has its pixels and epochs" test "$(config draft rays),$(config draft val_rays),$(config draft epochs)" = 6144,4096,8
check "and the rest of the preset" test "$(config draft harmonics),$(config draft loss)" = 3,l1
check "what is told of it is true of splats" grep -qx ' *trade-off: less detail, and scores of two seeds agree less' "$folder/stderr"
for level in quick=15 standard=30 reference=120; do
    check "${level%=*} has its epochs, and options override it" value "${level%=*}" --field splats --accuracy "${level%=*}" "${shape[@]}"
    check "which are ${level#*=}" test "$(config "${level%=*}" epochs),$(config "${level%=*}" rays)" = "${level#*=},256"
done
check "prices are those of splats" run "$program" info "$scene" --field splats --effects none --device llvmpipe --json --quiet
check "without lasting credit" test "$(json '$.prices.draft.lasting.seconds')" = ''
check "with the rest" test -n "$(json '$.prices.draft.worth.seconds')"
check "of 30 epochs" test "$(json '$.estimate.steps')" = 180
check "a line of text has no price, either" prints '^lasting  +7 +- +- +- +-$' "$program" info "$scene" --field splats --effects none \
    --device llvmpipe

# ---- The same training by every command ----

check "a training" run "$program" train "$scene" --out "$folder/train" --seed 1 "${once[@]}"
check "of 60 splats" grep -aqx 'element vertex 60' "$folder/train/field.ply"
drawn() { # its PSNR in both validation photos
    local view
    for view in view_006 view_007; do
        run "$program" render "$folder/train" --view $view --to "$folder/view.png" --device llvmpipe &&
            sed -n 's/.*PSNR \(.*\) dB.*/\1/p' "$folder/stdout"
    done
}
as_drawn=$(drawn)
retrained() { # the same numbers of the retraining of all photos with its seed
    sqlite3 "$folder/$1/retrainings.db" "SELECT printf('%.2f', psnr) FROM view JOIN retraining USING (retraining_id)
        WHERE seed = 1 AND views = '0 1 2 3 4 5' AND image_id IN (6, 7) ORDER BY image_id"
}
check "is drawn" grep -qE '^[0-9]' <<<"$as_drawn"
printf 'name,provider\n' >"$folder/providers.csv"
for i in 0 1 2 3 4 5; do echo "view_00$i,p$((i % 2))" >>"$folder/providers.csv"; done
check "worth with providers" value worth "${once[@]}" --providers "$folder/providers.csv" --retrainings 8
check "retrains splats" test "$(retrained worth)" = "$as_drawn"
check "and is intact" run "$program" verify "$folder/worth"
check "a run to select from" value select "${once[@]}"
check "lists are verified" run "$program" select "$folder/select" --to "$folder/list.txt" --device llvmpipe
check "by splats" test "$(retrained select)" = "$as_drawn"
check "without a word on lasting credit" bash -c "! grep -q lasting '$folder/stdout' '$folder/stderr'"
check "what is to be trained next" named train --epochs 2 --device llvmpipe
check "are splats" is_of_splats named_train
check "a comparison" run "$program" compare "$scene" --list all --list top:3 --scores "$folder/select" --out "$folder/compare" --seed 1 \
    --seeds 2 "${once[@]}"
check "is of splats" test "$(retrained compare)" = "$as_drawn"

# ---- Batches ----

cat >"$folder/jobs.json" <<JSON
{"defaults": {"rays": 256, "val-rays": 256, "splats": 60, "effects": "none", "epochs": 2}, "seeds": [0, 1],
 "jobs": [{"name": "field", "scene": "$scene", "options": {"field": "splats"}},
          {"name": "preset", "scene": "$scene", "options": {"preset": "splats"}}]}
JSON
check "a batch" run "$program" batch "$folder/jobs.json" --out "$folder/batch" --devices llvmpipe
for job in field preset; do
    check "its jobs by $job" is_of_splats "batch/$job/seed-1"
    check "leave splats" grep -aqx 'element vertex 60' "$folder/batch/$job/seed-0/field.ply"
done
conclude "$@"
