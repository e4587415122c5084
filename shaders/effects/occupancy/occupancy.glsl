// The cells that training may skip: a grid over the box with each cell's recent density (Mueller et al., "Instant
// neural graphics primitives", SIGGRAPH 2022, the appendix on occupancy grids). Samples in empty cells count as density
// 0 and are not evaluated. Validation never skips.
#ifndef OCCUPANCY_GLSL
#define OCCUPANCY_GLSL

uint occupancy_cell(vec3 position) {
    uvec3 cell = min(uvec3(position * float(VW_OCCUPANCY_SIDE)),
                     uvec3(VW_OCCUPANCY_SIDE - 1u)); // position 1.0 belongs to the last cell
    return cell.x + VW_OCCUPANCY_SIDE * (cell.y + VW_OCCUPANCY_SIDE * cell.z);
}

// Returns true also for a non-finite density, so that the field is evaluated there and the fault noticed.
bool occupied(float density) { return density > VW_EMPTY_DENSITY(float(SAMPLES)) || !finite(density); }

#endif
