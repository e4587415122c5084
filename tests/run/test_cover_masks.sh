#!/usr/bin/env bash
# Masks of what covers photos, from outside: a wall in 16 photos of files, of which one has a patch pasted in. value finds it, and writes a
# mask of the size of the file that hides the patch and nothing else; training with it finds nothing more. Takes the program's path.
. "$(dirname "$0")/../support/program_test.sh"

# Writes photo K of a wall at distance 4 from a camera that moves to the right: waves of the place, so that all photos agree.
write_photo() { # write_photo K FILE
    awk -v k="$1" 'BEGIN {
        print "P3 128 96 255"
        for (y = 0; y < 96; y++) for (x = 0; x < 128; x++) {
            u = (x - 64) / 25 + 0.2 * (k - 8); v = (y - 48) / 25
            if (k == 5 && x >= 40 && x < 80 && y >= 30 && y < 70) print 250, 20, 240
            else printf "%d %d %d\n", 128 + 60 * sin(3 * u) * cos(2 * v), 110 + 50 * sin(2 * u + v), 90 + 40 * cos(4 * v - u)
        } }' >"$2"
}

scene=$folder/wall
mkdir -p "$scene/images"
for k in {0..15}; do write_photo "$k" "$scene/images/$k.ppm"; done
awk 'BEGIN {
    printf "{\"fl_x\": 100, \"fl_y\": 100, \"cx\": 64, \"cy\": 48, \"w\": 128, \"h\": 96, \"frames\": ["
    for (k = 0; k < 16; k++)
        printf "%s{\"file_path\": \"images/%d.ppm\", \"transform_matrix\": [[1,0,0,%s],[0,1,0,0],[0,0,1,4],[0,0,0,1]]}",
            k ? ", " : "", k, 0.2 * (k - 8)
    print "]}" }' >"$scene/transforms.json"

value() { "$program" value "$scene" --effects none --accuracy draft --quiet "$@" >"$folder/text" 2>/dev/null; }
masks() { (cd "$1/masks" 2>/dev/null && find . -type f) | sort; }
# pixel FILE X Y: the brightness of a pixel of a mask, by python's own means of neither library: a grey PNG of 8 bits.
pixel() {
    python3 - "$@" <<'P'
import struct, sys, zlib
data, at, packed = open(sys.argv[1], "rb").read(), 8, b""
while at < len(data):
    size, kind = struct.unpack(">I4s", data[at:at + 8])
    if kind == b"IHDR":
        width, height, depth, colour = struct.unpack(">IIBB", data[at + 8:at + 18])
    packed += data[at + 8:at + 8 + size] if kind == b"IDAT" else b""
    at += 12 + size
if (width, height, depth, colour) != (128, 96, 8, 0):
    sys.exit(f"{width} x {height}, {depth} bits, colour {colour}")
raw, above, rows = zlib.decompress(packed), [0] * width, []
for y in range(height):
    kind, row = raw[y * (width + 1)], list(raw[y * (width + 1) + 1:(y + 1) * (width + 1)])
    for x in range(width):
        left, up, corner = (row[x - 1] if x else 0), above[x], (above[x - 1] if x else 0)
        guess = min((left, up, corner), key=lambda one: abs(left + up - corner - one))
        row[x] = (row[x] + (0, left, up, (left + up) // 2, guess)[kind]) % 256
    rows.append(row)
    above = row
print(rows[int(sys.argv[3])][int(sys.argv[2])])
P
}
is_pixel() { [[ $(pixel "$folder/run/masks/5.ppm.png" "$1" "$2") == "$3" ]]; } # is_pixel X Y BRIGHTNESS

check "the wall is valued" value --out "$folder/run"
check "only the covered photo has a mask" test "$(masks "$folder/run")" = ./5.ppm.png
check "it is black where the patch is" eval 'is_pixel 60 50 0 && is_pixel 43 33 0 && is_pixel 76 66 0'
check "  and white elsewhere" eval 'is_pixel 30 50 255 && is_pixel 90 50 255 && is_pixel 60 20 255 && is_pixel 60 80 255'
check "the answer says how to train with it" grep -q "^masks  *1 of what covers photos: viewworth value .* --masks $folder/run/masks" \
    "$folder/text"
check "advice tells the share, a tenth to a fifth" test "$(sqlite3 :memory: ".import --csv $folder/run/advice.csv t" "SELECT
    group_concat(name) FROM t WHERE CAST(covered_share AS REAL) BETWEEN 0.1 AND 0.2 AND reason = 'occluder'")" = images/5.ppm
check "at half the size it is the same" value --out "$folder/half" --downscale 2
check "  at the size of the file" test "$(pixel "$folder/half/masks/5.ppm.png" 60 50) $(pixel "$folder/half/masks/5.ppm.png" 30 50)" = \
    '0 255'
check "training with it" value --out "$folder/again" --masks "$folder/run/masks" --splits "$folder/run/splits.json"
check "  finds nothing more, and hands the mask on" test "$(masks "$folder/again") $(grep -c '^masks' "$folder/text")" = "./5.ppm.png 0"
check "an untrained has none" eval 'echo 5.ppm >"$folder/v"; value --out "$folder/u" --val "$folder/v" && test -z "$(masks "$folder/u")"'
conclude "$@"
