#!/usr/bin/env bash
# `viewworth compare` on a tiny recipe: that its metrics are those of train and render, and that it
# trains nothing twice. Takes the program's path.
# label: once
. "$(dirname "$0")/../support/program_test.sh"

# A photo to validate and two to test, not the other way round.
sed 's/"count": 2, "start_deg": 30/"count": 1, "start_deg": 30/; s/"count": 1, "start_deg": 7/"count": 2, "start_deg": 7/' \
    "$root/tests/support/tiny.json" >"$folder/tiny.json"
tiny=(--rays 16 --samples 8 --importance-samples 0 --lr 0.003 --learning-rate-decay 1 --levels 2 --log2-table 6 --width 16 --effects none
   --device llvmpipe)
cd "$folder" || exit 1

compare() { # compare OUT [OPTION]...
    "$program" compare tiny.json --out "$1" "${tiny[@]}" --epochs 3 --seeds 2 "${@:2}" >stdout 2>stderr && return
    cat stderr
    return 1
}
three=(--scores valued --list all --list top:3 --list random)
retrainings() { sqlite3 "$1/retrainings.db" 'SELECT count(*) FROM retraining' 2>/dev/null || echo 0; }
column() { # column LIST SEED NUMBER: of compare.csv
    awk -F, -v list="$1" -v seed="$2" -v number="$3" '$1 == list && $2 == seed { print $number }' whole/compare.csv
}

# ---- What it leaves ----

"$program" value tiny.json --out valued "${tiny[@]}" --epochs 3 --quiet >stdout || exit 1
check "a comparison without interruption" compare whole "${three[@]}"
price='trainings, about [0-9.]+ (s|min|h); Ctrl-C keeps what is done$'
check "its price is told first" grep -qE "^6 $price" stderr
check "the table has every list" test "$(grep -cE '^(all|top:3|random) +[36] +[36] ' stdout)" = 3
difference='^  test PSNR +[-+][0-9.]+ \[ *[-+][0-9.]+, +[-+][0-9.]+\] dB  (within noise|better|worse)$'
check "and differences with intervals" test "$(grep -cE "$difference" stdout)" = 3
check "what they are means of is said" grep -qx 'PSNR, SSIM and L1: means over 1 validation and 2 test photos, whole' stdout
check "as is what chose the lists" grep -q '^lists selected by --scores depend on the validation photos: only test metrics' stdout
check "the valued seed is warned of, and nothing else" test "$(grep -c '^warning: --scores valued: was valued with seed 0, ' stderr) $(
    grep -c '^warning' stderr)" = "1 1"
check "a row per list and seed" test "$(wc -l <whole/compare.csv)" = 7
check "six measures of three pairs" test "$(tail -n +2 whole/pairs.csv | wc -l)" = 18
check "every list against the first, others against random" test "$(cut -d, -f 1,2 whole/pairs.csv | tail -n +2 | uniq | tr '\n' ' ')" \
    = 'top:3,all random,all top:3,random '
in_json() { sqlite3 :memory: "SELECT value FROM json_each(CAST(readfile('whole/compare.json') AS TEXT), '$1')"; }
check "three photos are in one list alone" test "$(in_json '$.disagreements' | grep -c '"in":\["all"\],"not_in":\["top:3"\]')" = 3
check "a render of both test photos" test "$(cd whole/renders && echo *.png)" = "0.png 1.png"
check "every training has an SSIM of both splits" test "$(tail -n +2 whole/compare.csv | grep -cE '^([^,]+,){9}[^,]+$')" = 6
pictures() { grep -o 'data:image/webp' "$1/report.html" | wc -l; }
check "and thumbnails of the three photos in the report" test "$(pictures whole)" = 3
cp whole/report.html made.html
check "which report makes again" "$program" report whole --quiet
check "with the same bytes" cmp whole/report.html made.html
check "or without them" eval '"$program" report whole --quiet --no-thumbnails && [[ $(pictures whole) = 0 ]]'
mv made.html whole/report.html
check "a comparison on two devices" on_two_devices tiny compare spread "${three[@]}"
check "which are both opened" test "$(grep -c '^device ' stderr)" = 2
without_times() { sed 's/,[^,]*$//' "$1/compare.csv" && cat "$1/pairs.csv"; }
check "has the same rows" cmp <(without_times whole) <(without_times spread)
sides() { od -An -tu1 -j16 -N8 whole/renders/0.png | awk '{ print $3 * 256 + $4, $7 * 256 + $8 }'; }
check "the photo and three renders wide" test "$(sides)" = "64 12"

# ---- The metrics are those of train and render ----

# independently LIST-FILE EPOCHS SEED: mean PSNR of the test photos, as train and render have it.
independently() {
    local view sum=0
    "$program" train tiny.json --out trained --train "$1" --epochs "$2" --seed "$3" "${tiny[@]}" --quiet >stdout || return 1
    for view in view_007 view_008; do
        psnr=$("$program" render trained --view $view --device llvmpipe --json --quiet | sed -n 's/.*"psnr_db": \([0-9.]*\).*/\1/p')
        sum=$(awk -v a="$sum" -v b="$psnr" 'BEGIN { printf "%.12f", a + b / 2 }')
    done
    rm -r trained
    echo "$sum"
}
in_json '$.lists[1].photos' >kept.txt
check "three photos are kept" test "$(wc -l <kept.txt)" = 3
check "equal steps: half the photos, twice the epochs" test "$(column top:3 1 4)" = 6
check "PSNR on test photos as render has it" near "$(independently kept.txt 6 1)" "$(column top:3 1 8)" 1e-4

# ---- Resuming and reusing ----

before=$(retrainings whole)
check "six retrainings" test "$before" = 6
cp -r whole first
check "a finished comparison is repeated" compare whole "${three[@]}" --json
check "which costs nothing, with random lists too" eval '! grep -qE "$price" stderr'
check "with the same bytes" diff -r --exclude=retrainings.db first whole
json() { test "$(sqlite3 :memory: "WITH file AS (SELECT CAST(readfile('whole/compare.json') AS TEXT) AS j) SELECT $1 FROM file")" = "$2"; }
check "JSON names the photos of lists" json "json_array_length(j, '\$.lists[1].photos')" 3
check "but not of random ones" json "json_array_length(j, '\$.lists[2].photos') || (j ->> '\$.lists[2].outcomes[1].photo_count')" 03
check "metrics are of whole photos" json "j ->> '\$.half_views'" 0
check "means are over seeds" json "abs((j ->> '\$.lists[1].mean.val_l1') * 2 - (j ->> '\$.lists[1].outcomes[0].val_l1')
    - (j ->> '\$.lists[1].outcomes[1].val_l1')) < 1e-9" 1
check "pairs are of the same seeds" json "(abs((j ->> '\$.pairs[3].difference') * 2 - (j ->> '\$.lists[1].outcomes[0].test_psnr')
    - (j ->> '\$.lists[1].outcomes[1].test_psnr') + (j ->> '\$.lists[0].outcomes[0].test_psnr')
    + (j ->> '\$.lists[0].outcomes[1].test_psnr')) < 1e-9) || (j ->> '\$.pairs[3].list') || (j ->> '\$.pairs[3].measure')" 1top:3test_psnr
check "disagreements name the lists" json "(SELECT count(*) FROM json_each(j, '\$.disagreements') WHERE value ->> '\$.in[0]' = 'all'
    AND value ->> '\$.not_in[0]' = 'top:3')" 3
check "renders name their columns" json "(j ->> '\$.renders[0].columns') || (j ->> '\$.renders[0].view')" \
    '["photo","all","top:3","random"]view_007'
check "without a training" test "$(retrainings whole)" = "$before"
check "prints what it leaves" cmp stdout <(cat whole/compare.json && echo)
rm whole/renders/retrainings/*_7.png
check "a lost picture is made again" compare whole "${three[@]}"
check "to the same bytes" diff -r --exclude=retrainings.db first whole
check "a list of names is the list it names" compare whole --list all --list kept.txt
check "and was trained before" test "$(retrainings whole)" = "$before"
check "with the same outcome" near "$(column kept 0 8)" "$(awk -F, '$1 == "top:3" && $2 == 0 { print $8 }' first/compare.csv)"

check "the paper's way: equal epochs" compare whole --list kept.txt --list all --equal epochs --seeds 1
check "which are said" grep -q '^kept,0,3,3,' whole/compare.csv
check "and are another training" test "$(retrainings whole)" = 7
check "one seed says nothing of noise" grep -q '^all,kept,test_psnr,[-0-9.e]*,,,,false$' whole/pairs.csv

check "appearance is fitted on left halves" compare halves --list not-harmful --scores valued --seed 1 --seeds 1  \
   --effects appearance
check "which is said" grep -q 'test photos, their right halves: appearance' stdout
check "and in JSON" grep -q '"half_views": true' halves/compare.json
check "of another seed nothing is warned" test "$(grep -c '^warning' stderr)" = 0

# ---- Scores of another state of things ----

cp -r valued other
sqlite3 other/ledger.db "UPDATE run SET status = 'interrupted', scene_options_json = '{\"corrupt\":2}';
    UPDATE image SET sha256 = '00' WHERE name IN ('view_000', 'view_003', 'view_006')"
check "another state of the photos" compare states --list top:3 --scores other --seed 5 --seeds 1
check "an unfinished run is warned of" grep -q '^warning: other/ledger.db: the run is interrupted, not finished' stderr
check "corrupted photos are" grep -q '^warning: .* corrupted 2 photos (--corrupt), and 0 are to be' stderr
check "those to train on that have changed are" grep -q '^warning: --scores other: 2 photos have changed' stderr

# ---- Refusals ----

# refuses PATTERN [OPTION]...: in one line, and leaves nothing.
refuses() { fails 2 "$1" "$program" compare tiny.json --out refused "${tiny[@]}" --quiet "${@:2}" && [[ ! -e refused ]]; }
echo view_002 >one.txt
printf 'view_002\nview_099\n' >unknown.txt
printf 'name,score\nview_000,2\nview_001,5\nview_002,3.5\n' >nima.csv
sed 's/"count": 6/"count": 7/' tiny.json >other.json
check "no list" refuses '--list is missing'
check "a list that there is not" refuses 'neither a file nor' --list all --list best
check "an amount that is none" refuses 'neither a file nor' --scores valued --list top:few
check "scores are needed" refuses '--scores' --list positive
check "of a run that is there" refuses 'nowhere' --list positive --scores nowhere
check "of a method that there is" refuses 'dv_sharpness' --list top:2 --scores valued --method dv_sharpness
check "a single photo" refuses 'single photo' --list one.txt
check "a name that is not in the scene" refuses 'unknown.txt:2: view_099' --list all --list unknown.txt
check "random stands behind a list" refuses 'before it' --list random --list all
check "that is not all photos" refuses 'shorter' --list all --list random
check "scores of other photos" refuses 'which is not a photo to train on' --scores valued --list top:2 --train kept.txt
check "imported scores that are too low" refuses 'no train photo' --list nima.csv@6
query() { sqlite3 "$1/ledger.db" "$2"; }
cp -r valued twice
query twice "INSERT INTO image SELECT image_id, 'ff', 'of another scene', 'val', '', sha256, ground_truth FROM image
    WHERE name = 'view_005'"
check "an image_id of two scenes" refuses 'damaged: column image_id' --scores twice --list top:6 --list one.txt

# vanishing: a list is removed while a scene loads that takes a while.
vanishing() {
    local code=0 process
    sed 's/16, "height_px": 12/640, "height_px": 480/' tiny.json >large.json
    cp kept.txt gone.txt
    "$program" compare large.json --out refused "${tiny[@]}" --list gone.txt >stdout 2>stderr &
    process=$!
    until grep -q '^device' stderr || [[ ! -d /proc/$process ]]; do sleep 0.005; done
    rm gone.txt
    wait "$process" || code=$?
    [[ $code -eq 2 ]] && grep -qx 'viewworth: --list gone.txt: neither a file nor .*' stderr
}
check "a list that vanishes while the scene loads" vanishing
check "no seeds left" refuses 'lower' --list all --seed 9223372036854775806
check "imported scores above a threshold" compare nima --list all --list nima.csv@3 --seeds 1 --json
check "by their name" grep -q '"name": "nima@3"' nima/compare.json
conclude
