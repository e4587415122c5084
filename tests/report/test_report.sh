#!/usr/bin/env bash
# The report: that value writes it and report makes the same again, and what a browser makes of it. Takes the program's path; the browser is
# headless Chromium, driven by report_browser.py.
# label: once
. "$(dirname "$0")/../support/program_test.sh"
scene=$root/scenes/toys.json
tiny=(--epochs 4 --rays 64 --samples 16 --importance-samples 0 --lr 0.003 --learning-rate-decay 1 --val-rays 160 --levels 4
    --log2-table 10 --width 16 --effects auto --pilot-steps 8 --device llvmpipe --quiet)
synthetic=$(dirname "$program")/synthetic_ledger

value() { # value OUT [OPTION]...
    "$program" value "$scene" --out "$folder/$1" "${tiny[@]}" "${@:2}" >"$folder/stdout" 2>"$folder/stderr" && return
    cat "$folder/stderr"
    return 1
}
by=
report() { "${by:-$program}" report --quiet "$@" >"$folder/stdout" 2>"$folder/stderr"; }
warns() { # warns PATTERN COMMAND...: it succeeds, and one line on stderr matches, beside that of a ledger which the test edited
    "${@:2}" && [[ $(grep -vcE "$edited" "$folder/stderr") -eq 1 ]] && grep -qE "^warning: .*($1)" "$folder/stderr" && return
    cat "$folder/stdout" "$folder/stderr"
    return 1
}
refuses() { fails 2 "$1" "${by:-$program}" report --quiet "${@:2}"; } # refuses PATTERN ARGUMENT...

# ---- Made with the run, and again ---------------------------------------------------------------------------------------

check "value writes a report" value run
check "and says where" grep -qx "report   $folder/run/report.html" "$folder/stdout"
sed 's/"width_px": 64, "height_px": 48/"width_px": 160, "height_px": 120/' "$scene" >"$folder/wide.json"
# heights OUT: of the pictures, from the lowest PSNR up: those of validation photos, as no rays are left for others.
heights() {
    sqlite3 :memory: "SELECT value ->> 'picture' FROM json_each(CAST(readfile('$folder/$1/residuals.json') AS TEXT), '\$.photos')
        ORDER BY value ->> 'psnr'" | while read -r picture; do
        base64 -d <<<"$picture" | od -An -tu2 -j28 -N2 # of a WebP file that is lossy and has no alpha
    done | xargs
}
check "the validation photo in the middle by PSNR has a larger picture, of what rays are left" eval 'scene=$folder/wide.json value wide \
    --rays 3000 --epochs 6 --effects none && [[ $(heights wide) =~ ^72\ 72\ 1[0-9]+\ 72\ 72$ ]] || { heights wide; false; }'
cat >"$folder/noisy.json" <<'RECIPE'
{"viewworth_recipe": 1, "seed": 3, "image": {"width_px": 1200, "height_px": 300}, "box": {"centre": [0, 0, 0], "half_extent": 2},
 "shapes": [{"kind": "sphere", "centre": [0, 0, 0], "radius": 1.9, "texture": {"kind": "checker", "colour": [1, 0.9, 0.1],
             "second_colour": [0, 0.1, 0.9], "cell": 0.0017}}],
 "cameras": [{"path": "orbit", "centre": [0, 0, 0], "radius": 2, "count": 4, "field_of_view_deg": 90, "split": "train"},
             {"path": "orbit", "centre": [0, 0, 0], "radius": 2, "count": 1, "start_deg": 30, "field_of_view_deg": 90, "split": "val"}]}
RECIPE
check "unless its file would be too large" eval 'scene=$folder/noisy.json value noisy --downscale 1 --rays 100 --samples 4 --epochs 12 \
    --val-rays 120000 --effects none && [[ $(heights noisy) == 72 ]]'
check "another seed" value other --seed 1 --no-thumbnails
cp "$folder/run/report.html" "$folder/first.html"
check "report makes the same again, from the ledger and the scene" eval 'report "$folder/run" &&
    cmp "$folder/run/report.html" "$folder/first.html"'
check "advice.csv has the four words" eval '! tail -n +2 "$folder/run/advice.csv" | grep -qvE "^[^,]+,(keep|look|unclear|drop),."'
check "with thumbnails" grep -q 'data:image/webp;base64,UklGR' "$folder/first.html"
check "without, when asked" eval '! grep -q "data:image/webp" "$folder/other/report.html"'
check "--to writes elsewhere" report "$folder/run" --to "$folder/bare.html" --no-thumbnails
check "and leaves OUT alone" cmp "$folder/run/report.html" "$folder/first.html"
check "several folders make one page" report "$folder/run" "$folder/other" --to "$folder/both.html"
check "their photos are in it once" test "$(grep -o 'data:image/webp' "$folder/both.html" | wc -l)" -eq \
    "$(grep -o 'data:image/webp' "$folder/first.html" | wc -l)"
check "--json says where" eval '"$program" report "$folder/run" --json --quiet | grep -q "\"report\": \"$folder/run/report.html\""'

cp -r "$folder/run" "$folder/swept"
check "the backward pass of lasting credit" eval '"$program" lasting "$folder/swept" --device llvmpipe --quiet >"$folder/stdout" 2>&1'
check "brings the gate and the horizon into the report" grep -qE '"gate":\{[^}]*"image":\[[0-9].*"growth":\{"step":\[1,' \
    "$folder/swept/report.html"
cp "$folder/swept/report.html" "$folder/swept.html"
check "and a report made again" eval 'report "$folder/swept" && cmp "$folder/swept/report.html" "$folder/swept.html"'

cp -r "$folder/run" "$folder/blocked" && rm "$folder/blocked/report.html" && mkdir "$folder/blocked/report.html"
check "a report that cannot be written is named: the command fails" eval \
    '! value blocked --resume >/dev/null && grep -q "report.html: is not a file" "$folder/stderr"'
check "its ledger is as it was" cmp "$folder/run/ledger.db" "$folder/blocked/ledger.db"
check "new steps take an outdated report away" eval 'rmdir "$folder/blocked/report.html" && touch "$folder/blocked/report.html" &&
    value blocked --resume --epochs 5 && [[ $(wc -c <"$folder/blocked/report.html") -gt 200000 ]]'

# ---- What is missing or broken ------------------------------------------------------------------------------------------

check "the run leaves a map and renders in OUT" test -s "$folder/run/map.json" -a -s "$folder/run/residuals.json"
cp -r "$folder/run" "$folder/cut" && rm "$folder/cut/residuals.json"
check "renders that a stop left out are made by --resume" value cut --resume
check "with the bits of the run's own" cmp "$folder/cut/residuals.json" "$folder/run/residuals.json"
check "no renders with --no-thumbnails" test ! -e "$folder/other/residuals.json" -a -s "$folder/other/map.json"
check "nor in a report that goes without thumbnails" eval '! grep -q "\"picture\":" "$folder/bare.html"'
cp -r "$folder/run" "$folder/mapped"
# mapped PATTERN FILE SQL: map.json or residuals.json as SQLite's json functions change it is refused.
mapped() {
    sqlite3 :memory: "SELECT $3 FROM (SELECT CAST(readfile('$folder/run/$2') AS TEXT) AS j)" >"$folder/mapped/$2" &&
        refuses "mapped/$2: $1" "$folder/mapped" && cp "$folder/run/$2" "$folder/mapped/$2"
}
check "a map of another scene" mapped 'is of another scene' map.json "json_set(j, '\$.scene_hash', 'x')"
check "points that are none" mapped 'points: ' map.json "json_set(j, '\$.points', 7)"
check "a reconstruction of another scene" mapped 'is of another scene' reconstruction.json "json_set(j, '\$.scene_hash', 'x')"
check "one whose SSIM is text" mapped 'ssim: ' reconstruction.json "json_set(j, '\$.ssim', '<img>')"
check "a map that is no JSON" mapped 'line [0-9]+: ' map.json "'{'"
check "renders of another scene" mapped 'is of another scene' residuals.json "json_remove(j, '\$.scene_hash')"
rm "$folder/mapped/map.json" && ln -s ../run/map.json "$folder/mapped/map.json"
check "a map that is a link" refuses 'mapped/map.json: .*link' "$folder/mapped"
cp -r "$folder/run" "$folder/planned"
check "places for the next photos" eval '"$program" next "$folder/planned" --device llvmpipe --quiet >"$folder/stdout"'
check "change no report" cmp "$folder/planned/report.html" "$folder/first.html"
cp -r "$folder/planned" "$folder/edited_plan"
check "until it is made again" eval 'report "$folder/planned" && ! cmp -s "$folder/planned/report.html" "$folder/first.html" &&
    grep -q "\"next\":{" "$folder/planned/report.html"'
check "with a render of each" answers "json_array_length(j, '\$.pictures') = 10 AND json_array_length(j, '\$.proposals') = 10" \
    cat "$folder/planned/next.json"
check "unless photos are left out" eval 'report "$folder/planned" --no-thumbnails --to "$folder/unseen.html" &&
    grep -q "\"next\":{" "$folder/unseen.html" && ! grep -q UklGR "$folder/unseen.html"'
# planned PATTERN SQL: next.json as SQLite's json functions change it is refused.
planned() {
    sqlite3 :memory: "SELECT $2 FROM (SELECT CAST(readfile('$folder/planned/next.json') AS TEXT) AS j)" \
        >"$folder/edited_plan/next.json" && refuses "edited_plan/next.json: $1" "$folder/edited_plan"
}
check "places of another scene" planned 'is of another scene' "json_set(j, '\$.scene_hash', 'x')"
check "places that are none" planned 'proposals: is not an array' "json_set(j, '\$.proposals', 7)"
check "places that are no JSON" planned 'line [0-9]+: ' "'{'"
rm "$folder/edited_plan/next.json" && ln -s ../planned/next.json "$folder/edited_plan/next.json"
check "places that are a link" refuses 'edited_plan/next.json: .*link' "$folder/edited_plan"
sqlite3 :memory: "SELECT json_set(j, '\$.proposals[0].move', '<img src=x onerror=\"window.broken = 7\">',
    '\$.proposals[1].position[0]', 1e12)
    FROM (SELECT CAST(readfile('$folder/planned/next.json') AS TEXT) AS j)" >"$folder/next.json"
rm "$folder/edited_plan/next.json" && mv "$folder/next.json" "$folder/edited_plan/next.json"
check "hostile texts and numbers are data" report "$folder/edited_plan"
sqlite3 :memory: "SELECT json_remove(CAST(readfile('$folder/planned/next.json') AS TEXT), '\$.pictures')" >"$folder/edited_plan/next.json"
check "places without pictures are shown" eval 'report "$folder/edited_plan" --to "$folder/unseen_plan.html" &&
    grep -q "\"next\":{" "$folder/unseen_plan.html"'
check "a scene that is gone is a warning" eval 'mkdir "$folder/large" "$folder/hostile" && "$synthetic" "$folder/large/ledger.db" 2000 &&
    warns "without thumbnails.*scenes/none: no such scene" report "$folder/large"'
check "hostile names" eval '"$synthetic" "$folder/hostile/ledger.db" 12 hostile && warns "without thumbnails" report "$folder/hostile"'
check "a folder that is not there" refuses 'nowhere: no such folder' "$folder/nowhere"
mkdir "$folder/empty"
check "a folder that holds nothing" refuses 'empty: contains nothing to report' "$folder/run" "$folder/empty" --to "$folder/none.html"
check "leaves no report" test ! -e "$folder/none.html"
check "no folder at all" refuses 'OUT\.\.\. is missing'
mkdir -p "$folder/compare/renders" "$folder/bench"
printf '%s\n' scene,metric,method,value,ci_low,ci_high,count toys,lds/val_psnr,dv_psnr,0.62,0.4,0.8,200 toys,auc/harmful,dv_psnr,0.9,,,18 \
    "toys,lds/val_psnr,''=x,0.5,,,200" >"$folder/bench/benchmark.csv"
mkdir "$folder/costs"
{
    echo scene,metric,method,value,ci_low,ci_high,count
    for row in dv_psnr:1:0.4 tmc_shapley_4N:120:0.6 tmc_shapley_10:10:0.1 '<b>_2:2:0.3' '=x:1e99:0.5' free:0:0.9; do
        IFS=: read -r method cost value <<<"$row"
        printf '%s\n' "toys,lds/test_psnr,\"$method\",$value,0.05,0.7,40" "toys,cost/trainings,\"$method\",$cost,,,1"
    done
    printf '%s\n' "toys,lds/test_psnr,noise ceiling,0.8,,,40" "toys,sign_accuracy/test_psnr,dv_psnr,0.7,,,9" \
        toys,lds/val_psnr,dv_psnr,0.6,,,40
} >"$folder/costs/benchmark.csv"
check "a benchmark of methods that cost more is for the laboratory" refuses 'costs: contains nothing to report' "$folder/costs"
by=$lab check "which shows it" report "$folder/costs" --to "$folder/costs.html"
hash=$(sqlite3 "$folder/run/ledger.db" 'SELECT scene_hash FROM run')
photo=$(sqlite3 "$folder/run/ledger.db" "SELECT name FROM image WHERE split = 'train' LIMIT 1")
compare_json() { # compare_json RENDER
    cat <<JSON
{"scene": "scenes/toys.json", "scene_hash": "$hash", "seeds": [0, 1], "downscale": 1, "epochs": 4, "lists": [
  {"name": "all", "photos": ["$photo"], "outcomes": [{"seed": 0, "test_psnr": 18.0, "photo_count": 18}, {"seed": 1, "test_psnr": 18.1,
   "photo_count": 18}], "mean": {"test_psnr": 18.05, "val_psnr": null}, "stderr": {"test_psnr": 0.05}},
  {"name": "significant", "photos": [], "outcomes": [{"seed": 0, "test_psnr": 18.2, "photo_count": 9}, {"seed": 1, "test_psnr": 18.3,
   "photo_count": 9}], "mean": {"test_psnr": 18.25}, "stderr": {"test_psnr": 0.1}}],
 "pairs": [{"list": "significant", "against": "all", "measure": "test_psnr", "difference": 0.2, "stderr": 0.01, "ci_low": 0.1,
   "ci_high": 0.3,
  "beyond_noise": true},
  {"list": "significant", "against": "all", "measure": "test_l1", "difference": -0.2, "ci_low": -0.3, "ci_high": -0.1,
   "beyond_noise": true},
  {"list": "significant", "against": "all", "measure": "val_l1", "difference": 0.1, "ci_low": 0.05, "ci_high": 0.2, "beyond_noise": true},
  {"list": "significant", "against": "all", "measure": "val_psnr", "difference": 0.1, "ci_low": -0.1, "ci_high": 0.3,
   "beyond_noise": false}],
 "half_views": true,
 "disagreements": [{"photo": "$photo", "in": ["all"], "not_in": ["significant"]}],
 "renders": [{"view": "view_002", "split": "test", "file": "$1", "columns": ["photo", "all"]}]}
JSON
}
check "a render for the comparison" "$program" render "$folder/run" --to "$folder/compare/renders/0.png" --device llvmpipe --quiet
compare_json '../run/scores.csv' >"$folder/compare/compare.json"
check "a comparison's render from elsewhere is refused" refuses 'compare.json: renders' "$folder/compare"
compare_json 'renders/secret.png' >"$folder/compare/compare.json"
cp "$folder/compare/renders/0.png" "$folder/secret.png"
ln -s ../../secret.png "$folder/compare/renders/secret.png"
check "nor one that a link leads to" refuses 'renders/secret.png: .*link' "$folder/compare"
cp "$folder/run/scores.csv" "$folder/compare/renders/secret.png" --remove-destination
check "a render that is no picture" refuses 'renders/secret.png: is not a PNG file' "$folder/compare"
rm "$folder/compare/renders/secret.png" && mkfifo "$folder/compare/renders/secret.png"
check "nor a file, which might never end" refuses 'renders/secret.png: .*plain file' "$folder/compare"
mkdir "$folder/linked"
for name in benchmark.csv compare.json ledger.db; do
    by=$lab
    ln -s "../$(case $name in benchmark.csv) echo bench ;; compare.json) echo compare ;; *) echo run ;; esac)/$name" "$folder/linked/$name"
    check "$name that is a link to another folder" refuses "linked/$name: .*link" "$folder/linked"
    rm "$folder/linked/$name"
done
ln -s ../run "$folder/linked/seed_0"
check "so is the folder of a seed" refuses "linked/seed_0: .*link" "$folder/linked"
# edited PATTERN SQL: compare.json as SQLite's json functions change it is refused.
edited() {
    compare_json 'renders/0.png' >"$folder/draft.json"
    sqlite3 :memory: "SELECT $2 FROM (SELECT CAST(readfile('$folder/draft.json') AS TEXT) AS j)" >"$folder/compare/compare.json" &&
        refuses "compare/compare.json: $1" "$folder/compare"
}
check "a comparison of nothing" edited '.*scene' "'{}'"
check "a comparison without lists" edited '.*lists' "json_remove(j, '\$.lists')"
compare_json 'renders/0.png' >"$folder/draft.json"
sqlite3 :memory: "SELECT json_remove(CAST(readfile('$folder/draft.json') AS TEXT), '\$.lists[1].outcomes')" >"$folder/compare/compare.json"
check "a list without outcomes is for the page to tell" report "$folder/compare" --to "$folder/broken.html"
mkdir "$folder/edited"
by=$lab
for name in benchmark tradeoff providers payout duplicates summary; do
    printf 'scene,method,value,ci_low,ci_high,count\ntoys,dv_psnr,0.62,0.4,0.8,200\n' >"$folder/edited/$name.csv"
    check "$name.csv that lacks a column" refuses "edited/$name.csv: lacks the column [a-z]+; make it again" "$folder/edited"
    rm "$folder/edited/$name.csv"
done
echo '{"lists": [' >"$folder/compare/compare.json"
check "a comparison that is no JSON" refuses 'compare/compare.json: line [0-9]+: ' "$folder/compare"
compare_json 'renders/0.png' >"$folder/compare/compare.json"
check "a comparison and a benchmark beside runs" report "$folder/run" "$folder/other" "$folder/compare" "$folder/bench" \
    --to "$folder/all.html"
by=
pictures() { grep -o 'data:image/webp' "$folder/$1" | wc -l; }
check "which bring the thumbnails" test "$(pictures all.html)" -eq "$(pictures first.html)"
check "of a comparison alone, those on which lists disagree" eval 'cd "$root" && report "$folder/compare" && [[ ! -s $folder/stderr ]]'
check "are in it" test "$(pictures compare/report.html)" -eq 1
mv "$folder/compare/report.html" "$folder/compared.html"
check "unless asked not to" eval 'report "$folder/compare" --to "$folder/none.html" --no-thumbnails && [[ $(pictures none.html) -eq 0 ]]'
sed -i 's/"downscale": 1/"downscale": 0/' "$folder/compare/compare.json"
check "a divisor that there is not is a warning" warns 'out of range' report "$folder/compare"

# ---- Runs that are there already, and ledgers of other photos -----------------------------------------------------------

runs_of() { sed -n 's/.*id="data">//p' "$1" | grep -o '"run_id":' | wc -l; }
check "a folder named twice is one run" eval 'report "$folder/run" "$folder/run/" --no-thumbnails --to "$folder/twice.html" &&
    report "$folder/run" --no-thumbnails --to "$folder/once.html" && cmp "$folder/once.html" "$folder/twice.html"'
mkdir "$folder/seeds" && cp -r "$folder/run" "$folder/seeds/seed_0"
check "and so is that of a seed" report "$folder/seeds" "$folder/seeds/seed_0" "$folder/other" --no-thumbnails --to "$folder/twice.html"
check "the page has two runs" test "$(runs_of "$folder/twice.html")" -eq 2
cp -r "$folder/run" "$folder/padded" && rm "$folder/padded/map.json" "$folder/padded/residuals.json" "$folder/padded/SHA256SUMS"
sqlite3 "$folder/padded/ledger.db" "WITH RECURSIVE n(i) AS (SELECT 1000 UNION ALL SELECT i + 1 FROM n WHERE i < 31000)
    INSERT INTO image (image_id, scene_hash, name, split, provider, sha256, ground_truth)
    SELECT i, scene_hash, 'x' || i, 'excluded', provider, sha256, ground_truth FROM n, (SELECT * FROM image LIMIT 1)"
check "a ledger of more photos than the scene has is a warning" warns 'padded: its ledger names other photos' report "$folder/padded"
sqlite3 "$folder/padded/ledger.db" "DELETE FROM image WHERE image_id >= 1000; UPDATE image SET name = 'x' WHERE image_id = 3"
check "so is one of others" warns 'padded: its ledger names other photos' report "$folder/padded"

# ---- What accuracy costs in time ----------------------------------------------------------------------------------------

# tradeoff NAME [KIND]: a folder as tradeoff writes it. Its configurations are the base, one parameter after another, and
# full_resolution; the rows of a configuration are its methods. Without KIND: 11 configurations by 2 methods, no ground truth; "one": 1 by
# 1; "many": 60 by 20; "hostile": texts that would run as scripts, and numbers that no axis can show.
tradeoff() {
    mkdir -p "$folder/$1"
    awk -v kind="${2-}" 'BEGIN {
        OFS = ","
        print "configuration,parameter,value,base,epochs,steps,train_ms,value_ms,scoring_ratio,run_seconds,device_mib,val_psnr," \
            "psnr_pareto_front,method,seed_pearson,agreement_pearson"
        count = split("base: rays:125 rays:500 rays:2000 val-rays:256 val-rays:1024 val-rays:all effects:-sky accuracy:draft samples:8 " \
            "full_resolution:all", configurations, " ")
        if (kind == "one") count = 1
        if (kind == "many") for (count = 1; count < 60; count++)
            configurations[count + 1] = "parameter" int(count / 5) ":" 2 ^ (count % 5) + count
        method_count = kind == "one" ? 1 : kind == "many" ? 20 : 2
        for (p = 1; p <= count; p++)
            for (m = 1; m <= method_count; m++) {
                split(configurations[p], pair, ":")
                parameter = pair[1]; value = pair[2]
                configuration = p == 1 ? "base" : parameter "-" value
                if (p == 1 && kind != "hostile") value = "\"rays 1000, samples 16\""
                method = m == 1 ? "dv_psnr" : m == 2 ? "dv_loss" : "method_" m
                seconds = 10 * p; agreement = value == "all" && parameter == "full_resolution" ? "" : 0.5 + 0.03 * p - 0.1 * (m - 1)
                seeds = p == 1 ? 0.8 : ""
                psnr = 20 + p / 4
                if (kind == "hostile") {
                    hurt = "<img src=x onerror=\"\"window.broken = 8\"\"></script><script>window.broken = 9</script>"
                    configuration = "\"" hurt configuration "\""; parameter = "\"" hurt parameter "\""
                    value = "\"__proto__" hurt value "\""
                    method = "\"" hurt m "\""
                    split("0 -1 1e308 nan x 1e-320 9 10 11 12 13", odd, " ")
                    seconds = odd[p]; agreement = p == 8 ? "1e999" : p == 9 ? "-7" : agreement
                    psnr = p == 2 ? "1e308" : p == 3 ? "-1e308" : psnr
                }
                print configuration, parameter, value, p == 1, 20, 1000, 8, 10 * p, 1.25, seconds, 300, psnr, p % 2, method, seeds, \
                    agreement
            }
    }' >"$folder/$1/tradeoff.csv"
}
tradeoff trade && mkdir -p "$folder/trade/configurations/base" && cp -r "$folder/run" "$folder/trade/configurations/base/seed_0"
tradeoff trade_one one && tradeoff trade_many many && tradeoff trade_hostile hostile
for name in trade trade_one trade_many trade_hostile; do
    check "a page of $name" eval 'report "$folder/$name" && [[ ! -s $folder/stderr ]]'
done
check "shows none of the runs of its configurations" test "$(runs_of "$folder/trade/report.html")" -eq 0
check "unless a run is named beside it" report "$folder/run" "$folder/trade" "$folder/trade_one" --to "$folder/traded.html" --no-thumbnails
check "a tradeoff that lacks any column it needs" eval 'for column in configuration run_seconds psnr_pareto_front \
    agreement_pearson; do
    sed "1s/\b$column\b/other/" "$folder/trade/tradeoff.csv" >"$folder/edited/tradeoff.csv" &&
        refuses "edited/tradeoff.csv: lacks the column $column; make it again" "$folder/edited" || break
done'
mkdir "$folder/trade_linked" && ln -s ../trade/tradeoff.csv "$folder/trade_linked/tradeoff.csv"
check "one that is a link to another folder" refuses 'trade_linked/tradeoff.csv: .*link' "$folder/trade_linked"
check "an empty one" eval ': >"$folder/edited/tradeoff.csv" && refuses "edited/tradeoff.csv: is empty; remove it" "$folder/edited"'
check "one whose quotes are broken" eval '{ cat "$folder/trade/tradeoff.csv" && echo "\"open"; } >"$folder/edited/tradeoff.csv" &&
    refuses "edited/tradeoff.csv:24: " "$folder/edited"'

# ---- In a browser -------------------------------------------------------------------------------------------------------

# unseen WHY: skips what is left, loudly.
unseen() {
    echo "SKIPPED: the report was not seen in a browser: $1"
    [[ $failed -gt 0 ]] || exit 77
    conclude
}
python=${PYTHON:-/usr/bin/python3}
if ! [[ -x ${CHROMIUM:-/usr/bin/chromium} && -x ${CHROMEDRIVER:-/usr/bin/chromedriver} ]] ||
    ! "$python" -c 'import selenium' 2>/dev/null; then
    unseen "install chromium, chromium-driver and python3-selenium"
fi
seen=0
while read -r verdict what; do
    [[ $verdict != no ]] || unseen "there is $verdict $what"
    check "$what" test "$verdict" = ok
    seen=$((seen + 1))
done < <(HOME=$folder XDG_CACHE_HOME=$folder "$python" "$root/tests/report/report_browser.py" "$folder")
check "the browser looked at everything" test "$seen" -eq "$(grep -c '^@check' "$root/tests/report/report_browser.py")"
conclude "$@"
