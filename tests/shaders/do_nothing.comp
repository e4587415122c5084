// Does nothing: what a timed dispatch of it takes is not a pass's own.
#version 460
layout(local_size_x = 64) in;

void main() {}
