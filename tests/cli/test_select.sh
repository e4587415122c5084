#!/usr/bin/env bash
# select from outside: a tiny scene of every format is valued, its photos selected, and the list opened again; what other programs read in
# it; names made to do harm; what is refused. Takes the program's path.
# label: once
. "$(dirname "$0")/../support/program_test.sh"
tiny=(--epochs 3 --rays 32 --samples 8 --importance-samples 0 --lr 0.003 --learning-rate-decay 1 --val-rays 64 --levels 2 --log2-table 8
    --width 16 --device llvmpipe --effects none --quiet)

# refuses PATTERN ARGUMENT...: exit code 2, nothing on stdout, and one line on stderr that matches.
refuses() { fails 2 "$1" "$program" "${@:2}" --quiet; }

refuses_edited() { fails 1 'is not what its steps give' "$program" "$@" --quiet; } # refuses_edited ARGUMENT...

# file_says FILE SQL: the expression on a JSON file, called j, is true.
file_says() { answers "$2" cat "$1" | head -c 1000; return "${PIPESTATUS[0]}"; }

# ---- Scenes: 16 photos on a circle, of which 0 and 8 validate and 4 and 12 test, unless the files say otherwise ---------------

# Names that would do harm in a spreadsheet, a shell, a query or a page.
names=(p00.png '=cmd().png' '+1+1.png' "quote'; DROP TABLE image;--.png" 'p04.png' 'comma, "double".png' '-dash.png' '@at.png' 'p08.png'
    'süß 写真.png' '$(touch x) `y`.png' '<b>&amp;.png' 'p12.png' '%s%n.png' 'sub/p14.png' 'p15.png')

{
    echo 'CREATE TABLE photo(i, name);'
    for i in "${!names[@]}"; do echo "INSERT INTO photo VALUES ($i, '${names[i]//\'/\'\'}');"; done
} | sqlite3 "$folder/photos.db"

# frames PREFIX WHERE: an array of frames of transforms.json for these photos, with keys that viewworth does not read.
frames() {
    sqlite3 "$folder/photos.db" "SELECT json_group_array(json_object('file_path', '$1' || name, 'sharpness',
        json(printf('%d.345678901234567', 12 + i)), 'depth_file_path', 'depth/' || i || '.png', 'colmap_im_id', 9007199254740993,
        'transform_matrix', json_array(json_array(cos(a), 0, sin(a), 3 * sin(a)), json_array(0, 1, 0, json('0.10000000000000001')),
            json_array(-sin(a), 0, cos(a), 3 * cos(a)), json_array(0, 0, 0, 1)))) FROM (SELECT *, i * 0.39269908169872414 AS a FROM photo)
        WHERE $2"
}

# The model of the same cameras, in FOLDER.
write_model() {
    local i
    mkdir -p "$1"
    echo '1 PINHOLE 8 6 9.5 9.25 4.125 3.0625' >"$1/cameras.txt"
    for i in "${!names[@]}"; do
        awk -v i="$i" 'BEGIN { a = i * 0.39269908169872414; printf "%d 0 %.17g 0 %.17g 0 -0.1 3 1 ", 100 + i, cos(a / 2), -sin(a / 2) }'
        printf '%s\n\n' "${names[i]}"
    done >"$1/images.txt"
    : >"$1/points3D.txt"
}

single=$folder/single
write_photos "$single/images"
printf '{"fl_x": 9.5, "fl_y": 9.25, "cx": 4.125, "cy": 3.0625, "w": 8, "h": 6, "k1": 0.1000000000000000055, "aabb_scale": 16,
    "ply_file_path": "points.ply", "frames": %s, "applied_scale": 0.30000000000000004}\n' "$(frames images/ 1)" \
    >"$single/transforms.json"

blender=$folder/blender
write_photos "$blender/pictures"
write_blender() { printf '{"camera_angle_x": 0.8, "frames": %s}\n' "$(frames ./pictures/ "$2")" >"$blender/transforms_$1.json"; }
write_blender train 'i % 4 IN (1, 2)'
write_blender val 'i % 4 = 3'
write_blender test 'i % 4 = 0'

colmap=$folder/colmap
write_photos "$colmap/images"
write_model "$colmap/sparse/0"

tourism=$folder/tourism
write_photos "$tourism/dense/images"
write_model "$tourism/dense/sparse"
{
    printf 'id\tsplit\tfilename\tdataset\n'
    printf '%s\n' "107.0 train" " train" "103.0 test" "101.0 test" "109 train" "110 train" "104.0 test" "105.0 train" " test" | {
        i=0
        while IFS=' ' read -r id split; do
            [[ -n $split ]] || { split=$id id=; }
            printf '%s\t%s\t%s\ttiny\n' "$id" "$split" "${names[i++]}"
        done
    }
    printf '7\ttrain\tnot registered.png\ttiny\n8\ttest\tnor this.png\ttiny\n'
} >"$tourism/tiny.tsv"

# ---- Values -------------------------------------------------------------------------------------------------------------

for scene in single blender colmap tourism; do
    check "$scene is valued" prints 'dB' "$program" value "$folder/$scene" --out "$folder/$scene.run" "${tiny[@]}"
done
check "a recipe is valued" prints 'dB' "$program" value "$root/scenes/clean.json" --out "$folder/recipe.run" "${tiny[@]}" --seed 1

# kept RUN NAME...: the five best photos of the run's dv_psnr, and all that validate and test, are those that NAME's ledger holds in the
# same splits; NAME may leave photos out, but no other trains.
kept() {
    sqlite3 "$folder/$1/ledger.db" "ATTACH '$folder/$2/ledger.db' AS again;
        CREATE TEMP TABLE wanted AS SELECT name, split, sha256 FROM main.image WHERE split IN ('val', 'test') UNION ALL
            SELECT * FROM (SELECT name, split, sha256 FROM main.image JOIN main.score USING (image_id) WHERE method = 'dv_psnr'
                ORDER BY value DESC LIMIT 5);
        CREATE TEMP TABLE had AS SELECT replace(name, '${3-}', '') AS name, split, sha256 FROM again.image WHERE split <> 'excluded';
        SELECT count(*), (SELECT count(*) FROM wanted), (SELECT count(*) FROM (SELECT * FROM wanted EXCEPT SELECT * FROM had)) FROM had" |
        awk -F"|" "{ ok = \$1 == \$2 && \$1 > 6 && \$3 == 0 } END { if (!ok) print; exit !ok }"
}

# trains NAME SCENE [OPTION]...: trains on a list; NAME is the folder of the run.
trains() {
    "$program" train "${@:2}" --out "$folder/$1" "${tiny[@]}" --epochs 1 >"$folder/stdout" 2>&1 && return
    cat "$folder/stdout"
    return 1
}

# ---- transforms.json ------------------------------------------------------------------------------------------------------

best=$folder/best.txt
check "the best photos of transforms.json are listed" prints '^kept     5 of 12 photos to train on, by dv_psnr: top:5$' \
    "$program" select "$folder/single.run" --rule top:5 --to "$best"
check "the way to train on them is shown" grep -qx \
    "train    viewworth value $single --train $best --downscale 1 --field hash --out ANOTHER" "$folder/stdout"
check "that the rule was not verified is said" says '^nothing was verified: the rule was taken as asked; viewworth compare tests'
check "it is a list for --train" trains single.again "$single" --train "$best"
check "it holds them, and the others in their splits" kept single.run single.again
check "--quick trains nothing and says so" prints '^nothing was verified: --quick does not retrain$' \
    "$program" select "$folder/single.run" --quick --to "$folder/quick.txt"
check "it leaves only outliers out" says '^kept     12 of 12 photos to train on, by train_fit, dv_psnr, dv_loss: without-outliers$'
check "no training was made" test ! -e "$folder/single.run/retrainings.db"
check "--json tells the list" answers "j ->> '\$.path' = '$folder/above.txt' AND j ->> '\$.format' = 'text' AND
    j ->> '\$.method' = 'dv_loss' AND json_array_length(j, '\$.selected') = 5 AND (SELECT count(*) = 4 FROM json_each(j))" \
    "$program" select "$folder/single.run" --rule top:5 --to "$folder/above.txt" --json --method dv_loss
mv "$folder/answer.json" "$folder/selected.json"
check "the names come best first" file_says "$folder/selected.json" "json_extract(j, '\$.selected') = '$(query single.run "SELECT
    replace(json_group_array(name), '''', '''''') FROM (SELECT name FROM image JOIN score USING (image_id) WHERE method = 'dv_loss'
    ORDER BY value DESC LIMIT 5)")'"
check "what is there is not written over" refuses 'best\.txt: exists' select "$folder/single.run" --rule top:5 --to "$best"
check "another extension is refused, with the remedy" refuses 'a file of names \(.txt\).*--copy DIR' \
    select "$folder/single.run" --rule top:5 --to "$folder/best.json"
check "as is a TSV of a scene without one" refuses 'only a PhotoTourism scene has a TSV' \
    select "$folder/single.run" --rule top:5 --to "$folder/best.tsv"

# ---- COLMAP -------------------------------------------------------------------------------------------------------------

check "a list of COLMAP's photos is written" prints '\(text\)$' \
    "$program" select "$folder/colmap.run" --rule top:5 --to "$folder/colmap.txt"
check "it has their names" test "$(sort "$folder/colmap.txt")" = "$(query colmap.run "SELECT name FROM image
    JOIN score USING (image_id) WHERE method = 'dv_psnr' ORDER BY value DESC LIMIT 5" | sort)"
check "it is a list for --train" trains colmap.again "$folder/colmap" --train "$folder/colmap.txt"
check "it holds the photos" kept colmap.run colmap.again

# ---- NeRF-W -------------------------------------------------------------------------------------------------------------

check "a TSV is written" prints '\(phototourism\)$' "$program" select "$folder/tourism.run" --rule top:5 --to "$folder/picked.tsv"
check "the way to train on it is shown" grep -qx \
    "train    viewworth value $folder/tourism --train $folder/picked.tsv --downscale 1 --field hash --out ANOTHER" "$folder/stdout"
check "every chosen photo trains and has an id" test "$(awk -F'\t' 'NR > 1 && $2 == "train" && $1 != "" && $4 == "tiny" { print $3 }' \
    "$folder/picked.tsv" | sort)" = "$(query tourism.run "SELECT substr(name, 14) FROM image JOIN score USING (image_id)
    WHERE method = 'dv_psnr' ORDER BY value DESC LIMIT 5" | sort)"
check "it is a list for --train" trains tourism.again "$tourism" --train "$folder/picked.tsv"
check "it holds the photos in their splits" kept tourism.run tourism.again

# ---- Names, one a line ----------------------------------------------------------------------------------------------------

check "a recipe's photos are a list" prints '\(text\)$' "$program" select "$folder/recipe.run" --rule top:5 --to "$folder/recipe.txt"
check "it is a list for --train" trains recipe.again "$root/scenes/clean.json" --train "$folder/recipe.txt"
check "it holds the photos" kept recipe.run recipe.again
{
    echo 'step,epoch,photo,psnr,l1'
    echo '0,0,,10,0.5'
    for ((i = 1; i <= 12; i++)); do echo "$i,$(((i - 1) / 3)),\"${names[i % 3]}\",$((10 + i % 3)),0.$((50 - i))"; done
} >"$folder/log.csv"
"$program" import-steps "$folder/log.csv" --out "$folder/imported" >"$folder/stdout"
check "photos of an imported log are a list" prints '\(text\)$' \
    "$program" select "$folder/imported" --rule positive --to "$folder/imported.txt"
check "it has their names" test "$(sort "$folder/imported.txt")" = "$(query imported "SELECT name FROM image JOIN score USING (image_id)
    WHERE method = 'dv_psnr' AND value > 0 ORDER BY name")"
check "names for spreadsheets are guarded" grep -qE "^'(=cmd|\+1)" "$folder/imported/scores.csv"
query imported "UPDATE image SET name = 'two
lines.png' WHERE image_id = (SELECT image_id FROM score WHERE method = 'dv_psnr' ORDER BY value DESC LIMIT 1)"
check "a name of two lines is refused" refuses 'damaged: column name has an invalid value' \
    select "$folder/imported" --rule top:1 --to "$folder/lines.txt"
query imported "UPDATE image SET name = ' spaced.png' WHERE name LIKE 'two%'"
check "a name that readers would trim, too" refuses 'cannot be in a list' select "$folder/imported" --rule top:1 --to "$folder/lines.txt"
check "nothing was written of them" test ! -e "$folder/lines.txt"

# ---- Rules and refusals -----------------------------------------------------------------------------------------------------

# Steps whose photos have intervals of many widths, and whose first photo makes the L1 of validation worse.
awk 'BEGIN {
    print "step,epoch,photo,psnr,l1"; psnr = 10; l1 = 0.5
    print "0,0,,10,0.5"
    for (epoch = 0; epoch < 5; epoch++) for (i = 0; i < 12; i++) {
        psnr += (i - 3) * 0.02 + (epoch % 2 ? 0.01 : -0.01) * (i % 4) * (i % 4)
        l1 += i ? -0.0001 * i : 0.01
        printf "%d,%d,view_%02d,%.6f,%.6f\n", ++step, epoch, i, psnr, l1
    }
}' >"$folder/steps.csv"
"$program" import-steps "$folder/steps.csv" --out "$folder/steps" --quiet >"$folder/stdout"
run=$folder/single.run
list=$folder/none.txt
check "--rule positive is warned of" grep -q '^warning: --rule positive: ' <(
    "$program" select "$run" --rule positive --to "$folder/positive.txt" --quiet 2>&1 >/dev/null)
check "with --method outliers are left out, and named" prints "^left out view_00: dv_loss z = -" \
    "$program" select "$folder/steps" --method dv_loss --to "$folder/rule.txt"
check "all others are kept" test "$(tr '\n' ' ' <"$folder/rule.txt")" = "$(printf 'view_%02d ' {1..11})"
check "--rule without-outliers is that rule; --json names them, too" answers "j ->> '\$.method' = 'dv_loss' AND
    json_array_length(j, '\$.lone_views') = 0 AND
    json_array_length(j, '\$.left_out') = 1 AND j ->> '\$.left_out[0].name' = 'view_00' AND j ->> '\$.left_out[0].z' < -3" \
    "$program" select "$folder/steps" --rule without-outliers --method dv_loss --to "$folder/outliers.txt" --json
check "without a rule and training losses nobody is accused" prints "^kept     12 of 12 photos.*by train_fit, dv_psnr, dv_loss" \
    "$program" select "$folder/steps" --to "$folder/by_all.txt"
check "that an imported run cannot be verified is said" says '^nothing was verified: an imported run cannot be trained again$'
query steps "UPDATE score SET value = 9 WHERE method = 'dv_psnr' AND image_id = 0"
check "scores that the steps do not give are refused" refuses_edited select "$folder/steps" --rule top:3 --to "$folder/edited.txt"
check "--to is needed" refuses '--to is missing' select "$run" --rule positive
check "an unknown method is refused with those there are" refuses 'method "nima" has no scores; use one of: dv_psnr, dv_loss' \
    select "$run" --rule positive --method nima --to "$list"
check "--rule top:5x is refused" refuses '--rule takes one of without-outliers' select "$run" --rule top:5x --to "$list"
check "a folder without a ledger is refused" refuses 'ledger\.db' select "$folder/elsewhere" --rule positive --to "$list"
check "a run without scores is refused" refuses 'no scores; value the photos first' \
    select "$folder/single.again" --rule positive --to "$list"
check "a place that is not there is a failure" fails 1 'no/such' \
    "$program" select "$run" --rule top:3 --to "$folder/no/such/list.txt" --quiet

# ---- A ledger from elsewhere ------------------------------------------------------------------------------------------------

cp -r "$folder/colmap.run" "$folder/elsewhere.run"
query elsewhere.run "UPDATE run SET status = 'interrupted', scene_options_json =
    '{\"x; touch pwned #\":1,\"downscale\":2,\"corrupt\":3,\"providers\":\"\$(touch pwned)\"}'"
check "the way to train names known options alone, as a shell takes them" prints \
    "^train    viewworth value $folder/colmap --train $folder/from.txt --downscale 2 --providers '\\$\(touch pwned\)' --field hash --out " \
    "$program" select "$folder/elsewhere.run" --rule top:5 --to "$folder/from.txt"
check "a run that did not finish is warned of" grep -q '^warning: .*the run is interrupted, not finished' "$folder/stderr"
check "as are photos that were corrupted by --corrupt" grep -q '^warning: .*corrupted 3 photos (--corrupt)' "$folder/stderr"

# ---- Without the scene's photos -------------------------------------------------------------------------------------------

rm -r "$colmap/images" "$tourism/dense/images"
check "images are not needed" prints '\(text\)$' "$program" select "$folder/colmap.run" --rule top:5 --to "$folder/without.txt"
check "the list is the same" cmp "$folder/colmap.txt" "$folder/without.txt"
check "nor are a PhotoTourism scene's" prints '\(phototourism\)$' "$program" select "$folder/tourism.run" --rule top:5 \
    --to "$folder/without.tsv"
check "that list is the same, too" cmp "$folder/picked.tsv" "$folder/without.tsv"
rm -r "$tourism/dense/sparse"
check "a scene that lacks its photos is refused" refuses 'no COLMAP model; restore it' \
    select "$folder/tourism.run" --rule top:5 --to "$folder/gone.tsv"
check "refused lists left nothing" test -z "$(find "$folder" -name '*.part-*' -o -name 'gone.*')"
conclude "$@"
