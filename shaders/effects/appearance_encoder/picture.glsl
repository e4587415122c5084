// The square picture that a step's first rays make, and the thumbnail of it, by areas: as that of a photo of so many
// pixels.
#ifndef PICTURE_GLSL
#define PICTURE_GLSL

// Returns, for one axis, the overlap of a thumbnail's pixel and a pixel of a picture that is `side` wide. Both count in
// parts of THUMBNAIL_SIDE * side to the axis.
float share_of(uint thumbnail_at, uint picture_at, uint side) {
    uint begin = max(thumbnail_at * side, picture_at * THUMBNAIL_SIDE);
    uint end = min((thumbnail_at + 1u) * side, (picture_at + 1u) * THUMBNAIL_SIDE);
    return float(max(end, begin) - begin) / float(side);
}

// Returns the first of the `to` pixels of an axis that overlap pixel `at` of `from`; the next returns the end.
uvec2 overlapped(uvec2 at, uint from, uint to) { return at * to / from; }
uvec2 overlapped_end(uvec2 at, uint from, uint to) { return ((at + 1u) * to + from - 1u) / from; }

#endif
