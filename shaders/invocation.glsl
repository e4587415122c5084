// The index of this invocation in a dispatch that vw_batch_dispatch may have folded into y.
#ifndef INVOCATION_GLSL
#define INVOCATION_GLSL

uint workgroup_index() { return gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x; }
uint invocation_index() { return workgroup_index() * gl_WorkGroupSize.x + gl_LocalInvocationID.x; }

#endif
