// The index of this invocation in a dispatch that vw_submission_dispatch may have folded into y.
#ifndef INVOCATION_GLSL
#define INVOCATION_GLSL

// Macros, since gl_WorkGroupSize in a function that stands before the pass's layout(local_size_x) would silently be 1.
#define workgroup_index() (gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x)
#define invocation_index() (workgroup_index() * gl_WorkGroupSize.x + gl_LocalInvocationID.x)

#endif
