// Uses double precision, which viewworth never enables: validation must complain.
#version 460

layout(local_size_x = 1) in;
layout(set = 0, binding = 0) buffer Value { float value; };

void main() { value = float(double(value) * 0.5); }
