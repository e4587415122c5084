#!/usr/bin/env bash
# select --copy from outside: the copy of a scene of each format opens by both of its formats, with the cameras, splits and photos of the
# run; what is refused, and that it leaves nothing. Takes the program's path.
# label: once
. "$(dirname "$0")/../support/program_test.sh"
tiny=(--epochs 3 --rays 32 --samples 8 --importance-samples 0 --lr 0.003 --learning-rate-decay 1 --val-rays 64 --levels 2 --log2-table 8
    --width 16 --device llvmpipe --effects none --quiet)
refuses() { fails 2 "$1" "$program" select "${@:2}" --quiet; } # refuses PATTERN ARGUMENT...
copies() { run "$program" select "$1" --rule drop:1 --copy "${@:2}" --quiet; }

names=(0.png '=1+1.png' "2'; DROP.png" '$(touch x).png' 4.png 'süß 写真.png' '<b>&amp;.png' 'sub/7.png' '%s%n.png' -9.png 10.png 11.png)
frames() { # frames PREFIX KEYS: of transforms.json; every second photo has a mask, and every third frame these keys
    local i mask keys
    for i in "${!names[@]}"; do
        mask= keys=
        [[ $((i % 2)) -ne 0 ]] || mask='"mask_path": "hide.png", '
        [[ $((i % 3)) -ne 0 ]] || keys=$2
        awk -v i="$i" -v head="{$mask$keys\"file_path\": \"$1${names[i]}\", \"transform_matrix\"" 'BEGIN {
            a = i * 0.52359877559829887; printf "%s%s: [[%.17g,0,%.17g,%.17g],[0,1,0,0.1],[%.17g,0,%.17g,%.17g],[0,0,0,1]]}", i ? "," : "",
                head, cos(a), sin(a), 3 * sin(a), -sin(a), cos(a), 3 * cos(a) }'
    done
}

transforms=$folder/transforms
write_photos "$transforms/pictures"
write_photo "$transforms/hide.png"
printf '{"camera_model": "OPENCV", "fl_x": 9.1, "fl_y": 9.3, "cx": 4.1, "cy": 3.2, "k1": 0.1, "k2": -0.02, "p1": 0.003, "frames": [%s]}' \
    "$(frames ./pictures/ '"fl_x": 8.7, "k1": 0.05, ')" >"$transforms/transforms.json"
colmap=$folder/colmap
write_mask() { # write_mask FILE WIDTH HEIGHT: the left half is black
    awk -v w="$2" -v h="$3" 'BEGIN { printf "P2 %d %d 255\n", w, h
        for (i = 0; i < w * h; i++) print i % w < w / 2 ? 0 : 255 }' >"$1"
}
write_mask "$folder/wide.png" 8 6 # a PGM file, which its content tells
write_mask "$folder/tall.png" 6 8
write_photos "$colmap/images"
mkdir -p "$colmap/sparse/0" "$colmap/masks/sub"
write_photo "$colmap/masks/0.png"
write_photo "$colmap/masks/sub/7.png"
mkdir -p "$colmap/features/sub" # hashed and copied, but not read without the effect uncertainty
for map in 0 sub/7; do echo "map $map" >"$colmap/features/$map.npy"; done
printf '1 PINHOLE 8 6 9.5 9.25 4.125 3.0625\n2 SIMPLE_RADIAL 8 6 9.75 4 3 -0.02\n' >"$colmap/sparse/0/cameras.txt"
: >"$colmap/sparse/0/points3D.txt"
for i in "${!names[@]}"; do
    awk -v i="$i" 'BEGIN { a = i * 0.26179938779914944; printf "%d 0 %.17g 0 %.17g 0 -0.1 3 %d ", 50 - i, cos(a), -sin(a), 1 + i % 2 }'
    printf '%s\n\n' "${names[i]}"
done >"$colmap/sparse/0/images.txt"

# same_cameras SCENE COPY FORMAT: info tells the same cameras of the copy, no others, and as many photos as the run kept.
same_cameras() (
    export VK_DRIVER_FILES=/dev/null # info says enough without a device
    "$program" info "$1" --json --quiet >"$folder/first.json" &&
        "$program" info "$2" --format "$3" --json --quiet >"$folder/second.json" || return 1
    [[ $(sqlite3 :memory: "WITH
        f AS (SELECT json_remove(value, '\$.views') AS c FROM json_each(CAST(readfile('$folder/first.json') AS TEXT), '\$.cameras')),
        s AS (SELECT json_remove(value, '\$.views') AS c FROM json_each(CAST(readfile('$folder/second.json') AS TEXT), '\$.cameras'))
        SELECT (SELECT count(*) = 2 FROM s) AND NOT EXISTS (SELECT c FROM s EXCEPT SELECT c FROM f)") == 1 ]]
)

# same_photos RUN AGAIN FROM TO: the run AGAIN of a copy has all photos of RUN but the worst one that trained, byte for byte and in their
# splits; the start of their names was FROM and is TO.
same_photos() {
    [[ $(sqlite3 "$folder/$1/ledger.db" "ATTACH '$folder/$2/ledger.db' AS again;
        CREATE TEMP TABLE wanted AS SELECT replace(name, '$3', '$4') AS name, split, sha256 FROM main.image WHERE image_id NOT IN
            (SELECT image_id FROM main.score WHERE method = 'dv_psnr' ORDER BY value LIMIT 1);
        SELECT count(*), (SELECT count(*) FROM again.image), (SELECT count(*) FROM
            (SELECT * FROM wanted INTERSECT SELECT name, split, sha256 FROM again.image)) FROM wanted") == '11|11|11' ]]
}

for scene in transforms colmap; do
    check "$scene is valued at half its size" run "$program" value "$folder/$scene" --out "$folder/$scene.run" "${tiny[@]}" --downscale 2
    check "it is copied at its own" copies "$folder/$scene.run" "$folder/$scene.copy"
    check "its cameras are of that size" answers "j ->> '\$.frames[0].w' = 8" cat "$folder/$scene.copy/transforms.json"
    check "the copy is valued as it is" run "$program" value "$folder/$scene.copy" --out "$folder/$scene.again" "${tiny[@]}"
    for format in transforms colmap; do
        check "its $format has the same cameras" same_cameras "$folder/$scene" "$folder/$scene.copy" "$format"
    done
done
check "it has the photos of the run in their splits" same_photos transforms.run transforms.again pictures/ images/
check "so does that of COLMAP" same_photos colmap.run colmap.again images/ images/
check "masks came along" answers "j ->> '\$.masks' BETWEEN 5 AND 6" \
    env VK_DRIVER_FILES=/dev/null "$program" info "$folder/transforms.copy" --json --quiet
check "transforms.json names them" answers "(SELECT count(*) = 11 AND sum(value ->> '\$.mask_path' =
    'masks/' || substr(value ->> '\$.file_path', 8) || '.png') BETWEEN 5 AND 6 FROM json_each(j, '\$.frames'))" \
    cat "$folder/transforms.copy/transforms.json"
check "by COLMAP's names, too" test -s "$folder/colmap.copy/masks/0.png.png" -a -s "$folder/colmap.copy/masks/sub/7.png.png"
check "so are maps of features" cmp "$colmap/features/sub/7.npy" "$folder/colmap.copy/features/sub/7.png.npy"
check "--to and --copy go together; --json tells both" answers "j ->> '\$.path' = '$folder/list.txt' AND j ->> '\$.format' = 'text' AND
    j ->> '\$.copy' = '$folder/both' AND json_array_length(j, '\$.selected') = 8" \
    "$program" select "$folder/colmap.run" --rule drop:1 --to "$folder/list.txt" --copy "$folder/both" --json --quiet
check "both are there" test -s "$folder/list.txt" -a -s "$folder/both/transforms.json"
check "the copy is told" prints "^copy     $folder/told " "$program" select "$folder/colmap.run" --rule drop:1 --copy "$folder/told"

# ---- Masks that a run has found, and those of another folder ----

found=$folder/colmap.run/masks
mkdir -p "$found/sub"
cp "$folder/wide.png" "$found/10.png.png"
cp "$folder/wide.png" "$found/sub/7.png.png"
check "masks that the run found come along" copies "$folder/colmap.run" "$folder/masked"
check "  where the scene has none" cmp "$found/10.png.png" "$folder/masked/masks/10.png.png"
check "  and instead of its own" cmp "$found/sub/7.png.png" "$folder/masked/masks/sub/7.png.png"
check "  not of others" cmp "$colmap/masks/0.png" "$folder/masked/masks/0.png.png"
check "a run trains with them" run "$program" value "$colmap" --masks "$found" --out "$folder/with" "${tiny[@]}" --downscale 2
check "  on another scene" test "$(sqlite3 "$folder/with/ledger.db" "SELECT scene_hash FROM run")" != \
    "$(sqlite3 "$folder/colmap.run/ledger.db" "SELECT scene_hash FROM run")"
check "  and opens it again" run "$program" verify "$folder/with" --replay 3 --device llvmpipe --quiet
check "its copy has its masks" copies "$folder/with" "$folder/with.copy"
check "  from their folder" cmp "$found/10.png.png" "$folder/with.copy/masks/10.png.png"
check "masks of another shape are refused" eval 'mkdir "$folder/tall" && cp "$folder/tall.png" \
    "$folder/tall/10.png.png" && fails 2 "10.png.png: the mask has 6 x 8 pixels but its photo 8 x 6" \
    "$program" info "$colmap" --masks "$folder/tall" --quiet'
check "a folder that is not there is refused" fails 2 'no-masks: is not a folder' \
    "$program" info "$colmap" --masks "$folder/no-masks" --quiet
check "so are masks of a recipe" fails 2 'a recipe has no masks' "$program" info "$root/scenes/clean.json" --masks "$found" --quiet
check "links that leave the folder are refused" eval 'mkdir "$folder/linked" && ln -s "$folder/wide.png" "$folder/linked/10.png.png" &&
    fails 2 "10.png.png" "$program" info "$colmap" --masks "$folder/linked" --quiet'
check "a folder that has no mask of a photo is refused" fails 2 'has no mask of a photo' \
    "$program" value "$colmap" --masks "$colmap/features" --out "$folder/none" "${tiny[@]}"
mkdir -p "$folder/taken/masks" "$folder/file"
: >"$folder/file/masks"
check "masks of somebody else are not written over" fails 2 'has a folder masks but no run' \
    "$program" value "$colmap" --out "$folder/taken" "${tiny[@]}"
check "nor is a file of that name" fails 2 'masks: is not a folder' "$program" value "$colmap" --out "$folder/file" "${tiny[@]}"

# ---- What is refused leaves nothing -----------------------------------------------------------------------------------------

check "a folder with files is refused" refuses 'both: exists; name a new' "$folder/colmap.run" --rule drop:1 --copy "$folder/both"
check "neither --to nor --copy is refused" refuses '--to is missing.*--copy' "$folder/colmap.run" --rule drop:1
run "$program" value "$root/scenes/clean.json" --out "$folder/recipe.run" "${tiny[@]}"
check "a recipe is refused" refuses 'a recipe has no photo files' "$folder/recipe.run" --rule drop:1 --copy "$folder/none"
check "a place that is not there is a failure" fails 1 'no/such/copy: cannot make the folder' \
    "$program" select "$folder/colmap.run" --rule drop:1 --copy "$folder/no/such/copy" --quiet
mkdir "$folder/full"
if mount -t tmpfs -o size=12k tmpfs "$folder/full" 2>/dev/null; then
    check "a full disk is a failure" fails 1 'No space left' \
        "$program" select "$folder/colmap.run" --rule drop:1 --copy "$folder/full/copy" --quiet
    check "nothing is left on it" test -z "$(ls -A "$folder/full")"
    umount "$folder/full"
else
    echo "SKIPPED: a full disk: a small file system cannot be mounted here"
fi
{
    printf 'step,epoch,photo,psnr,l1\n0,0,,10,0.5\n'
    for i in {1..12}; do echo "$i,$(((i - 1) / 3)),photo$((i % 3)),$((10 + i % 3)),0.$((50 - i))"; done
} >"$folder/log.csv"
run "$program" import-steps "$folder/log.csv" --out "$folder/imported" --quiet
check "an imported run is refused before its scores choose" refuses 'was imported and has no scene' "$folder/imported" --method nima \
    --copy "$folder/none"
check "a recipe is refused before any training" eval 'refuses "a recipe has no photo files" "$folder/recipe.run" --copy "$folder/none" &&
    test ! -e "$folder/recipe.run/retrainings.db"'
check "so is a list of another extension" eval 'refuses "best.list: takes a file of names" \
    "$folder/transforms.run" --to "$folder/best.list" && test ! -e "$folder/transforms.run/retrainings.db"'
check "and one that is there, before the copy is made" refuses 'list.txt: exists' \
    "$folder/colmap.run" --rule drop:1 --to "$folder/list.txt" \
    --copy "$folder/none"
mkdir "$folder/new"
check "a list that can be written leaves no folder before it is" refuses 'both: exists; name a new or an empty' \
    "$folder/transforms.run" --rule drop:1 --to "$folder/new/list.txt" --copy "$folder/both"
check "and nothing in it" test -z "$(ls -A "$folder/new")"
printf x >>"$colmap/images/4.png"
check "a photo that has changed is refused" refuses 'images/4\.png: not the file that was valued' "$folder/colmap.run" --rule drop:1 \
    --copy "$folder/none" --to "$folder/later.txt"
check "its list is not written, so that the same command can go on" test ! -e "$folder/later.txt"
sed -i 's,pictures/10.png,../secret.png,' "$transforms/transforms.json"
write_photo "$folder/secret.png"
check "a name that leaves the scene is refused" refuses 'file_path leaves the scene folder' "$folder/transforms.run" --rule drop:1 \
    --copy "$folder/none"
sed -i 's,\.\./secret.png,pictures/none.png,' "$transforms/transforms.json"
check "a photo that the scene lacks is refused" refuses 'it lacks pictures/10\.png' \
    "$folder/transforms.run" --rule drop:1 --copy "$folder/none"
check "nothing is left of them" test -z "$(find "$folder" -maxdepth 2 -name '.viewworth-*' -o -maxdepth 2 -name none)"
conclude "$@"
