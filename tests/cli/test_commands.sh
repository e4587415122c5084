#!/usr/bin/env bash
# The program from outside: exit codes, messages, outputs, and that equal runs leave equal rows. Takes the program's path.
. "$(dirname "$0")/../support/program_test.sh"
scene=$root/scenes/clean.json
tiny=("${small[@]}" --epochs 3 --effects visibility)

refuses() { fails 2 "$1" "$program" "${@:2}"; } # refuses PATTERN ARGUMENT...

in_folder() { (cd "$folder" && "$@"); }

begins_as() { # begins_as RUN LONGER: all steps of the run, with their hashes, are the first ones of the longer run
    local steps
    steps=$(query "$1" 'SELECT count(*) FROM step')
    [[ $steps -gt 1 ]] && diff <(query "$1" 'SELECT * FROM step ORDER BY step') \
        <(query "$2" "SELECT * FROM step ORDER BY step LIMIT $steps") >"$folder/diff" && return
    head -n 5 "$folder/diff"
    return 1
}
value() { # value OUT [OPTION]...
    "$program" value "$scene" --out "$folder/$1" "${tiny[@]}" --quiet "${@:2}" >/dev/null
}

# ---- Without a device ---------------------------------------------------------------------------------------------------

check "--help lists the commands" prints '^  value SCENE' "$program" --help
check "--help lists them in groups" prints '^Use the scores:$' "$program" --help
check "--version names a version" prints '^viewworth [0-9]+\.[0-9]+\.[0-9]+$' "$program" --version
for command in devices info value train render; do
    check "$command --help shows its usage" prints "^usage: viewworth $command " "$program" "$command" --help
done
helps() { # helps PATTERN [help] COMMAND: the main options, or all of them, with their lines joined, match
    run "$program" "${@:2}" $([[ $2 == help ]] || echo --help) || return
    grep -qE -- "$1" <<<"$(tr -s '[:space:]' ' ' <"$folder/stdout")" && return
    cat "$folder/stdout"
    return 1
}
not() { ! "$@" >/dev/null; }
for command in compare tradeoff; do
    check "$command --help says that it resumes" helps 'Run the same command again to resume it\.' "$command"
    check "and does not ask for --resume" test "$(grep -c 'unless --resume' "$folder/stdout")" = 0
done
check "select --help says that rules train nothing" helps '--quick, --rule and --method train nothing' select
check "what is trained is among them" helps ' --field hash' value
check "--to of select does not speak of pages" not helps 'page of report' select
check "compare has --accuracy, of known levels" fails 2 '"sketch" is not one of draft' "$program" compare "$scene" --list all \
    --accuracy sketch --out "$folder/sketch"
check "help shows the options that most people need" not helps ' --rays N ' value
check "and says where the others are" helps 'help value lists all options \([0-9]+ more\)' value
check "help fits a terminal of 80 columns" test "$("$program" help value | awk '{ print length($0) }' | sort -n | tail -n 1)" -le 80
check "help shows ranges and defaults" helps '--rays N [^-]*\(1 to 65536; default 250, with --field splats 6144\)\.' help value
check "help shows ranges with gaps" helps '--width N [^-]*\(a multiple of 8, 16 to 512; default 32, .*256\)\.' help train
check "help shows ranges outside the config" helps '--downscale auto\|N [^-]*\(1 to 64; default auto\)\.' info
check "help shows what is chosen" helps '--field hash\|mlp\|splats\|auto [^-]*\(default auto\)\.' help value
check "help shows what keeps the splits" helps '--splits FILE The splits.json of an earlier run' info
check "help shows choices" helps '--loss l1\|l2\|huber Training loss \(default l2\)\.' help value
for words in help -h; do
    check "$words is --help" test "$("$program" $words)" = "$("$program" --help)"
done
check "COMMAND -h is COMMAND --help" test "$("$program" value -h)" = "$("$program" value --help)"
check "help shows short options" helps '--out FOLDER, -o FOLDER ' value
check "-o is --out" refuses 'no such scene' value "$folder/no/scene" -o "$folder/none" --device llvmpipe --quiet
check "and needs a value" refuses '-o needs a value' value "$scene" -o
check "a mistyped command gets a suggestion" refuses 'unknown command "vlaue"; is value meant\?$' vlaue
check "also of help" refuses 'unknown command "inof"; is info meant\?$' help inof
check "a mistyped option gets a suggestion" refuses 'unknown option "--epohcs"; is --epochs meant\?$' value "$scene" --epohcs 3
check "two letters get none" refuses 'unknown option "--lr"; see' select "$folder" --lr 3
check "no command is refused" refuses 'no command'
check "an unknown command is refused" refuses 'unknown command "frobnicate"' frobnicate
check "an unknown option is refused" refuses 'unknown option "--frobnicate"' devices --frobnicate
check "the beginning of an option is refused" refuses 'unknown option "--downsc"; is --downscale meant?' info "$scene" --downsc 2
check "with = as well" refuses 'unknown option "--downsc"; is --downscale meant?' info "$scene" --downsc=2
check "an option of another command is refused" refuses 'unknown option "--out"' info "$scene" --out x
check "a missing value is refused" refuses '--seed needs a value' value "$scene" --seed
check "a value for a flag is refused" refuses '--json takes no value' devices --json=1
check "a missing operand is refused" refuses 'SCENE is missing' value --out "$folder/none"
check "a second operand is refused" refuses 'unexpected argument "other"' value "$scene" other --out "$folder/none"
check "value without --out is refused" refuses '--out is missing' value "$scene"
check "an empty --out is refused" refuses '--out is missing' value "$scene" --out ''
for bad in '--rays 5x' '--rays -1' '--rays 0' '--rays 65537' '--rays 99999999999999999999' '--epochs 1.5' '--epochs 0' \
    '--seed 9223372036854775808' '--downscale 0' '--lr nan' '--lr 0' '--lr 1e999' '--beta1 1' '--beta1 x' \
    '--growth 5' '--width 33' '--levels 17' '--loss l3'; do
    read -r option number <<<"$bad"
    check "$bad is refused" refuses "$option\b" value "$scene" --out "$folder/none" "$option" "$number"
done
check "a number that is none is told the range" refuses '--rays takes a whole number, 1 to 65536, not "5x"$' value "$scene" \
    --out "$folder/none" --rays 5x
check "a number out of range is told the range" refuses '--growth takes 1 to 4, not 5$' value "$scene" --out "$folder/none" --growth 5
check "a scene that is not there is refused" refuses 'no/such/scene' value "$folder/no/such/scene" --out "$folder/none" "${tiny[@]}" --quiet
check "render of a folder without a run is refused" refuses 'ledger\.db' render "$folder"
check "render to an unknown kind of image is refused" refuses '--to .*\.gif' render "$folder" --to "$folder/view.gif"
check "refused commands leave no --out folder" test ! -e "$folder/none"
check "output that cannot be written is a failure" bash -c "'$program' --help >/dev/full 2>'$folder/stderr'; [[ \$? -eq 1 ]]"

# ---- Devices and scenes -------------------------------------------------------------------------------------------------

check "devices lists lavapipe" prints '^[0-9]+ +cpu .*llvmpipe' "$program" devices
check "devices --json lists lavapipe" answers "(SELECT count(*) FROM json_each(j, '\$.devices') WHERE value ->> 'kind' = 'cpu'
    AND value ->> 'name' LIKE 'llvmpipe%') = 1" "$program" devices --json
check "devices --json says what bits depend on" answers "(SELECT count(*) FROM json_each(j, '\$.devices')
    WHERE value ->> '\$.bits_depend_on.keeps_nan'
    AND value ->> '\$.bits_depend_on.subgroup_size' > 0) >= 1" "$program" devices --json
check "a device that is not there is refused" refuses 'abacus' value "$scene" --out "$folder/none" --device abacus
check "info shows splits and effects" prints '^distortion ' "$program" info "$scene" --pilot-steps 0
check "info ends each line" says '^photos .* excluded$'
check "info tells in words what commands cost" says '^worth --retrainings 64 +64( +[0-9.]+ (s|min|h)){4}$'
check "info --json has what is contracted" answers "j ->> '\$.views' = 16 AND j ->> '\$.splits.train' = 12 AND j ->> '\$.splits.val' = 2
    AND json_array_length(j, '\$.cameras') = 1 AND j ->> '\$.bounds.half_extent_world' = 1 AND json_array_length(j, '\$.effects') >= 2
    AND (SELECT min(json_type(value, '\$.called_for') IN ('true', 'false') AND json_type(value, '\$.evidence') IS NOT NULL
        AND json_type(value, '\$.threshold') IS NOT NULL) FROM json_each(j, '\$.effects'))" \
    "$program" info "$scene" --field hash --pilot-steps 0 --json
mv "$folder/answer.json" "$folder/info.json"
check "info --json says what a run would take" answers "j ->> '\$.estimate.device_bytes' > 1e6 AND j ->> '\$.estimate.host_bytes' > 1e4
    AND j ->> '\$.estimate.steps' = 576 AND j ->> '\$.points' > 0 AND j ->> '\$.tracks' > 0
    AND j ->> '\$.masks' = 0" cat "$folder/info.json"
check "and what each command costs at each level" answers "(SELECT count(*) = 20 AND max(price.value ->> 'trainings') = 64
    AND min(price.value ->> 'seconds') > 0 FROM json_each(j, '\$.prices') AS level, json_each(level.value) AS price)
    AND j ->> '\$.prices.draft.worth.seconds' < j ->> '\$.prices.reference.worth.seconds'" cat "$folder/info.json"
check "--profile says where the time went" answers "json_array_length(j, '\$.profile') > 12
    AND abs((SELECT sum(value ->> 'share') FROM json_each(j, '\$.profile')) - 1) < 1e-6
    AND (SELECT min(value ->> 'ms' > 0 AND value ->> 'dispatches' > 0) FROM json_each(j, '\$.profile'))" \
    "$program" value "$scene" --out "$folder/profiled" "${tiny[@]}" --effects none --profile --json
check "a level that does not fit has no price" answers "j ->> '\$.prices.reference.worth.seconds' IS NULL
    AND j ->> '\$.prices.draft.worth.seconds' > 0" "$program" info "$scene" --pilot-steps 0 --base-resolution 32 --growth 2 \
    --json

# ---- Valuing ------------------------------------------------------------------------------------------------------------

check "value prints that two validation photos tell no ranks" prints '^no ranks by credit: those by 2 other ' "$program" value "$scene" \
    --out "$folder/first" "${tiny[@]}"
check "the run is finished" test "$(query first 'SELECT status FROM run')" = finished
check "a step per photo and epoch, and the untrained one" test "$(query first 'SELECT count(*), max(step) FROM step')" = '37|36'
check "every step is validated on every view" test "$(query first 'SELECT count(*) FROM view')" = 74
check "the configuration is kept" test "$(query first "SELECT config_json ->> '\$.rays' FROM run")" = 64
check "scores.csv has a line per photo and method" test "$(grep -c '' "$folder/first/scores.csv")" = \
    "$(($(query first 'SELECT count(*) FROM score') + 1))"
check "scores follow from the steps by SQL" test "$(sqlite3 "$folder/first/ledger.db" <"$root/scripts/dv_psnr.sql" |
    while IFS='|' read -r run image name value visits; do
        query first "SELECT abs(value - ($value)) < 1e-9 AND visits = $visits FROM score
            WHERE run_id = '$run' AND image_id = $image AND method = 'dv_psnr'"
    done | sort | uniq -c | tr -s ' ')" = ' 12 1'
check "value again gives a run, its effects added to the facts" value second --effects +visibility --pilot-steps 0
check "the same effects leave the same rows" same_rows first second

# Names, times and bytes of a run's files. A command that reads changes none, whether it ends well or not.
files_of() { (cd "$folder/$1" && stat -c '%n %y %s' . ./* && cat ./*) | sha256sum; }
leaves_alone() { # leaves_alone RUN EXIT_CODE COMMAND [ARGUMENT]...
    local before code=0
    before=$(files_of "$1")
    "$program" "${@:3}" >"$folder/stdout" 2>&1 || code=$?
    [[ $code -eq $2 && $(files_of "$1") == "$before" ]] && return
    cat "$folder/stdout"
    return 1
}
cp -r "$folder/first" "$folder/edited"
sqlite3 "$folder/edited/ledger.db" 'UPDATE step SET val_psnr = val_psnr + 1 WHERE step = 3'
cp -r "$folder/first" "$folder/indexed"
sqlite3 "$folder/indexed/ledger.db" 'CREATE INDEX extra ON score (method)'
for reading in 'verify RUN' "select RUN --rule top:2 --to $folder/list.txt" "report RUN --to $folder/page.html" \
    "render RUN --to $folder/view.png"; do
    read -ra words <<<"${reading/RUN/$folder/first}"
    check "${words[0]} changes nothing in the folder" leaves_alone first 0 "${words[@]}"
    read -ra words <<<"${reading/RUN/$folder/indexed}"
    check "${words[0]} refuses an index, and changes nothing" leaves_alone indexed 2 "${words[@]}"
done
check "verify finds an edit, and changes nothing" leaves_alone edited 1 verify "$folder/edited"

check "value with four driver threads gives a run" eval 'LP_NUM_THREADS=4 value threads'
check "the rows do not depend on threads" same_rows first threads
check "a folder that cannot be made is refused" \
    fails 1 '/proc/none: cannot create the folder' "$program" value "$scene" --out /proc/none "${tiny[@]}"
check "a folder that holds a run is refused" refuses 'already contains a run' value "$scene" --out "$folder/first" "${tiny[@]}"
check "value --json prints one object" answers "j ->> '\$.steps' = 36 AND json_array_length(j, '\$.most_valuable') = 5
    AND json_array_length(j, '\$.least_valuable') = 5 AND json_type(j, '\$.most_valuable[0].stderr') = 'real'
    AND (SELECT min(value ->> 'ground_truth' = 'clean') FROM json_each(j, '\$.least_valuable'))
    AND j ->> '\$.most_valuable[0].value' >= j ->> '\$.least_valuable[0].value' AND j ->> '\$.val_psnr_end_db' > 0" \
    "$program" value "$scene" --out "$folder/seeded" "${tiny[@]}" --seed 1 --json
check "another seed leaves other rows" test "$(rows first)" != "$(rows seeded)"
check "too few epochs give a run" value short --epochs 1 2>"$folder/stderr"
check "and warn" grep -q '^warning: .*no scores' "$folder/stderr"
check "too few epochs leave steps" test "$(query short 'SELECT count(*) FROM step')" = 13
check "a longer run keeps the chain of a shorter one" begins_as short first
check "too few epochs leave no scores" test "$(query short 'SELECT count(*) FROM score')" = 0
check "too few epochs leave a table without rows" test "$(cat "$folder/short/scores.csv")" = "$(head -n 1 "$folder/first/scores.csv")"

# ---- The quality of scores ----------------------------------------------------------------------------------------------

quality() { "$root/scripts/lab/score_quality" "$@" | grep '^dv_' | tr '\n' ' '; }
check "without corrupted photos there is no AUC" test "$(quality "$folder/first")" = 'dv_loss - dv_psnr - '
check "a run agrees with itself" test "$(quality "$folder/first" "$folder/second")" = \
    'dv_loss - 1.0000 dv_psnr - 1.0000 '
query second "UPDATE image SET ground_truth = 'blur'
    WHERE image_id IN (SELECT image_id FROM score WHERE method = 'dv_psnr' ORDER BY value LIMIT 3)"
check "corrupted photos with the least scores are found" prints '^dv_psnr 1\.0000$' "$root/scripts/lab/score_quality" "$folder/second"
query second "UPDATE image SET ground_truth = NULL"
check "without ground truth there is no AUC" test "$(quality "$folder/second")" = 'dv_loss - dv_psnr - '

# ---- Training and rendering ---------------------------------------------------------------------------------------------

check "train prints its files" prints 'field\.vwf$' "$program" train "$scene" --out "$folder/trained" "${tiny[@]}"
check "train's field is value's, byte for byte" cmp "$folder/first/field.vwf" "$folder/trained/field.vwf"
check "train takes value's steps" test "$(query trained 'SELECT step, image_id, train_loss FROM step')" = \
    "$(query first 'SELECT step, image_id, train_loss FROM step')"
check "train validates nothing" test "$(query trained 'SELECT count(val_psnr), (SELECT count(*) FROM score) FROM step')" = '0|0'
check "render writes a PNG" prints 'PSNR [0-9.]+ dB' "$program" render "$folder/first"
check "the PNG is one" test "$(head -c 8 "$folder/first/render_view_000.png" | od -An -tx1 | tr -d ' ')" = 89504e470d0a1a0a
check "render --json says what it wrote" answers "j ->> '\$.view' = 'view_008' AND j ->> '\$.psnr_db' > 0" \
    "$program" render "$folder/first" --view 1 --to "$folder/view.exr" --json
check "render writes an EXR" test "$(head -c 4 "$folder/view.exr" | od -An -tx1 | tr -d ' ')" = 762f3101
check "a view that is not there is refused" refuses '--view nowhere' render "$folder/first" --view nowhere --quiet
check "render takes no options of the scene" refuses 'unknown option "--downscale"' render "$folder/first" --downscale 2

query first "SELECT name FROM image WHERE split = 'train' LIMIT 4" >"$folder/train.txt"
query first "SELECT name FROM image WHERE split = 'val'" >"$folder/val.txt"
cp "$scene" "$folder/scene.json"
check "training with options of the scene gives a run" in_folder prints 'field\.vwf$' "$program" train scene.json --out listed \
    --format recipe --downscale 2 --train train.txt --val val.txt "${tiny[@]}"
check "the options are kept" test "$(query listed 'SELECT scene_options_json FROM run')" = \
    '{"downscale":2,"format":"recipe","train":"train.txt","val":"val.txt"}'
check "without options nothing is kept" test "$(query first 'SELECT scene_options_json FROM run')" = '{}'
check "render opens the scene as the run did" in_folder prints '^photo left, render right: ' "$program" render listed
printf 'view_001\nview_002\n' >"$folder/train.txt"
check "another scene than the trained one is refused" in_folder refuses 'no longer the scene' render listed --quiet

# ---- Under the validation layer -----------------------------------------------------------------------------------------

# validated COMMAND...: the command succeeds, and the layer, synchronization validation included, was there and had nothing to say.
validated() {
    VK_INSTANCE_LAYERS=VK_LAYER_KHRONOS_validation VK_LOADER_DEBUG=layer \
        VK_LAYER_ENABLES=VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT "$@" >"$folder/stdout" 2>"$folder/stderr" &&
        grep -q 'Insert.*VK_LAYER_KHRONOS_validation' "$folder/stderr" || return 1
    grep -hE 'Validation (Error|Warning)|VUID-|SYNC-HAZARD' "$folder/stdout" "$folder/stderr" >"$folder/messages" || return 0
    head -n 5 "$folder/messages"
    return 1
}
check "value gives the validation layer nothing to say" validated "$program" value "$scene" --out "$folder/validated" "${tiny[@]}" \
    --effects auto --pilot-steps 8 --quiet
check "render gives it nothing to say" validated "$program" render "$folder/validated"

# ---- Outputs that cannot be written ---------------------------------------------------------------------------------------

mkdir -p "$folder/taken/field.vwf"
check "a run says at once that its field has no place" fails 2 'field.vwf: is not a file, but a result is written there' value taken

conclude "$@"
