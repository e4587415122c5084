#!/usr/bin/env bash
# COLMAP itself reads the model of select --copy: as many cameras, images, points and observations as the kept photos have, and a mean
# reprojection error. Takes the program's path.
# label: once unsanitized
command -v colmap >/dev/null || { echo "SKIPPED: copies were not read by COLMAP: colmap is missing; apt-get install colmap"; exit 77; }
. "$(dirname "$0")/../support/program_test.sh"

# 16 photos on a circle, two cameras; photos i and i + 1 see point i a tenth of a pixel beside its image, and have a feature without a
# point.
scene=$folder/scene
mkdir -p "$scene/images" "$scene/sparse/0"
for ((i = 0; i < 16; i++)); do
    write_photo "$scene/images/photo $i.png"
    printf '%s' "$i" >>"$scene/images/photo $i.png" # behind the image's end: only its hash differs
done
awk -v folder="$scene/sparse/0" '
    function feature(image, point,   x, y, z, c, s) {
        c = cos(image * 0.19634954084936207); s = -sin(image * 0.19634954084936207)
        x = (2 * c * c - 1) * px[point] + 2 * c * s * pz[point]
        y = -py[point] - 0.1
        z = 2 * c * s * px[point] + (2 * s * s - 1) * pz[point] + 3
        return sprintf("%.17g %.17g %d ", 9.5 * x / z + 4.1, 9.25 * y / z + 3, point + 1)
    }
    BEGIN {
        print "1 PINHOLE 8 6 9.5 9.25 4 3\n2 OPENCV 8 6 9.5 9.25 4 3 0 0 0 0.001" >folder "/cameras.txt"
        for (i = 0; i < 16; i++) { px[i] = (i % 3) / 9; py[i] = (i % 4) / 9; pz[i] = (i % 5) / 9 }
        for (i = 0; i < 16; i++) {
            a = i * 0.19634954084936207
            printf "%d 0 %.17g 0 %.17g 0 -0.1 3 %d photo %d.png\n1.5 1.5 -1 %s%s\n", i + 1, cos(a), -sin(a), 1 + (i == 8), i, feature(i, i),
                feature(i, (i + 15) % 16) >folder "/images.txt"
            printf "%d %.17g %.17g %.17g 10 20 30 0.1 %d 1 %d 2\n", i + 1, px[i], py[i], pz[i], i + 1, (i + 1) % 16 + 1 \
                >folder "/points3D.txt"
        }
    }'
check "COLMAP reads the scene" prints '^(Images|Points): 16$' colmap model_analyzer --path "$scene/sparse/0"
check "it is valued" run "$program" value "$scene" --out "$folder/run" --epochs 3 "${small[@]}" --quiet
for rule in drop:20% top:5; do
    check "$rule is copied" answers "json_array_length(j, '\$.selected') BETWEEN 1 AND 11" \
        "$program" select "$folder/run" --rule "$rule" --copy "$folder/copy" --json --quiet
    # What is expected of it: pairs of neighbours on the circle, of photos that are kept or do not train.
    read -r cameras images points < <(sqlite3 -separator ' ' "$folder/run/ledger.db" "CREATE TEMP TABLE kept AS SELECT image_id AS i
        FROM image WHERE split <> 'train'
            OR name IN (SELECT value FROM json_each(CAST(readfile('$folder/answer.json') AS TEXT), '\$.selected'));
        SELECT 1 + (SELECT count(*) FROM kept WHERE i = 8), count(*),
            (SELECT count(*) FROM kept AS a JOIN kept AS b ON b.i = (a.i + 1) % 16) FROM kept")
    check "COLMAP reads the copy" run colmap model_analyzer --path "$folder/copy/sparse/0"
    cat "$folder/stdout" "$folder/stderr" >"$folder/analysis" # which of them has the numbers depends on COLMAP's version
    check "it finds $cameras cameras, $images images, $points points" test "$(sed -nE \
        's/.*(Cameras|Registered images|Points|Observations): //p' "$folder/analysis" | tr '\n' ' ')" = \
        "$cameras $images $points $((2 * points)) "
    check "its error is the tenth of a pixel" near "$(sed -nE 's/.*Mean reprojection error: (.*)px/\1/p' "$folder/analysis")" 0.1 0.002
    check "it writes the model as text" run colmap model_converter --input_path "$folder/copy/sparse/0" --output_path "$folder/copy" \
        --output_type TXT
    # A line of images.txt has an image's id first, the next one its features; a point has its id first, its track after seven more.
    check "features and points name each other" awk '/^#/ { next }
        FILENAME ~ /images/ && ++line % 2 { image = $1; next }
        FILENAME ~ /images/ { for (i = 3; i <= NF; i += 3) if ($i >= 0) { point_of[image, i / 3 - 1] = $i; left++ } next }
        { for (i = 9; i < NF; i += 2) if (point_of[$i, $(i + 1)] == $1) left--; else wrong = 1 }
        END { exit wrong || left }' "$folder/copy/images.txt" "$folder/copy/points3D.txt"
    check "images/ has the photos of the model and no others" diff <(ls "$folder/copy/images") \
        <(grep -o 'photo .*' "$folder/copy/images.txt" | sort)
    rm -r "$folder/copy"
done
conclude "$@"
